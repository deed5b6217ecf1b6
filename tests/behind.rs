//! Files that are written beside the solve and on several threads: the same bytes as on one thread, and errors
//! that end the run once.

mod workplace;

use serde_json::Value;
use std::process::{Command, Stdio};
use workplace::{BINARY, Ended, Workplace};

const MORE: [&str; 2] = [
    "--set",
    "output={every: 3, pictures: true, pictures_at: [40, 80], bonds: true}",
];

fn run(threads: &str) -> (Workplace, Value) {
    let place = Workplace::with_plate();
    let arguments = [&["run", "plate.yaml", "--threads", threads], &MORE[..]].concat();
    place.call(&arguments).succeeded();
    let summary = place.read("results/plate/summary.json");
    (place, serde_json::from_slice(&summary).expect("JSON"))
}

/// A file does not depend on the thread that writes it.
#[test]
fn one_thread_and_two_write_the_same_files() {
    let [(one, of_one), (two, of_two)] = ["1", "2"].map(run);
    assert_eq!(of_one["files"], of_two["files"]);
    let files = of_one["files"].as_array().expect("files").iter();
    for file in files.filter_map(Value::as_str) {
        let file = format!("results/plate/{file}");
        assert!(
            file.ends_with("summary.json") || one.read(&file) == two.read(&file),
            "{file}"
        );
    }
    let raw = |summary: &Value| summary["written"]["vtu"]["raw_bytes"].clone();
    assert_eq!(raw(&of_one), raw(&of_two));
    for place in [one, two] {
        assert!(!place.path("results/plate/.draft").exists());
    }
}

/// `run` where no file may grow beyond so many blocks of a kilobyte: a full disk, for those that do.
fn limited(place: &Workplace, kilobytes: u32, more: &[&str]) -> Ended {
    let script = format!("trap '' XFSZ; ulimit -f {kilobytes}; exec \"$0\" \"$@\"");
    let mut command = Command::new("bash");
    command
        .args(["-c", &script, BINARY, "run", "plate.yaml"])
        .args(more);
    command
        .current_dir(place.path(""))
        .env("NO_COLOR", "1")
        .env_remove("RUST_BACKTRACE");
    command.stdin(Stdio::null());
    command.output().expect("bash starts").into()
}

fn halves(place: &Workplace) -> Vec<String> {
    let files = place
        .snapshot()
        .into_keys()
        .map(|file| file.display().to_string());
    files.filter(|file| file.ends_with(".partial")).collect()
}

/// A frame of 1000 points and 16 000 bonds takes some 30 kB, a checkpoint more.
#[test]
fn a_full_disk_ends_the_run_once_and_leaves_no_half_file() {
    let place = Workplace::with_plate();
    place
        .call(&["run", "plate.yaml", "--until", "mesh"])
        .succeeded();
    let ended = limited(&place, 20, &["--threads", "2"]);
    assert_eq!(ended.code, Some(1), "{}", ended.err);
    assert_eq!(
        ended.err.matches("cannot write").count(),
        1,
        "{}",
        ended.err
    );
    assert!(ended.err.contains("results/plate/"), "{}", ended.err);
    assert!(ended.err.contains("is there space"), "{}", ended.err);
    assert_eq!(halves(&place), [""; 0]);
    // And with space again, all is well.
    place.call(&["run", "plate.yaml"]).succeeded();
}

/// A part with bonds takes some 180 kB, all else under 100.
#[test]
fn a_part_that_does_not_fit_ends_the_output_stage_and_the_solve_stands() {
    let place = Workplace::with_plate();
    let with_bonds = ["--threads", "2", "--set", "output.bonds=true"];
    let ended = limited(&place, 130, &with_bonds);
    assert_eq!(ended.code, Some(1), "{}", ended.err);
    assert_eq!(
        ended.err.matches("cannot write").count(),
        1,
        "{}",
        ended.err
    );
    assert!(
        ended.err.contains("plate_bonds_000007.vtu"),
        "the first that fails: {}",
        ended.err
    );
    assert_eq!(halves(&place), [""; 0]);
    assert!(!place.path("results/plate/.draft").exists());
    let ended = place
        .call(&[&["run", "plate.yaml"], &with_bonds[..]].concat())
        .succeeded();
    assert_eq!(ended.stages(), ["output"]);
}
