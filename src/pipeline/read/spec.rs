//! The pipeline file as it is written (YAML): raw text for every quantity, no unknown key.

mod boundary;
mod coupling;
mod loading;
mod names;
mod output;
mod pictures;
mod region;
mod scalar;
mod sweep;

pub use boundary::{Boundary, Components, Displacement, Gravity, Position};
pub use coupling::{Coupling, Truss};
pub use loading::{Control, Loading, Phase, ReferenceSteps, Until};
pub use names::{Name, Names};
pub use output::{Component, Output, OutputField, Probe};
pub use pictures::{Format, PictureKind, Pictures};
pub use region::{Micromodulus, Region, RegionModel};
pub use scalar::Scalar;
pub use sweep::{Combine, Range, Scale, Sweep, Values};

use crate::material::PlaneState;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A whole pipeline file.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Spec {
    /// Results go to `results/NAME/`; letters, digits, `_`, `-`, `.`, not beginning with a dot.
    pub name: String,
    /// The geometry.
    pub geometry: Geometry,
    /// `stress`: σ_zz = 0; `strain`: ε_zz = 0.
    #[serde(default)]
    pub plane: PlaneState,
    /// h_t; forces and reactions are for this thickness. Unit: m.
    #[serde(default = "one_metre")]
    pub thickness: Scalar,
    /// One entry for each material, under a name of your choice.
    pub materials: BTreeMap<String, Material>,
    /// The model and material of each physical surface.
    pub regions: Vec<Region>,
    /// Physical curves that sever bonds and trusses from the start ([rule](pipeline.md#cracks)).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cracks: Vec<Name>,
    /// Physical surfaces: a bond or truss with an end in one of them never breaks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub no_fail: Vec<String>,
    /// How interface nodes are tied to material points: `truss` ([settings](#truss)) or `clip`.
    /// [Which one](howto.md#choose-a-coupling).
    #[serde(default)]
    pub coupling: Coupling,
    /// Supports and loads; at least one displacement.
    pub boundary: Vec<Boundary>,
    /// The weight of every region whose material has a `density`: `{ y: -9.81 m/s^2 }`. As all
    /// loads it grows with λ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Gravity>,
    /// How the load grows while bonds break ([fracture](pipeline.md#fracture)). Without it: one
    /// elastic solve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loading: Option<Loading>,
    /// Displacements to report, under names of your choice.
    #[serde(default)]
    pub probes: BTreeMap<String, Probe>,
    /// The files to write.
    #[serde(default)]
    pub output: Output,
    /// A [study](pipeline.md#studies), for `peristitch sweep`; `run` ignores it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep: Option<Sweep>,
}

fn one_metre() -> Scalar {
    Scalar("1 m".to_owned())
}

/// The file with the body, its regions and boundaries.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Geometry {
    /// Geometry for Gmsh: `.geo`, `.geo_unrolled`, `.brep`, `.step`, `.stp`; a mesh of Gmsh: `.msh`
    /// (2.2, 4.1); or a [mesh of another program](pipeline.md#meshes-of-other-programs): `.inp`,
    /// `.bdf`, `.nas`, `.fem`, `.med`, `.vtu`, `.vtk`.
    pub file: String,
    /// Unit of length of the file, such as `mm`.
    #[serde(default = "metre")]
    pub unit: String,
    /// Values of the variables that a `.geo` defines by `DefineConstant[…]` or tests by
    /// `Exists(…)`; plain numbers in the geometry's own unit.
    #[serde(default)]
    pub parameters: BTreeMap<String, Scalar>,
    /// Whether a `.geo` may [run programs and write files](pipeline.md#a-geo-is-code). Default: `false`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub trust: bool,
}

fn metre() -> String {
    "m".to_owned()
}

/// A linear elastic material and its strength.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Young's modulus E > 0. Unit: Pa.
    pub young: Scalar,
    /// Poisson's ratio, −1 < ν < 1/2. Bonds alone have 1/3 in plane stress, 1/4 in plane strain; others
    /// take cells.
    pub poisson: Scalar,
    /// f_t > 0: a bond breaks at a stretch above f_t/E. Unit: Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tensile_strength: Option<Scalar>,
    /// f_c > 0: a bond breaks at a stretch below −f_c/E; needs `tensile_strength`. Without it
    /// compression breaks nothing. Unit: Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compressive_strength: Option<Scalar>,
    /// G0 > 0, instead of the strengths: a bond breaks at a stretch above √(G0/(c0 M3)),
    /// [scaled](method.md#isotropised-micromodulus) if `micromodulus` is `isotropised`. Unit: J/m².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_release_rate: Option<Scalar>,
    /// K_IC > 0, in place of `energy_release_rate`: G0 = K_IC²/E', with E' = E in plane stress and
    /// E/(1 − ν²) in plane strain. `1 MPa m^0.5`, `1 MPa√m`. Unit: Pa √m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fracture_toughness: Option<Scalar>,
    /// ρ > 0, for `gravity`. Unit: kg/m³.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<Scalar>,
}

impl Material {
    /// Whether its bonds break at some stretch.
    pub fn has_strength(&self) -> bool {
        self.tensile_strength.is_some()
            || self.energy_release_rate.is_some()
            || self.fracture_toughness.is_some()
    }
}
