//! `pipelines/plate_mode_i.yaml`, killed by SIGKILL at 20 random moments and started again each time:
//! the history, every frame and the solution are those of a run that nothing disturbed, to the bit, with
//! one thread, with two, and where the number changes at each start.

mod workplace;

use std::collections::BTreeMap;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use workplace::{BINARY, repository};

const GOES_ON: &str = "an interrupted run goes on after step";
const SIGKILL: i32 = 9;
/// The plate separates at step 92.
const LAST_STEP: u64 = 92;

/// SplitMix64 (Steele, Lea & Flood 2014): the same moments in every run of the test.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) % limit
    }
}

fn command(results: &TempDir, threads: u64) -> Command {
    let mut command = Command::new(BINARY);
    command
        .arg("run")
        .arg(repository().join("pipelines/plate_mode_i.yaml"))
        .arg("--results")
        .arg(results.path())
        .args(["--until", "solve", "--threads", &threads.to_string()]);
    command
}

/// Runs to the end and returns what was said.
fn run(results: &TempDir, threads: u64) -> String {
    let output = command(results, threads).output();
    let output = output.expect("the binary starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    said
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Starts a run and kills it when `is_time` says so; it must not have ended before.
fn kill(results: &TempDir, threads: u64, is_time: impl Fn(&Path, Duration) -> bool) {
    let mut command = command(results, threads);
    let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let mut child: Child = child.expect("the binary starts");
    let begin = Instant::now();
    while !is_time(&results.path().join("plate_mode_i"), begin.elapsed()) {
        let running = child.try_wait().expect("a child").is_none();
        assert!(running && begin.elapsed() < Duration::from_secs(120));
        std::thread::sleep(Duration::from_micros(200));
    }
    child.kill().expect("it runs");
    let status = child.wait().expect("it has ended");
    assert_eq!(status.signal(), Some(SIGKILL), "killed, not ended");
}

fn steps(plate: &Path) -> u64 {
    let text = std::fs::read(plate.join("history.csv")).unwrap_or_default();
    (text.iter().filter(|&&byte| byte == b'\n').count() as u64).saturating_sub(1)
}

/// `solution.bin`, `history.csv` and all frames; nothing else may lie in `frames/`.
fn files(results: &TempDir) -> BTreeMap<String, Vec<u8>> {
    let plate = results.path().join("plate_mode_i");
    let frames = std::fs::read_dir(plate.join("frames")).expect("frames");
    let frames = frames.map(|entry| {
        let name = entry.expect("an entry").file_name();
        format!("frames/{}", name.to_string_lossy())
    });
    let names = ["solution.bin", "history.csv"].map(str::to_owned);
    let names = names.into_iter().chain(frames);
    names
        .map(|name| {
            (
                name.clone(),
                std::fs::read(plate.join(name)).expect("a file"),
            )
        })
        .collect()
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

/// One test, since the runs would only take each other's processors.
#[test]
fn twenty_kills_leave_no_trace() {
    let whole = folder();
    let begin = Instant::now();
    run(&whole, 1);
    let undisturbed = begin.elapsed();
    let expected = files(&whole);
    assert_eq!(steps(&whole.path().join("plate_mode_i")), LAST_STEP);
    assert!(expected.contains_key("frames/000092.bin"), "the last frame");
    let other = folder();
    run(&other, 2);
    assert_same(&files(&other), &expected, "two threads");

    let mut random = Random(42);
    let by_steps = folder();
    // Strictly ascending, below the end: each kill finds a run that goes on.
    let mut moments: Vec<u64> = (0..10).map(|k| 9 * k + random.below(9)).collect();
    moments.dedup();
    assert!(moments.len() == 10 && moments.last() < Some(&LAST_STEP));
    for &step in &moments {
        let threads = 1 + random.below(2);
        kill(&by_steps, threads, |plate, _| steps(plate) >= step.max(1));
    }
    let said = run(&by_steps, 1);
    assert!(said.contains(GOES_ON), "{said}");
    assert_same(
        &files(&by_steps),
        &expected,
        &format!("killed at {moments:?}"),
    );

    let by_time = folder();
    // Thousandths of the undisturbed run's time after each start, in the mesher, in the first
    // factorisation, between steps: in all less than the whole, so that no run ends before.
    let moments: Vec<u64> = (0..10).map(|_| 3 + random.below(80)).collect();
    for &moment in &moments {
        let threads = 1 + random.below(2);
        let moment = undisturbed.mul_f64(moment as f64 / 1000.0);
        kill(&by_time, threads, |_, elapsed| elapsed >= moment);
    }
    run(&by_time, 2);
    assert_same(
        &files(&by_time),
        &expected,
        &format!("killed after {moments:?} thousandths"),
    );
}
