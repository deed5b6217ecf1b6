//! The pipelines' own plates, with updates of the last factorisation and with a factorisation for every
//! response: the same bonds in every step, loads and fields to 1e-9.

mod workplace;

use peristitch::pipeline::record::frames::Frame;
use std::path::Path;
use std::process::Command;
use workplace::{BINARY, repository};

fn frames(pipeline: &str, settings: &[&str], is_reference: bool) -> Vec<Frame> {
    let results = tempfile::tempdir().expect("a temporary folder");
    let mut command = Command::new(BINARY);
    command
        .current_dir(repository())
        .args(["run", &format!("pipelines/{pipeline}.yaml")])
        .args(["--until", "solve", "--results"])
        .arg(results.path())
        .args(["--set", "output={ every: 1, pictures: false }"]);
    for setting in settings {
        command.args(["--set", setting]);
    }
    if is_reference {
        command.arg("--reference-solver");
    }
    let output = command.output().expect("the binary starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let folder = results.path().join(pipeline).join("frames");
    let files = std::fs::read_dir(folder).expect("frames");
    let mut paths: Vec<_> = files.map(|file| file.expect("a frame").path()).collect();
    paths.sort();
    paths.iter().map(|path| frame(path)).collect()
}

fn frame(path: &Path) -> Frame {
    let bytes = std::fs::read(path).expect("a frame");
    Frame::from_file(&bytes).expect("a frame")
}

/// Runs both ways and compares frame by frame; returns the number of bonds broken in the end.
fn compare(pipeline: &str, settings: &[&str]) -> usize {
    let [fast, reference] = [false, true].map(|r| frames(pipeline, settings, r));
    let what = format!("{pipeline} {settings:?}");
    assert_eq!(fast.len(), reference.len(), "{what}");
    let last = reference.last().expect("a frame");
    let largest = |frame: &Frame| {
        let u = frame.displacement.iter().flatten();
        u.fold(0.0, |a, b| f64::max(a, b.abs()))
    };
    for (own, other) in fast.iter().zip(&reference) {
        let what = format!("{what}, step {}", other.step);
        assert_eq!(own.step, other.step, "{what}");
        assert!(own.integrity == other.integrity, "{what}: other bonds");
        let off = (own.load_factor - other.load_factor).abs();
        assert!(off <= 1e-9 * other.load_factor.abs(), "{what}: {off:e}");
        let scale = largest(other);
        let both = own.displacement.iter().zip(&other.displacement);
        for (own, other) in both {
            let off = f64::max((own[0] - other[0]).abs(), (own[1] - other[1]).abs());
            assert!(off <= 1e-9 * scale, "{what}: {own:?} {other:?}");
        }
    }
    let count = |frame: &Frame| {
        let integrity = frame.integrity.to_vec().into_iter();
        integrity.filter(|phi| *phi == 0.0).count()
    };
    count(last) - count(&reference[0])
}

/// Section 4.2 of Qian et al. (2021), to separation: hinges and fragments on the way.
#[test]
fn a_central_crack_step_by_step() {
    assert!(compare("plate_mode_i", &[]) > 6000);
}

/// Section 4.3, to separation.
#[test]
fn two_cracks_step_by_step() {
    assert!(compare("plate_two_cracks", &[]) > 6000);
}

/// Passes at one load until no bond breaks, to the snap that separates the plate.
#[test]
fn a_central_crack_in_equilibrium() {
    let settings = ["loading.control=equilibrium", "regions.1.spacing=1 mm"];
    assert!(compare("plate_mode_i", &settings) > 1000);
}

#[test]
fn a_central_crack_event_by_event() {
    let settings = ["loading.control=event-driven", "loading.steps=100"];
    assert!(compare("plate_mode_i", &settings) > 300);
}
