//! Bond laws: how the integrity of an interaction changes with its stretch.
//!
//! Between two events every interaction is linear, f = φ k e, and its integrity φ stays. A [`BondLaw`]
//! gives the limits of that branch and the integrity after one of them has been reached. A change from φ
//! to φ' between two states of equilibrium, with the elongations e and e', takes the energy
//! [`released`]. A law is one file here and one line in `bond_laws.rs`.

pub mod brittle;
pub mod weaker;

use std::fmt::Debug;
use std::sync::Arc;

/// The stretches between which an interaction stays on its branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StretchLimits {
    /// Largest stretch of the branch; infinite where elongation has no limit [-].
    pub tension: f64,
    /// Largest shortening of the branch, −s; infinite where compression has no limit [-].
    pub compression: f64,
}

impl StretchLimits {
    /// No stretch ends the branch.
    pub const NONE: StretchLimits = StretchLimits {
        tension: f64::INFINITY,
        compression: f64::INFINITY,
    };

    /// The stretches that lie within both.
    pub fn and(self, other: StretchLimits) -> StretchLimits {
        StretchLimits {
            tension: self.tension.min(other.tension),
            compression: self.compression.min(other.compression),
        }
    }

    /// Qian et al. (2021), eq. (5): whether the stretch `s` is beyond a limit.
    pub fn is_exceeded(&self, s: f64) -> bool {
        s > self.tension || s < -self.compression
    }

    /// The stretch over the limit of its sign: the branch ends at 1 [-].
    pub fn utilisation(&self, s: f64) -> f64 {
        match s > 0.0 {
            true => s / self.tension,
            false => -s / self.compression,
        }
    }
}

/// How the integrity of an interaction changes with its stretch.
pub trait BondLaw: Debug + Send + Sync {
    /// Limits of the branch of an interaction that has this integrity φ.
    fn limits(&self, integrity: f64) -> StretchLimits;

    /// Integrity after the stretch `s` has reached a limit of the branch [-].
    fn next(&self, integrity: f64, s: f64) -> f64;

    /// The law of a clipped bond, the part t of a bond's length.
    fn of_part(&self, t: f64) -> Arc<dyn BondLaw>;
}

/// Energy that a change of integrity takes, with the elongations before and after it [J]:
///
/// ```text
/// ½ (φ − φ') k e e'
/// ```
pub fn released([before, after]: [f64; 2], stiffness: f64, elongations: [f64; 2]) -> f64 {
    0.5 * ((before - after) * stiffness) * elongations[0] * elongations[1]
}

/// The strength of a material, from which its law follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Strength {
    /// s_t = f_t/E, s_c = f_c/E, Qian et al. (2021), eq. (6): the energy release rate depends on the
    /// horizon.
    Stress {
        /// Tensile strength f_t [Pa].
        tensile: f64,
        /// Compressive strength f_c [Pa]; `None`: compression does not break.
        compressive: Option<f64>,
    },
    /// G0 = c0 s0² M3 [J/m²]: the strength depends on the horizon.
    EnergyReleaseRate(f64),
}
