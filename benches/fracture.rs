//! What a fracture costs beside its own cold linear solve, and per broken bond:
//! `cargo bench --bench fracture`, or for one lattice spacing [mm] and other settings
//! `cargo bench --bench fracture -- 1/4 threads=2 runs=3 pipeline=plate_two_cracks`.
//! The plates of Qian et al. (2021), section 4.2 or 4.3; medians of five runs of the binary, on one thread.
//!
//! Event-driven runs take at most 2000 events from the start, of some four bonds each; what the first
//! linear solve costs is left out. The reference, a factorisation for every response, runs once and for
//! few events: its cost per event does not change on the way.

use serde_json::Value;
use std::process::Command;
use std::time::Instant;

/// Events of a run. Half a millimetre is torn through within 816.
const EVENTS: usize = 2000;
const REFERENCE_EVENTS: usize = 6;
/// Where one-pass runs are left out: a run takes minutes.
const MOST_DOFS: u64 = 130_000;

/// Of 9 868, 18 868, 90 868 and 306 868 dofs [mm].
const SPACINGS: [&str; 4] = ["1/2", "1/3", "1/7", "1/13"];

/// Phases of the first solution; what comes before is meshing.
const COLD: [&str; 7] = [
    "elements",
    "pattern",
    "ordering",
    "symbolic",
    "assembly",
    "factorisation",
    "solution",
];

struct Settings {
    pipeline: String,
    threads: String,
    runs: usize,
}

fn main() {
    let mut settings = Settings {
        pipeline: "plate_mode_i".to_owned(),
        threads: "1".to_owned(),
        runs: 5,
    };
    let mut spacings = Vec::new();
    // Cargo adds options of its own.
    for given in std::env::args().skip(1).filter(|a| !a.starts_with('-')) {
        match given.split_once('=') {
            Some(("pipeline", name)) => settings.pipeline = name.to_owned(),
            Some(("threads", count)) => settings.threads = count.to_owned(),
            Some(("runs", count)) => settings.runs = count.parse().expect("a number"),
            Some((other, _)) => panic!("{other}: pipeline, threads or runs"),
            None => spacings.push(given),
        }
    }
    if spacings.is_empty() {
        spacings = SPACINGS.map(str::to_owned).to_vec();
    }
    println!(
        "{:>8} {:>8} {:>9} {:>9} {:>13} {:>8} {:>12} {:>12} {:>10}",
        "dx [mm]",
        "dofs",
        "cold [s]",
        "one pass",
        "one pass/cold",
        "bonds",
        "ms per bond",
        "reference",
        "ratio"
    );
    spacings.iter().for_each(|spacing| row(spacing, &settings));
}

fn row(spacing: &str, settings: &Settings) {
    let events = median(spacing, "event-driven", EVENTS, false, settings);
    let once = Settings {
        runs: 1,
        pipeline: settings.pipeline.clone(),
        threads: settings.threads.clone(),
    };
    let reference = median(spacing, "event-driven", REFERENCE_EVENTS, true, &once);
    let [one_pass, over_cold] = match events.dofs < MOST_DOFS {
        true => {
            let run = median(spacing, "one-pass", 130, false, settings);
            [run.solve, run.solve / run.cold].map(|value| format!("{value:.2}"))
        }
        false => ["–", "–"].map(str::to_owned),
    };
    let per_bond = |run: &Run| 1e3 * (run.solve - run.cold) / run.bonds;
    println!(
        "{spacing:>8} {:>8} {:>9.3} {one_pass:>9} {over_cold:>13} {:>8} {:>12.3} {:>12.1} {:>10.0}",
        events.dofs,
        events.cold,
        events.bonds,
        per_bond(&events),
        per_bond(&reference),
        per_bond(&reference) / per_bond(&events)
    );
}

struct Run {
    dofs: u64,
    bonds: f64,
    /// Elements, pattern, ordering, symbolic analysis, and one assembly, factorisation and solution [s].
    cold: f64,
    /// The whole of the solve stage, history and checkpoints included [s].
    solve: f64,
}

/// The run with the median time.
fn median(
    spacing: &str,
    control: &str,
    steps: usize,
    is_reference: bool,
    settings: &Settings,
) -> Run {
    let mut all: Vec<Run> = (0..settings.runs)
        .map(|_| run(spacing, control, steps, is_reference, settings))
        .collect();
    all.sort_by(|a, b| a.solve.total_cmp(&b.solve));
    all.swap_remove(settings.runs / 2)
}

fn run(spacing: &str, control: &str, steps: usize, is_reference: bool, settings: &Settings) -> Run {
    let results = tempfile::tempdir().expect("a temporary folder");
    let peristitch = |until: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_peristitch"));
        command
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .args(["run", &format!("pipelines/{}.yaml", settings.pipeline)])
            .args(["--threads", &settings.threads])
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
    let summary = std::fs::read(results.path().join(&settings.pipeline).join("summary.json"));
    let summary: Value = serde_json::from_slice(&summary.expect("a summary")).expect("JSON");
    let phases = summary["phases"].as_array().expect("phases");
    let seconds = |phase: &Value| phase["seconds"].as_f64().expect("a number");
    let count = |phase: &Value| phase["count"].as_f64().expect("a number");
    let is_of = |phase: &&Value| COLD.iter().any(|name| phase["phase"] == *name);
    let discretisation = phases.iter().find(|p| p["phase"] == "discretisation");
    let of_solve = phases.iter().filter(is_of);
    Run {
        dofs: summary["sizes"]["dofs"].as_u64().expect("a number"),
        bonds: summary["fracture"]["bonds_broken"]
            .as_f64()
            .expect("a number"),
        cold: of_solve.map(|p| seconds(p) / count(p)).sum(),
        solve: whole - discretisation.map_or(0.0, seconds),
    }
}
