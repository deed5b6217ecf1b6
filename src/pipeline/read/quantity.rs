//! Quantities with units as people write them: `30 GPa`, `1.0e-8 m`, `1050 kN/m`, `1/3`.
//!
//! An own parser of a hundred lines: `uom` knows single units of one quantity at a time, not
//! products such as `kN/m^2` in a place that wants a pressure.

mod units;

use std::f64::consts::TAU;
use thiserror::Error;
use units::{other_case, unit_product};

/// Exponents of metre, kilogram and second, in halves: a fracture toughness is in Pa √m.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension {
    halves: [i32; 3],
}

impl Dimension {
    pub const NUMBER: Dimension = Dimension::new(0, 0, 0);
    pub const LENGTH: Dimension = Dimension::new(1, 0, 0);
    pub const AREA: Dimension = Dimension::new(2, 0, 0);
    pub const PRESSURE: Dimension = Dimension::new(-1, 1, -2);
    pub const FORCE: Dimension = Dimension::new(1, 1, -2);
    pub const FORCE_PER_VOLUME: Dimension = Dimension::new(-2, 1, -2);
    pub const DENSITY: Dimension = Dimension::new(-3, 1, 0);
    pub const ACCELERATION: Dimension = Dimension::new(1, 0, -2);
    pub const ENERGY_PER_AREA: Dimension = Dimension::new(0, 1, -2);
    pub const FRACTURE_TOUGHNESS: Dimension = Dimension {
        halves: [-1, 2, -4],
    };

    const fn new(metre: i32, kilogram: i32, second: i32) -> Dimension {
        Dimension {
            halves: [2 * metre, 2 * kilogram, 2 * second],
        }
    }

    /// This dimension times that of a unit, which is never a root, to the power of `halves`/2.
    fn times(self, unit: Dimension, halves: i32) -> Dimension {
        let [a, b] = [self.halves, unit.halves];
        Dimension {
            halves: std::array::from_fn(|k| a[k] + halves * b[k] / 2),
        }
    }

    /// The SI unit, such as `Pa`.
    pub fn symbol(self) -> String {
        match NAMES.iter().find(|(dimension, ..)| *dimension == self) {
            Some((_, _, unit, _)) => (*unit).to_owned(),
            None => {
                let [m, kg, s] = self.halves.map(|half| f64::from(half) / 2.0);
                format!("m^{m} kg^{kg} s^{s}")
            }
        }
    }

    /// Name of the dimension.
    pub fn name(self) -> String {
        match NAMES.iter().find(|(dimension, ..)| *dimension == self) {
            Some((_, name, ..)) => (*name).to_owned(),
            None => format!("a quantity in {}", self.symbol()),
        }
    }

    /// An example of such a quantity.
    pub fn example(self) -> &'static str {
        let known = NAMES.iter().find(|(dimension, ..)| *dimension == self);
        known.map_or("1", |(.., example)| example)
    }
}

/// Dimensions with their names, SI units and an example.
const NAMES: [(Dimension, &str, &str, &str); 13] = [
    (Dimension::NUMBER, "a plain number", "", "0.5"),
    (Dimension::LENGTH, "a length", "m", "2.5 mm"),
    (Dimension::AREA, "an area", "m^2", "5 mm^2"),
    (Dimension::PRESSURE, "a pressure", "Pa", "30 GPa"),
    (Dimension::FORCE, "a force", "N", "2 kN"),
    (
        Dimension::FORCE_PER_VOLUME,
        "a force per volume",
        "N/m^3",
        "25 kN/m^3",
    ),
    (Dimension::DENSITY, "a density", "kg/m^3", "2400 kg/m^3"),
    (
        Dimension::ACCELERATION,
        "an acceleration",
        "m/s^2",
        "9.81 m/s^2",
    ),
    (
        Dimension::new(0, 1, -2),
        "a force per length or an energy per area",
        "N/m",
        "2 kN/m",
    ),
    (
        Dimension::FRACTURE_TOUGHNESS,
        "a fracture toughness",
        "Pa m^0.5",
        "1 MPa m^0.5",
    ),
    (Dimension::new(0, 0, 1), "a time", "s", "1 s"),
    (Dimension::new(0, 1, 0), "a mass", "kg", "1 kg"),
    (Dimension::new(2, 1, -2), "an energy", "J", "1 J"),
];

#[derive(Clone, Debug, Error, PartialEq)]
pub enum QuantityError {
    #[error("`{text}` is not a number with a unit")]
    NotANumber { text: String },
    #[error("`{unit}` is not a unit")]
    UnknownUnit { unit: String },
    #[error("`{text}` is {found}, but this must be {}", .expected.name())]
    WrongDimension {
        text: String,
        found: String,
        expected: Dimension,
    },
    #[error("`{text}` is not finite")]
    NotFinite { text: String },
    #[error("`{text}` is not an angle")]
    NotAnAngle { text: String },
    #[error("an angle of `{text}` without a unit is in radians, and more than a whole turn")]
    ManyTurns { text: String },
}

impl QuantityError {
    /// The fix.
    pub fn help(&self) -> String {
        match self {
            QuantityError::UnknownUnit { unit } => {
                let known = "units are m, g, s, N, Pa, J with a prefix n, µ, m, c, k, M or G, t, in, ft, \
                             lbf, psi, ksi, and products of them: mm, GPa, kN/m, N/mm^2";
                match other_case(unit) {
                    Some(meant) => format!("did you mean `{meant}`? {known}"),
                    None => known.to_owned(),
                }
            }
            QuantityError::WrongDimension { expected, .. } => {
                format!(
                    "write {}, such as `{}`",
                    expected.name(),
                    expected.example()
                )
            }
            QuantityError::NotAnAngle { .. } => {
                "write degrees, `20 deg`, or radians, `0.35`".to_owned()
            }
            QuantityError::ManyTurns { text } => {
                format!("write `{text} deg`, or `{text} rad` if it is meant so")
            }
            _ => "write a number and a unit, such as `30 GPa` or `2.5e-3 m`; a bare number is SI"
                .to_owned(),
        }
    }
}

/// The value in SI units of a quantity that must have the dimension `expected`; a bare number is SI.
///
/// # Errors
/// See [`QuantityError`].
pub fn parse(text: &str, expected: Dimension) -> Result<f64, QuantityError> {
    let (value, dimension) = parse_any(text)?;
    match dimension {
        Some(found) if found != expected => Err(QuantityError::WrongDimension {
            text: text.to_owned(),
            found: found.name(),
            expected,
        }),
        _ => Ok(value),
    }
}

/// The value in SI units, and the dimension if a unit is written.
///
/// # Errors
/// See [`QuantityError`].
pub fn parse_any(text: &str) -> Result<(f64, Option<Dimension>), QuantityError> {
    let trimmed = text.trim();
    let (number, unit) = split(trimmed).ok_or_else(|| not_a_number(text))?;
    let (scale, dimension) = match unit {
        "" => (1.0, None),
        unit => unit_product(unit).map(|(scale, dimension)| (scale, Some(dimension)))?,
    };
    let value = number * scale;
    if value.is_finite() {
        Ok((value, dimension))
    } else {
        Err(QuantityError::NotFinite {
            text: text.to_owned(),
        })
    }
}

const DEGREES: [&str; 4] = ["deg", "°", "degree", "degrees"];

/// An angle [rad] in `deg`, `°` or `rad`; a bare number is in radians, and must then be one turn at most.
///
/// # Errors
/// See [`QuantityError`].
pub fn parse_angle(text: &str) -> Result<f64, QuantityError> {
    let text = text.trim();
    let not_an_angle = || QuantityError::NotAnAngle {
        text: text.to_owned(),
    };
    let (number, unit) = split(text).ok_or_else(not_an_angle)?;
    match unit {
        _ if !number.is_finite() => Err(not_an_angle()),
        unit if DEGREES.contains(&unit) => Ok(number.to_radians()),
        "rad" => Ok(number),
        "" if number.abs() <= TAU => Ok(number),
        "" => Err(QuantityError::ManyTurns {
            text: text.to_owned(),
        }),
        _ => Err(not_an_angle()),
    }
}

/// The number of an angle that is written in degrees.
pub(crate) fn parse_degrees(text: &str) -> Option<f64> {
    let (number, unit) = split(text.trim())?;
    (number.is_finite() && DEGREES.contains(&unit)).then_some(number)
}

/// The number as it is written, and the text of its unit; `None` for what is no finite number with a known unit.
pub(crate) fn number_and_unit(text: &str) -> Option<(f64, &str)> {
    parse_any(text).ok()?;
    split(text.trim())
}

fn not_a_number(text: &str) -> QuantityError {
    QuantityError::NotANumber {
        text: text.to_owned(),
    }
}

/// The number at the front, fractions such as 1/3 included, and the unit behind it.
fn split(text: &str) -> Option<(f64, &str)> {
    let (number, rest) = leading_number(text)?;
    let after = rest.trim_start();
    if let Some((denominator, rest)) = after
        .strip_prefix('/')
        .and_then(|r| leading_number(r.trim_start()))
    {
        return Some((number / denominator, rest.trim()));
    }
    Some((number, rest.trim()))
}

/// The longest number that `text` starts with.
fn leading_number(text: &str) -> Option<(f64, &str)> {
    let numeric = |c: char| c.is_ascii_digit() || matches!(c, '.' | '+' | '-' | 'e' | 'E' | '_');
    let end = text.find(|c| !numeric(c)).unwrap_or(text.len());
    (1..=end)
        .rev()
        .filter(|&k| text.is_char_boundary(k))
        .find_map(|k| {
            let number = text[..k].replace('_', "").parse().ok()?;
            Some((number, &text[k..]))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_as_people_write_them() {
        let cases = [
            ("30 GPa", Dimension::PRESSURE, 30e9),
            ("30GPa", Dimension::PRESSURE, 30e9),
            ("1.05 N/mm^2", Dimension::PRESSURE, 1.05e6),
            ("1050 kN/m²", Dimension::PRESSURE, 1.05e6),
            ("1.0e-8 m", Dimension::LENGTH, 1e-8),
            ("-2 µm", Dimension::LENGTH, -2e-6),
            ("0.5", Dimension::LENGTH, 0.5),
            ("12.5 mm^2", Dimension::AREA, 12.5e-6),
            ("1/3", Dimension::NUMBER, 1.0 / 3.0),
            ("1/2 mm", Dimension::LENGTH, 0.5e-3),
            ("140.7 mJ/m^2 / mm", Dimension::PRESSURE, 140.7),
            ("1 inch", Dimension::LENGTH, 0.0254),
            ("2 ft", Dimension::LENGTH, 0.6096),
            ("3 millimeters", Dimension::LENGTH, 3e-3),
            ("10 ksi", Dimension::PRESSURE, 68_947_572.931_683_61),
            ("2.4 t/m^3", Dimension::DENSITY, 2400.0),
            ("1.5 MPa m^0.5", Dimension::FRACTURE_TOUGHNESS, 1.5e6),
            ("1.5 MPa*m^(1/2)", Dimension::FRACTURE_TOUGHNESS, 1.5e6),
            ("1.5 MPa√m", Dimension::FRACTURE_TOUGHNESS, 1.5e6),
            ("1.5 MPa sqrt(m)", Dimension::FRACTURE_TOUGHNESS, 1.5e6),
            // MPa √mm, as N/mm^(3/2): √1e-3 of MPa √m.
            (
                "2 N/mm^(3/2)",
                Dimension::FRACTURE_TOUGHNESS,
                2e6 * 1e-3_f64.sqrt(),
            ),
            (
                "1 ksi in^0.5",
                Dimension::FRACTURE_TOUGHNESS,
                1_098_843.494_108_754_7,
            ),
        ];
        for (text, dimension, expected) in cases {
            let value = parse(text, dimension).expect(text);
            // One division, a root and some powers of ten.
            assert!((value / expected - 1.0).abs() < 1e-15, "{text}: {value}");
        }
    }

    #[test]
    fn a_bare_angle_is_in_radians_and_one_turn_at_most() {
        assert_eq!(parse_angle("45 deg"), Ok(45_f64.to_radians()));
        assert_eq!(parse_angle("-30°"), Ok(-30_f64.to_radians()));
        assert_eq!(parse_angle("1.5 rad"), Ok(1.5));
        assert_eq!(parse_angle("100 rad"), Ok(100.0));
        assert_eq!(parse_angle("6.2"), Ok(6.2));
        for text in ["45", "-6.3"] {
            let error = parse_angle(text).expect_err(text);
            let message = format!(
                "an angle of `{text}` without a unit is in radians, and more than a whole turn"
            );
            assert_eq!(error.to_string(), message);
            let help = format!("write `{text} deg`, or `{text} rad` if it is meant so");
            assert_eq!(error.help(), help);
        }
        assert!(parse_angle("5 mm").is_err() && parse_angle("deg").is_err());
    }

    #[test]
    fn what_is_wrong_is_said() {
        let error = |text| parse(text, Dimension::LENGTH).expect_err(text).to_string();
        assert_eq!(
            error("30 GPa"),
            "`30 GPa` is a pressure, but this must be a length"
        );
        assert_eq!(error("3 parsec"), "`parsec` is not a unit");
        assert_eq!(error("wide"), "`wide` is not a number with a unit");
        assert_eq!(error("1e999 m"), "`1e999 m` is not finite");
        assert_eq!(error("1/0 m"), "`1/0 m` is not finite");
        assert_eq!(error("3 m^x"), "`m^x` is not a unit");
        assert_eq!(error("1 m^99"), "`m^99` is not a unit");
        assert_eq!(error("1 m^0.3"), "`m^0.3` is not a unit");
        let wrong_case = parse("30 gpa", Dimension::PRESSURE).expect_err("no unit");
        assert!(wrong_case.help().starts_with("did you mean `GPa`? "));
    }
}
