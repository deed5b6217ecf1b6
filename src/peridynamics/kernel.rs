//! The micromodulus c(ξ) = c0 g(ξ/δ), Qian et al. (2021), eqs. (8)–(10).
//!
//! c0 follows from equal energy densities: with M2 = ∫₀^δ g ξ² dξ the modulus of the family is
//! C12 = C66 = (π/8) c0 M2, and ν = 1/3 (plane stress) or 1/4 (plane strain) makes C12 = 3E/8 or 2E/5. For another ν
//! it is the part p of the elasticity that bonds can carry ([`crate::material::LatticeElasticity`]).

use super::isotropy::{self, Isotropy};
use crate::material::{Material, PlaneState};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// The kernel g(r), r = ξ/δ: how the long-range force fades with the bond's length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kernel {
    /// (1 − r²)², the improved PMB kernel of the paper, eq. (9).
    Quartic,
    /// 1, the prototype microelastic brittle (PMB) model.
    Constant,
    /// 1 − r.
    Linear,
    /// 1 − r².
    Parabolic,
    /// 1/r.
    Inverse,
}

impl Kernel {
    pub const ALL: [Kernel; 5] = [
        Kernel::Quartic,
        Kernel::Constant,
        Kernel::Linear,
        Kernel::Parabolic,
        Kernel::Inverse,
    ];

    /// g(r) [-]. Past r = 1, which only partial areas reach, the kernels that fade to zero stay zero.
    pub fn value(self, r: f64) -> f64 {
        match self {
            Kernel::Quartic => (1.0 - r * r).max(0.0).powi(2),
            Kernel::Constant => 1.0,
            Kernel::Linear => (1.0 - r).max(0.0),
            Kernel::Parabolic => (1.0 - r * r).max(0.0),
            Kernel::Inverse => 1.0 / r,
        }
    }

    /// M3 / δ⁴ = ∫₀¹ g r³ dr [-].
    pub fn third_moment(self) -> f64 {
        match self {
            Kernel::Quartic => 1.0 / 24.0,
            Kernel::Constant => 1.0 / 4.0,
            Kernel::Linear => 1.0 / 20.0,
            Kernel::Parabolic => 1.0 / 12.0,
            Kernel::Inverse => 1.0 / 3.0,
        }
    }

    /// M2 / δ³ = ∫₀¹ g r² dr [-].
    pub fn second_moment(self) -> f64 {
        match self {
            Kernel::Quartic => 8.0 / 105.0,
            Kernel::Constant => 1.0 / 3.0,
            Kernel::Linear => 1.0 / 12.0,
            Kernel::Parabolic => 2.0 / 15.0,
            Kernel::Inverse => 1.0 / 2.0,
        }
    }
}

/// How much of a neighbour's area lies within the horizon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PartialArea {
    /// Full area (FA): all of it when its centre does. The paper's.
    Full,
    /// Hu, Ha & Bobaru: linear from one to zero as ξ goes from δ − dx/2 to δ + dx/2.
    Hhb,
}

/// c(ξ) of one material on one lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Micromodulus {
    pub kernel: Kernel,
    pub partial_area: PartialArea,
    /// δ [m].
    pub horizon: f64,
    /// Lattice spacing dx [m].
    pub spacing: f64,
    /// c0 per unit thickness [N/m⁵]; eq. (10) for the quartic kernel in plane stress.
    pub c0: f64,
    /// Correction of c(ξ) for the lattice's quadrature; [`Isotropy::RAW`] leaves it as it is.
    pub isotropy: Isotropy,
    /// The lattice's energy release rate over that of the continuum at one critical stretch; 1 where
    /// the kernel is raw [-].
    pub energy_release_ratio: f64,
}

/// Bonds a relative 1e-9 longer than the horizon belong to the family: lattice coordinates carry
/// rounding errors, and a bond of exactly δ must not depend on them.
const REACH_TOLERANCE: f64 = 1e-9;

impl Micromodulus {
    pub fn new(
        kernel: Kernel,
        partial_area: PartialArea,
        material: &Material,
        plane: PlaneState,
        horizon: f64,
        spacing: f64,
    ) -> Micromodulus {
        let young = material.on_lattice(plane).bond_young;
        let c12 = plane.bond_modulus();
        let c0 = 8.0 * c12 * young / (PI * kernel.second_moment() * horizon.powi(3));
        Micromodulus {
            kernel,
            partial_area,
            horizon,
            spacing,
            c0,
            isotropy: Isotropy::RAW,
            energy_release_ratio: 1.0,
        }
    }

    /// Replaces c(ξ) by the c*(ξ) that gives the lattice the material's moduli, see [`isotropy`], and sets the
    /// lattice's energy release rate.
    pub fn isotropised(mut self) -> Micromodulus {
        self.isotropy = Isotropy::RAW;
        self.isotropy = Isotropy::on_lattice(&self);
        self.energy_release_ratio = isotropy::energy_release_ratio(&self);
        self
    }

    /// The longest bond [m].
    pub fn reach(&self) -> f64 {
        let longest = match self.partial_area {
            PartialArea::Full => self.horizon,
            PartialArea::Hhb => self.horizon + 0.5 * self.spacing,
        };
        longest * (1.0 + REACH_TOLERANCE)
    }

    /// M2 = ∫₀^δ g ξ² dξ [m³].
    pub fn second_moment(&self) -> f64 {
        self.kernel.second_moment() * self.horizon.powi(3)
    }

    /// M3 [m⁴], which links the energy release rate to the critical stretch, G = c0 s0² M3: ∫₀^δ g ξ³ dξ,
    /// times the lattice's [`energy_release_ratio`](Self::energy_release_ratio) where it is isotropised.
    pub fn third_moment(&self) -> f64 {
        self.energy_release_ratio * self.kernel.third_moment() * self.horizon.powi(4)
    }

    /// The share of a neighbour's area that counts at the distance `xi` [-].
    pub fn area_fraction(&self, xi: f64) -> f64 {
        match self.partial_area {
            PartialArea::Full => 1.0,
            PartialArea::Hhb => {
                ((self.horizon + 0.5 * self.spacing - xi) / self.spacing).clamp(0.0, 1.0)
            }
        }
    }

    /// c(ξ) of a bond along `bond` = x_j − x_i [m], partial area and isotropisation included [N/m⁵].
    pub fn density(&self, bond: [f64; 2]) -> f64 {
        let xi = bond[0].hypot(bond[1]);
        let r = xi / self.horizon;
        // A bond of exactly δ, whatever the rounding errors: kernels that fade are zero there.
        let r = if (r - 1.0).abs() <= REACH_TOLERANCE {
            1.0
        } else {
            r
        };
        let c = self.c0 * self.kernel.value(r) * self.area_fraction(xi);
        c * self.isotropy.factor(bond)
    }

    /// Axial stiffness [N/m] of a bond or truss along `bond` = x_j − x_i [m], see [`axial_stiffness`].
    pub fn axial_stiffness(&self, bond: [f64; 2], areas: [f64; 2], thickness: f64) -> f64 {
        let xi = bond[0].hypot(bond[1]);
        axial_stiffness(self.density(bond), xi, areas, thickness)
    }
}

/// Axial stiffness k = c(ξ) A_i A_j h_t / ξ [N/m] of a bond or truss of the length ξ [m] with the micromodulus
/// c(ξ) [N/m⁵]; Qian et al. (2021), eqs. (17)–(20), which print force densities: times the two areas
/// and the thickness.
pub fn axial_stiffness(c: f64, xi: f64, areas: [f64; 2], thickness: f64) -> f64 {
    c * areas[0] * areas[1] * thickness / xi
}

#[cfg(test)]
mod tests {
    use super::*;

    fn micromodulus(kernel: Kernel, plane: PlaneState) -> Micromodulus {
        let material = Material {
            young: 1.0,
            poisson: plane.bond_based_poisson(),
        };
        Micromodulus::new(kernel, PartialArea::Full, &material, plane, 1.0, 0.25)
    }

    #[test]
    fn c0_of_every_kernel_and_plane_state_is_that_of_the_literature() {
        let expected = [
            (Kernel::Quartic, 315.0 / (8.0 * PI), 42.0 / PI),
            (Kernel::Constant, 9.0 / PI, 48.0 / (5.0 * PI)),
            (Kernel::Linear, 36.0 / PI, 192.0 / (5.0 * PI)),
            (Kernel::Parabolic, 45.0 / (2.0 * PI), 24.0 / PI),
            (Kernel::Inverse, 6.0 / PI, 32.0 / (5.0 * PI)),
        ];
        for (kernel, stress, strain) in expected {
            for (plane, c0) in [(PlaneState::Stress, stress), (PlaneState::Strain, strain)] {
                let relative = micromodulus(kernel, plane).c0 / c0 - 1.0;
                assert!(relative.abs() < 1e-15, "{kernel:?} {plane:?} {relative:e}");
            }
        }
    }

    /// ½ ∫ over the family of c ξ (n·ε·n)² / 2 by quadrature, against ½ ε:C:ε, for tension and shear.
    #[test]
    fn family_energy_equals_the_continuum_energy() {
        let strains = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.7, -0.4, 0.3]];
        for kernel in Kernel::ALL {
            for plane in [PlaneState::Stress, PlaneState::Strain] {
                let c = micromodulus(kernel, plane);
                let d = Material {
                    young: 1.0,
                    poisson: plane.bond_based_poisson(),
                }
                .elasticity(plane);
                for [xx, yy, gamma] in strains {
                    let voigt = nalgebra::Vector3::new(xx, yy, gamma);
                    let continuum = 0.5 * voigt.dot(&(d * voigt));
                    let stretch = |phi: f64| {
                        let (s, co) = phi.sin_cos();
                        xx * co * co + yy * s * s + gamma * s * co
                    };
                    let angular = midpoint(64, 0.0, 2.0 * PI, |phi| stretch(phi).powi(2));
                    let radial = midpoint(4000, 0.0, 1.0, |xi| c.c0 * kernel.value(xi) * xi * xi);
                    // The midpoint rule's error is 1/(24·4000²) times g'' of order ten.
                    let error = 0.25 * angular * radial / continuum - 1.0;
                    assert!(error.abs() < 1e-6, "{kernel:?} {plane:?}: {error:e}");
                }
            }
        }
    }

    fn midpoint(n: usize, from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
        let step = (to - from) / n as f64;
        (0..n)
            .map(|i| f(from + (i as f64 + 0.5) * step))
            .sum::<f64>()
            * step
    }

    #[test]
    fn a_bond_of_exactly_the_horizon_has_no_stiffness_under_a_fading_kernel() {
        for xi in [1.0 - 1e-15, 1.0, 1.0 + 1e-15] {
            for (kernel, fades) in [(Kernel::Quartic, true), (Kernel::Constant, false)] {
                let c = micromodulus(kernel, PlaneState::Stress);
                assert_eq!(
                    c.axial_stiffness([xi, 0.0], [1.0; 2], 1.0) == 0.0,
                    fades,
                    "{kernel:?}"
                );
            }
        }
    }

    #[test]
    fn hhb_fades_linearly_over_one_spacing() {
        let mut c = micromodulus(Kernel::Constant, PlaneState::Stress);
        c.partial_area = PartialArea::Hhb;
        let at = |xi| c.area_fraction(xi);
        assert_eq!(
            (at(0.875), at(1.0), at(1.125), at(0.3)),
            (1.0, 0.5, 0.0, 1.0)
        );
    }
}
