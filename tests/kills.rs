//! SIGKILL at random moments, over all stages of `run` and in the middle of `sweep`: the next call goes on,
//! and at the end every file is that of an undisturbed run, to the bit, what a summary tells of costs apart.
//! Ten kills of each here; as many as wanted by
//!
//! ```text
//! KILLS=200 cargo test --release --test kills -- --nocapture
//! ```
//!
//! And what a sweep starts ends with it: killed, or interrupted.

#[path = "hostile/random.rs"]
mod random;
mod workplace;

use random::Random;
use rustix::process::{Pid, Signal, kill_process};
use std::collections::BTreeMap;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use workplace::{PLATE, Workplace};

fn kills() -> usize {
    let text = std::env::var("KILLS");
    text.map_or(10, |text| text.parse().expect("a number"))
}

/// The small plate with pictures, so that there are drafts and an output stage to kill.
fn plate() -> Workplace {
    let place = Workplace::with_plate();
    let text = PLATE.replace("every: 7, pictures: false", "every: 20, pictures: true");
    place.write("plate.yaml", text);
    place
}

const SWEEP: &str = "sweep: { over: { materials.rock.tensile_strength: [2 MPa, 2.5 MPa], loading.control: [one-pass, event-driven] } }\n";

fn start(place: &Workplace, arguments: &[&str]) -> Child {
    let mut command: Command = place.command(arguments);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().expect("the binary starts")
}

/// Kills after so long, unless it has ended: whether it had not.
fn kill_after(mut child: Child, time: Duration) -> bool {
    let begin = Instant::now();
    while begin.elapsed() < time && child.try_wait().expect("a child").is_none() {
        std::thread::sleep(Duration::from_micros(200));
    }
    let _ = child.kill();
    let status = child.wait().expect("it has ended");
    status.signal().is_some()
}

#[track_caller]
fn assert_same(
    found: &BTreeMap<String, Vec<u8>>,
    expected: &BTreeMap<String, Vec<u8>>,
    what: &str,
) {
    let lacks = |a: &BTreeMap<String, Vec<u8>>, b: &BTreeMap<String, Vec<u8>>| {
        let names = a.keys().filter(|name| !b.contains_key(*name));
        names.cloned().collect::<Vec<_>>()
    };
    let (more, fewer) = (lacks(found, expected), lacks(expected, found));
    assert!(
        more.is_empty() && fewer.is_empty(),
        "{what}: {more:?} too many, {fewer:?} missing"
    );
    for (name, bytes) in expected {
        assert!(found[name] == *bytes, "{what}: {name} differs");
    }
}

/// Calls again and again, killed each time after a share of the time that the whole takes, and to its
/// end whenever `together` kills have fallen on one run.
fn kill_at_random(make: fn() -> Workplace, arguments: &[&str], folder: &str, seed: u64) {
    let whole = make();
    let begin = Instant::now();
    whole.call(arguments).succeeded();
    let undisturbed = begin.elapsed();
    let expected = whole.results(folder);
    assert!(expected.len() > 5, "{:?}", expected.keys());

    let mut random = Random(seed);
    let (mut killed, mut runs) = (0, 0);
    while killed < kills() {
        let place = make();
        let mut moments = Vec::new();
        // From one kill to five in a run, each up to 1.1 times the whole away from the start.
        for _ in 0..1 + random.below(5) {
            let share = random.below(1100) as f64 / 1000.0;
            let moment = undisturbed.mul_f64(share);
            if !kill_after(start(&place, arguments), moment) {
                break;
            }
            killed += 1;
            moments.push(share);
        }
        let ended = place.call(arguments);
        let what = format!("{arguments:?} killed at {moments:?} of {undisturbed:?}");
        assert_eq!(ended.code, Some(0), "{what}: {}", ended.err);
        assert_same(&place.results(folder), &expected, &what);
        runs += 1;
    }
    println!(
        "{arguments:?}: {killed} kills in {runs} runs, {} files the same each time, {:.0} s",
        expected.len(),
        begin.elapsed().as_secs_f64()
    );
}

#[test]
fn a_run_that_is_killed_anywhere_ends_with_the_same_files() {
    kill_at_random(plate, &["run", "plate.yaml"], "results/plate", 11);
}

fn swept() -> Workplace {
    let place = Workplace::with_plate();
    place.write("plate.yaml", [PLATE, SWEEP].concat());
    place
}

#[test]
fn a_sweep_that_is_killed_anywhere_ends_with_the_same_files() {
    let arguments = ["sweep", "plate.yaml"];
    kill_at_random(swept, &arguments, "results/plate_sweep", 12);
}

/// Processes that work in this folder.
fn at_work(place: &Workplace) -> Vec<String> {
    let folder = place.path(".").canonicalize().expect("a folder");
    let mut found = Vec::new();
    for entry in std::fs::read_dir("/proc").expect("Linux").flatten() {
        let is_there = std::fs::read_link(entry.path().join("cwd")).is_ok_and(|cwd| cwd == folder);
        if is_there {
            let command = std::fs::read(entry.path().join("cmdline")).unwrap_or_default();
            found.push(String::from_utf8_lossy(&command).replace('\0', " "));
        }
    }
    // What has ended and is not yet waited for has no command line.
    found.retain(|command| !command.is_empty());
    found
}

#[track_caller]
fn assert_nobody_at_work(place: &Workplace) {
    let begin = Instant::now();
    while !at_work(place).is_empty() {
        assert!(
            begin.elapsed() < Duration::from_secs(5),
            "{:?}",
            at_work(place)
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A sweep with a child at work.
fn sweep_with_children(place: &Workplace) -> Child {
    let mut sweep = start(place, &["sweep", "plate.yaml"]);
    let begin = Instant::now();
    while at_work(place).len() < 2 {
        assert!(begin.elapsed() < Duration::from_secs(30));
        assert!(sweep.try_wait().expect("a child").is_none(), "it ended");
        std::thread::sleep(Duration::from_millis(1));
    }
    sweep
}

#[test]
fn the_children_of_a_killed_sweep_end_with_it() {
    let place = swept();
    let mut sweep = sweep_with_children(&place);
    sweep.kill().expect("it runs");
    sweep.wait().expect("it has ended");
    assert_nobody_at_work(&place);
    place.call(&["sweep", "plate.yaml"]).succeeded();
}

#[test]
fn an_interrupted_sweep_says_so_and_goes_on_later() {
    for signal in [Signal::INT, Signal::TERM] {
        let place = swept();
        let mut sweep = sweep_with_children(&place);
        let process = Pid::from_child(&sweep);
        kill_process(process, signal).expect("it runs");
        let status = sweep.wait().expect("it has ended");
        assert_eq!(status.code(), Some(130), "{signal:?}");
        assert_nobody_at_work(&place);
        let ended = place.call(&["sweep", "plate.yaml"]).succeeded();
        assert!(
            ended.err.contains("horizon") || ended.err.contains("control"),
            "{}",
            ended.err
        );
    }
}
