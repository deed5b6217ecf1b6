//! When a bond breaks: Qian et al. (2021), eqs. (5) and (6), in both branches.

use crate::peridynamics::kernel::Micromodulus;

/// The stretches that a bond survives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalStretch {
    /// Breaks above this elongation [-].
    pub tension: f64,
    /// Breaks below minus this; infinite where compression does not break [-].
    pub compression: f64,
}

/// How the critical stretch of a material is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Strength {
    /// s_t = f_t/E, s_c = f_c/E, eq. (6): the energy release rate depends on the horizon.
    Stress {
        /// f_t [Pa].
        tensile: f64,
        /// f_c [Pa]; `None`: compression does not break.
        compressive: Option<f64>,
    },
    /// G0 = c0 s0² M3 [J/m²]: the strength depends on the horizon.
    EnergyReleaseRate(f64),
}

impl CriticalStretch {
    /// Never breaks.
    pub const UNBREAKABLE: CriticalStretch = CriticalStretch {
        tension: f64::INFINITY,
        compression: f64::INFINITY,
    };

    /// `young` is E [Pa].
    pub fn new(strength: Strength, young: f64, micromodulus: &Micromodulus) -> CriticalStretch {
        match strength {
            Strength::Stress {
                tensile,
                compressive,
            } => CriticalStretch {
                tension: tensile / young,
                compression: compressive.map_or(f64::INFINITY, |f_c| f_c / young),
            },
            Strength::EnergyReleaseRate(g0) => CriticalStretch {
                tension: (g0 / (micromodulus.c0 * micromodulus.third_moment())).sqrt(),
                compression: f64::INFINITY,
            },
        }
    }

    /// The limits of what an interface leaves of a bond, the part t < 1 of its length: at s_c/√t it takes
    /// the energy of the whole bond, ½ (k/t)(t ξ s)² = ½ k ξ² s_c², so that a crack beside an interface
    /// costs what it costs elsewhere. Springs longer than a bond keep its limits.
    pub fn of_part(self, t: f64) -> CriticalStretch {
        let factor = t.min(1.0).sqrt().recip();
        CriticalStretch {
            tension: factor * self.tension,
            compression: factor * self.compression,
        }
    }

    /// The limits of a bond that breaks when either of two would.
    pub fn weaker(self, other: CriticalStretch) -> CriticalStretch {
        CriticalStretch {
            tension: self.tension.min(other.tension),
            compression: self.compression.min(other.compression),
        }
    }

    /// Eq. (5): whether the bond breaks at the stretch `s`.
    pub fn is_exceeded(&self, s: f64) -> bool {
        s > self.tension || s < -self.compression
    }

    /// The stretch over the limit of its sign: above one the bond breaks [-].
    pub fn utilisation(&self, s: f64) -> f64 {
        match s > 0.0 {
            true => s / self.tension,
            false => -s / self.compression,
        }
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
                let s0 = CriticalStretch::new(Strength::EnergyReleaseRate(0.7), 3.0, &c).tension;
                let unit = 0.7 / (3.0 * 0.5);
                // A square root and five products.
                assert!(
                    (s0 * s0 / unit / expected - 1.0).abs() < 1e-15,
                    "{kernel:?} {plane:?}"
                );
            }
        }
    }

    #[test]
    fn a_part_of_a_bond_takes_the_energy_of_the_whole() {
        let limit = CriticalStretch {
            tension: 1.0,
            compression: 10.0,
        };
        let quarter = limit.of_part(0.25);
        assert_eq!((quarter.tension, quarter.compression), (2.0, 20.0));
        assert_eq!(limit.of_part(1.2), limit);
        let unbreakable = CriticalStretch::UNBREAKABLE;
        assert_eq!(unbreakable.of_part(0.25), unbreakable);
    }

    #[test]
    fn both_branches_break() {
        let limit = CriticalStretch {
            tension: 1.0,
            compression: 10.0,
        };
        assert!(limit.is_exceeded(1.1) && limit.is_exceeded(-10.1));
        assert!(!limit.is_exceeded(0.9) && !limit.is_exceeded(-9.9));
        assert_eq!(limit.utilisation(0.5), 0.5);
        assert_eq!(limit.utilisation(-0.5), 0.05);
        assert_eq!(CriticalStretch::UNBREAKABLE.utilisation(-3.0), 0.0);
    }
}
