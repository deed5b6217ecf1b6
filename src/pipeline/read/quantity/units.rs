//! Units, their prefixes and products.

use super::{Dimension, QuantityError};

/// `kN/m^2`, `N/mm²`, `Pa*m`, `N m`, `MPa √m`, `N/mm^(3/2)`: factors with exponents.
pub(super) fn unit_product(text: &str) -> Result<(f64, Dimension), QuantityError> {
    let plain = text
        .replace('²', "^2")
        .replace('³', "^3")
        .replace("(1/2)", "0.5")
        .replace("(3/2)", "1.5")
        .replace("**", "^")
        .replace('√', " √")
        .replace(['·', '*'], " ")
        .replace('/', " / ");
    let (mut scale, mut dimension, mut sign) = (1.0, Dimension::NUMBER, 1);
    for word in plain.split_whitespace() {
        if word == "/" {
            sign = -1;
            continue;
        }
        let (unit, halves) = with_exponent(word)?;
        let (factor, of_unit) = named_unit(unit)?;
        scale *= f64::powi(factor, sign * (halves / 2));
        if halves % 2 != 0 {
            scale *= factor.sqrt().powi(sign * (halves % 2));
        }
        dimension = dimension.times(of_unit, sign * halves);
        sign = 1;
    }
    Ok((scale, dimension))
}

/// A unit and its exponent in halves.
fn with_exponent(word: &str) -> Result<(&str, i32), QuantityError> {
    let unknown = || QuantityError::UnknownUnit {
        unit: word.to_owned(),
    };
    let root = word.strip_prefix('√').or_else(|| word.strip_prefix("sqrt"));
    if let Some(unit) = root {
        let bare = unit.strip_prefix('(').and_then(|u| u.strip_suffix(')'));
        return Ok((bare.unwrap_or(unit), 1));
    }
    match word.split_once('^') {
        Some((unit, exponent)) => {
            let exponent: f64 = exponent.parse().map_err(|_| unknown())?;
            let halves = 2.0 * exponent;
            if halves.abs() > 18.0 || halves.fract() != 0.0 {
                Err(unknown())
            } else {
                Ok((unit, halves as i32))
            }
        }
        None => Ok((word, 2)),
    }
}

/// A unit that takes no prefix, or one that does.
fn named_unit(word: &str) -> Result<(f64, Dimension), QuantityError> {
    const MASS: Dimension = Dimension::new(0, 1, 0);
    /// Units of NIST SP 811, appendix B; psi and ksi are lbf/in².
    const WHOLE: [(&[&str], f64, Dimension); 9] = [
        (&["in", "inch", "inches"], 0.0254, Dimension::LENGTH),
        (&["ft", "foot", "feet"], 0.3048, Dimension::LENGTH),
        (&["micron", "microns"], 1e-6, Dimension::LENGTH),
        (&["lb", "lbm"], 0.453_592_37, MASS),
        (&["t", "tonne"], 1e3, MASS),
        (&["lbf"], 4.448_221_615_260_5, Dimension::FORCE),
        (&["kip"], 4_448.221_615_260_5, Dimension::FORCE),
        (&["psi"], 6_894.757_293_168_361, Dimension::PRESSURE),
        (&["ksi"], 6_894_757.293_168_361, Dimension::PRESSURE),
    ];
    let whole = WHOLE.iter().find(|(names, ..)| names.contains(&word));
    match whole {
        Some(&(_, factor, dimension)) => Ok((factor, dimension)),
        None => prefixed_unit(word),
    }
}

fn prefixed_unit(word: &str) -> Result<(f64, Dimension), QuantityError> {
    const UNITS: [(&str, f64, Dimension); 10] = [
        ("metres", 1.0, Dimension::LENGTH),
        ("meters", 1.0, Dimension::LENGTH),
        ("metre", 1.0, Dimension::LENGTH),
        ("meter", 1.0, Dimension::LENGTH),
        ("Pa", 1.0, Dimension::PRESSURE),
        ("m", 1.0, Dimension::LENGTH),
        ("g", 1e-3, Dimension::new(0, 1, 0)),
        ("s", 1.0, Dimension::new(0, 0, 1)),
        ("N", 1.0, Dimension::new(1, 1, -2)),
        ("J", 1.0, Dimension::new(2, 1, -2)),
    ];
    const PREFIXES: [(&str, f64); 14] = [
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
        ("micro", 1e-6),
        ("milli", 1e-3),
        ("centi", 1e-2),
        ("kilo", 1e3),
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

/// The unit that differs from this word in the case of its letters only.
pub(super) fn other_case(word: &str) -> Option<&'static str> {
    const USUAL: [&str; 17] = [
        "mm", "cm", "m", "µm", "um", "in", "ft", "Pa", "kPa", "MPa", "GPa", "N", "kN", "MN", "psi",
        "ksi", "kg",
    ];
    USUAL
        .into_iter()
        .find(|unit| unit.eq_ignore_ascii_case(word))
}
