//! docs/tutorial.md is a session that happens: each of its commands, in one folder and in order, prints what
//! the page shows, times apart.

mod workplace;

use std::process::Command;
use workplace::{BINARY, Ended, repository};

/// The commands of a page's `console` blocks, each with what it prints.
fn session(page: &str) -> Vec<(&str, Vec<&str>)> {
    let mut commands: Vec<(&str, Vec<&str>)> = Vec::new();
    for block in page.split("```console\n").skip(1) {
        for line in block.split("```").next().unwrap_or_default().lines() {
            match (line.strip_prefix("$ "), commands.last_mut()) {
                (Some(command), _) => commands.push((command, Vec::new())),
                (None, Some((_, printed))) => printed.push(line),
                (None, None) => panic!("no command before {line:?}"),
            }
        }
    }
    commands
}

/// A line with what is left of zero as 0, and without what differs from machine to machine: Gmsh's version,
/// the interpreter that draws, times.
fn plain(line: &str) -> String {
    let words = line.split(' ').map(|word| {
        let bare = word.trim_matches(['(', ')', ',']);
        match bare.parse::<f64>() {
            Ok(number) if number.abs() < 1e-8 && bare.contains('e') => word.replace(bare, "0"),
            _ => word.to_owned(),
        }
    });
    let line = words.collect::<Vec<_>>().join(" ");
    let line = line.split("  (by ").next().unwrap_or_default().to_owned();
    match line.split_once("Gmsh 4.") {
        Some((before, after)) => {
            let rest = after.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
            format!("{before}Gmsh{rest}")
        }
        None if line.contains("to expect") => "  to expect".to_owned(),
        None => line,
    }
}

#[test]
fn the_tutorial_is_a_session_that_happens() {
    let page = std::fs::read_to_string(repository().join("docs/tutorial.md")).expect("the page");
    let session = session(&page);
    assert!(session.len() >= 7, "{session:?}");
    let folder = tempfile::tempdir().expect("a folder");
    for (command, shown) in session {
        let words: Vec<&str> = command.split_whitespace().collect();
        assert_eq!(words[0], "peristitch");
        let output = Command::new(BINARY)
            .args(&words[1..])
            .current_dir(folder.path())
            .output();
        let ended = Ended::from(output.expect("it starts")).succeeded();
        let printed: Vec<String> = ended.out.trim().lines().map(plain).collect();
        let shown: Vec<String> = shown.join("\n").trim().lines().map(plain).collect();
        assert_eq!(printed, shown, "{command}");
    }
}

/// The history is plain CSV, the fields are read by meshio: three lines of Python.
#[test]
fn the_results_are_read_from_python() {
    let place = workplace::Workplace::with_plate();
    place.call(&["run", "plate.yaml"]).succeeded();
    let script = "
import csv, meshio
with open('results/plate/history.csv') as file:
    rows = list(csv.DictReader(file))
mesh = meshio.read('results/plate/plate_points_000000.vtu')
print(len(rows), max(float(row['reaction_n']) for row in rows), len(mesh.point_data['damage']))
";
    let python = repository().join(".venv/bin/python3");
    let output = Command::new(python)
        .args(["-c", script])
        .current_dir(place.path("."))
        .output();
    let ended = Ended::from(output.expect("it starts")).succeeded();
    let summary: serde_json::Value =
        serde_json::from_slice(&place.read("results/plate/summary.json")).expect("JSON");
    let words: Vec<f64> = ended
        .out
        .split_whitespace()
        .map(|word| word.parse().expect("a number"))
        .collect();
    assert_eq!(
        words[0],
        summary["fracture"]["end"]["step"].as_f64().expect("steps")
    );
    assert_eq!(
        words[1],
        summary["fracture"]["peak"]["reaction_n"]
            .as_f64()
            .expect("N")
    );
    assert_eq!(
        words[2],
        summary["sizes"]["material_points"]
            .as_f64()
            .expect("points")
    );
}
