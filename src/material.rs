//! Isotropic linear elasticity in the plane.

use nalgebra::Matrix3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// State of plane bodies: what is zero in the third direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PlaneState {
    /// σ_zz = 0: thin plates.
    #[default]
    Stress,
    /// ε_zz = 0: long prisms.
    Strain,
}

impl PlaneState {
    /// The Poisson ratio that central forces allow (λ = μ): 1/3 in plane stress, 1/4 in plane strain.
    pub fn bond_based_poisson(self) -> f64 {
        match self {
            PlaneState::Stress => 1.0 / 3.0,
            PlaneState::Strain => 1.0 / 4.0,
        }
    }
}

/// Elastic constants of an isotropic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus E [Pa].
    pub young: f64,
    /// Poisson's ratio ν [-].
    pub poisson: f64,
}

/// Poisson's ratio of bonds may differ by this much from 1/3 or 1/4, so that 0.3333333 is accepted.
const POISSON_TOLERANCE: f64 = 1e-6;

/// An elastic constant that a material cannot have.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum MaterialError {
    #[error("Young's modulus {young} Pa is not positive")]
    YoungNotPositive { young: f64 },
    #[error("Poisson's ratio {poisson} is not between -1 and 1/2")]
    PoissonOutOfRange { poisson: f64 },
    /// Bonds are central forces, which leave no choice.
    #[error("Poisson's ratio is {poisson}, and bonds can only have {needed}")]
    PoissonOfBonds { poisson: f64, needed: f64 },
}

impl Material {
    /// Whether the constants are those of an elastic material.
    ///
    /// # Errors
    /// [`MaterialError::YoungNotPositive`], [`MaterialError::PoissonOutOfRange`].
    pub fn check(&self) -> Result<(), MaterialError> {
        let Material { young, poisson } = *self;
        if !(young > 0.0 && young.is_finite()) {
            return Err(MaterialError::YoungNotPositive { young });
        }
        if !(-1.0 < poisson && poisson < 0.5) {
            return Err(MaterialError::PoissonOutOfRange { poisson });
        }
        Ok(())
    }

    /// Whether a lattice of bonds can have this Poisson's ratio.
    ///
    /// # Errors
    /// [`MaterialError::PoissonOfBonds`].
    pub fn check_bond_based(&self, plane: PlaneState) -> Result<(), MaterialError> {
        let (poisson, needed) = (self.poisson, plane.bond_based_poisson());
        if (poisson - needed).abs() <= POISSON_TOLERANCE {
            return Ok(());
        }
        Err(MaterialError::PoissonOfBonds { poisson, needed })
    }

    /// E' of Irwin's G = K_I²/E' [Pa]: E in plane stress, E/(1 − ν²) in plane strain.
    pub fn plane_modulus(&self, plane: PlaneState) -> f64 {
        match plane {
            PlaneState::Stress => self.young,
            PlaneState::Strain => self.young / (1.0 - self.poisson * self.poisson),
        }
    }

    /// D of σ = D ε in Voigt order xx, yy, xy with the engineering shear strain γ_xy [Pa].
    pub fn elasticity(&self, plane: PlaneState) -> Matrix3<f64> {
        let Material {
            young: e,
            poisson: nu,
        } = *self;
        let shear = e / (2.0 * (1.0 + nu));
        let (c11, c12) = match plane {
            PlaneState::Stress => (e / (1.0 - nu * nu), e * nu / (1.0 - nu * nu)),
            PlaneState::Strain => {
                let c = e / ((1.0 + nu) * (1.0 - 2.0 * nu));
                (c * (1.0 - nu), c * nu)
            }
        };
        Matrix3::new(c11, c12, 0.0, c12, c11, 0.0, 0.0, 0.0, shear)
    }

    /// σ_zz from the in-plane stresses [Pa]: zero in plane stress, ν(σ_xx + σ_yy) in plane strain.
    pub fn out_of_plane_stress(&self, plane: PlaneState, xx: f64, yy: f64) -> f64 {
        match plane {
            PlaneState::Stress => 0.0,
            PlaneState::Strain => self.poisson * (xx + yy),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniaxial_stress_stretches_by_sigma_over_e() {
        let m = Material {
            young: 100e9,
            poisson: 1.0 / 3.0,
        };
        let strain = m
            .elasticity(PlaneState::Stress)
            .try_inverse()
            .expect("D is positive definite")
            * nalgebra::Vector3::new(1.05e6, 0.0, 0.0);
        // Two rounding errors of the 3 × 3 inverse.
        assert!((strain[0] - 1.05e-5).abs() < 1e-15 * 1.05e-5 * 10.0);
        assert!((strain[1] + 0.35e-5).abs() < 1e-15 * 1.05e-5 * 10.0);
    }

    #[test]
    fn bond_based_ratios_make_lame_constants_equal() {
        for plane in [PlaneState::Stress, PlaneState::Strain] {
            let d = Material {
                young: 1.0,
                poisson: plane.bond_based_poisson(),
            }
            .elasticity(plane);
            assert!(
                (d[(0, 1)] - d[(2, 2)]).abs() < 1e-15,
                "C12 = C66, {plane:?}"
            );
            assert!(
                (d[(0, 0)] - 3.0 * d[(0, 1)]).abs() < 1e-15,
                "C11 = 3 C12, {plane:?}"
            );
        }
    }
}
