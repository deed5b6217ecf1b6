//! The plate of Qian et al. (2021), section 4.2, under the three controls: the table of
//! docs/fracture.md.
//!
//! Total opening of the grips. Griffith's crack of the same energy release rate, 0.1407 J/m²: 9.04e-7 m;
//! all-lattice figures of others: 1.05e-6 m in equilibrium, 8.1e-7 to 1.04e-6 m along the event-driven
//! path, where the lattice traps the tip.

mod workplace;

use serde_json::Value;
use std::process::Command;
use workplace::{BINARY, repository};

const PAGE: &str = include_str!("../docs/fracture.md");

/// The summary, and the largest grip displacement of the path [m].
fn run(control: &str, steps: usize) -> (Value, f64) {
    let results = tempfile::tempdir().expect("a temporary folder");
    let output = Command::new(BINARY)
        .args(["run", "pipelines/plate_mode_i.yaml", "--results"])
        .arg(results.path())
        .args(["--set", &format!("loading.control={control}")])
        .args(["--set", &format!("loading.steps={steps}")])
        .args(["--set", "output={ every: 1000000, pictures: false }"])
        .current_dir(repository())
        .output()
        .expect("the binary starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let folder = results.path().join("plate_mode_i");
    let summary = std::fs::read(folder.join("summary.json")).expect("a summary");
    let history = std::fs::read_to_string(folder.join("history.csv")).expect("a history");
    let mut lines = history.lines();
    let mut names = lines.next().expect("names").split(',');
    let column = names.position(|name| name == "grip_displacement_m");
    let column = column.expect("the column");
    let grips = lines.map(|line| {
        let grip = line.split(',').nth(column).expect("a cell");
        grip.parse::<f64>().expect("a number")
    });
    let largest = grips.fold(0.0, f64::max);
    (serde_json::from_slice(&summary).expect("JSON"), largest)
}

/// The opening that docs/fracture.md gives for a control is twice the grip displacement, to the digits written.
fn assert_written(control: &str, grip: f64) {
    let row = PAGE
        .lines()
        .find(|line| line.starts_with(&format!("| `{control}`")));
    let opening = format!("{:.2e} m", 2.0 * grip);
    assert!(
        row.is_some_and(|row| row.contains(&opening)),
        "{control}: {opening}"
    );
}

fn end(summary: &Value) -> f64 {
    assert_eq!(summary["outcome"], "separated");
    summary["fracture"]["end"]["grip_displacement_m"]
        .as_f64()
        .expect("a number")
}

#[test]
fn one_pass() {
    let (summary, _) = run("one-pass", 130);
    assert_eq!(summary["fracture"]["end"]["step"], 92, "the paper's");
    assert_written("one-pass", end(&summary));
    // A solve before the first step and one after each step that broke bonds, but for the last: bonds
    // break in every step from 45 on. Before that nothing is solved again.
    let solves: Vec<&Value> = summary["phases"]
        .as_array()
        .expect("phases")
        .iter()
        .filter(|phase| phase["phase"] == "solution")
        .collect();
    assert_eq!(solves.len(), 1, "a phase is listed once");
    // And one for the frame of the peak.
    assert_eq!(solves[0]["count"], 92 - 45 + 1 + 1);
}

#[test]
fn equilibrium() {
    let (summary, _) = run("equilibrium", 130);
    let opening = 2.0 * end(&summary);
    // The step is 2 % of it, and the hybrid is stiffer than a lattice alone.
    assert!((opening / 1.05e-6 - 1.0).abs() < 0.05, "{opening:e}");
    assert_written("equilibrium", end(&summary));
}

#[test]
fn event_driven() {
    let (summary, largest) = run("event-driven", 3000);
    assert_eq!(summary["outcome"], "separated");
    assert!((8.1e-7..1.04e-6).contains(&(2.0 * largest)), "{largest:e}");
    assert_written("event-driven", largest);
    // Discrete energy release rates of .985 to .995 of the continuum's, a ligament of 40 mm and a
    // crack of 10 mm; the last bonds break in tension of their own at the sides.
    let crack = summary["fracture"]["crack_length_m"]
        .as_f64()
        .expect("a number");
    assert!((crack / 0.05 - 1.0).abs() < 0.02, "{crack}");
}
