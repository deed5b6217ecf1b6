//! The pipeline file as it is written (YAML): raw text for every quantity, no unknown key.

mod pictures;

pub use pictures::{Format, PictureKind, Pictures};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

/// A whole pipeline file; docs/pipeline.md describes every key.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Spec {
    /// Results go to `results/NAME/`; letters, digits, `_`, `-`, `.`, not beginning with a dot.
    pub name: String,
    /// The file that is meshed or read.
    pub geometry: Geometry,
    /// `stress`: σ_zz = 0; `strain`: ε_zz = 0.
    #[serde(default)]
    pub plane: Plane,
    /// h_t; forces and reactions are for this thickness. Unit: m.
    #[serde(default = "one_metre")]
    pub thickness: Scalar,
    /// One entry for each material, under a name of your choice.
    pub materials: BTreeMap<String, Material>,
    /// Which surfaces are what.
    pub regions: Vec<Region>,
    /// Physical curves that sever bonds and trusses from the start ([rule](pipeline.md#cracks)).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cracks: Vec<String>,
    /// Physical surfaces: a bond or truss with an end at a material point in one of them never
    /// breaks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub no_fail: Vec<String>,
    /// How interface nodes are tied to material points: `truss` (the paper's; [settings](#truss)), `clip`
    /// (bonds end where they cross the interface), `splice` (nodes and points follow each other in an overlap).
    /// [Which one](howto.md).
    #[serde(default)]
    pub coupling: Coupling,
    /// Supports and loads; at least one displacement.
    pub boundary: Vec<Boundary>,
    /// `{ y: -9.81 m/s^2 }`: the weight of every region whose material has a `density`. As all loads
    /// it grows with λ, in its `phase` where there are phases.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Gravity>,
    /// How the load grows while bonds break ([fracture](pipeline.md#fracture)). By default: one
    /// elastic solve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loading: Option<Loading>,
    /// Displacements to report, under names of your choice.
    #[serde(default)]
    pub probes: BTreeMap<String, Probe>,
    /// What is written.
    #[serde(default)]
    pub output: Output,
    /// A [study](pipeline.md#studies): values to run the rest of the file with, by `peristitch
    /// sweep`; `run` takes no notice of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep: Option<Sweep>,
}

fn one_metre() -> Scalar {
    Scalar("1 m".to_owned())
}

#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Geometry {
    /// `.geo`, `.geo_unrolled`, `.brep`, `.step`, `.stp`: meshed by Gmsh in two dimensions. `.msh`
    /// (2.2, 4.1): taken as it is. `.inp`, `.bdf`, `.nas`, `.fem`, `.med`, `.vtu`, `.vtk`: [meshes of
    /// other programs](pipeline.md#meshes-of-other-programs).
    pub file: String,
    /// What 1 is in the file: `mm`.
    #[serde(default = "metre")]
    pub unit: String,
    /// Values for the variables that a `.geo` defines by `DefineConstant[…]` or asks for by
    /// `Exists(…)`; plain numbers, in the geometry's own unit.
    #[serde(default)]
    pub parameters: BTreeMap<String, Scalar>,
    /// Whether a `.geo` may [run programs and write files](pipeline.md#a-geo-is-code).
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub trust: bool,
}

fn metre() -> String {
    "m".to_owned()
}

#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Plane {
    #[default]
    Stress,
    Strain,
}

#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Young's modulus E > 0. Unit: Pa.
    pub young: Scalar,
    /// Poisson's ratio, −1 < ν < 1/2. Under peridynamic regions 1/3 in plane stress, 1/4 in plane
    /// strain, within 1e-6.
    pub poisson: Scalar,
    /// f_t > 0: a bond breaks at a stretch above f_t/E. Unit: Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tensile_strength: Option<Scalar>,
    /// f_c > 0: a bond breaks at a stretch below −f_c/E; beside `tensile_strength`. By default:
    /// compression breaks nothing. Unit: Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compressive_strength: Option<Scalar>,
    /// G0 > 0: a bond breaks at a stretch above √(G0/(c0 M3)), scaled by the lattice's own energy
    /// release rate where `micromodulus` is `isotropised`
    /// ([how](method.md#isotropised-micromodulus)); instead of the strengths. Unit: J/m².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_release_rate: Option<Scalar>,
    /// ρ > 0, for `gravity`. Unit: kg/m³.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<Scalar>,
}

#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Physical surfaces; a list forms one region. Surfaces in no region are left out of the body.
    pub group: Names,
    /// `fem` or `peridynamics`.
    pub model: RegionModel,
    /// A key of `materials`.
    pub material: String,
    /// dx of the lattice. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing: Option<Scalar>,
    /// δ: without a unit in spacings (`4`), with one a length (`10 mm`); 2 to 20 spacings. Unit:
    /// spacings, or m with a unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub horizon: Option<Scalar>,
    /// g(ξ/δ): `quartic`, `constant`, `linear`, `parabolic`, `inverse`
    /// ([table](method.md#1-kernel-and-micromodulus)). Default: `quartic`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernel: Option<Kernel>,
    /// `cell-centred`: no point on the boundary; `grid-nodes`: first and last rows on it. Default:
    /// `cell-centred`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Points>,
    /// Of the lattice's first axis to x, counter-clockwise: `20 deg`, or radians. By default that of
    /// the straight sides which, with those at right angles to them, are the longest, so that a
    /// turned rectangle has a turned lattice; 0 where there are none
    /// ([rule](method.md#4-material-points)). `angle: 0` keeps it upright. Regions that touch have
    /// one lattice, and an angle that one of them gives holds for all. Unit: rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<Scalar>,
    /// A corner of the lattice's squares: `[0 mm, 0.2 mm]`. By default: lower left of the region's
    /// box, seen along the lattice; where dx does not divide the box, such that both ends are cut
    /// alike. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub origin: Option<[Scalar; 2]>,
    /// `clipped`: the areas sum to the region's; `full`: dx² each, as the paper. Default: `clipped`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cell_area: Option<CellArea>,
    /// Share of a neighbour at the edge of the horizon: `full` (FA, the paper's) or `hhb`. Default:
    /// `full`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub partial_area: Option<PartialArea>,
    /// `isotropised`: c(ξ) with two coefficients that give the lattice the material's moduli in every
    /// direction ([equations](method.md#isotropised-micromodulus)); `raw`: without, as the paper.
    /// Default: `isotropised`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub micromodulus: Option<Micromodulus>,
    /// Stiffness of bonds near free surfaces ([equations](method.md#surface-correction)): `none` (the
    /// paper's), `volume`, `energy`, `force`, `least-squares` (exact in tension along edges parallel
    /// to the lattice). Default: `force`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface_correction: Option<SurfaceCorrection>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RegionModel {
    Fem,
    Peridynamics,
}

#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kernel {
    Quartic,
    Constant,
    Linear,
    Parabolic,
    Inverse,
}

#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Points {
    CellCentred,
    GridNodes,
}

#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum CellArea {
    Full,
    Clipped,
}

#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PartialArea {
    Full,
    Hhb,
}

#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Micromodulus {
    Isotropised,
    Raw,
}

#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SurfaceCorrection {
    None,
    Volume,
    Energy,
    Force,
    LeastSquares,
}

/// `clip`, `splice`, `truss`, or `truss: { node_area: … }`.
#[derive(Clone, Debug)]
pub enum Coupling {
    Truss(Truss),
    Clip,
    Splice,
}

/// The words that `coupling` knows.
const COUPLINGS: &[&str] = &["truss", "clip", "splice"];

#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Truss {
    /// A_FE: `lumped`, `half-edge` ([definitions](method.md#6-truss-coupling)), or one area for all
    /// nodes, such as `12.5 mm^2`. Unit: m².
    #[serde(default = "lumped")]
    pub node_area: Scalar,
    /// Whether a truss breaks, by the limit of the material at its point.
    #[serde(default)]
    pub breakable: bool,
}

fn lumped() -> Scalar {
    Scalar("lumped".to_owned())
}

impl Default for Coupling {
    fn default() -> Coupling {
        Coupling::Truss(Truss {
            node_area: lumped(),
            breakable: false,
        })
    }
}

impl JsonSchema for Coupling {
    fn schema_name() -> Cow<'static, str> {
        "Coupling".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let truss = generator.subschema_for::<Truss>();
        json_schema!({
            "description": "How finite elements are tied to material points",
            "oneOf": [
                { "enum": COUPLINGS },
                {
                    "type": "object",
                    "properties": { "truss": truss },
                    "required": ["truss"],
                    "additionalProperties": false
                }
            ]
        })
    }
}

impl Serialize for Coupling {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Coupling::Truss(truss) => {
                let mut map = serializer.serialize_map(Some(1))?;
                map.serialize_entry("truss", truss)?;
                map.end()
            }
            Coupling::Clip => serializer.serialize_str("clip"),
            Coupling::Splice => serializer.serialize_str("splice"),
        }
    }
}

impl<'de> Deserialize<'de> for Coupling {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Coupling, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = Coupling;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("`clip`, `splice`, `truss` or `truss: { node_area: … }`")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Coupling, E> {
                match text {
                    "truss" => Ok(Coupling::default()),
                    "clip" => Ok(Coupling::Clip),
                    "splice" => Ok(Coupling::Splice),
                    _ => Err(E::unknown_variant(text, COUPLINGS)),
                }
            }

            fn visit_map<A: de::MapAccess<'de>>(self, mut map: A) -> Result<Coupling, A::Error> {
                let mut truss = None;
                while let Some(key) = map.next_key::<String>()? {
                    match key.as_str() {
                        "truss" => truss = Some(map.next_value()?),
                        _ => return Err(de::Error::unknown_field(&key, &["truss"])),
                    }
                }
                truss
                    .map(Coupling::Truss)
                    .ok_or_else(|| de::Error::missing_field("truss"))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Boundary {
    /// A physical curve or point ([what it acts on](method.md#7-supports-and-loads)); for
    /// `body_force` a surface.
    #[serde(deserialize_with = "name")]
    #[schemars(schema_with = "name_schema")]
    pub group: String,
    /// Prescribed components; what is not named is free. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement: Option<Displacement>,
    /// Force per area in fixed directions; what is not named is 0. Curves only. Unit: Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub traction: Option<Components>,
    /// Acts against the outward normal; negative pulls. Curves only. Unit: Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Scalar>,
    /// In all, on a curve (shared along it) or on a point. In a peridynamic region a force on a point
    /// is spread over the points within δ ([how](method.md#7-supports-and-loads)). Unit: N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<Components>,
    /// On a physical surface. Unit: N/m³.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body_force: Option<Components>,
    /// The phase of `loading.phases` that applies it; the other phases hold its displacements where
    /// they are. Without it: a support, the same in all phases.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<String>,
}

#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Components {
    /// Along x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<Scalar>,
    /// Along y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<Scalar>,
}

/// Along x and y, or along axes turned by `angle`; or along the curve's normal and tangent.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Displacement {
    /// Along x, or along x turned by `angle`. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<Scalar>,
    /// Along y, or along y turned by `angle`. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<Scalar>,
    /// Turns the directions of `x` and `y` counter-clockwise: `{ y: 0, angle: 30 deg }` is a roller
    /// on a slope of 30°. Default: 0. Unit: rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<Scalar>,
    /// Along the curve's outward normal, instead of `x` and `y`: `{ normal: 0 }` is a roller on a curve.
    /// Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<Scalar>,
    /// Along the curve with the body on the left, instead of `x` and `y`. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tangential: Option<Scalar>,
}

#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Gravity {
    /// Acceleration along x. Unit: m/s².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<Scalar>,
    /// Acceleration along y, such as `-9.81 m/s^2`. Unit: m/s².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<Scalar>,
    /// The phase of `loading.phases` in which the weight grows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<String>,
}

/// How the load grows while bonds break.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Loading {
    /// `one-pass`, `equilibrium` or `event-driven` ([controls](pipeline.md#controls)).
    pub control: Control,
    /// The most load steps, or events, from 1 on.
    pub steps: usize,
    /// `separated`: ends earlier, when the force falls under 2 % of its peak; `steps`: does not.
    #[serde(default)]
    pub until: Until,
    /// Under `equilibrium`, solves at one load.
    #[serde(default = "most_passes")]
    pub most_passes: usize,
    /// Δλ of a load step. Default: `1`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub increment: Option<Scalar>,
    /// λ at which the run ends; the last step is as short as it must be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<Scalar>,
    /// A [programme](pipeline.md#programmes) of several phases; `increment` and `to` then stand in
    /// the phases.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<Phase>,
    /// Load steps that another source reports, printed beside the result.
    #[serde(default, skip_serializing_if = "ReferenceSteps::is_empty")]
    pub reference: ReferenceSteps,
}

/// A part of the load that grows by itself while the others rest.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Phase {
    /// What `boundary` calls it.
    pub name: String,
    /// Δλ of a load step. Default: `1`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub increment: Option<Scalar>,
    /// λ at the phase's end, where the next one begins; only the last phase may do without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<Scalar>,
}

/// Steps that another source reports.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceSteps {
    /// The load step of the first break.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_break: Option<usize>,
    /// The load step at which the body is in two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub separated: Option<usize>,
}

impl ReferenceSteps {
    fn is_empty(&self) -> bool {
        self.first_break.is_none() && self.separated.is_none()
    }
}

fn most_passes() -> usize {
    1000
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Control {
    OnePass,
    Equilibrium,
    EventDriven,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Until {
    #[default]
    Separated,
    Steps,
}

/// A displacement to report.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Must lie in the box around the body; the nearest element node or material point is read, and
    /// `summary.json` tells where that is. Unit: m.
    pub at: [Scalar; 2],
    /// `x` or `y`.
    pub component: Component,
    /// What it should be: the error against it is reported. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<Scalar>,
}

#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Component {
    X,
    Y,
}

#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Of `displacement`, `stress`, `strain`.
    pub fields: Vec<OutputField>,
    /// Of a fracture run: a frame at every so many steps. The start, the first break and the end
    /// always have one.
    pub every: usize,
    /// Write bonds and trusses as lines.
    pub bonds: bool,
    /// Which pictures are drawn: of `mesh`, `displacement-x`, `displacement-y`, `stress-xx`,
    /// `stress-yy`, `stress-xy`, `principal-stress` (the largest), `von-mises`, `damage`,
    /// `load-displacement`, `energies`. `true`: all but `von-mises`.
    pub pictures: Pictures,
    /// Steps of a fracture run whose damage is drawn, as `damage_000057.png`; they have a frame,
    /// whatever `every` says. A step that the run does not come to gives a note.
    pub pictures_at: Vec<usize>,
    /// Of the pictures: `png`, `svg`.
    pub formats: Vec<Format>,
    /// Of a fracture run: `crack.gif`. Default: as `pictures`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub animation: Option<bool>,
    /// `report.html`. Default: as `pictures`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub report: Option<bool>,
}

impl Default for Output {
    fn default() -> Output {
        use OutputField::{Displacement, Strain, Stress};
        Output {
            fields: vec![Displacement, Stress, Strain],
            every: 1,
            bonds: false,
            pictures: Pictures::Usual,
            pictures_at: Vec::new(),
            formats: vec![Format::Png],
            animation: None,
            report: None,
        }
    }
}

impl Output {
    /// The formats, each once.
    pub fn formats(&self) -> Vec<Format> {
        let all = [Format::Png, Format::Svg].into_iter();
        all.filter(|format| self.formats.contains(format)).collect()
    }

    pub fn is_animated(&self) -> bool {
        self.animation.unwrap_or(self.pictures != Pictures::None)
    }

    pub fn is_reported(&self) -> bool {
        self.report.unwrap_or(self.pictures != Pictures::None)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputField {
    Displacement,
    Stress,
    Strain,
}

/// A study of many runs.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// What is varied, as `--set` names it, and the values.
    pub over: BTreeMap<String, Values>,
    /// `crossed`: every value with every other; `zipped`: the first of each, the second of each.
    #[serde(default)]
    pub combine: Combine,
}

/// How the values of several parameters are combined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Combine {
    /// Every value with every other.
    #[default]
    Crossed,
    /// The first of each, the second of each, …
    Zipped,
}

/// A list, or a range.
#[derive(Clone, Debug, JsonSchema, Serialize)]
#[serde(untagged)]
pub enum Values {
    List(Vec<Scalar>),
    Range(Range),
}

/// `count` values from `from` to `to`, both included.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// The first value.
    pub from: Scalar,
    /// The last value.
    pub to: Scalar,
    /// How many, both ends included.
    pub count: usize,
    /// What is equal between neighbours: `linear`: the difference; `log`: the ratio.
    #[serde(default)]
    pub scale: Scale,
}

/// What is the same between two values of a range that follow each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// The difference.
    #[default]
    Linear,
    /// The ratio.
    Log,
}

impl<'de> Deserialize<'de> for Values {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Values, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = Values;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str(
                    "a list of values, or a range such as `{ from: 1 mm, to: 2 mm, count: 5 }`",
                )
            }

            fn visit_seq<A: de::SeqAccess<'de>>(self, mut list: A) -> Result<Values, A::Error> {
                let mut values = Vec::new();
                while let Some(value) = list.next_element()? {
                    values.push(value);
                }
                Ok(Values::List(values))
            }

            fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<Values, A::Error> {
                Range::deserialize(de::value::MapAccessDeserializer::new(map)).map(Values::Range)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// A physical group: one without a name goes by its number.
struct Name(String);

impl<'de> Deserialize<'de> for Name {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Name, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = Name;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a group's name")
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<Name, E> {
                Ok(Name(name.to_owned()))
            }

            fn visit_u64<E: de::Error>(self, tag: u64) -> Result<Name, E> {
                Ok(Name(tag.to_string()))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

fn name<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    Name::deserialize(deserializer).map(|Name(name)| name)
}

/// A name, or the number of a group without one.
fn name_schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": ["string", "integer"] })
}

/// One name or a list of them.
#[derive(Clone, Debug, Serialize)]
#[serde(transparent)]
pub struct Names(pub Vec<String>);

impl JsonSchema for Names {
    fn schema_name() -> Cow<'static, str> {
        "Names".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "oneOf": [
                { "type": ["string", "integer"] },
                { "type": "array", "items": name_schema(generator), "minItems": 1 }
            ]
        })
    }
}

impl<'de> Deserialize<'de> for Names {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Names, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = Names;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a group's name or a list of them")
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<Names, E> {
                Ok(Names(vec![name.to_owned()]))
            }

            fn visit_u64<E: de::Error>(self, tag: u64) -> Result<Names, E> {
                Ok(Names(vec![tag.to_string()]))
            }

            fn visit_seq<A: de::SeqAccess<'de>>(self, mut list: A) -> Result<Names, A::Error> {
                let mut names = Vec::new();
                while let Some(Name(name)) = list.next_element()? {
                    names.push(name);
                }
                if names.is_empty() {
                    Err(de::Error::invalid_length(0, &self))
                } else {
                    Ok(Names(names))
                }
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// A number, a quantity or a word, kept as it is written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Scalar(pub String);

impl JsonSchema for Scalar {
    fn schema_name() -> Cow<'static, str> {
        "Scalar".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number, or a quantity with its unit, such as `30 GPa`; a bare number is SI",
            "type": ["number", "string"]
        })
    }
}

impl<'de> Deserialize<'de> for Scalar {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Scalar, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = Scalar;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number or a quantity such as `30 GPa`")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Scalar, E> {
                Ok(Scalar(text.to_owned()))
            }

            fn visit_i64<E: de::Error>(self, number: i64) -> Result<Scalar, E> {
                Ok(Scalar(number.to_string()))
            }

            fn visit_u64<E: de::Error>(self, number: u64) -> Result<Scalar, E> {
                Ok(Scalar(number.to_string()))
            }

            fn visit_f64<E: de::Error>(self, number: f64) -> Result<Scalar, E> {
                Ok(Scalar(number.to_string()))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}
