//! A new user's first commands: `new` writes files that run, editors get a schema that takes what the program
//! takes, shells their completions, and programs a run as lines of JSON.

mod workplace;

use serde_json::Value;
use std::process::Command;
use workplace::{Workplace, repository};

/// Coarser than the files say, to be quick; the physics is the same.
const COARSE: [&str; 2] = ["--set", "regions.1.spacing=1 mm"];

#[test]
fn what_new_writes_runs_and_breaks_near_griffiths_load() {
    let place = Workplace::new();
    let said = place.call(&["new", "studies/my_plate"]).succeeded().out;
    let next = said.lines().last().expect("a line");
    let command = next
        .strip_prefix("next: peristitch ")
        .expect("the next command");
    let words: Vec<&str> = command.split_whitespace().collect();
    assert_eq!(words, ["run", "studies/my_plate.yaml"]);
    place.call(&[&words[..], &COARSE].concat()).succeeded();
    let summary = place.read("studies/results/my_plate/summary.json");
    let summary: Value = serde_json::from_slice(&summary).expect("JSON");
    assert_eq!(summary["outcome"], "separated");
    // Edge crack a = 12 in a plate 50 × 50 mm: K_I = F σ √(πa). Under clamped grips F is no handbook's: that
    // of remote tension, 1.46 at a/W = .24 (Tada), bounds it from above, 1.12 (a → 0) from below.
    let kc = f64::sqrt(30e9 * 100.0);
    let reaction = summary["fracture"]["peak"]["reaction_n"]
        .as_f64()
        .expect("N");
    let sigma = reaction / (0.05 * 0.01);
    let factor = kc / (sigma * (std::f64::consts::PI * 0.012).sqrt());
    assert!((0.6..1.46).contains(&factor), "{factor}");
}

#[test]
fn new_never_writes_over_a_file_and_takes_plain_names() {
    let place = Workplace::new();
    place.write("a.geo", "// mine");
    let before = place.snapshot();
    for (name, text) in [
        ("a", "a.geo is there already"),
        ("a b", "cannot name"),
        ("x.yaml", "no ending"),
    ] {
        let ended = place.call(&["new", name]);
        assert_eq!(ended.code, Some(2));
        assert!(ended.err.contains(text), "{}", ended.err);
    }
    assert_eq!(place.snapshot(), before);
}

#[test]
fn the_schema_takes_what_the_program_takes() {
    let place = Workplace::with_plate();
    let schema = place.call(&["schema"]).succeeded().out;
    let kept = std::fs::read_to_string(repository().join("docs/pipeline.schema.json"));
    assert!(
        kept.expect("there") == schema,
        "peristitch schema > docs/pipeline.schema.json"
    );
    let page = place.call(&["schema", "--markdown"]).succeeded().out;
    let kept = std::fs::read_to_string(repository().join("docs/pipeline_reference.md"));
    assert!(
        kept.expect("there") == page,
        "peristitch schema --markdown > docs/pipeline_reference.md"
    );
    let keys: Vec<&str> = page
        .lines()
        .filter(|line| line.starts_with("- `"))
        .collect();
    let has_meaning = |line: &&str| {
        line.split_once("): ")
            .is_some_and(|(_, text)| !text.is_empty())
    };
    assert!(keys.len() > 60, "{} keys", keys.len());
    assert!(keys.iter().all(has_meaning), "a key without a meaning");
    place.write("schema.json", schema);
    place.call(&["new", "fresh"]).succeeded();

    let pipelines = std::fs::read_dir(repository().join("pipelines")).expect("a folder");
    let pipelines = pipelines.map(|entry| entry.expect("an entry").path().display().to_string());
    let mut files: Vec<String> = pipelines.filter(|path| path.ends_with(".yaml")).collect();
    let page = std::fs::read_to_string(repository().join("docs/pipeline.md")).expect("there");
    let examples = page.split("```yaml\n").skip(1);
    let examples = examples.map(|rest| rest.split("```").next().expect("an end"));
    for (k, example) in examples
        .filter(|text| text.starts_with("name:"))
        .enumerate()
    {
        let name = format!("example_{k}.yaml");
        place.write(&name, example);
        files.push(name);
    }
    files.extend(["plate.yaml", "bar.yaml", "fresh.yaml"].map(str::to_owned));
    let sound = files.len();
    assert!(sound >= 15, "{files:?}");

    let wrong = [
        ("plane: stress", "plane: stres", "$.plane"),
        ("horizon: 4", "horizan: 4", "$.regions[1]"),
        ("model: fem", "model: [fem]", "$.regions[0].model"),
        (
            "coupling: truss",
            "coupling: { truss: { area: 1 } }",
            "$.coupling",
        ),
        ("name: bar\n", "", "$"),
    ];
    let bar = String::from_utf8(place.read("bar.yaml")).expect("UTF-8");
    for (k, (old, new, _)) in wrong.iter().enumerate() {
        let name = format!("wrong_{k}.yaml");
        place.write(&name, bar.replace(old, new));
        let ended = place.call(&["status", &name]);
        assert_eq!(ended.code, Some(2), "{new}: {}", ended.err);
        files.push(name);
    }
    let output = Command::new(repository().join(".venv/bin/python3"))
        .arg(repository().join("tests/python/check_schema.py"))
        .arg("schema.json")
        .args(&files)
        .current_dir(place.path("."))
        .output()
        .expect("it starts");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let verdicts = String::from_utf8(output.stdout).expect("UTF-8");
    let verdicts: Vec<&str> = verdicts.lines().collect();
    assert_eq!(verdicts.len(), files.len());
    for (file, verdict) in files.iter().zip(&verdicts[..sound]) {
        assert_eq!(*verdict, "sound", "{file}");
    }
    for ((_, new, path), verdict) in wrong.iter().zip(&verdicts[sound..]) {
        assert!(verdict.starts_with(path), "{new}: {verdict}");
    }
}

#[test]
fn programs_get_a_line_of_json_for_each_event() {
    let place = Workplace::with_plate();
    let said = place.call(&["run", "plate.yaml", "--json"]).succeeded();
    assert_eq!(said.err, "");
    let lines: Vec<Value> = said
        .out
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    let events = |name: &str| lines.iter().filter(|line| line["event"] == name).count();
    let done = &lines[lines.len() - 1]["summary"];
    let steps = done["fracture"]["end"]["step"].as_u64().expect("steps") as usize;
    assert_eq!(
        (events("starts"), events("ends"), events("step")),
        (3, 3, steps)
    );
    let broken = lines
        .iter()
        .rfind(|line| line["event"] == "step")
        .expect("a step");
    // What the last step breaks is counted when it is done; the summary has the same number.
    assert_eq!(
        broken["bonds_broken_total"],
        done["fracture"]["bonds_broken"]
    );

    let again = place.call(&["run", "plate.yaml", "--json"]).succeeded().out;
    assert_eq!(again.matches("\"event\":\"fresh\"").count(), 3, "{again}");

    let wrong = place.call(&["run", "plate.yaml", "--json", "--set", "plane=x"]);
    assert_eq!(wrong.code, Some(2));
    let error: Value = serde_json::from_str(&wrong.out).expect("JSON");
    assert_eq!(
        (&error["event"], &error["code"]),
        (&"error".into(), &2.into())
    );
    place.edit("plate.yaml", "one-pass", "one-path");
    let wrong = place.call(&["run", "plate.yaml", "--json"]);
    let error: Value = serde_json::from_str(&wrong.out).expect("JSON");
    assert_eq!(
        (&error["file"], &error["line"]),
        (&"plate.yaml".into(), &15.into())
    );
}

#[test]
fn verbose_tells_why_and_what_took_the_time() {
    let place = Workplace::new();
    let first = place.run(&["-v"]);
    assert!(
        first.err.contains("bar: mesh   is stale: "),
        "{}",
        first.err
    );
    let second = place.run(&["-v", "--set", "thickness=2 m"]);
    assert!(
        second.err.contains("thickness: 1.0 m → 2.0 m"),
        "{}",
        second.err
    );
    assert!(!second.err.contains("mesh   is stale"));
    assert!(second.out.contains("  factorisation "), "{}", second.out);
}

#[test]
fn shells_and_the_manual_know_every_command() {
    let place = Workplace::new();
    let help = place.call(&["--help"]).succeeded().out;
    let commands = help
        .split("Commands:")
        .nth(1)
        .and_then(|rest| rest.split("Options:").next());
    let commands: Vec<&str> = commands
        .expect("a list")
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(commands.len() >= 12, "{commands:?}");
    let bash = place.call(&["completions", "bash"]).succeeded().out;
    let man = place.call(&["man"]).succeeded().out.replace('\\', "");
    for command in commands {
        assert!(
            bash.contains(&format!("peristitch__subcmd__{command}"))
                || bash.contains(&format!("peristitch__{command}")),
            "{command}"
        );
        assert!(
            man.contains(&format!("peristitch-{command}(1)")),
            "{command}"
        );
    }
    // Bash itself finds no mistake in it.
    place.write("complete.sh", &bash);
    let checked = Command::new("bash")
        .arg("-n")
        .arg(place.path("complete.sh"))
        .status();
    assert!(checked.expect("bash").success());
}
