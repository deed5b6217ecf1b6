//! The checks as a table: for a terminal, and for a Markdown page.

use super::{Check, Reference, short};

const HEADINGS: [&str; 7] = [
    "case",
    "quantity",
    "reference",
    "source",
    "measured",
    "error",
    "verdict",
];

/// Columns padded to the same width.
pub fn aligned(checks: &[Check]) -> String {
    let mut rows = vec![HEADINGS.map(str::to_owned)];
    rows.extend(checks.iter().map(cells));
    let widths: [usize; 7] = std::array::from_fn(|column| {
        let widths = rows.iter().map(|row| row[column].chars().count());
        widths.max().unwrap_or(0)
    });
    let line = |row: &[String; 7]| {
        let padded = row.iter().zip(widths).map(|(cell, width)| {
            let rest = width - cell.chars().count();
            format!("{cell}{}", " ".repeat(rest))
        });
        let line: Vec<String> = padded.collect();
        line.join("  ").trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}

/// A table of a Markdown page.
pub fn markdown(checks: &[Check]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let mut text = line(&HEADINGS.map(str::to_owned));
    text.push_str(&line(&HEADINGS.map(|_| "---".to_owned())));
    for check in checks {
        text.push_str(&line(&cells(check).map(|cell| cell.replace('|', "\\|"))));
    }
    text
}

fn cells(check: &Check) -> [String; 7] {
    [
        check.case.to_owned(),
        check.quantity.to_owned(),
        check.reference.to_string(),
        check.source.to_owned(),
        measured(check),
        error(check),
        check.verdict().to_owned(),
    ]
}

/// Rounding errors of zero have no digits worth printing.
fn measured(check: &Check) -> String {
    match check.reference {
        Reference::Zero { .. } if check.measured != 0.0 => format!("{:.0e}", check.measured),
        _ => short(check.measured),
    }
}

/// The difference in percent of the reference, where there is one.
fn error(check: &Check) -> String {
    let Reference::Value { .. } = check.reference else {
        return "–".to_owned();
    };
    let percent = 100.0 * check.error();
    match format!("{percent:+.2} %").as_str() {
        "+0.00 %" | "-0.00 %" => "0.00 %".to_owned(),
        text => text.replace('-', "−"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checks() -> [Check; 2] {
        let check = |quantity, reference, measured| Check {
            case: "case",
            quantity,
            reference,
            source: "exact",
            measured,
        };
        let value = Reference::Value {
            value: 2.0,
            within: 0.01,
        };
        [
            check("|ΣF|", Reference::Zero { within: 1e-12 }, 3.2e-15),
            check("k", value, 1.9),
        ]
    }

    #[test]
    fn columns_stand_under_each_other() {
        let table = aligned(&checks());
        let lines: Vec<Vec<char>> = table.lines().map(|line| line.chars().collect()).collect();
        let places = lines.iter().map(|line| {
            let text: String = line.iter().collect();
            text.find("exact").map(|at| text[..at].chars().count())
        });
        let places: Vec<usize> = places.flatten().collect();
        assert_eq!(places.len(), 2);
        assert_eq!(places[0], places[1]);
        assert!(table.contains("−5.00 %") && table.contains("falls short"));
    }

    #[test]
    fn a_bar_does_not_end_a_cell() {
        let table = markdown(&checks());
        assert!(
            table.contains("| \\|ΣF\\| | 0 ± 1e-12 | exact | 3e-15 | – | holds |"),
            "{table}"
        );
    }
}
