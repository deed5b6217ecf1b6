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
    /// Results go to `results/NAME/`.
    pub name: String,
    pub geometry: Geometry,
    #[serde(default)]
    pub plane: Plane,
    #[serde(default = "one_metre")]
    pub thickness: Scalar,
    pub materials: BTreeMap<String, Material>,
    pub regions: Vec<Region>,
    /// Physical curves that sever the bonds they meet.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cracks: Vec<String>,
    /// Physical surfaces in which no bond breaks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub no_fail: Vec<String>,
    #[serde(default)]
    pub coupling: Coupling,
    pub boundary: Vec<Boundary>,
    /// Acts on all regions whose material has a density.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Gravity>,
    /// Absent: one elastic solve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loading: Option<Loading>,
    #[serde(default)]
    pub probes: BTreeMap<String, Probe>,
    #[serde(default)]
    pub output: Output,
    /// A study: values to run the rest of the file with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep: Option<Sweep>,
}

fn one_metre() -> Scalar {
    Scalar("1 m".to_owned())
}

#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Geometry {
    /// A `.geo` or `.msh`, relative to the pipeline file.
    pub file: String,
    /// The length that 1 stands for in the file.
    #[serde(default = "metre")]
    pub unit: String,
    /// `DefineConstant` values of the `.geo`.
    #[serde(default)]
    pub parameters: BTreeMap<String, Scalar>,
    /// Let the `.geo` run programs and write files.
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
    pub young: Scalar,
    pub poisson: Scalar,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tensile_strength: Option<Scalar>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compressive_strength: Option<Scalar>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_release_rate: Option<Scalar>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<Scalar>,
}

#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// One physical surface, or several that form one region.
    pub group: Names,
    pub model: RegionModel,
    pub material: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing: Option<Scalar>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub horizon: Option<Scalar>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernel: Option<Kernel>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Points>,
    /// From the x axis to the lattice's, such as `20 deg`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<Scalar>,
    /// A corner of the lattice's squares.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub origin: Option<[Scalar; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cell_area: Option<CellArea>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub partial_area: Option<PartialArea>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub micromodulus: Option<Micromodulus>,
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
    /// `lumped`, `half-edge` or an area.
    #[serde(default = "lumped")]
    pub node_area: Scalar,
    /// Whether trusses break as bonds do.
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
    /// A physical curve or point; for `body_force` a surface.
    #[serde(deserialize_with = "name")]
    #[schemars(schema_with = "name_schema")]
    pub group: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement: Option<Displacement>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub traction: Option<Components>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Scalar>,
    /// In all, on a curve or a point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<Components>,
    /// Per volume, on a surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body_force: Option<Components>,
    /// The phase of `loading.phases` that applies it; absent: a support in all of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<String>,
}

#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Components {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<Scalar>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<Scalar>,
}

/// Along x and y, or along axes turned by `angle`; or along the curve's normal and tangent.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Displacement {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<Scalar>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<Scalar>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<Scalar>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<Scalar>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tangential: Option<Scalar>,
}

#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Gravity {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<Scalar>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<Scalar>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<String>,
}

/// How the load grows while bonds break.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Loading {
    pub control: Control,
    /// Load steps, or events.
    pub steps: usize,
    #[serde(default)]
    pub until: Until,
    /// Under `control: equilibrium`, passes at one load.
    #[serde(default = "most_passes")]
    pub most_passes: usize,
    /// Δλ of a load step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub increment: Option<Scalar>,
    /// λ at which the run ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<Scalar>,
    /// One after the other; absent: one, of all that `boundary` says.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<Phase>,
    /// What others found, to be shown beside the result.
    #[serde(default, skip_serializing_if = "ReferenceSteps::is_empty")]
    pub reference: ReferenceSteps,
}

/// A part of the load that grows by itself while the others rest.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Phase {
    pub name: String,
    /// Δλ of a load step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub increment: Option<Scalar>,
    /// λ at the phase's end; only the last phase may do without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<Scalar>,
}

/// Steps that another source reports.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceSteps {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_break: Option<usize>,
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
    /// The nearest node or material point is read.
    pub at: [Scalar; 2],
    pub component: Component,
    /// What it should be.
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
    pub fields: Vec<OutputField>,
    /// A frame at every so many steps; the first break and the end always have one.
    pub every: usize,
    /// Write bonds and trusses as lines with their stretch.
    pub bonds: bool,
    /// Which pictures are drawn: `true`, the usual ones, `false`, none, or a list.
    pub pictures: Pictures,
    /// Steps of a fracture run whose damage is drawn; they have a frame.
    pub pictures_at: Vec<usize>,
    /// Of the pictures.
    pub formats: Vec<Format>,
    /// The damage of a fracture run's frames as a film; as `pictures` where it is not said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub animation: Option<bool>,
    /// All of it on one page; as `pictures` where it is not said.
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
    /// What is varied, such as `regions.1.spacing`, and over which values.
    pub over: BTreeMap<String, Values>,
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
    pub from: Scalar,
    pub to: Scalar,
    pub count: usize,
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
