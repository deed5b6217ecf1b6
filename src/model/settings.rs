//! Settings of a model and of its regions, and the values that they may have.

use crate::coupling::Coupling;
use crate::material::{Material, MaterialError, PlaneState};
use crate::peridynamics::kernel::{Kernel, Micromodulus, PartialArea};
use crate::peridynamics::lattice::LatticeSettings;
use crate::peridynamics::surface::SurfaceCorrection;
use thiserror::Error;

/// A part of the body: cells of the mesh, their material and their method.
#[derive(Clone, Debug)]
pub struct Region {
    pub name: String,
    /// Indices of the mesh's cells, ascending.
    pub cells: Vec<usize>,
    pub material: Material,
    pub method: Method,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    FiniteElements,
    Peridynamics(PeridynamicSettings),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeridynamicSettings {
    pub lattice: LatticeSettings,
    /// m = δ/dx [-].
    pub horizon_ratio: f64,
    pub kernel: Kernel,
    pub partial_area: PartialArea,
    /// Whether c(ξ) is corrected such that the lattice has the material's moduli.
    pub isotropised: bool,
    pub surface_correction: SurfaceCorrection,
}

/// Horizons of fewer spacings hold too few bonds for an isotropic material.
pub const SMALLEST_HORIZON: f64 = 2.0;
/// Larger families than these 1 250 neighbours are a slip of the pen.
pub const LARGEST_HORIZON: f64 = 20.0;

/// A value that a region's settings cannot have.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum SettingsError {
    #[error(transparent)]
    Material(#[from] MaterialError),
    #[error("the spacing {spacing} m is not positive")]
    SpacingNotPositive { spacing: f64 },
    #[error("the lattice's angle {angle} rad is not finite")]
    AngleNotFinite { angle: f64 },
    #[error("the lattice's origin ({x}, {y}) m is not finite")]
    OriginNotFinite { x: f64, y: f64 },
    #[error("the horizon is {ratio:.3} spacings, less than {least}")]
    HorizonTooSmall { ratio: f64, least: f64 },
    #[error("the horizon is {ratio:.3} spacings, more than {most}")]
    HorizonTooLarge { ratio: f64, most: f64 },
    #[error(
        "the surface correction by least squares knows bonds alone, whose Poisson's ratio is {poisson:.4}"
    )]
    LeastSquaresOfCells { poisson: f64 },
    #[error(
        "the clip needs a lattice with the finite elements' moduli, and a raw micromodulus has others: \
         0.6 % of a uniform strain would be wrong beside the interface"
    )]
    RawMicromodulusUnderClip,
}

impl Region {
    /// Whether material and method may be those of a region.
    ///
    /// # Errors
    /// The first value that may not.
    pub fn check(&self, settings: &ModelSettings) -> Result<(), SettingsError> {
        self.material.check()?;
        match self.method {
            Method::FiniteElements => Ok(()),
            Method::Peridynamics(lattice) => {
                lattice.check()?;
                let on_lattice = self.material.on_lattice(settings.plane);
                let correction = lattice.surface_correction;
                if correction == SurfaceCorrection::LeastSquares && !on_lattice.is_of_bonds() {
                    let poisson = settings.plane.bond_based_poisson();
                    return Err(SettingsError::LeastSquaresOfCells { poisson });
                }
                lattice.check_coupling(settings.coupling)
            }
        }
    }
}

impl PeridynamicSettings {
    /// Whether spacing, horizon, angle and origin may be those of a lattice.
    ///
    /// # Errors
    /// The first value that may not.
    pub fn check(&self) -> Result<(), SettingsError> {
        let LatticeSettings {
            spacing,
            angle,
            origin,
            ..
        } = self.lattice;
        if !(spacing > 0.0 && spacing.is_finite()) {
            return Err(SettingsError::SpacingNotPositive { spacing });
        }
        check_horizon(self.horizon_ratio)?;
        if !angle.is_finite() {
            return Err(SettingsError::AngleNotFinite { angle });
        }
        match origin {
            Some([x, y]) if !(x.is_finite() && y.is_finite()) => {
                Err(SettingsError::OriginNotFinite { x, y })
            }
            _ => Ok(()),
        }
    }

    /// Clipped bonds and finite elements must have one elasticity.
    ///
    /// # Errors
    /// [`SettingsError::RawMicromodulusUnderClip`].
    pub fn check_coupling(&self, coupling: Coupling) -> Result<(), SettingsError> {
        if coupling == Coupling::Clip && !self.isotropised {
            return Err(SettingsError::RawMicromodulusUnderClip);
        }
        Ok(())
    }

    /// c(ξ) of a material on this lattice.
    pub fn micromodulus(&self, material: &Material, plane: PlaneState) -> Micromodulus {
        let spacing = self.lattice.spacing;
        let raw = Micromodulus::new(
            self.kernel,
            self.partial_area,
            material,
            plane,
            self.horizon_ratio * spacing,
            spacing,
        );
        if self.isotropised {
            raw.isotropised()
        } else {
            raw
        }
    }
}

/// Settings of the whole model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelSettings {
    pub plane: PlaneState,
    /// h_t [m].
    pub thickness: f64,
    pub coupling: Coupling,
}

/// Whether m = δ/dx is within what a lattice can have.
///
/// # Errors
/// [`SettingsError::HorizonTooSmall`], [`SettingsError::HorizonTooLarge`].
pub fn check_horizon(ratio: f64) -> Result<(), SettingsError> {
    if ratio > LARGEST_HORIZON {
        let most = LARGEST_HORIZON;
        return Err(SettingsError::HorizonTooLarge { ratio, most });
    }
    // Not a number is neither.
    if ratio >= SMALLEST_HORIZON * (1.0 - 1e-9) {
        return Ok(());
    }
    let least = SMALLEST_HORIZON;
    Err(SettingsError::HorizonTooSmall { ratio, least })
}
