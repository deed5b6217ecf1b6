//! A `.geo` is code: by default it may draw and nothing else. What its text shows is refused with file and
//! line; what its text hides, the kernel forbids; who trusts it lets it.

mod workplace;

use landlock::{ABI, AccessFs, CompatLevel, Compatible, Ruleset, RulesetAttr};
use peristitch::gmsh::library::Places;
use serde_json::json;
use std::io::Write;
use std::process::Stdio;
use workplace::{Ended, Workplace};

/// The small bar, with these lines before the last of its geometry; CANARY is the path of a file that is not there.
fn with_lines(lines: &str) -> Workplace {
    let place = Workplace::new();
    let canary = place.path("canary").display().to_string();
    let geometry = String::from_utf8(place.read("geo/bar.geo")).expect("UTF-8");
    place.write("geo/bar.geo", geometry + &lines.replace("CANARY", &canary));
    place
}

#[track_caller]
fn assert_refused(place: &Workplace, texts: &[&str]) {
    let before = place.snapshot();
    for command in ["run", "check"] {
        let ended = place.call(&[command, "bar.yaml"]);
        assert_eq!(ended.code, Some(2), "{}", ended.err);
        for text in texts.iter().chain(&["--trust-geometry"]) {
            assert!(ended.err.contains(text), "no {text:?} in\n{}", ended.err);
        }
    }
    assert_eq!(place.snapshot(), before);
}

#[test]
fn a_geometry_that_runs_or_writes_is_refused_with_its_line() {
    let line = Workplace::new()
        .read("geo/bar.geo")
        .iter()
        .filter(|&&byte| byte == b'\n')
        .count()
        + 2;
    let line = format!("bar.geo:{line}: ");
    for (script, what) in [
        (
            "\nSystemCall \"touch CANARY\";\n",
            "SystemCall runs a program",
        ),
        (
            "\nNonBlockingSystemCall StrCat(\"tou\", \"ch CANARY\");\n",
            "NonBlockingSystemCall runs",
        ),
        ("\nOnelabRun(\"x\", \"touch CANARY\");\n", "OnelabRun runs"),
        ("\nField[9] = ExternalProcess;\n", "ExternalProcess runs"),
        (
            "\nIf (1) /* why */ Save View[0] \"CANARY\"; EndIf\n",
            "Save View writes a file",
        ),
        (
            "\nPrint StrCat(\"CANARY\", \".png\");\n",
            "Print writes a file",
        ),
        (
            "\nPrintf(\"x\") > \"CANARY\";\n",
            "Printf with > writes a file",
        ),
        (
            "\nInclude Str(\"a\", \".geo\");\n",
            "Include computes the name of its file",
        ),
    ] {
        assert_refused(&with_lines(script), &[&line, what, "may only draw"]);
    }
}

#[test]
fn a_save_is_passed_over_with_a_note_and_writes_nothing() {
    let place = with_lines("\nMesh 2;\nSave \"CANARY.msh\";\nSave StrCat(\"CANARY\", \".vtk\");\n");
    let ended = place.call(&["run", "bar.yaml", "--until", "mesh"]);
    assert_eq!(ended.code, Some(0), "{}", ended.err);
    let notes = ended.err.matches("`Save` is passed over").count();
    assert_eq!(notes, 2, "{}", ended.err);
    for name in [
        "CANARY.msh",
        "CANARY.vtk",
        "geo/CANARY.msh",
        "geo/CANARY.vtk",
    ] {
        assert!(!place.path(name).exists(), "{name}");
    }
    // Other errors are not passed over.
    let place = with_lines("\nSave \"CANARY.msh\";\nMerge \"nowhere.msh\";\n");
    let ended = place.call(&["run", "bar.yaml"]);
    assert_eq!(ended.code, Some(2), "{}", ended.err);
    assert!(ended.err.contains("nowhere.msh"), "{}", ended.err);
}

#[test]
fn what_is_read_along_is_looked_at_too() {
    for (file, command) in [
        ("other.geo", "Include"),
        ("other.geo", "Merge"),
        // Gmsh takes what it does not know for a script.
        ("other.dat", "Merge"),
        ("other", "Include"),
        ("other.pos", "Merge"),
    ] {
        let place = with_lines(&format!("\n{command} \"{file}\";\n"));
        place.write(&format!("geo/{file}"), "a = 1;\nSystemCall \"true\";\n");
        assert_refused(&place, &[&format!("{file}:2: SystemCall runs a program")]);
    }
    // The options that Gmsh reads unasked.
    let place = Workplace::new();
    place.write("geo/bar.geo.opt", "SystemCall \"true\";\n");
    assert_refused(&place, &["bar.geo.opt:1: SystemCall"]);
}

#[test]
fn other_cases_and_other_extensions_hide_nothing() {
    let place = with_lines("\nSYSTEMCALL \"touch CANARY\";\n");
    // No command of Gmsh's: its own error.
    let ended = place.call(&["run", "bar.yaml"]);
    assert_eq!(ended.code, Some(2), "{}", ended.err);
    assert!(!place.path("canary").exists());
    let place = with_lines("\nSystemCall \"touch CANARY\";\n");
    for name in ["bar.GEO", "bar.geo_unrolled"] {
        place.write(&format!("geo/{name}"), place.read("geo/bar.geo"));
        let ended = place.call(&[
            "run",
            "bar.yaml",
            "--set",
            &format!("geometry.file=geo/{name}"),
            "--set",
            "geometry.parameters={}",
        ]);
        assert_eq!(ended.code, Some(2), "{}", ended.err);
        assert!(
            ended.err.contains("SystemCall runs a program"),
            "{}",
            ended.err
        );
        assert!(!place.path("canary").exists());
    }
}

#[test]
fn who_trusts_a_geometry_lets_it() {
    for arguments in [&["--trust-geometry"][..], &["--set", "geometry.trust=true"]] {
        let place = with_lines("\nSystemCall \"touch CANARY\";\n");
        place.run(arguments);
        assert!(place.path("canary").exists());
    }
    let place = with_lines("\nSystemCall \"touch CANARY\";\n");
    place.edit("bar.yaml", "unit: mm", "unit: mm\n  trust: true");
    place.run(&[]);
    assert!(place.path("canary").exists());
}

/// The worker itself, past all that is looked for in the text.
fn worker(place: &Workplace, trust: bool) -> Ended {
    let libraries = Places::of_this_process().search().found;
    std::fs::create_dir_all(place.path("own")).expect("a folder");
    let request = json!({
        "geometry": place.path("geo/bar.geo"),
        "mesh_dimension": 2,
        "arguments": ["gmsh", "-nopopup"],
        "parameters": [],
        "libraries": libraries,
        "outcome": place.path("own/outcome"),
        "trust": trust,
    });
    let mut command = place.command(&["mesh-worker"]);
    let mut child = command
        .stdin(Stdio::piped())
        .spawn()
        .expect("the binary starts");
    let mut input = child.stdin.take().expect("a pipe");
    writeln!(input, "{request}").expect("it listens");
    let status = child.wait().expect("a child");
    drop(input);
    assert!(place.path("own/outcome").exists(), "no mesh");
    Ended {
        code: status.code(),
        out: String::new(),
        err: String::new(),
    }
}

#[test]
fn the_kernel_forbids_what_the_text_hides() {
    let asked = Ruleset::default().set_compatibility(CompatLevel::HardRequirement);
    let known = asked.handle_access(AccessFs::from_write(ABI::V1));
    if known.and_then(Ruleset::create).is_err() {
        // Said, not passed over: here only the text is looked at.
        eprintln!("NOT CHECKED: this kernel has no Landlock");
        return;
    }
    for line in [
        "SystemCall \"touch CANARY\";",
        "NonBlockingSystemCall \"touch CANARY\";",
        "Printf(\"x\") > \"CANARY\";",
        "Save \"CANARY.msh\";",
    ] {
        let place = with_lines(&format!("\n{line}\n"));
        let before = std::fs::read_dir(place.path("."))
            .expect("a folder")
            .count();
        worker(&place, false);
        // A program that was started without waiting for it has had its time by then.
        std::thread::sleep(std::time::Duration::from_millis(100));
        let after = std::fs::read_dir(place.path("."))
            .expect("a folder")
            .count();
        assert_eq!(
            after,
            before + 1,
            "{line}: only the worker's own folder is new"
        );
        worker(&place, true);
        std::thread::sleep(std::time::Duration::from_millis(100));
        let trusted = std::fs::read_dir(place.path("."))
            .expect("a folder")
            .count();
        assert_eq!(trusted, before + 2, "{line}: trusted, it does what it says");
    }
}

#[test]
fn a_flood_of_messages_ends_as_one_error() {
    let place = with_lines(
        "\nFor i In {1:2000000}\n  Printf(\"%g: a line of some length, again and again, to no end at all\", i);\nEndFor\n",
    );
    let ended = place.call(&["run", "bar.yaml"]);
    assert_eq!(ended.code, Some(1), "{}", ended.err);
    assert!(
        ended.err.contains("wrote more than 64 MB of messages"),
        "{}",
        ended.err
    );
    assert!(!place.path("results").exists());
}

#[test]
fn a_hunger_for_memory_ends_with_gmsh() {
    let place = with_lines("\na() = {0:1e12};\n");
    // A small limit from outside in place of half of the machine, so that the test is quick.
    let run = format!("ulimit -v 1500000; exec {} run bar.yaml", workplace::BINARY);
    let mut command = std::process::Command::new("bash");
    let command = command.args(["-c", &run]).current_dir(place.path("."));
    let ended = Ended::from(command.output().expect("bash"));
    assert_eq!(ended.code, Some(1), "{}", ended.err);
    let is_one_error = ended.err.matches("  × ").count() == 1;
    assert!(
        is_one_error && ended.err.contains("Gmsh crashed on"),
        "{}",
        ended.err
    );
    assert!(!place.path("results").exists());
}
