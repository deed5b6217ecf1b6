//! A disk that is full, a folder that may not be written to, files that vanish, another run, a clock that
//! goes back: one clear message, exit code 1, nothing damaged, and the next run goes on.

mod workplace;

use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime};
use workplace::{BINARY, Ended, Workplace};

/// `run plate.yaml`, where no file may grow beyond so many blocks of 512 bytes: writes fail from there on, as
/// on a full disk. A signal that nobody wants told is left out.
fn run_with_blocks(place: &Workplace, blocks: usize) -> Ended {
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" run plate.yaml");
    let mut command = Command::new("sh");
    command
        .args(["-c", &script, BINARY])
        .current_dir(place.path("."));
    command.env("NO_COLOR", "1").stdin(Stdio::null());
    command.output().expect("it starts").into()
}

/// Limits from the mesh's few kilobytes to the largest frame's and beyond.
#[test]
fn a_full_disk_is_told_and_the_next_run_goes_on() {
    let whole = Workplace::with_plate();
    whole.call(&["run", "plate.yaml"]).succeeded();
    let expected = whole.results("results/plate");
    let mut failed = 0;
    for blocks in [1, 8, 16, 32, 48, 64, 96, 128, 192] {
        let place = Workplace::with_plate();
        let ended = run_with_blocks(&place, blocks);
        if ended.code == Some(0) {
            continue;
        }
        failed += 1;
        assert_eq!(ended.code, Some(1), "{blocks}: {}", ended.err);
        assert_eq!(ended.err.matches("  × ").count(), 1, "{}", ended.err);
        assert!(!ended.err.contains("panicked"), "{}", ended.err);
        // With one block not even Gmsh's log has room for it.
        let cause = if blocks == 1 {
            "Gmsh crashed"
        } else {
            "File too large"
        };
        assert!(ended.err.contains(cause), "{blocks}: {}", ended.err);
        let again = place.call(&["run", "plate.yaml"]);
        assert_eq!(again.code, Some(0), "{blocks}: {}", again.err);
        let found = place.results("results/plate");
        assert!(found == expected, "{blocks}: {:?}", found.keys());
    }
    assert!(failed > 3, "{failed} limits were met");
}

/// Nobody may write below a file, not even root.
#[test]
fn a_place_that_cannot_be_written_to_is_named() {
    let place = Workplace::with_plate();
    place.write("results", "a file");
    let ended = place.call(&["run", "plate.yaml"]);
    assert_eq!(ended.code, Some(1), "{}", ended.err);
    for text in ["results/plate", "--results FOLDER"] {
        assert!(ended.err.contains(text), "no {text:?} in {}", ended.err);
    }
    assert_eq!(place.read("results"), b"a file");
}

/// Where the user is not root, a folder without permission.
#[test]
fn a_read_only_folder_is_named_and_keeps_what_it_has() {
    use std::os::unix::fs::PermissionsExt;
    let place = Workplace::with_plate();
    place.call(&["run", "plate.yaml"]).succeeded();
    let folder = place.path("results/plate");
    let allow = |mode: u32| {
        for folder in [
            folder.clone(),
            folder.join(".stamps"),
            folder.join("frames"),
        ] {
            let permissions = std::fs::Permissions::from_mode(mode);
            std::fs::set_permissions(folder, permissions).expect("ours");
        }
    };
    allow(0o555);
    let is_root = std::fs::write(folder.join("probe"), "").is_ok();
    let before = place.results("results/plate");
    // What is fresh needs no writing.
    place.call(&["run", "plate.yaml"]).succeeded();
    let ended = place.call(&["run", "plate.yaml", "--set", "thickness=2"]);
    allow(0o755);
    if !is_root {
        assert_eq!(ended.code, Some(1), "{}", ended.err);
        assert!(ended.err.contains("Permission denied"), "{}", ended.err);
        assert!(place.results("results/plate") == before);
    }
}

/// The folder is emptied while the run writes: an error that names a file, or, if nothing was missed, a
/// good end; and the next run gives the results.
#[test]
fn files_that_vanish_under_a_run_are_missed_by_name() {
    let whole = Workplace::with_plate();
    whole.call(&["run", "plate.yaml"]).succeeded();
    let expected = whole.results("results/plate");
    for (steps, gone) in [
        (5, "frames"),
        (30, ".stamps"),
        (60, "frames/000007.bin"),
        (90, "history.csv"),
    ] {
        let place = Workplace::with_plate();
        let mut command = place.command(&["run", "plate.yaml"]);
        let mut child = command.spawn().expect("the binary starts");
        let lines = || std::fs::read(place.path("results/plate/history.csv")).unwrap_or_default();
        let begin = Instant::now();
        while lines().iter().filter(|&&byte| byte == b'\n').count() <= steps
            && child.try_wait().expect("a child").is_none()
        {
            assert!(begin.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_micros(200));
        }
        let path = place.path("results/plate").join(gone);
        let removed = if path.is_dir() {
            std::fs::remove_dir_all(&path)
        } else {
            std::fs::remove_file(&path)
        };
        drop(removed);
        let ended = Ended::from(child.wait_with_output().expect("it has ended"));
        assert!(matches!(ended.code, Some(0 | 1)), "{gone}: {ended:?}");
        assert!(!ended.err.contains("panicked"), "{gone}: {}", ended.err);
        if ended.code == Some(1) {
            assert!(ended.err.contains("results/plate"), "{gone}: {}", ended.err);
        }
        let again = place.call(&["run", "plate.yaml"]);
        assert_eq!(again.code, Some(0), "{gone}: {}", again.err);
        let found = place.results("results/plate");
        for (name, bytes) in &expected {
            assert!(found.get(name) == Some(bytes), "{gone}: {name} differs");
        }
    }
}

/// Two at once: one works, the other says who does, or comes when all is done.
#[test]
fn two_runs_at_once_leave_one_result() {
    let place = Workplace::with_plate();
    let start = || {
        place
            .command(&["run", "plate.yaml"])
            .spawn()
            .expect("the binary starts")
    };
    let children: Vec<_> = (0..4).map(|_| start()).collect();
    let pids: Vec<u32> = children.iter().map(|child| child.id()).collect();
    let mut good = 0;
    for child in children {
        let ended = Ended::from(child.wait_with_output().expect("it has ended"));
        match ended.code {
            Some(0) => good += 1,
            Some(1) => {
                let names = |pid: &u32| ended.err.contains(&format!("process {pid}"));
                assert!(
                    ended.err.contains("another run is writing"),
                    "{}",
                    ended.err
                );
                assert!(pids.iter().any(names), "{}", ended.err);
            }
            code => panic!("{code:?}: {}", ended.err),
        }
    }
    assert!(good > 0);
    let whole = Workplace::with_plate();
    whole.call(&["run", "plate.yaml"]).succeeded();
    place.call(&["run", "plate.yaml"]).succeeded();
    assert!(place.results("results/plate") == whole.results("results/plate"));
}

/// Files from the future, as after a clock that was set back: what counts is their content.
#[test]
fn times_of_files_play_no_part() {
    let place = Workplace::with_plate();
    place.call(&["run", "plate.yaml"]).succeeded();
    let future = SystemTime::now() + Duration::from_secs(400 * 86_400);
    for (file, _) in place.snapshot() {
        let file = std::fs::File::options()
            .append(true)
            .open(place.path(".").join(file));
        file.and_then(|file| file.set_modified(future))
            .expect("ours");
    }
    let ended = place.call(&["run", "plate.yaml"]).succeeded();
    assert!(ended.stages().is_empty(), "{}", ended.err);
    // An edit is older than every result now.
    let text = place.read("plate.yaml");
    place.write("plate.yaml", text);
    place.edit("plate.yaml", "every: 7", "every: 9");
    let past = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000_000);
    let file = std::fs::File::options()
        .append(true)
        .open(place.path("plate.yaml"));
    file.and_then(|file| file.set_modified(past)).expect("ours");
    let ended = place.call(&["run", "plate.yaml"]).succeeded();
    assert_eq!(ended.stages(), ["solve", "output"], "{}", ended.err);
}

/// The results are there; what could not be printed is told by the exit code.
#[test]
fn a_full_disk_behind_the_printed_text_is_no_panic() {
    let full = || {
        std::fs::File::options()
            .write(true)
            .open("/dev/full")
            .expect("Linux")
    };
    for (arguments, code) in [
        (&["run", "plate.yaml"][..], 1),
        (&["check", "plate.yaml"], 1),
    ] {
        let place = Workplace::with_plate();
        let mut command = place.command(arguments);
        let ended = Ended::from(command.stdout(full()).output().expect("it starts"));
        assert_eq!(ended.code, Some(code), "{}", ended.err);
        assert!(
            ended.err.contains("standard output could not be written"),
            "{}",
            ended.err
        );
        assert!(!ended.err.contains("panicked"), "{}", ended.err);
        let has_results = place.path("results/plate/summary.json").is_file();
        assert_eq!(has_results, arguments[0] == "run");
    }
    let place = Workplace::with_plate();
    let mut command = place.command(&["run", "plate.yaml"]);
    let status = command.stderr(full()).stdout(Stdio::null()).status();
    assert!(status.expect("it starts").success());
}

/// As `head` does.
#[test]
fn a_reader_that_goes_away_is_no_error() {
    let place = Workplace::with_plate();
    let mut command = place.command(&["check", "plate.yaml"]);
    let mut child = command.spawn().expect("the binary starts");
    drop(child.stdout.take());
    let ended = Ended::from(child.wait_with_output().expect("it has ended"));
    assert_eq!(ended.code, Some(0), "{}", ended.err);
}
