//! The ladder of `peristitch verify`: the quick cases are measured here, and docs/verification.md shows the
//! table that it prints. The slow cases (half a minute) are measured by `verify` alone; of them, the page's
//! rows are checked against what each one may measure.

use peristitch::verification::{Check, ladder, table};
use std::collections::BTreeSet;
use std::process::Command;

const PAGE: &str = include_str!("../docs/verification.md");
const BEGIN: &str = "<!-- verification: begin -->\n";
const END: &str = "<!-- verification: end -->";

/// The rows of the page's table, each as its cells.
fn rows() -> Vec<Vec<String>> {
    let begin = PAGE.split(BEGIN).nth(1).expect("the page has the table");
    let table = begin.split(END).next().expect("the table ends");
    let cells = |line: &str| {
        let line = line.replace("\\|", "¦");
        let cells = line.trim_matches('|').split('|');
        cells.map(|cell| cell.trim().replace('¦', "|")).collect()
    };
    table
        .lines()
        .filter(|line| !line.is_empty())
        .skip(2)
        .map(cells)
        .collect()
}

fn quick() -> Vec<Check> {
    let cases = ladder().into_iter().filter(|case| case.is_quick);
    let measured = cases.map(|case| case.run().expect("it can be measured"));
    measured.flatten().collect()
}

#[test]
fn every_quick_case_holds_and_stands_on_the_page() {
    let checks = quick();
    assert!(checks.len() >= 30, "{}", checks.len());
    let rows = rows();
    for check in &checks {
        assert!(check.holds(), "{check:?}");
        let row = rows
            .iter()
            .find(|row| row[0] == check.case && row[1] == check.quantity);
        let row = row.unwrap_or_else(|| panic!("docs/verification.md has no row for {check:?}"));
        let printed = table::markdown(std::slice::from_ref(check));
        let printed: Vec<String> = printed
            .lines()
            .skip(2)
            .flat_map(|line| {
                let line = line.replace("\\|", "¦");
                let cells: Vec<String> = line
                    .trim_matches('|')
                    .split('|')
                    .map(|cell| cell.trim().replace('¦', "|"))
                    .collect();
                cells
            })
            .collect();
        // Rounding errors differ from machine to machine, and other numbers in the last digit at most.
        assert_eq!(row[2..4], printed[2..4], "{check:?}");
        if row[4].contains("e-1") {
            continue;
        }
        assert_eq!(row[4], printed[4], "{check:?}");
    }
}

/// The page lists every case of the ladder, the slow ones too, and no verdict but one that holds.
#[test]
fn the_page_lists_every_case_and_all_hold() {
    let rows = rows();
    let listed: BTreeSet<&str> = rows.iter().map(|row| row[0].as_str()).collect();
    let mut missing = Vec::new();
    for case in ladder() {
        // One rung may hold several cases, named one after the other.
        for name in case.name.split("; ") {
            if !listed.contains(name) {
                missing.push(name);
            }
        }
    }
    assert!(missing.is_empty(), "{missing:?} of {listed:?}");
    assert!(rows.iter().all(|row| row.len() == 7 && row[6] == "holds"));
}

#[test]
fn the_command_prints_a_table_and_json() {
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_peristitch"));
        let output = command
            .arg("verify")
            .arg("--quick")
            .args(arguments)
            .output();
        let output = output.expect("it starts");
        assert!(output.status.success());
        String::from_utf8(output.stdout).expect("text")
    };
    let json: serde_json::Value = serde_json::from_str(&run(&["--json"])).expect("JSON");
    let list = json.as_array().expect("a list");
    assert!(list.len() >= 30 && list.iter().all(|check| check["holds"] == true));
    let table = run(&[]);
    assert_eq!(table.lines().count(), list.len() + 1);
    assert!(!table.contains("falls short"));
}
