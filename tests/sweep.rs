//! `peristitch sweep` and `plan` through the binary: every run is the pipeline with its values, failures do
//! not stop the others, what is there does not run again, and make and Snakemake get the same table.

mod workplace;

use std::process::Command;
use workplace::{Ended, Workplace, repository};

/// Six runs of the small bar; its band is 400 mm wide, so that points 900 mm apart leave none in it.
const SWEEP: &str = "\
sweep:
  over:
    regions.1.spacing: [12.5 mm, 25 mm, 0.9 m]
    regions.1.horizon: [3, 4]
";

fn with_sweep(sweep: &str) -> Workplace {
    let place = Workplace::new();
    let text = String::from_utf8(place.read("bar.yaml")).expect("UTF-8");
    place.write("bar.yaml", text + sweep);
    place
}

fn table(place: &Workplace) -> String {
    String::from_utf8(place.read("results/bar_sweep/sweep.csv")).expect("UTF-8")
}

/// The cells of one column, row by row.
fn column(table: &str, name: &str) -> Vec<String> {
    let mut rows = table
        .lines()
        .map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let head = rows.next().expect("a head");
    let at = head.iter().position(|cell| cell == name);
    let at = at.unwrap_or_else(|| panic!("no {name} in {head:?}"));
    rows.map(|row| row[at].clone()).collect()
}

#[track_caller]
fn ended_with(ended: &Ended, code: i32, texts: &[&str]) {
    assert_eq!(ended.code, Some(code), "{}", ended.err);
    let said = format!("{}{}", ended.out, ended.err);
    for text in texts {
        assert!(said.contains(text), "no {text:?} in\n{said}");
    }
}

#[test]
fn a_sweep_has_a_line_for_each_run_and_goes_on_behind_one_that_fails() {
    let place = with_sweep(SWEEP);
    let first = place.call(&["sweep", "bar.yaml"]);
    let failed = "horizon-3_spacing-0.9m";
    let again = format!("peristitch sweep bar.yaml --only {failed}");
    ended_with(&first, 1, &["4 of 6 runs are done", &again]);
    let table = table(&place);
    let names = ["horizon-3_spacing-12.5mm", "horizon-3_spacing-25mm", failed];
    assert_eq!(column(&table, "run")[..3], names);
    assert_eq!(
        column(&table, "status"),
        ["done", "done", "failed", "done", "done", "failed"]
    );
    assert_eq!(column(&table, "regions.1.spacing")[1], "25 mm");
    assert!(
        column(&table, "message")[2].contains("no material point"),
        "{table}"
    );

    // Each number is that of the same run by itself, to the bit.
    let tips = column(&table, "probe_tip_m");
    for (k, [horizon, spacing]) in [["3", "12.5 mm"], ["3", "25 mm"]].into_iter().enumerate() {
        let sets = [
            format!("regions.1.horizon={horizon}"),
            format!("regions.1.spacing={spacing}"),
        ];
        place.run(&["--force", "--set", &sets[0], "--set", &sets[1]]);
        assert_eq!(
            tips[k],
            place.summary()["probes"][0]["displacement_m"].to_string()
        );
    }
    assert!(tips[0] != tips[1] && tips[0] != tips[3]);

    // What is there does not run again, and the table keeps its bits.
    let before = place.snapshot();
    let second = place.call(&["sweep", "bar.yaml", "--jobs", "1"]);
    ended_with(&second, 1, &["horizon-3_spacing-12.5mm"]);
    assert_eq!(second.err.matches("  fresh").count(), 4, "{}", second.err);
    let after = place.snapshot();
    let solution = std::path::Path::new("results/bar_sweep/horizon-4_spacing-25mm/solution.bin");
    assert_eq!(before[solution], after[solution]);
    assert_eq!(self::table(&place), table);

    // A value that is mended: the run by its name, and the others stay.
    place.edit("bar.yaml", "0.9 m", "50 mm");
    let one = place.call(&["sweep", "bar.yaml", "--only", "horizon-3_spacing-50mm"]);
    ended_with(&one, 0, &["5 of 6 runs are done"]);
    let list = place.call(&["sweep", "bar.yaml", "--list"]).succeeded();
    assert_eq!(list.out.matches("  done").count(), 5, "{}", list.out);
    assert_eq!(list.out.matches("  to run").count(), 1, "{}", list.out);
    assert!(
        place
            .path("results/bar_sweep/probe_tip_m_over_spacing.png")
            .is_file()
    );
}

#[test]
fn zipped_values_go_together_and_ranges_hold_both_ends() {
    let sweep = "\
sweep:
  combine: zipped
  over:
    thickness: [1 m, 2 m, 4 m]
    materials.solid.young: { from: 100 GPa, to: 400 GPa, count: 3, scale: log }
";
    let place = with_sweep(sweep);
    place.call(&["sweep", "bar.yaml"]).succeeded();
    let table = table(&place);
    assert_eq!(
        column(&table, "materials.solid.young"),
        ["100 GPa", "200 GPa", "400 GPa"]
    );
    let numbers: Vec<f64> = column(&table, "probe_tip_m")
        .iter()
        .map(|u| u.parse().expect("u"))
        .collect();
    // u = σL/E: the thickness plays no part, and E halves it each time, but for rounding.
    for pair in numbers.windows(2) {
        assert!((pair[0] / pair[1] - 2.0).abs() < 1e-10, "{numbers:?}");
    }
}

#[test]
fn a_study_that_is_wrong_runs_nothing() {
    let wrong = |sweep: &str, texts: &[&str]| {
        let place = with_sweep(sweep);
        let before = place.snapshot();
        ended_with(&place.call(&["sweep", "bar.yaml"]), 2, texts);
        assert_eq!(place.snapshot(), before);
    };
    wrong("", &["there is no `sweep`", "sweep: { over:"]);
    wrong("sweep: { over: {} }\n", &["nothing is varied", "bar.yaml:"]);
    wrong(
        "sweep: { over: { regions.1.horizon: 3 } }\n",
        &["must be a list or a group with the keys `from`, `to`, `count`"],
    );
    wrong(
        "sweep: { over: { regions.1.horizon: [] } }\n",
        &["there are no values"],
    );
    wrong(
        "sweep: { over: { regions.1.horizon: [3, 4, 3] } }\n",
        &["`3` is there twice", "bar.yaml:22"],
    );
    wrong(
        "sweep: { over: { regions.1.horizan: [3] } }\n",
        &[
            "unknown key `horizan`",
            "--set regions.1.horizan=3",
            "`horizon`",
        ],
    );
    wrong(
        "sweep: { over: { regions.1.spacing: [1 mm, 2 GPa] } }\n",
        &["`2 GPa` is a pressure", "--set regions.1.spacing=2 GPa"],
    );
    wrong(
        "sweep: { combine: zipped, over: { thickness: [1, 2], regions.1.horizon: [3] } }\n",
        &["cannot be zipped"],
    );
    wrong(
        "sweep: { over: { thickness: { from: 1 mm, to: 2 m, count: 3 } } }\n",
        &["`from` is in `mm` and `to` in `m`"],
    );
    wrong(
        "sweep: { over: { thickness: { from: 1, to: 2, count: 1001 }, regions.1.horizon: { from: 2, to: 3, count: 1000 } } }\n",
        &["1001000 runs", "the most is 100000"],
    );
}

#[test]
fn make_and_snakemake_give_the_same_table() {
    let sweep = SWEEP.replace(", 0.9 m", "");
    let places: Vec<Workplace> = (0..3).map(|_| with_sweep(&sweep)).collect();
    places[0].call(&["sweep", "bar.yaml"]).succeeded();

    let planned = places[1]
        .call(&["plan", "bar.yaml", "--make", "bar.mk"])
        .succeeded();
    assert!(
        planned.out.contains("4 runs; next: make -k -j2 -f bar.mk"),
        "{}",
        planned.out
    );
    engine(
        &places[1],
        Command::new("make").args(["-k", "-j2", "-f", "bar.mk"]),
    );
    // Nothing to do the second time.
    let again = engine(
        &places[1],
        Command::new("make").args(["-k", "-f", "bar.mk"]),
    );
    assert!(again.out.contains("up to date"), "{}", again.out);

    places[2]
        .call(&["plan", "bar.yaml", "--snakemake", "bar.smk"])
        .succeeded();
    let snakemake = repository().join(".venv/bin/snakemake");
    let arguments = ["--keep-going", "--cores", "2", "--snakefile", "bar.smk"];
    let mut command = Command::new(snakemake);
    // Its cache is not to be shared with anybody.
    engine(
        &places[2],
        command
            .args(arguments)
            .env("XDG_CACHE_HOME", places[2].path("cache")),
    );

    let tables: Vec<String> = places.iter().map(table).collect();
    assert_eq!(column(&tables[0], "status"), ["done"; 4]);
    assert_eq!(tables[1], tables[0]);
    assert_eq!(tables[2], tables[0]);
}

#[track_caller]
fn engine(place: &Workplace, command: &mut Command) -> Ended {
    let output = command
        .current_dir(place.path("."))
        .output()
        .expect("it starts");
    Ended::from(output).succeeded()
}

#[test]
fn make_refuses_paths_that_it_cannot_name() {
    let place = with_sweep(SWEEP);
    let ended = place.call(&[
        "plan",
        "bar.yaml",
        "--make",
        "bar.mk",
        "--results",
        "my results",
    ]);
    ended_with(&ended, 2, &["make cannot name the path", "--snakemake"]);
    assert!(!place.path("bar.mk").exists());
}
