//! Mutated input of every kind that is read: no panic, no hang, no memory beyond the limit, a message
//! that names the place. 2000 inputs for each target here; as many as wanted by
//!
//! ```text
//! INPUTS=100000 FOLDERS=500 cargo test --release --test hostile -- --nocapture
//! ```
//!
//! `SEEDS=folder` keeps what the mutations begin with, for `fuzz/`.
//!
//! Then files in results folders, of runs that have ended and of one that was killed: the next run gives
//! the same results, or says what is wrong. The damage goes with a manifest that vouches for it, too.

#[path = "hostile/random.rs"]
mod random;
#[path = "hostile/readers.rs"]
mod readers;
#[path = "hostile/targets.rs"]
mod targets;
mod workplace;

use peristitch::pipeline::record::stamp;
use peristitch::pipeline::record::stored::Kind;
use random::Random;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};
use targets::{Counting, mutated, targets};
use workplace::Workplace;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn number(variable: &str, default: usize) -> usize {
    let text = std::env::var(variable);
    text.map_or(default, |text| text.parse().expect("a number"))
}

/// A run of the small plate, killed behind step 40.
fn interrupted() -> Workplace {
    let place = Workplace::with_plate();
    let mut command = place.command(&["run", "plate.yaml", "--threads", "1"]);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().expect("the binary starts");
    let begin = Instant::now();
    let lines = || std::fs::read(place.path("results/plate/history.csv")).unwrap_or_default();
    while lines().iter().filter(|&&byte| byte == b'\n').count() <= 40 {
        assert!(begin.elapsed() < Duration::from_secs(60));
        assert!(child.try_wait().expect("a child").is_none(), "it ended");
        std::thread::sleep(Duration::from_micros(200));
    }
    child.kill().expect("it runs");
    child.wait().expect("it has ended");
    place
}

fn finished() -> Workplace {
    let place = Workplace::with_plate();
    place.call(&["run", "plate.yaml"]).succeeded();
    place
}

/// One test: the allocator counts for the whole process.
#[test]
fn no_input_does_harm() {
    let inputs = number("INPUTS", 2000);
    let (ended, killed) = (finished(), interrupted());
    let of = |place: &Workplace, name: &str| place.read(&format!("results/plate/{name}"));
    let stored = [
        (Kind::Mesh, of(&ended, "mesh.bin")),
        (Kind::Solution, of(&ended, "solution.bin")),
        (Kind::Frame, of(&ended, "frames/000007.bin")),
        (Kind::Manifest, of(&ended, ".stamps/solve.json")),
        (Kind::Checkpoint, of(&killed, ".stamps/checkpoint.bin")),
        (Kind::Journal, of(&killed, ".stamps/journal.bin")),
    ];
    let targets = targets(&stored);
    targets.iter().for_each(targets::Target::assert_seeds);
    if let Some(folder) = std::env::var_os("SEEDS") {
        let write = |target: &targets::Target| target.write_seeds(Path::new(&folder));
        targets.iter().for_each(write);
    }
    std::panic::set_hook(Box::new(|_| {}));
    let mut faults = Vec::new();
    for (number, target) in targets.iter().enumerate() {
        let tally = target.feed(inputs, 42 + number as u64);
        println!(
            "{:<13} {:>7} inputs, {:>6} taken, slowest {:>6.1} ms, most {:>6.2} MB, {:>6.1} s",
            target.name,
            tally.inputs,
            tally.taken,
            1e3 * tally.slowest.as_secs_f64(),
            tally.most_bytes as f64 / 1e6,
            tally.time.as_secs_f64()
        );
        for (fault, input) in &tally.faults {
            let start = String::from_utf8_lossy(&input[..input.len().min(3000)]).into_owned();
            faults.push(format!("{}: {fault}\n{start}", target.name));
        }
        if let Some((_, input)) = tally.faults.first() {
            let file = std::env::temp_dir().join(format!("peristitch-hostile-{number}"));
            std::fs::write(&file, input).expect("writable");
            println!(
                "              the first of {} faults: {}",
                tally.faults.len(),
                file.display()
            );
        }
    }
    let _ = std::panic::take_hook();
    faults.truncate(3);
    assert!(faults.is_empty(), "{}", faults.join("\n\n"));

    let folders = number("FOLDERS", 20);
    let expected = ended.results("results/plate");
    let mut random = Random(7);
    let (mut redone, mut told) = (0, 0);
    for turn in 0..folders {
        // A damaged file that a manifest vouches for may be of another run: only harm is excluded.
        let [of_killed, vouched] = [turn % 2 == 1, turn % 4 >= 2];
        let source = if of_killed { &killed } else { &ended };
        let place = source.copy();
        let files = files_below(&place.path("results/plate"));
        let is_checkpoint = |file: &&PathBuf| file.ends_with("checkpoint.bin");
        let file = match files.iter().find(is_checkpoint) {
            Some(checkpoint) if vouched => checkpoint,
            _ => &files[random.below(files.len())],
        };
        let bytes = std::fs::read(file).expect("a file");
        let mut damaged = mutated(&[bytes], &mut random);
        if vouched && is_checkpoint(&file) && damaged.len() > 32 {
            let (seal, state) = damaged.split_at_mut(32);
            seal.copy_from_slice(blake3::hash(state).as_bytes());
        }
        std::fs::write(file, &damaged).expect("writable");
        let name = file
            .strip_prefix(place.path("results/plate"))
            .expect("below");
        let name = name.to_string_lossy().into_owned();
        if vouched {
            vouch(&place.path("results/plate"), &name, &damaged);
        }
        let command = format!("{name} damaged, turn {turn}");
        let mut command_line = place.command(&["run", "plate.yaml"]);
        let child = command_line.spawn().expect("the binary starts");
        let ended = wait(child, &command);
        assert!(!ended.1.contains("panicked"), "{command}: {}", ended.1);
        match ended.0 {
            Some(0) if vouched => redone += 1,
            Some(0) => {
                let found = place.results("results/plate");
                // What the user adds or renames stays.
                for (file, bytes) in &expected {
                    assert!(found.get(file) == Some(bytes), "{command}: {file} differs");
                }
                redone += 1;
            }
            Some(1 | 2) => {
                assert!(ended.1.contains("  × "), "{command}: {}", ended.1);
                told += 1;
            }
            code => panic!("{command}: {code:?}: {}", ended.1),
        }
    }
    println!(
        "{folders} folders with a damaged file: {redone} runs gave their results, {told} told what is wrong"
    );
}

/// Exit code and messages, within a minute.
fn wait(mut child: std::process::Child, what: &str) -> (Option<i32>, String) {
    let begin = Instant::now();
    while child.try_wait().expect("a child").is_none() {
        if begin.elapsed() > Duration::from_secs(60) {
            child.kill().expect("it runs");
            panic!("{what}: it does not end");
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    let output = child.wait_with_output().expect("it has ended");
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), told)
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut pending = vec![folder.to_owned()];
    while let Some(folder) = pending.pop() {
        for entry in std::fs::read_dir(folder).expect("readable") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                pending.push(path);
            } else if !path.ends_with("lock") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// Writes the hash of the damaged file wherever that of the sound one stands.
fn vouch(folder: &Path, name: &str, bytes: &[u8]) {
    for stage in ["mesh", "solve", "output"] {
        let path = folder.join(format!(".stamps/{stage}.json"));
        let Ok(mut manifest) =
            serde_json::from_slice::<Value>(&std::fs::read(&path).unwrap_or_default())
        else {
            continue;
        };
        for part in ["outputs", "inputs"] {
            let list = match part {
                "outputs" => &mut manifest["outputs"],
                _ => &mut manifest["recipe"]["inputs"],
            };
            if let Some(hash) = list.get_mut(name) {
                *hash = stamp::hash(bytes).into();
            }
        }
        std::fs::write(&path, manifest.to_string()).expect("writable");
    }
}

/// Names that lead out of the folder, in a manifest that came with it.
#[test]
fn a_manifest_names_no_file_outside_its_folder() {
    for name in [
        "../../precious",
        "/dev/zero",
        "frames/../../../precious",
        ".stamps/lock",
    ] {
        let place = finished();
        place.write("precious", "mine");
        let stamp = "results/plate/.stamps/output.json";
        let text = String::from_utf8(place.read(stamp)).expect("UTF-8");
        let mut manifest: Value = serde_json::from_str(&text).expect("JSON");
        manifest["outputs"][name] = stamp::hash(b"mine").into();
        place.write(stamp, manifest.to_string());
        let ended = place.call(&["run", "plate.yaml", "--set", "output.every=8"]);
        assert_eq!(ended.code, Some(0), "{}", ended.err);
        place.write(stamp, manifest.to_string());
        place.call(&["clean", "plate.yaml"]).succeeded();
        assert_eq!(place.read("precious"), b"mine", "{name}");
    }
}

/// The memory is not taken: ten million points with 628 bonds each would need 500 GB.
#[test]
fn what_no_machine_holds_is_refused_with_the_estimate() {
    for (spacing, horizon, texts) in [
        ("0.1 um", "3", &["material points", "more than 1e7"][..]),
        (
            "0.065 mm",
            "20",
            &["e9 bonds", "GB, and the machine has", "smaller `horizon`"],
        ),
    ] {
        for command in ["run", "check"] {
            let place = Workplace::new();
            let sets = [("spacing", spacing), ("horizon", horizon)]
                .map(|(key, value)| format!("regions.1.{key}={value}"));
            let begin = Instant::now();
            let ended = place.call(&[command, "bar.yaml", "--set", &sets[0], "--set", &sets[1]]);
            assert!(begin.elapsed() < Duration::from_secs(20), "{spacing}");
            assert_eq!(ended.code, Some(2), "{spacing}: {}", ended.err);
            let told = ended.err.split_whitespace().collect::<Vec<_>>().join(" ");
            for text in texts {
                assert!(told.contains(text), "no {text:?} in\n{}", ended.err);
            }
            assert!(!place.path("results").exists());
        }
    }
}

/// Numbers that are only counted with: nothing is reserved for them.
#[test]
fn counts_of_a_thousand_million_take_no_memory() {
    let place = Workplace::with_plate();
    let huge = ["loading.steps=1000000000", "loading.control=equilibrium"];
    let sets = ["--set", huge[0], "--set", huge[1]];
    place
        .call(&[&["check", "plate.yaml"], &sets[..]].concat())
        .succeeded();
    place.edit(
        "plate.yaml",
        "control: one-pass",
        "control: equilibrium, most_passes: 1000000000",
    );
    place.call(&["run", "plate.yaml"]).succeeded();
    let range = "sweep: { over: { thickness: { from: 1, to: 2, count: 1000000000 } } }\n";
    let text = [workplace::PIPELINE, range].concat();
    place.write("bar.yaml", text);
    let ended = place.call(&["sweep", "bar.yaml"]);
    assert_eq!(ended.code, Some(2), "{}", ended.err);
    assert!(
        ended.err.contains("1000000000 values are too many"),
        "{}",
        ended.err
    );
}

/// Depth that overflowed the stack, or took for ever: at once a message.
#[test]
fn depth_without_end_is_refused_at_once() {
    let brackets = ["[", "{a: ", "&a [", "a: [", "!b ["].map(|unit| (unit, 1_000_000));
    let others = ["- ", "? ", "\"", "'", ": ", "*a ", "%"].map(|unit| (unit, 20_000));
    for (unit, length) in brackets.into_iter().chain(others) {
        let place = Workplace::new();
        place.write(
            "bar.yaml",
            format!("name: a\nb: {}", unit.repeat(length / unit.len())),
        );
        let begin = Instant::now();
        let ended = place.call(&["check", "bar.yaml"]);
        assert!(begin.elapsed() < Duration::from_secs(20), "{unit}");
        let (code, told) = (ended.code, ended.err);
        assert_eq!(code, Some(2), "{unit}: {told:.300}");
        assert!(told.contains("  × "), "{unit}: {told:.300}");
    }
}
