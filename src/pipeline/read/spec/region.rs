//! `regions`: which surfaces are what, and the lattice of a peridynamic one.

use super::{Names, Scalar};
use crate::peridynamics::kernel::{Kernel, PartialArea};
use crate::peridynamics::lattice::{CellArea, Placement};
use crate::peridynamics::surface::SurfaceCorrection;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Surfaces of one material and one model. The keys from `spacing` on are for `peridynamics`.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Physical surfaces. Surfaces in no region are left out of the body.
    pub group: Names,
    /// Finite elements, or a lattice of material points.
    pub model: RegionModel,
    /// A key of `materials`.
    pub material: String,
    /// dx of the lattice. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing: Option<Scalar>,
    /// δ, 2 to 20 spacings: a number of spacings (`4`) or a length (`10 mm`). Unit: spacings or m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub horizon: Option<Scalar>,
    /// The [kernel](method.md#1-kernel-and-micromodulus) g(ξ/δ). Default: `quartic`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernel: Option<Kernel>,
    /// `cell-centred`: no point on the boundary; `grid-nodes`: the outer rows lie on it. Default:
    /// `cell-centred`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Placement>,
    /// Angle of the lattice to x, counter-clockwise, such as `20 deg`. By default the lattice
    /// follows the longest straight sides ([rule](method.md#4-material-points)). Regions that touch
    /// share one angle. Unit: rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<Scalar>,
    /// A corner of a square of the lattice: `[0 mm, 0.2 mm]`
    /// ([default](method.md#4-material-points)). Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub origin: Option<[Scalar; 2]>,
    /// `clipped`: the areas sum to the region's; `full`: dx² each, as in the paper. Default:
    /// `clipped`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cell_area: Option<CellArea>,
    /// [Share](method.md#3-partial-areas) of a neighbour at the edge of the horizon; `full` is the
    /// paper's. Default: `full`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub partial_area: Option<PartialArea>,
    /// `isotropised`: the lattice has the material's moduli in every direction
    /// ([equations](method.md#isotropised-micromodulus)); `raw`: as in the paper. Default:
    /// `isotropised`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub micromodulus: Option<Micromodulus>,
    /// [Correction](method.md#surface-correction) of bonds near free surfaces; `none` is the
    /// paper's. Default: `force`.
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
pub enum Micromodulus {
    Isotropised,
    Raw,
}
