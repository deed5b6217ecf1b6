//! `regions`: which surfaces are what, and the lattice of a peridynamic one.

use super::{Names, Scalar};
use crate::peridynamics::kernel::{Kernel, PartialArea};
use crate::peridynamics::lattice::{CellArea, Placement};
use crate::peridynamics::surface::SurfaceCorrection;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Surfaces of one material: finite elements, or material points, to which all keys from `spacing` on belong.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Physical surfaces; a list forms one region. Surfaces in no region are left out of the body.
    pub group: Names,
    /// Finite elements, or a lattice of material points.
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
    /// g(ξ/δ), how a bond's stiffness falls with its length
    /// ([table](method.md#1-kernel-and-micromodulus)). Default: `quartic`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernel: Option<Kernel>,
    /// `cell-centred`: no point on the boundary; `grid-nodes`: first and last rows on it. Default:
    /// `cell-centred`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Placement>,
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
    /// Share of a neighbour at the edge of the horizon: `full`: all of it (FA, the paper's); `hhb`:
    /// what reaches in. Default: `full`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub partial_area: Option<PartialArea>,
    /// `isotropised`: c(ξ) with two coefficients that give the lattice the material's moduli in every
    /// direction ([equations](method.md#isotropised-micromodulus)); `raw`: without, as the paper.
    /// Default: `isotropised`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub micromodulus: Option<Micromodulus>,
    /// Stiffness of bonds near free surfaces ([equations](method.md#surface-correction)): `none` is
    /// the paper's, `least-squares` exact in tension along edges parallel to the lattice. Default:
    /// `force`.
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
