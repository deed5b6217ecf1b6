//! Gmsh's own tutorials and demos, as its package brings them, through `check`: each is either meshed, with groups
//! of ours added, or gives one message; docs/gmsh_tutorials.md tells which.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const PAGE: &str = include_str!("../docs/gmsh_tutorials.md");
/// None takes as much as a tenth of this.
const LIMIT: Duration = Duration::from_secs(120);

/// Beginnings of messages, and what the page calls them.
const OUTCOMES: [(&str, &str); 6] = [
    (" writes a file", "more than a drawing"),
    (" runs a program", "more than a drawing"),
    (" computes the name of its file", "more than a drawing"),
    ("lie off the plane z = 0", "not flat"),
    (
        "the geometry has no physical surface; it has 0 plain surface(s)",
        "no surface",
    ),
    ("there is no physical curve or point `edges`", "no surface"),
];

/// Folders of the package, copied, since the scripts read files beside them.
fn copied(place: &Path) -> Vec<PathBuf> {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join(".venv/share/doc/gmsh");
    assert!(
        package.is_dir(),
        "no {}: run `make setup`",
        package.display()
    );
    let mut scripts = Vec::new();
    let mut pending = vec![PathBuf::from("tutorials"), PathBuf::from("examples")];
    while let Some(folder) = pending.pop() {
        fs::create_dir_all(place.join(&folder)).expect("writable");
        for entry in fs::read_dir(package.join(&folder)).expect("readable") {
            let entry = entry.expect("an entry");
            let name = folder.join(entry.file_name());
            if entry.path().is_dir() {
                pending.push(name);
                continue;
            }
            fs::copy(entry.path(), place.join(&name)).expect("writable");
            if name.extension().is_some_and(|extension| extension == "geo") {
                scripts.push(name);
            }
        }
    }
    scripts.sort();
    scripts
}

/// `check` of the script with all its surfaces and curves as groups: what the page calls its end.
fn outcome(place: &Path, script: &Path) -> &'static str {
    // A file of its own: other scripts include this one.
    let original = place.join(script);
    let text = String::from_utf8_lossy(&fs::read(&original).expect("readable")).into_owned();
    let name = original.file_name().and_then(|name| name.to_str());
    let name = format!("ours_{}", name.expect("a name"));
    let file = original.with_file_name(&name);
    let groups =
        "Physical Surface(\"ours\") = Surface{:};\nPhysical Curve(\"edges\") = Curve{:};\n";
    fs::write(&file, format!("{text}\n{groups}")).expect("writable");
    let pipeline = file.with_extension("yaml");
    let text = format!(
        "name: x\ngeometry: {{ file: {name} }}\nmaterials: {{ m: {{ young: 1 GPa, poisson: 0.3 }} }}\n\
         regions: [ {{ group: ours, model: fem, material: m }} ]\n\
         boundary: [ {{ group: edges, displacement: {{ x: 0, y: 0 }} }} ]\n"
    );
    fs::write(&pipeline, text).expect("writable");
    let [out, err] = ["out", "err"].map(|name| file.with_extension(name));
    let into = |path: &Path| fs::File::create(path).expect("writable");
    let mut child = Command::new(env!("CARGO_BIN_EXE_peristitch"))
        .arg("check")
        .arg(&pipeline)
        .env("NO_COLOR", "1")
        .stdin(Stdio::null())
        .stdout(into(&out))
        .stderr(into(&err))
        .spawn()
        .expect("the binary starts");
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child") {
            break status;
        }
        if start.elapsed() > LIMIT {
            child.kill().expect("it runs");
            panic!("{} hangs", script.display());
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let err = fs::read_to_string(&err).expect("UTF-8");
    let message = || format!("{}: {:?}\n{err}", script.display(), status.code());
    assert!(!err.contains("panicked"), "{}", message());
    if status.code() == Some(0) {
        let out = fs::read_to_string(&out).expect("UTF-8");
        assert!(out.contains("x: sound"), "{}", message());
        return "meshed";
    }
    assert_eq!(
        (status.code(), err.matches("  × ").count()),
        (Some(2), 1),
        "{}",
        message()
    );
    let known = OUTCOMES.iter().find(|(part, _)| err.contains(part));
    known
        .unwrap_or_else(|| panic!("a new kind of end, {}", message()))
        .1
}

#[test]
fn each_is_meshed_or_gives_one_message() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let scripts = copied(place.path());
    // Every tutorial, 1 to 21, and as many demos again.
    let is_tutorial = |script: &&PathBuf| script.starts_with("tutorials");
    assert_eq!(scripts.iter().filter(is_tutorial).count(), 21);
    assert!(scripts.len() > 60, "{}", scripts.len());
    let mut found: BTreeMap<(String, &str), Vec<String>> = BTreeMap::new();
    for script in &scripts {
        let folder = script.parent().expect("a folder").display().to_string();
        let name = script
            .file_stem()
            .and_then(|stem| stem.to_str())
            .expect("a name");
        let outcome = outcome(place.path(), script);
        found
            .entry((folder, outcome))
            .or_default()
            .push(format!("`{name}`"));
    }
    let mut rows = String::new();
    for ((folder, outcome), names) in &found {
        rows += &format!(
            "| `{folder}` | {outcome} | {} | {} |\n",
            names.len(),
            names.join(", ")
        );
    }
    assert!(
        PAGE.contains(&rows),
        "docs/gmsh_tutorials.md should have\n{rows}"
    );
}
