//! What a fracture costs beside its own cold linear solve, and per broken bond:
//! `cargo bench --bench fracture`, or `cargo bench --bench fracture -- 0.25` for one lattice spacing
//! [mm]. The plate of Qian et al. (2021), section 4.2; medians of five runs of the binary, on one thread.
//!
//! The reference, a factorisation for every response, runs once and for few events: its cost per event
//! does not change on the way.

use serde_json::Value;
use std::process::Command;
use std::time::Instant;

const RUNS: usize = 5;
/// Events of a run. Half a millimetre is torn through within 816.
const EVENTS: usize = 816;
const REFERENCE_EVENTS: usize = 8;

/// Phases of the first solution; what comes before is meshing.
const COLD: [&str; 8] = [
    "elements",
    "pattern",
    "ordering",
    "symbolic",
    "assembly",
    "supports",
    "factorisation",
    "solution",
];

fn main() {
    let given: Vec<f64> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let spacings = if given.is_empty() {
        vec![0.5, 0.25, 0.125]
    } else {
        given
    };
    println!(
        "{:>8} {:>8} {:>9} {:>12} {:>12} {:>12} {:>10}",
        "dx [mm]", "dofs", "cold [s]", "one pass/cold", "ms per bond", "reference", "ratio"
    );
    for spacing in spacings {
        row(spacing);
    }
}

fn row(spacing: f64) {
    let one_pass = median(spacing, "one-pass", 130, false, RUNS);
    let events = median(spacing, "event-driven", EVENTS, false, RUNS);
    let reference = median(spacing, "event-driven", REFERENCE_EVENTS, true, 1);
    let per_bond = |run: &Run| 1e3 * (run.solve - run.set_up) / run.bonds;
    println!(
        "{spacing:>8} {:>8} {:>9.3} {:>12.2} {:>12.2} {:>12.1} {:>10.0}",
        one_pass.dofs,
        one_pass.cold,
        one_pass.solve / one_pass.cold,
        per_bond(&events),
        per_bond(&reference),
        per_bond(&reference) / per_bond(&events)
    );
}

struct Run {
    dofs: u64,
    bonds: f64,
    /// What happens once: elements, pattern, ordering, symbolic analysis [s].
    set_up: f64,
    /// The set-up, and one assembly, factorisation and solution [s].
    cold: f64,
    /// The whole of the solve stage, history and checkpoints included [s].
    solve: f64,
}

/// The run with the median time.
fn median(spacing: f64, control: &str, steps: usize, is_reference: bool, runs: usize) -> Run {
    let mut all: Vec<Run> = (0..runs)
        .map(|_| run(spacing, control, steps, is_reference))
        .collect();
    all.sort_by(|a, b| a.solve.total_cmp(&b.solve));
    all.swap_remove(runs / 2)
}

fn run(spacing: f64, control: &str, steps: usize, is_reference: bool) -> Run {
    let results = tempfile::tempdir().expect("a temporary folder");
    let peristitch = |until: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_peristitch"));
        command
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .args(["run", "pipelines/plate_mode_i.yaml", "--threads", "1"])
            .args(["--until", until, "--results"])
            .arg(results.path());
        for value in [
            format!("regions.1.spacing={spacing} mm"),
            format!("loading.control={control}"),
            format!("loading.steps={steps}"),
            "output={ every: 1000000, pictures: false }".to_owned(),
        ] {
            command.args(["--set", &value]);
        }
        if is_reference {
            command.arg("--reference-solver");
        }
        let start = Instant::now();
        let output = command.output().expect("the binary starts");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{errors}");
        start.elapsed().as_secs_f64()
    };
    peristitch("mesh");
    let whole = peristitch("solve");
    peristitch("output");
    let summary = std::fs::read(results.path().join("plate_mode_i/summary.json"));
    let summary: Value = serde_json::from_slice(&summary.expect("a summary")).expect("JSON");
    let phases = summary["phases"].as_array().expect("phases");
    let seconds = |phase: &Value| phase["seconds"].as_f64().expect("a number");
    let count = |phase: &Value| phase["count"].as_f64().expect("a number");
    let is_of = |phase: &&Value| COLD.iter().any(|name| phase["phase"] == *name);
    let discretisation = phases.iter().find(|p| p["phase"] == "discretisation");
    let of_solve = phases.iter().filter(is_of);
    let once = phases.iter().filter(|p| is_of(p) && p["count"] == 1);
    Run {
        dofs: summary["sizes"]["dofs"].as_u64().expect("a number"),
        bonds: summary["fracture"]["bonds_broken"]
            .as_f64()
            .expect("a number"),
        set_up: once.map(seconds).sum(),
        cold: of_solve.map(|p| seconds(p) / count(p)).sum(),
        solve: whole - discretisation.map_or(0.0, seconds),
    }
}
