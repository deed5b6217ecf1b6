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
    /// The Poisson's ratio that central forces have (λ = μ): 1/3 in plane stress, 1/4 in plane strain.
    pub fn bond_based_poisson(self) -> f64 {
        match self {
            PlaneState::Stress => 1.0 / 3.0,
            PlaneState::Strain => 1.0 / 4.0,
        }
    }

    /// C12 = C66 over Young's modulus for central forces [-].
    pub fn bond_modulus(self) -> f64 {
        match self {
            PlaneState::Stress => 3.0 / 8.0,
            PlaneState::Strain => 2.0 / 5.0,
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

/// Poisson's ratio may differ by this much from 1/3 or 1/4 and count as that, so that 0.3333333 needs no cells.
const POISSON_TOLERANCE: f64 = 1e-6;

/// An elastic constant that a material cannot have.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum MaterialError {
    #[error("Young's modulus {young} Pa is not positive")]
    YoungNotPositive { young: f64 },
    #[error("Poisson's ratio {poisson} is not between -1 and 1/2")]
    PoissonOutOfRange { poisson: f64 },
}

/// Elasticity of a lattice, in its two parts: axial bonds, λ = μ = p, and cells,
///
/// ```text
/// W = ½ κ (ε_x + ε_y)² + ½ μ_D [(ε_x − ε_y)² + γ²]
/// ```
///
/// p is the largest for which the rest is not negative, p = min(μ, (λ + μ)/2) with λ = C12: above the Poisson's
/// ratio of bonds the rest is an area modulus κ = λ − μ, below it a deviator μ_D = (μ − λ)/2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticeElasticity {
    /// Young's modulus that the bonds alone have, with their own Poisson's ratio [Pa].
    pub bond_young: f64,
    /// Area modulus κ of the cells [Pa].
    pub area: f64,
    /// Deviator μ_D of the cells [Pa].
    pub deviator: f64,
}

impl LatticeElasticity {
    /// Whether bonds alone are enough.
    pub fn is_of_bonds(&self) -> bool {
        self.area == 0.0 && self.deviator == 0.0
    }
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

    /// The elasticity of a lattice of this material, in its two parts.
    pub fn on_lattice(&self, plane: PlaneState) -> LatticeElasticity {
        if (self.poisson - plane.bond_based_poisson()).abs() <= POISSON_TOLERANCE {
            return LatticeElasticity {
                bond_young: self.young,
                area: 0.0,
                deviator: 0.0,
            };
        }
        let d = self.elasticity(plane);
        let (lambda, mu) = (d[(0, 1)], d[(2, 2)]);
        LatticeElasticity {
            bond_young: mu.min(0.5 * (lambda + mu)) / plane.bond_modulus(),
            area: (lambda - mu).max(0.0),
            deviator: 0.5 * (mu - lambda).max(0.0),
        }
    }

    /// The share of a modulus that the cells of a lattice carry: of the shear modulus below the
    /// Poisson's ratio of bonds, of the area modulus above it [-].
    pub fn cell_share(&self, plane: PlaneState) -> f64 {
        let LatticeElasticity { area, deviator, .. } = self.on_lattice(plane);
        let d = self.elasticity(plane);
        deviator / d[(2, 2)] + area / (0.5 * (d[(0, 0)] + d[(0, 1)]))
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

    /// C12 = C66 = p and C11 = 3 p of the bonds, and the two parts of the cells, are D; and the rest vanishes
    /// in the limit of the ratio of bonds, from both sides.
    #[test]
    fn bonds_and_cells_together_are_the_material() {
        for plane in [PlaneState::Stress, PlaneState::Strain] {
            for poisson in [-0.9, 0.0, 0.1, 0.2, 0.3, 0.4, 0.45, 0.49] {
                let material = Material {
                    young: 3.0,
                    poisson,
                };
                let parts = material.on_lattice(plane);
                let p = plane.bond_modulus() * parts.bond_young;
                let (k, g) = (parts.area, parts.deviator);
                let sum = Matrix3::new(
                    3.0 * p + k + g,
                    p + k - g,
                    0.0,
                    p + k - g,
                    3.0 * p + k + g,
                    0.0,
                    0.0,
                    0.0,
                    p + g,
                );
                let d = material.elasticity(plane);
                // Some rounding errors of the largest modulus.
                assert!(
                    (sum - d).amax() < 1e-15 * 4.0 * d.amax(),
                    "{plane:?} {poisson}"
                );
                assert!(p > 0.0 && k >= 0.0 && g >= 0.0 && k * g == 0.0);
            }
            let nearly = Material {
                young: 1.0,
                poisson: plane.bond_based_poisson() + 1e-5,
            };
            assert!((nearly.on_lattice(plane).bond_young - 1.0).abs() < 1e-4);
        }
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
