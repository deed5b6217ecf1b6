//! Round numbers along an axis, and units that keep them short.

/// A unit of the numbers along an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Unit {
    pub name: String,
    /// Numbers of this unit per SI unit.
    pub per_si: f64,
}

impl Unit {
    /// The unit among m, mm and µm in which `extent` [m] is a number of a few digits.
    pub fn of_length(extent: f64) -> Unit {
        let (name, per_si) = match extent {
            e if e >= 5.0 => ("m", 1.0),
            e if e >= 1e-3 => ("mm", 1e3),
            _ => ("µm", 1e6),
        };
        Unit {
            name: name.to_owned(),
            per_si,
        }
    }

    /// `si` with the prefix in which `magnitude` lies between 1 and 1000: 2e-5 m gives µm. Without
    /// a unit the prefix is a power of ten.
    pub fn prefixed(si: &str, magnitude: f64) -> Unit {
        const PREFIXES: [(&str, i32); 9] = [
            ("p", -12),
            ("n", -9),
            ("µ", -6),
            ("m", -3),
            ("", 0),
            ("k", 3),
            ("M", 6),
            ("G", 9),
            ("T", 12),
        ];
        let thousands = if magnitude > 0.0 {
            (magnitude.log10() / 3.0 + 1e-12).floor() as i32 * 3
        } else {
            0
        };
        let prefix = PREFIXES.iter().find(|(_, power)| *power == thousands);
        let name = match (si, prefix) {
            // Shares such as damage are read as they are.
            ("", _) if (-3..=3).contains(&thousands) && magnitude >= 0.01 => {
                return Unit {
                    name: String::new(),
                    per_si: 1.0,
                };
            }
            (si, Some((prefix, _))) if !si.is_empty() => format!("{prefix}{si}"),
            (_, _) if thousands == 0 => si.to_owned(),
            (si, _) => format!("1e{thousands} {si}").trim_end().replace('-', MINUS),
        };
        Unit {
            name,
            per_si: 10_f64.powi(-thousands),
        }
    }

    /// `quantity [unit]`, or the quantity alone.
    pub fn label(&self, quantity: &str) -> String {
        match self.name.as_str() {
            "" => quantity.to_owned(),
            name => format!("{quantity} [{name}]"),
        }
    }
}

/// The minus sign: as wide as the digits, unlike the hyphen.
const MINUS: &str = "−";

/// Multiples of 1, 2 or 5 times a power of ten.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ticks {
    step: f64,
    first: i64,
    last: i64,
}

impl Ticks {
    /// All ticks within `min..=max`, at most `most` of them (two at least).
    pub fn within(min: f64, max: f64, most: usize) -> Ticks {
        let range = (max - min).max(f64::MIN_POSITIVE);
        let rough = range / most.max(2) as f64;
        let decade = 10_f64.powf(rough.log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0, 20.0].map(|multiple| multiple * decade);
        let fits = |step: &&f64| (max / **step).floor() - (min / **step).ceil() < most as f64;
        let step = *steps.iter().find(fits).unwrap_or(&steps[4]);
        // A tick on the end of the range belongs to it, whatever the rounding.
        let slack = 1e-9;
        Ticks {
            step,
            first: (min / step - slack).ceil() as i64,
            last: (max / step + slack).floor() as i64,
        }
    }

    pub fn values(&self) -> impl Iterator<Item = f64> {
        (self.first..=self.last).map(|multiple| multiple as f64 * self.step)
    }

    /// The number with as many decimals as the step needs.
    pub fn label(&self, value: f64) -> String {
        let decimals = (-(self.step.log10() + 1e-9).floor()).clamp(0.0, 12.0) as usize;
        with_minus(format!("{value:.decimals$}"))
    }
}

/// `value` with `digits` significant digits.
pub(super) fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = (digits - 1 - value.abs().log10().floor() as i32).clamp(0, 12) as usize;
    with_minus(format!("{value:.decimals$}"))
}

/// `count` with a space after each three digits.
pub(super) fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut grouped = String::with_capacity(digits.len() + digits.len() / 3);
    for (position, digit) in digits.chars().enumerate() {
        if position > 0 && (digits.len() - position).is_multiple_of(3) {
            grouped.push(' ');
        }
        grouped.push(digit);
    }
    grouped
}

/// `number` with a minus sign for the hyphen, and without the sign of a zero.
fn with_minus(number: String) -> String {
    let is_zero = !number.contains(|c: char| ('1'..='9').contains(&c));
    match number.strip_prefix('-') {
        Some(magnitude) if is_zero => magnitude.to_owned(),
        Some(magnitude) => format!("{MINUS}{magnitude}"),
        None => number,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(min: f64, max: f64, most: usize) -> Vec<String> {
        let ticks = Ticks::within(min, max, most);
        ticks.values().map(|value| ticks.label(value)).collect()
    }

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(
            labels(0.0, 1000.0, 6),
            ["0", "200", "400", "600", "800", "1000"]
        );
        assert_eq!(
            labels(-0.1, 0.1, 5),
            ["−0.10", "−0.05", "0.00", "0.05", "0.10"]
        );
        assert_eq!(labels(0.31, 0.44, 4), ["0.35", "0.40"]);
        assert_eq!(labels(9.99, 10.01, 3), ["9.99", "10.00", "10.01"]);
        for most in 2..12 {
            for scale in [1e-9, 0.37, 1.0, 7.3, 1e5] {
                let count = labels(-0.3 * scale, scale, most).len();
                assert!((1..=most).contains(&count), "{most} {scale}: {count}");
            }
        }
    }

    #[test]
    fn lengths_choose_their_unit() {
        for (extent, name) in [(7.0, "m"), (1.0, "mm"), (2e-3, "mm"), (9e-4, "µm")] {
            assert_eq!(Unit::of_length(extent).name, name);
        }
    }

    #[test]
    fn values_choose_their_prefix() {
        let name = |si, magnitude| Unit::prefixed(si, magnitude).name;
        assert_eq!(name("m", 2e-5), "µm");
        assert_eq!(name("m", 1e-3), "mm");
        assert_eq!(name("Pa", 2.01e6), "MPa");
        assert_eq!(name("Pa", 0.0), "Pa");
        assert_eq!(name("m", 1e-20), "1e−21 m");
        assert_eq!(name("", 0.4), "");
        assert_eq!(name("", 2e-4), "1e−6");
        assert_eq!(Unit::prefixed("Pa", 2.01e6).per_si, 1e-6);
        assert_eq!(Unit::prefixed("", 2e-4).per_si, 1e6);
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(significant(-0.0123456, 4), "−0.01235");
        assert_eq!(significant(123.456, 4), "123.5");
        assert_eq!(significant(0.0, 4), "0");
        assert_eq!(grouped(33_600), "33 600");
        assert_eq!(grouped(1_000_000), "1 000 000");
        assert_eq!(grouped(999), "999");
    }
}
