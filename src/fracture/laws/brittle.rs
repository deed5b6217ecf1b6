//! The brittle law, Qian et al. (2021), eqs. (5) and (6), in tension and in compression: a bond keeps
//! φ = 1 up to its critical stretch and has φ = 0 from there on.

use super::{BondLaw, Strength, StretchLimits};
use crate::peridynamics::kernel::Micromodulus;
use std::sync::Arc;

/// A bond that breaks at its critical stretch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brittle {
    /// Critical stretches s_t and s_c.
    pub limits: StretchLimits,
}

impl Brittle {
    /// Never breaks.
    pub const UNBREAKABLE: Brittle = Brittle {
        limits: StretchLimits::NONE,
    };

    /// The law of a material with Young's modulus `young` [Pa].
    pub fn new(strength: Strength, young: f64, micromodulus: &Micromodulus) -> Brittle {
        let limits = match strength {
            Strength::Stress {
                tensile,
                compressive,
            } => StretchLimits {
                tension: tensile / young,
                compression: compressive.map_or(f64::INFINITY, |f_c| f_c / young),
            },
            Strength::EnergyReleaseRate(g0) => StretchLimits {
                tension: (g0 / (micromodulus.c0 * micromodulus.third_moment())).sqrt(),
                compression: f64::INFINITY,
            },
        };
        Brittle { limits }
    }

    /// The law of the part t < 1 of a bond's length: at s_c/√t it takes the energy of the whole bond,
    /// ½ (k/t)(t ξ s)² = ½ k ξ² s_c², so that a crack beside an interface costs what it costs elsewhere.
    /// Clipped bonds longer than their bond keep its limits.
    pub fn part(self, t: f64) -> Brittle {
        let factor = t.min(1.0).sqrt().recip();
        Brittle {
            limits: StretchLimits {
                tension: factor * self.limits.tension,
                compression: factor * self.limits.compression,
            },
        }
    }
}

impl BondLaw for Brittle {
    fn limits(&self, integrity: f64) -> StretchLimits {
        match integrity > 0.0 {
            true => self.limits,
            false => StretchLimits::NONE,
        }
    }

    fn next(&self, _: f64, _: f64) -> f64 {
        0.0
    }

    fn of_part(&self, t: f64) -> Arc<dyn BondLaw> {
        Arc::new(self.part(t))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Material, PlaneState};
    use crate::peridynamics::kernel::{Kernel, PartialArea};
    use std::f64::consts::PI;

    /// s0² in units of G0/(Eδ), for plane stress and plane strain (handbook, section 1).
    #[test]
    fn critical_stretch_from_the_energy_release_rate_for_every_kernel() {
        let table = [
            (Kernel::Quartic, 64.0 * PI / 105.0, 4.0 * PI / 7.0),
            (Kernel::Constant, 4.0 * PI / 9.0, 5.0 * PI / 12.0),
            (Kernel::Linear, 5.0 * PI / 9.0, 25.0 * PI / 48.0),
            (Kernel::Parabolic, 8.0 * PI / 15.0, PI / 2.0),
            (Kernel::Inverse, PI / 2.0, 15.0 * PI / 32.0),
        ];
        for (kernel, stress, strain) in table {
            for (plane, expected) in [(PlaneState::Stress, stress), (PlaneState::Strain, strain)] {
                let material = Material {
                    young: 3.0,
                    poisson: plane.bond_based_poisson(),
                };
                let c = Micromodulus::new(kernel, PartialArea::Full, &material, plane, 0.5, 0.1);
                let strength = Strength::EnergyReleaseRate(0.7);
                let s0 = Brittle::new(strength, 3.0, &c).limits.tension;
                let unit = 0.7 / (3.0 * 0.5);
                // A square root and five products.
                assert!(
                    (s0 * s0 / unit / expected - 1.0).abs() < 1e-15,
                    "{kernel:?} {plane:?}"
                );
            }
        }
    }

    const LIMITS: StretchLimits = StretchLimits {
        tension: 1.0,
        compression: 10.0,
    };

    #[test]
    fn a_part_of_a_bond_takes_the_energy_of_the_whole() {
        let law = Brittle { limits: LIMITS };
        let quarter = law.part(0.25).limits;
        assert_eq!((quarter.tension, quarter.compression), (2.0, 20.0));
        assert_eq!(law.part(1.2), law);
        assert_eq!(Brittle::UNBREAKABLE.part(0.25), Brittle::UNBREAKABLE);
    }

    #[test]
    fn both_branches_break() {
        assert!(LIMITS.is_exceeded(1.1) && LIMITS.is_exceeded(-10.1));
        assert!(!LIMITS.is_exceeded(0.9) && !LIMITS.is_exceeded(-9.9));
        assert_eq!(LIMITS.utilisation(0.5), 0.5);
        assert_eq!(LIMITS.utilisation(-0.5), 0.05);
        assert_eq!(StretchLimits::NONE.utilisation(-3.0), 0.0);
        let law = Brittle { limits: LIMITS };
        assert_eq!([law.next(1.0, 1.0), law.next(1.0, -10.0)], [0.0; 2]);
        assert_eq!(law.limits(0.0), StretchLimits::NONE);
    }
}
