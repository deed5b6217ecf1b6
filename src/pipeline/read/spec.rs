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

pub use boundary::{Boundary, Components, Displacement, Gravity};
pub use coupling::{Coupling, Truss};
pub use loading::{Control, Loading, Phase, ReferenceSteps, Until};
pub use names::Names;
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
    /// The file that is meshed or read.
    pub geometry: Geometry,
    /// `stress`: σ_zz = 0; `strain`: ε_zz = 0.
    #[serde(default)]
    pub plane: PlaneState,
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
    /// (bonds end where they cross the interface).
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

/// The body: where its regions and boundaries come from.
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
    /// Whether a `.geo` may [run programs and write files](pipeline.md#a-geo-is-code). Default: `false`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub trust: bool,
}

fn metre() -> String {
    "m".to_owned()
}

/// A linear elastic material, and what breaks its bonds.
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
