//! A run that is killed goes on where it was, with the same bits: `kill -9` at many moments, then the
//! same command again. Every file that the solve leaves is compared byte by byte.

mod workplace;

use std::collections::BTreeMap;
use std::process::Child;
use std::time::{Duration, Instant};
use workplace::{Ended, Workplace};

const GOES_ON: &str = "an interrupted run goes on after step";

/// Lines of history after which a run is killed.
const MOMENTS: [usize; 8] = [1, 2, 9, 30, 31, 64, 110, 144];

/// `solution.bin`, `history.csv` and all frames; nothing else may lie in `frames/`.
fn results(place: &Workplace) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for file in ["solution.bin", "history.csv"] {
        files.insert(
            file.to_owned(),
            place.read(&format!("results/plate/{file}")),
        );
    }
    for entry in std::fs::read_dir(place.path("results/plate/frames")).expect("frames") {
        let name = entry
            .expect("an entry")
            .file_name()
            .into_string()
            .expect("UTF-8");
        let bytes = place.read(&format!("results/plate/frames/{name}"));
        files.insert(name, bytes);
    }
    files
}

/// The top free to move along 5 degrees to the x axis.
const ON_ROLLERS: &str = "boundary.0.displacement={ y: 2.0e-8 m, angle: 5 deg }";

fn run(place: &Workplace, more: &[&str]) -> Ended {
    place
        .call(&[&["run", "plate.yaml"], more].concat())
        .succeeded()
}

fn undisturbed(more: &[&str]) -> BTreeMap<String, Vec<u8>> {
    let place = Workplace::with_plate();
    let ended = run(&place, more);
    assert!(!ended.err.contains(GOES_ON), "{}", ended.err);
    results(&place)
}

#[track_caller]
fn assert_same(
    found: &BTreeMap<String, Vec<u8>>,
    expected: &BTreeMap<String, Vec<u8>>,
    what: &str,
) {
    assert!(
        found.keys().eq(expected.keys()),
        "{what}: {:?}",
        found.keys()
    );
    for (name, bytes) in expected {
        assert!(found[name] == *bytes, "{what}: {name} differs");
    }
}

fn start(place: &Workplace, more: &[&str]) -> Child {
    let mut command = place.command(&[&["run", "plate.yaml"], more].concat());
    command
        .stderr(std::process::Stdio::null())
        .stdout(std::process::Stdio::null());
    command.spawn().expect("the binary starts")
}

fn lines(place: &Workplace) -> usize {
    let text = std::fs::read(place.path("results/plate/history.csv")).unwrap_or_default();
    text.iter().filter(|&&byte| byte == b'\n').count()
}

/// Starts a run and kills it once the history has so many lines behind its header, or earlier if it
/// ends before.
fn kill_after(place: &Workplace, steps: usize, more: &[&str]) {
    let mut child = start(place, more);
    let begin = Instant::now();
    while lines(place) <= steps && child.try_wait().expect("a child").is_none() {
        assert!(begin.elapsed() < Duration::from_secs(60), "no step {steps}");
        std::thread::sleep(Duration::from_micros(200));
    }
    // SIGKILL.
    let _ = child.kill();
    child.wait().expect("it has ended");
}

#[test]
fn killed_at_many_moments_and_resumed_each_time() {
    let expected = undisturbed(&[]);
    let place = Workplace::with_plate();
    for steps in MOMENTS {
        kill_after(&place, steps, &[]);
    }
    let ended = run(&place, &[]);
    assert_same(&results(&place), &expected, "eight kills in one run");
    // The last kill came at the separation, so perhaps there was nothing left to resume.
    assert!(ended.stages().contains(&"output"), "{}", ended.err);
    assert!(!place.path("results/plate/.stamps/checkpoint.bin").exists());
}

#[test]
fn killed_once_and_resumed() {
    for more in [
        &[][..],
        &["--set", "loading.control=equilibrium"],
        &["--set", "loading.control=event-driven"],
        &["--set", ON_ROLLERS],
        &["--set", ON_ROLLERS, "--set", "loading.control=event-driven"],
    ] {
        let expected = undisturbed(more);
        for steps in [5, 32] {
            let place = Workplace::with_plate();
            kill_after(&place, steps, more);
            let ended = run(&place, more);
            assert_same(
                &results(&place),
                &expected,
                &format!("{more:?}, killed at {steps}"),
            );
            let last = lines(&place);
            assert!(
                ended.err.contains(GOES_ON) || last <= steps + 3,
                "{}",
                ended.err
            );
        }
    }
}

/// Killed after set times, wherever that is: in Gmsh, in a solve, in the output.
#[test]
fn killed_at_any_time() {
    let begin = Instant::now();
    let expected = undisturbed(&[]);
    let whole = begin.elapsed();
    for share in [0.1, 0.3, 0.45, 0.6, 0.75, 0.9] {
        let place = Workplace::with_plate();
        let mut child = start(&place, &[]);
        std::thread::sleep(whole.mul_f64(share));
        let _ = child.kill();
        child.wait().expect("it has ended");
        run(&place, &[]);
        assert_same(
            &results(&place),
            &expected,
            &format!("killed after {share} of the time"),
        );
    }
}

#[test]
fn the_number_of_threads_may_change_at_the_restart() {
    let expected = undisturbed(&["--threads", "1"]);
    assert_same(&undisturbed(&["--threads", "2"]), &expected, "two threads");
    for [before, after] in [["1", "2"], ["2", "1"]] {
        let place = Workplace::with_plate();
        kill_after(&place, 40, &["--threads", before]);
        let ended = run(&place, &["--threads", after]);
        assert!(ended.err.contains(GOES_ON), "{}", ended.err);
        assert_same(&results(&place), &expected, "threads");
    }
}

#[test]
fn another_recipe_begins_anew_and_leaves_no_old_frame() {
    let other = ["--set", "output.every=11"];
    let expected = undisturbed(&other);
    let place = Workplace::with_plate();
    kill_after(&place, 40, &[]);
    let ended = run(&place, &other);
    assert!(!ended.err.contains(GOES_ON), "{}", ended.err);
    assert_same(&results(&place), &expected, "another recipe");
}

#[test]
fn force_begins_anew() {
    let place = Workplace::with_plate();
    kill_after(&place, 40, &[]);
    let ended = run(&place, &["--force"]);
    assert!(!ended.err.contains(GOES_ON), "{}", ended.err);
}

#[test]
fn a_frame_that_is_gone_cannot_be_resumed_from() {
    let place = Workplace::with_plate();
    kill_after(&place, 40, &[]);
    std::fs::remove_file(place.path("results/plate/frames/000007.bin")).expect("a frame");
    let ended = run(&place, &[]);
    assert!(!ended.err.contains(GOES_ON), "{}", ended.err);
    assert_same(&results(&place), &undisturbed(&[]), "a frame was gone");
}

#[test]
fn a_spoilt_checkpoint_begins_anew() {
    let place = Workplace::with_plate();
    kill_after(&place, 40, &[]);
    place.write("results/plate/.stamps/checkpoint.bin", b"\x05spoilt");
    let ended = run(&place, &[]);
    assert!(!ended.err.contains(GOES_ON), "{}", ended.err);
    assert_same(&results(&place), &undisturbed(&[]), "a spoilt checkpoint");
}

/// Files of version 0.1 had no format before their content.
#[test]
fn a_checkpoint_of_version_0_1_is_refused_with_one_message() {
    let place = Workplace::with_plate();
    kill_after(&place, 40, &[]);
    let path = "results/plate/.stamps/checkpoint.bin";
    let bytes = place.read(path);
    let content = bytes.strip_prefix(b"peristitch\x02").expect("the format");
    place.write(path, content);
    let ended = run(&place, &[]);
    assert!(!ended.err.contains(GOES_ON), "{}", ended.err);
    let refused = "checkpoint.bin is refused: peristitch 0.1 wrote it, or it is damaged";
    assert_eq!(ended.err.matches(refused).count(), 1, "{}", ended.err);
    assert_same(&results(&place), &undisturbed(&[]), "a checkpoint of 0.1");
}

#[test]
fn clean_removes_what_a_killed_run_left() {
    let place = Workplace::with_plate();
    kill_after(&place, 40, &[]);
    place.call(&["clean", "plate.yaml"]).succeeded();
    assert!(!place.path("results/plate").exists());
}
