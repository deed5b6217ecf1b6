//! Verification cases, measured on the spot: `peristitch verify`.
//!
//! Each check builds its own body from structured meshes, measures one number, and holds it against a
//! reference that does not come from this program: a closed form, a published figure, or zero where the
//! method is exact.

pub mod any_poisson;
pub mod bend;
pub mod bodies;
pub mod centre_crack;
pub mod crack_modes;
pub mod cracks;
pub mod disc;
pub mod griffith;
pub mod kirsch;
pub mod moduli;
pub mod patches;
pub mod rigid_modes;
pub mod strips;
pub mod table;
pub mod table_1;

use crate::boundary::BoundaryError;
use crate::model::ModelError;
use crate::peridynamics::surface::SurfaceError;
use crate::statics::StaticsError;
use std::fmt;
use thiserror::Error;

/// A case that could not be measured.
#[derive(Debug, Error)]
pub enum VerificationError {
    #[error(transparent)]
    Model(#[from] ModelError),
    #[error(transparent)]
    Boundary(#[from] BoundaryError),
    #[error(transparent)]
    Statics(#[from] StaticsError),
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    #[error("nothing has broken that the case needs broken")]
    NothingBroken,
}

/// A rung of the ladder: what is measured together.
#[derive(Clone, Copy)]
pub struct Case {
    pub name: &'static str,
    /// Takes a second or so.
    pub is_quick: bool,
    measure: fn() -> Result<Vec<Check>, VerificationError>,
}

impl Case {
    /// Measures it, now.
    ///
    /// # Errors
    /// See [`VerificationError`].
    pub fn run(&self) -> Result<Vec<Check>, VerificationError> {
        (self.measure)()
    }
}

/// All cases, from the smallest part to the whole.
pub fn ladder() -> Vec<Case> {
    let quick = |name, measure| Case {
        name,
        is_quick: true,
        measure,
    };
    let slow = |name, measure| Case {
        name,
        is_quick: false,
        measure,
    };
    vec![
        quick("rigid modes", rigid_modes::measure),
        quick("lattice moduli", moduli::measure_moduli),
        quick("any Poisson's ratio", any_poisson::measure),
        quick("energy of a cut", moduli::measure_energy_release),
        quick("strip", strips::measure),
        quick("linear patch", patches::measure_linear),
        quick("quadratic patch", patches::measure_quadratic),
        quick("overall equilibrium", patches::measure_balance),
        quick("damage beside a crack", cracks::measure_damage),
        quick("Table 1", table_1::measure),
        slow("plate with a hole", kirsch::measure),
        slow("Brazilian disc", disc::measure),
        slow("centre crack", cracks::measure_centre_crack),
        slow("crack in an infinite plate", crack_modes::measure),
        slow("single-edge bend", bend::measure),
        slow(
            "Griffith, clamped strip; solver equivalence; mirror symmetry",
            griffith::measure,
        ),
    ]
}

/// The reference of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reference {
    /// The value, and the largest relative error that the method leaves.
    Value { value: f64, within: f64 },
    /// The method is exact: rounding only, up to this size.
    Zero { within: f64 },
    /// The method is known to be off; what it leaves lies between these.
    Between { low: f64, high: f64 },
}

/// One line of the ladder.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    pub case: &'static str,
    pub quantity: &'static str,
    pub reference: Reference,
    /// The source of the reference.
    pub source: &'static str,
    pub measured: f64,
}

impl Check {
    /// Relative to the reference where there is one that is not zero.
    pub fn error(&self) -> f64 {
        match self.reference {
            Reference::Value { value, .. } => self.measured / value - 1.0,
            Reference::Zero { .. } | Reference::Between { .. } => self.measured,
        }
    }

    /// False for a number that is none.
    pub fn holds(&self) -> bool {
        match self.reference {
            Reference::Value { within, .. } | Reference::Zero { within } => {
                self.error().abs() <= within
            }
            Reference::Between { low, high } => (low..=high).contains(&self.measured),
        }
    }
}

impl Check {
    pub fn verdict(&self) -> &'static str {
        if self.holds() { "holds" } else { "falls short" }
    }
}

impl fmt::Display for Reference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reference::Value { value, within } if *within == 0.0 => write!(f, "{}", short(*value)),
            Reference::Value { value, within } if *within < 1e-5 => {
                write!(f, "{} ± {within:.0e}", short(*value))
            }
            Reference::Value { value, within } => {
                let percent = format!("{:.3}", 100.0 * within);
                let percent = percent.trim_end_matches('0').trim_end_matches('.');
                write!(f, "{} ± {percent} %", short(*value))
            }
            Reference::Zero { within } if *within == 0.0 => write!(f, "0"),
            Reference::Zero { within } => write!(f, "0 ± {within:.0e}"),
            Reference::Between { low, high } => write!(f, "{} … {}", short(*low), short(*high)),
        }
    }
}

/// Five digits, in powers of ten where the number is very small or large.
pub fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e5).contains(&size) {
        let digits = (4.0 - size.max(1e-3).log10().floor()).max(0.0) as usize;
        let text = format!("{value:.digits$}");
        match text.contains('.') {
            true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
            false => text,
        }
    } else {
        format!("{value:.4e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(reference: Reference, measured: f64) -> Check {
        Check {
            case: "",
            quantity: "",
            reference,
            source: "",
            measured,
        }
    }

    #[test]
    fn a_check_holds_within_its_bounds_and_never_for_nan() {
        let value = Reference::Value {
            value: 2.0,
            within: 0.01,
        };
        assert!(check(value, 2.01).holds() && !check(value, 2.03).holds());
        let zero = Reference::Zero { within: 1e-12 };
        assert!(check(zero, -1e-13).holds() && !check(zero, 1e-11).holds());
        let between = Reference::Between {
            low: 1.0,
            high: 2.0,
        };
        assert!(check(between, 1.5).holds() && !check(between, 0.5).holds());
        for reference in [value, zero, between] {
            assert!(!check(reference, f64::NAN).holds());
        }
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(short(1.0268e-5), "1.0268e-5");
        assert_eq!(short(0.98491), "0.98491");
        assert_eq!(short(2.65), "2.65");
        assert_eq!(short(0.0), "0");
        assert_eq!(short(92.0), "92");
    }
}
