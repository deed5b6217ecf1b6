//! Numbers as they are printed. Zero has no sign and no digits, whatever is left of a sum.

/// `value` with so many decimals.
pub fn fixed(value: f64, decimals: usize) -> String {
    without_sign_of_zero(format!("{value:.decimals$}"))
}

/// `value` as a power of ten with so many decimals.
pub fn scientific(value: f64, decimals: usize) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    format!("{value:.decimals$e}")
}

/// The shortest decimal that reads back as `value`.
pub fn exact(value: f64) -> String {
    // Minus zero plus zero is zero; every other number keeps its bits.
    (value + 0.0).to_string()
}

/// `value` with five digits, and its unit.
pub fn quantity(value: f64, unit: &str) -> String {
    let number = match value.abs() {
        size if (1e-2..1e5).contains(&size) => {
            let decimals = (4.0 - size.log10().floor()).max(0.0) as usize;
            format!("{value:.decimals$}")
        }
        _ => scientific(value, 4),
    };
    format!("{number} {unit}").trim_end().to_owned()
}

/// A share in percent with so many decimals.
pub fn percent(share: f64, decimals: usize) -> String {
    fixed(100.0 * share, decimals) + " %"
}

/// A difference in percent with two decimals, signed unless it rounds to zero.
pub fn signed_percent(difference: f64) -> String {
    let text = percent(difference, 2);
    match text.as_bytes().first() {
        Some(b'-') => text,
        _ if text == "0.00 %" => text,
        _ => format!("+{text}"),
    }
}

fn without_sign_of_zero(number: String) -> String {
    match number.strip_prefix('-') {
        Some(magnitude) if !magnitude.contains(|c| ('1'..='9').contains(&c)) => {
            magnitude.to_owned()
        }
        _ => number,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_has_no_sign() {
        assert_eq!(fixed(-0.0, 0), "0");
        assert_eq!(fixed(-0.004, 2), "0.00");
        assert_eq!(scientific(-0.0, 4), "0");
        assert_eq!(exact(-0.0), "0");
        assert_eq!(quantity(-0.0, "m"), "0 m");
        assert_eq!(percent(-1e-9, 0), "0 %");
        let percents = [-2.21e-2, 4e-3, 4e-5, -4e-16, 0.0].map(signed_percent);
        assert_eq!(
            percents,
            ["-2.21 %", "+0.40 %", "0.00 %", "0.00 %", "0.00 %"]
        );
    }

    #[test]
    fn numbers_keep_their_digits() {
        assert_eq!(scientific(-5.2189e3, 4), "-5.2189e3");
        assert_eq!(exact(0.1 + 0.2), "0.30000000000000004");
        assert_eq!(quantity(4.5e-7, "m"), "4.5000e-7 m");
        assert_eq!(quantity(-31_967.4, "N"), "-31967 N");
        assert_eq!(quantity(62.0, ""), "62.000");
        assert_eq!(fixed(-0.05, 2), "-0.05");
    }
}
