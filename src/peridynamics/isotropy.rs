//! The isotropised micromodulus: what makes the lattice's own moduli isotropic and exact.
//!
//! The sum over lattice points is a quadrature of the family's integral, and its error has the symmetry
//! of the square: C11 and C12 are off by different shares. Two coefficients,
//!
//! ```text
//! c*(ξ) = c(ξ) (a + b cos 4φ),   φ the bond's angle to the lattice's axis,
//! ```
//!
//! are found such that the lattice's C12 is (π/8) c0 M2 and its C11 three times that: 3E/8 and 9E/8 in
//! plane stress, 2E/5 and 6E/5 in plane strain. a and b depend on kernel, partial area and m = δ/dx alone.

use super::bonds::family_offsets;
use super::kernel::Micromodulus;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// The coefficients of a + b cos 4φ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Isotropy {
    /// a [-].
    pub mean: f64,
    /// b [-].
    pub fourfold: f64,
}

impl Isotropy {
    /// The kernel as it is.
    pub const RAW: Isotropy = Isotropy {
        mean: 1.0,
        fourfold: 0.0,
    };

    /// Makes a raw micromodulus isotropic on its lattice. Needs bonds along the axes and across, m ≥ √2.
    pub fn on_lattice(raw: &Micromodulus) -> Isotropy {
        // C11 and C12 per unit of a, and per unit of b.
        let (mut mean, mut fourfold) = ([0.0; 2], [0.0; 2]);
        for bond in neighbours(raw) {
            let terms = moduli_of(raw, bond);
            let cos = cos_of_four_angles(bond);
            for k in 0..2 {
                mean[k] += terms[k];
                fourfold[k] += terms[k] * cos;
            }
        }
        let c12 = PI / 8.0 * raw.c0 * raw.second_moment();
        let wanted = [3.0 * c12, c12];
        let determinant = mean[0] * fourfold[1] - mean[1] * fourfold[0];
        Isotropy {
            mean: (wanted[0] * fourfold[1] - wanted[1] * fourfold[0]) / determinant,
            fourfold: (mean[0] * wanted[1] - mean[1] * wanted[0]) / determinant,
        }
    }

    /// a + b cos 4φ of a bond along `bond`, of any length.
    pub fn factor(&self, bond: [f64; 2]) -> f64 {
        self.mean + self.fourfold * cos_of_four_angles(bond)
    }
}

/// C11 and C12 = C66 of the lattice in its own axes [Pa]: ½ Σ c ξ n⊗n⊗n⊗n A over a whole family.
pub fn lattice_moduli(micromodulus: &Micromodulus) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for bond in neighbours(micromodulus) {
        let terms = moduli_of(micromodulus, bond);
        (0..2).for_each(|k| sum[k] += terms[k]);
    }
    sum
}

/// The energy at s0 of the bonds across a straight cut, over c0 s0² M3: the mean of cuts along the axis
/// and at 45° [-].
///
/// A cut with the normal ν meets |ξ·ν|/dx² bonds ξ per length, so G = ¼ s0² Σ c ξ |ξ·ν| A. The two
/// directions are the ones that the lattice cuts at the least cost, and along which cracks run on it.
pub fn energy_release_ratio(micromodulus: &Micromodulus) -> f64 {
    let area = micromodulus.spacing * micromodulus.spacing;
    let across = |[x, y]: [f64; 2]| {
        let axis = y.abs();
        let diagonal = FRAC_1_SQRT_2 * (y - x).abs();
        0.5 * (axis + diagonal)
    };
    let rate: f64 = neighbours(micromodulus)
        .map(|bond| {
            let c = micromodulus.density(bond);
            0.25 * c * bond[0].hypot(bond[1]) * across(bond) * area
        })
        .sum();
    rate / (micromodulus.c0 * micromodulus.kernel.third_moment() * micromodulus.horizon.powi(4))
}

/// The bonds of an inner lattice point [m].
fn neighbours(micromodulus: &Micromodulus) -> impl Iterator<Item = [f64; 2]> {
    let dx = micromodulus.spacing;
    let offsets = family_offsets(micromodulus).into_iter();
    offsets.map(move |offset| offset.map(|steps| f64::from(steps) * dx))
}

fn moduli_of(micromodulus: &Micromodulus, bond: [f64; 2]) -> [f64; 2] {
    let [x, y] = bond;
    let xi = x.hypot(y);
    let area = micromodulus.spacing * micromodulus.spacing;
    let weight = 0.5 * micromodulus.density(bond) * area / xi.powi(3);
    [weight * x.powi(4), weight * x * x * y * y]
}

fn cos_of_four_angles([x, y]: [f64; 2]) -> f64 {
    let product = x * y / (x * x + y * y);
    1.0 - 8.0 * product * product
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Material, PlaneState};
    use crate::peridynamics::kernel::{Kernel, PartialArea};

    fn micromodulus(kernel: Kernel, partial_area: PartialArea, m: f64) -> Micromodulus {
        let plane = PlaneState::Stress;
        let material = Material {
            young: 1.0,
            poisson: plane.bond_based_poisson(),
        };
        Micromodulus::new(kernel, partial_area, &material, plane, m, 1.0)
    }

    /// Figures found apart from this program, to their last digit.
    #[test]
    fn coefficients_of_the_quartic_kernel() {
        for (m, a, b) in [
            (3.0, 1.02566, -0.11683),
            (4.0, 1.006556, -0.056812),
            (5.0, 1.003292, -0.033186),
        ] {
            let raw = micromodulus(Kernel::Quartic, PartialArea::Full, m);
            let found = Isotropy::on_lattice(&raw);
            let digit = if m == 3.0 { 0.5e-5 } else { 0.5e-6 };
            assert!((found.mean - a).abs() <= digit, "{m}: {found:?}");
            assert!((found.fourfold - b).abs() <= digit, "{m}: {found:?}");
        }
    }

    /// A bond of negative stiffness would make the lattice unstable. No kernel comes near, on any
    /// horizon that a pipeline may have: the least factor is 0.618, PMB's at m = 2.24. A new kernel for
    /// which this fails needs an error that sends its user to the raw one.
    #[test]
    fn no_bond_of_any_kernel_loses_its_stiffness() {
        let mut least = f64::INFINITY;
        for kernel in Kernel::ALL {
            for partial_area in [PartialArea::Full, PartialArea::Hhb] {
                for step in 0..=1800 {
                    let raw = micromodulus(kernel, partial_area, 2.0 + 0.01 * f64::from(step));
                    let isotropy = Isotropy::on_lattice(&raw);
                    let stiff = neighbours(&raw).filter(|&bond| raw.density(bond) > 0.0);
                    least = stiff.map(|b| isotropy.factor(b)).fold(least, f64::min);
                }
            }
        }
        assert_eq!(format!("{least:.3}"), "0.618");
    }

    #[test]
    fn energy_release_rate_of_the_lattice() {
        for (m, raw_rate, isotropised_rate) in [(3.0, 0.97745, 1.0001), (4.0, 0.98980, 0.9961)] {
            let raw = micromodulus(Kernel::Quartic, PartialArea::Full, m);
            let found = energy_release_ratio(&raw);
            // Means of the two directions' figures, printed to 1e-4 each.
            assert!((found - raw_rate).abs() < 1e-4, "{m}: {found}");
            let found = energy_release_ratio(&raw.isotropised());
            assert!((found - isotropised_rate).abs() < 1e-4, "{m}: {found}");
        }
    }
}
