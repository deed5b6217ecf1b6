//! Quantities with units as people write them: `30 GPa`, `1.0e-8 m`, `1050 kN/m`, `1/3`.
//!
//! An own parser of a hundred lines: `uom` knows single units of one quantity at a time, not
//! products such as `kN/m^2` in a place that wants a pressure.

use thiserror::Error;

/// Exponents of metre, kilogram and second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension {
    exponents: [i32; 3],
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

    const fn new(metre: i32, kilogram: i32, second: i32) -> Dimension {
        Dimension {
            exponents: [metre, kilogram, second],
        }
    }

    fn times(self, other: Dimension, power: i32) -> Dimension {
        let [a, b] = [self.exponents, other.exponents];
        Dimension {
            exponents: std::array::from_fn(|k| a[k] + power * b[k]),
        }
    }

    /// The SI unit, such as `Pa`.
    pub fn symbol(self) -> String {
        match NAMES.iter().find(|(dimension, ..)| *dimension == self) {
            Some((_, _, unit, _)) => (*unit).to_owned(),
            None => {
                let [m, kg, s] = self.exponents;
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
const NAMES: [(Dimension, &str, &str, &str); 12] = [
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
}

impl QuantityError {
    /// The fix.
    pub fn help(&self) -> String {
        match self {
            QuantityError::UnknownUnit { .. } => {
                "units are m, g, s, N, Pa, J with a prefix n, µ, m, c, k, M or G, and products of \
                 them: mm, GPa, kN/m, N/mm^2"
                    .to_owned()
            }
            QuantityError::WrongDimension { expected, .. } => {
                format!(
                    "write {}, such as `{}`",
                    expected.name(),
                    expected.example()
                )
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

/// `kN/m^2`, `N/mm²`, `Pa*m`, `N m`: factors with exponents.
fn unit_product(text: &str) -> Result<(f64, Dimension), QuantityError> {
    let plain = text
        .replace('²', "^2")
        .replace('³', "^3")
        .replace(['·', '*'], " ")
        .replace('/', " / ");
    let (mut scale, mut dimension, mut power) = (1.0, Dimension::NUMBER, 1);
    for word in plain.split_whitespace() {
        if word == "/" {
            power = -1;
            continue;
        }
        let (unit, exponent) = with_exponent(word)?;
        let (factor, of_unit) = prefixed_unit(unit)?;
        scale *= f64::powi(factor, power * exponent);
        dimension = dimension.times(of_unit, power * exponent);
        power = 1;
    }
    Ok((scale, dimension))
}

fn with_exponent(word: &str) -> Result<(&str, i32), QuantityError> {
    let unknown = || QuantityError::UnknownUnit {
        unit: word.to_owned(),
    };
    match word.split_once('^') {
        Some((unit, exponent)) => {
            let exponent: i32 = exponent.parse().map_err(|_| unknown())?;
            if exponent.abs() > 9 {
                Err(unknown())
            } else {
                Ok((unit, exponent))
            }
        }
        None => Ok((word, 1)),
    }
}

fn prefixed_unit(word: &str) -> Result<(f64, Dimension), QuantityError> {
    const UNITS: [(&str, f64, Dimension); 6] = [
        ("Pa", 1.0, Dimension::PRESSURE),
        ("m", 1.0, Dimension::LENGTH),
        ("g", 1e-3, Dimension::new(0, 1, 0)),
        ("s", 1.0, Dimension::new(0, 0, 1)),
        ("N", 1.0, Dimension::new(1, 1, -2)),
        ("J", 1.0, Dimension::new(2, 1, -2)),
    ];
    const PREFIXES: [(&str, f64); 10] = [
        ("", 1.0),
        ("n", 1e-9),
        ("µ", 1e-6),
        ("μ", 1e-6),
        ("u", 1e-6),
        ("m", 1e-3),
        ("c", 1e-2),
        ("k", 1e3),
        ("M", 1e6),
        ("G", 1e9),
    ];
    UNITS
        .iter()
        .find_map(|&(unit, base, dimension)| {
            let prefix = word.strip_suffix(unit)?;
            let (_, scale) = PREFIXES.iter().find(|(name, _)| *name == prefix)?;
            Some((scale * base, dimension))
        })
        .ok_or_else(|| QuantityError::UnknownUnit {
            unit: word.to_owned(),
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
        ];
        for (text, dimension, expected) in cases {
            let value = parse(text, dimension).expect(text);
            // One division and one power of ten.
            assert!((value / expected - 1.0).abs() < 4e-16, "{text}: {value}");
        }
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
    }
}
