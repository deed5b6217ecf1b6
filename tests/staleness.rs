//! What runs again after which change, and what a killed, a second and a forced run leave.

mod workplace;

use std::io::Read;
use std::path::{Path, PathBuf};
use workplace::Workplace;

const ALL: [&str; 3] = ["mesh", "solve", "output"];
/// Every file of the results.
const RESULTS: [&str; 15] = [
    "bar.pvd",
    "bar_elements.vtu",
    "bar_points.vtu",
    "displacement_x.png",
    "displacement_y.png",
    "mesh.bin",
    "mesh.png",
    "principal_stress.png",
    "report.html",
    "solution.bin",
    "stress_xx.png",
    "stress_xy.png",
    "stress_yy.png",
    "summary.json",
    "view.py",
];

fn result(name: &str) -> String {
    format!("results/bar/{name}")
}

/// A workplace whose results are fresh.
fn finished() -> Workplace {
    let place = Workplace::new();
    assert_eq!(place.run(&[]).stages(), ALL);
    place
}

#[test]
fn a_second_run_does_nothing() {
    let place = finished();
    let before = place.snapshot();
    // Gmsh's worker needs a temporary folder: without one a run that meshes fails.
    let mut again = place.command(&["run", "bar.yaml"]);
    let again: workplace::Ended = again
        .env("TMPDIR", "/nowhere")
        .output()
        .expect("runs")
        .into();
    assert_eq!(again.err.matches("fresh").count(), 3, "{}", again.err);
    assert_eq!(again.code, Some(0));
    assert!(again.out.contains("tip: u_x = "), "{}", again.out);
    assert_eq!(place.snapshot(), before);
    let mut forced = place.command(&["run", "bar.yaml", "--force"]);
    let forced = forced.env("TMPDIR", "/nowhere").output().expect("runs");
    assert_eq!(forced.status.code(), Some(1));
}

#[test]
fn each_edit_runs_what_depends_on_it() {
    let place = finished();
    let bar = "bar.yaml";
    let cases: [(&str, &str, &str, &[&str]); 9] = [
        ("geo/bar.geo", "height = 200;", "height = 400;", &ALL),
        ("geo/bar.geo", "height = 400;", "height = 200;", &ALL),
        // Gmsh looks, the mesh is the same, and nothing follows from it.
        (
            "geo/bar.geo",
            "length = 1000;",
            "length = 1000; // mm",
            &["mesh"],
        ),
        (bar, "1.05 MPa", "2 MPa", &["solve", "output"]),
        (
            bar,
            "spacing: 12.5 mm",
            "spacing: 0.0125 m",
            &["solve", "output"],
        ),
        (bar, "component: x,", "component: y,", &["output"]),
        (
            bar,
            "coupling: truss",
            "coupling: truss\noutput: { bonds: true }",
            &["output"],
        ),
        (bar, "plane: stress", "plane: stress # a word", &[]),
        (bar, "element: 50", "element: 25", &ALL),
    ];
    for (index, (file, old, new, stages)) in cases.into_iter().enumerate() {
        place.edit(file, old, new);
        // The spacing is the same in metres; the load goes back, and that is noticed.
        if index == 4 {
            place.edit(bar, "2 MPa", "1.05e6 Pa");
        }
        assert_eq!(place.run(&[]).stages(), stages, "{old} → {new}");
        assert!(place.run(&[]).stages().is_empty(), "{old} → {new}");
    }
    // A file that is no longer asked for goes.
    assert!(place.path(&result("bar_bonds.vtu")).exists());
    place.edit(bar, "output: { bonds: true }", "");
    assert_eq!(place.run(&[]).stages(), ["output"]);
    assert!(!place.path(&result("bar_bonds.vtu")).exists());
}

#[test]
fn the_same_quantity_in_other_units_changes_nothing() {
    let place = finished();
    place.edit("bar.yaml", "12.5 mm", "0.0125 m");
    place.edit("bar.yaml", "100 GPa", "1e5 MPa");
    assert!(
        place
            .run(&["--set", "boundary.1.traction.x=1050 kPa"])
            .stages()
            .is_empty()
    );
    let stages = ["solve", "output"];
    assert_eq!(
        place.run(&["--set", "regions.1.horizon=3"]).stages(),
        stages
    );
    assert_eq!(place.run(&[]).stages(), stages);
}

#[test]
fn from_where_it_is_started_does_not_matter() {
    let place = finished();
    let mut inside = place.command(&["run", "../bar.yaml"]);
    let inside = inside
        .current_dir(place.path("geo"))
        .output()
        .expect("runs");
    let inside = workplace::Ended::from(inside).succeeded();
    assert!(inside.stages().is_empty(), "{}", inside.err);
}

#[test]
fn an_edit_of_an_included_file_is_noticed() {
    let place = Workplace::new();
    place.edit("geo/bar.geo", "height = 200;", "Include \"height.geo\";");
    place.write("geo/height.geo", "height = 200;\n");
    assert_eq!(place.run(&[]).stages(), ALL);
    place.write("geo/height.geo", "height = 400;\n");
    let explained = place.call(&["explain", "bar.yaml"]).succeeded();
    assert!(
        explained.out.contains("height.geo has changed"),
        "{}",
        explained.out
    );
    assert_eq!(place.run(&[]).stages(), ALL);
}

#[test]
fn damage_to_any_result_is_noticed_and_mended() {
    let place = finished();
    for name in RESULTS {
        let sound = place.read(&result(name));
        let stage = match name {
            "mesh.bin" => "mesh",
            "solution.bin" => "solve",
            _ => "output",
        };
        let mut damaged = sound.clone();
        let middle = damaged.len() / 2;
        damaged[middle] ^= 1;
        place.write(&result(name), &damaged);
        let explained = place.call(&["explain", "bar.yaml"]).succeeded();
        let reason = format!("{name} is not what the stage wrote");
        assert!(explained.out.contains(&reason), "{}", explained.out);
        assert_eq!(place.run(&[]).stages()[0], stage, "{name}");
        std::fs::remove_file(place.path(&result(name))).expect("it was there");
        assert_eq!(place.run(&[]).stages()[0], stage, "{name}");
        // The summary tells times.
        if name != "summary.json" {
            assert!(place.read(&result(name)) == sound, "{name}");
        }
        assert!(place.run(&[]).stages().is_empty(), "{name}");
    }
}

/// A mesh.bin that another version wrote: its hash is right, its content cannot be decoded.
#[test]
fn a_mesh_that_cannot_be_decoded_is_made_again() {
    let place = finished();
    let manifest = "results/bar/.stamps/mesh.json";
    let old = hash(&place.read(&result("mesh.bin")));
    place.write(&result("mesh.bin"), b"\xff\xff\xff");
    place.edit(manifest, &old, &hash(b"\xff\xff\xff"));
    assert_eq!(place.run(&[]).stages(), ["mesh"]);
    place.write(manifest, "{ no manifest");
    assert_eq!(place.run(&[]).stages(), ["mesh"]);
}

fn hash(bytes: &[u8]) -> String {
    peristitch::pipeline::record::stamp::hash(bytes)
}

#[test]
fn a_half_written_file_is_swept_by_the_next_run() {
    let place = Workplace::new();
    place.run(&[]);
    // The lock tells which process held it last.
    let snapshot = || {
        let mut files = place.snapshot();
        files.remove(Path::new("results/bar/.stamps/lock"));
        files
    };
    let before = snapshot();
    for half in [".stamps/mesh.json.partial", "mesh.bin.partial"] {
        let path = place.path("results/bar").join(half);
        std::fs::write(&path, "half").expect("writable");
        assert!(place.run(&[]).stages().is_empty());
        assert!(!path.exists(), "{half}");
    }
    assert_eq!(snapshot(), before);
}

#[test]
fn a_killed_run_leaves_what_the_next_one_completes() {
    let place = Workplace::new();
    // Larger, so that each phase takes its time.
    place.edit("bar.yaml", "element: 50", "element: 20");
    place.edit("bar.yaml", "spacing: 12.5 mm", "spacing: 5 mm");
    let whole = std::time::Instant::now();
    place.run(&[]);
    let whole = whole.elapsed();
    let names = |place: &Workplace| -> Vec<PathBuf> { place.snapshot().into_keys().collect() };
    let expected = names(&place);
    for tenth in 1..10 {
        let mut run = place
            .command(&["run", "bar.yaml", "--force"])
            .spawn()
            .expect("starts");
        std::thread::sleep(whole * tenth / 10);
        run.kill().expect("it runs, or has ended");
        run.wait().expect("it was started");
        place.run(&[]);
        assert!(place.run(&[]).stages().is_empty(), "killed at {tenth}/10");
        assert_eq!(names(&place), expected, "killed at {tenth}/10");
    }
    // What a killed run leaves is removed too.
    let mut run = place
        .command(&["run", "bar.yaml", "--force"])
        .spawn()
        .expect("starts");
    std::thread::sleep(whole * 7 / 10);
    run.kill().expect("it runs, or has ended");
    run.wait().expect("it was started");
    place.call(&["clean", "bar.yaml"]).succeeded();
    assert!(!place.path("results/bar").exists());
}

#[test]
fn two_runs_at_once_do_not_mix() {
    let place = finished();
    let lock = std::fs::File::open(place.path("results/bar/.stamps/lock")).expect("the lock");
    lock.lock().expect("no run holds it");
    let before = place.snapshot();
    for command in [&["run", "bar.yaml", "--force"][..], &["clean", "bar.yaml"]] {
        let busy = place.call(command);
        assert_eq!(busy.code, Some(1), "{}", busy.err);
        assert!(
            busy.err.contains("another run is writing to results/bar"),
            "{}",
            busy.err
        );
    }
    assert_eq!(place.snapshot(), before);
    drop(lock);
    let both = [1, 2].map(|_| {
        place
            .command(&["run", "bar.yaml", "--force"])
            .spawn()
            .unwrap()
    });
    for mut run in both {
        let mut err = String::new();
        run.stderr
            .take()
            .expect("piped")
            .read_to_string(&mut err)
            .expect("UTF-8");
        let code = run.wait().expect("started").code();
        let is_told = code == Some(1) && err.contains("another run is writing");
        assert!(code == Some(0) || is_told, "{err}");
    }
    place.run(&[]);
    assert!(place.run(&[]).stages().is_empty());
}

#[test]
fn clean_removes_what_was_written_and_nothing_else() {
    let place = Workplace::new();
    let files = |place: &Workplace| place.snapshot();
    let before = files(&place);
    place.run(&[]);
    let cleaned = place.call(&["clean", "bar.yaml"]).succeeded();
    assert!(
        cleaned.out.contains("results/bar: 15 files removed"),
        "{}",
        cleaned.out
    );
    assert_eq!(files(&place), before);
    place.call(&["clean", "bar.yaml"]).succeeded();

    place.run(&[]);
    place.write(&result("notes.txt"), "mine");
    place.call(&["clean", "bar.yaml"]).succeeded();
    assert_eq!(
        std::fs::read_dir(place.path("results/bar"))
            .expect("kept")
            .count(),
        1
    );
    assert_eq!(place.read(&result("notes.txt")), b"mine");
}

#[test]
fn what_only_looks_writes_nothing() {
    let place = Workplace::new();
    let commands: [&[&str]; 3] = [
        &["status", "bar.yaml"],
        &["explain", "bar.yaml"],
        &["run", "bar.yaml", "--dry-run", "--force"],
    ];
    let look = || {
        let before = place.snapshot();
        for command in commands {
            place.call(command).succeeded();
            assert_eq!(place.snapshot(), before, "{command:?}");
        }
    };
    look();
    place.run(&[]);
    look();
    place.edit("bar.yaml", "1.05 MPa", "2 MPa");
    look();
}

#[test]
fn explain_names_the_key_with_its_old_and_new_value() {
    let place = finished();
    place.edit("bar.yaml", "1.05 MPa", "2 MPa");
    place.edit("bar.yaml", "order: 2", "order: 1");
    let explained = place.call(&["explain", "bar.yaml"]).succeeded().out;
    for line in [
        "bar: mesh   stale",
        "    geometry.parameters.order: 2.0 → 1.0",
        "bar: solve  stale",
        "    boundary.1.traction.x: 1050000.0 Pa → 2000000.0 Pa",
    ] {
        assert!(
            explained.lines().any(|found| found == line),
            "{line}\n{explained}"
        );
    }
    let dry = place.call(&["run", "bar.yaml", "--dry-run"]).succeeded();
    assert_eq!(dry.stages(), ALL);
    place.edit("bar.yaml", "2 MPa", "1.05 MPa");
    let status = place.call(&["status", "bar.yaml"]).succeeded().out;
    assert!(
        status.contains("solve  stale if mesh delivers something new"),
        "{status}"
    );
}

#[test]
fn until_stops_after_its_stage() {
    let place = Workplace::new();
    assert_eq!(place.run(&["--until", "mesh"]).stages(), ["mesh"]);
    assert!(!place.path(&result("solution.bin")).exists());
    assert_eq!(place.run(&["--until", "solve"]).stages(), ["solve"]);
    assert_eq!(place.run(&[]).stages(), ["output"]);
}

#[test]
fn forced_runs_and_thread_counts_give_the_same_bytes() {
    let place = finished();
    let results = || RESULTS.map(|name| place.read(&result(name)));
    let displacement = || place.summary()["probes"].clone();
    let (first, tip) = (results(), displacement());
    for threads in ["1", "2", "3"] {
        assert_eq!(place.run(&["--force", "--threads", threads]).stages(), ALL);
        for ((name, now), before) in RESULTS.iter().zip(results()).zip(&first) {
            // The summary tells times.
            let is_timed = *name == "summary.json";
            assert!(is_timed || now == *before, "{name} with {threads} threads");
        }
        assert_eq!(displacement(), tip);
    }
}
