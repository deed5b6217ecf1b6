//! What README.md and docs/ show is true: every complete pipeline is sound, every command runs, the
//! quoted output and the verification table are what the program computes, no key, option or field
//! goes without mention.

use peristitch::gmsh::library;
use peristitch::pipeline::read::plan::Plan;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

const PROGRAM: &str = env!("CARGO_BIN_EXE_peristitch");
const README: &str = include_str!("../README.md");
const HOWTO_PAGE: &str = include_str!("../docs/howto.md");
const PIPELINE_PAGE: &str = include_str!("../docs/pipeline.md");
const REFERENCE_PAGE: &str = include_str!("../docs/pipeline_reference.md");
const ARCHITECTURE_PAGE: &str = include_str!("../docs/architecture.md");

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// README.md and docs/*.md: path and text.
fn pages() -> Vec<(PathBuf, String)> {
    let docs = fs::read_dir(repository().join("docs")).expect("docs/ exists");
    let mut paths: Vec<PathBuf> = docs.map(|entry| entry.expect("readable").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "md"));
    paths.sort();
    paths.insert(0, repository().join("README.md"));
    let read = |path: PathBuf| {
        let text = fs::read_to_string(&path).expect("a page is text");
        (path, text)
    };
    paths.into_iter().map(read).collect()
}

/// The contents of the fenced blocks of a language.
fn fenced<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let parts = page.split("\n```").skip(1).step_by(2);
    parts
        .filter_map(|block| block.strip_prefix(language)?.strip_prefix('\n'))
        .collect()
}

/// The complete pipelines of a page: name and text.
fn pipelines(page: &str) -> Vec<(&str, &str)> {
    let named = |block| {
        let first = str::lines(block).next()?;
        Some((first.strip_prefix("name:")?.trim(), block))
    };
    fenced(page, "yaml").into_iter().filter_map(named).collect()
}

/// A folder with the project's geo/ and pipelines/, the pipeline that README.md shows and the geometry of
/// docs/howto.md.
fn workplace() -> TempDir {
    let place = tempfile::tempdir().expect("a temporary folder");
    for folder in ["geo", "pipelines"] {
        let copy = place.path().join(folder);
        fs::create_dir(&copy).expect("a new folder");
        for entry in fs::read_dir(repository().join(folder)).expect("a folder of the project") {
            let path = entry.expect("readable").path();
            let name = path.file_name().expect("a file has a name");
            fs::copy(&path, copy.join(name)).expect("a copy");
        }
    }
    for block in fenced(HOWTO_PAGE, "geo") {
        let first = block.lines().next().expect("a block has lines");
        let path = first
            .strip_prefix("// ")
            .and_then(|rest| rest.split(':').next());
        let path = path.expect("the first line of a geometry names its file");
        fs::write(place.path().join(path), format!("{block}\n")).expect("writable");
    }
    for (name, text) in pipelines(README) {
        write_pipeline(&place, name, text);
    }
    place
}

fn write_pipeline(place: &TempDir, name: &str, text: &str) -> String {
    let path = format!("pipelines/{name}.yaml");
    fs::write(place.path().join(&path), text).expect("writable");
    path
}

/// A command in a workplace, with the program on the path and the Gmsh that this process finds.
fn command(program: &str, place: &Path) -> Command {
    let folder = Path::new(PROGRAM)
        .parent()
        .expect("a program lies in a folder");
    let path = std::env::var("PATH").unwrap_or_default();
    let found = library::Places::of_this_process().search().found;
    let mut command = Command::new(program);
    command
        .current_dir(place)
        .env("PATH", format!("{}:{path}", folder.display()));
    command.env(
        library::VARIABLE,
        found.first().expect("a Gmsh library; run `make setup`"),
    );
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn succeeded(what: &str, output: &Output) -> String {
    assert!(
        output.status.success(),
        "{what}: {}\n{}",
        output.status,
        text(&output.stderr)
    );
    text(&output.stdout)
}

fn run(place: &TempDir, arguments: &[&str]) -> String {
    let output = command(PROGRAM, place.path())
        .args(arguments)
        .output()
        .expect("it starts");
    succeeded(&arguments.join(" "), &output)
}

fn summary(place: &TempDir, name: &str) -> Value {
    let path = place.path().join("results").join(name).join("summary.json");
    serde_json::from_slice(&fs::read(path).expect("a summary")).expect("JSON")
}

#[test]
fn every_complete_pipeline_is_sound() {
    let place = workplace();
    let pages = pages();
    let shown: Vec<(&str, &str)> = pages.iter().flat_map(|(_, page)| pipelines(page)).collect();
    assert_eq!(shown.len(), 4, "README.md has one, docs/pipeline.md three");
    for (name, text) in shown {
        let stdout = run(&place, &["check", &write_pipeline(&place, name, text)]);
        assert!(stdout.starts_with(&format!("{name}: sound\n")), "{stdout}");
    }
    let files =
        std::fs::read_dir(place.path().join("results/every_key")).expect("the mesh is kept");
    let mut names: Vec<_> = files
        .map(|file| file.expect("an entry").file_name())
        .collect();
    names.sort();
    assert_eq!(names, [".stamps", "mesh.bin"], "check writes nothing else");
}

#[test]
fn every_command_runs() {
    let place = workplace();
    let mut counts = [0, 0];
    for page in [README, HOWTO_PAGE, PIPELINE_PAGE] {
        for line in fenced(page, "sh").into_iter().flat_map(str::lines) {
            let output = if let Some(target) = line.strip_prefix("make ") {
                counts[0] += 1;
                let mut make = command("make", repository());
                make.arg("-n").args(target.split(' ')).output()
            } else if line.starts_with("peristitch ") {
                counts[1] += 1;
                command("sh", place.path()).args(["-c", line]).output()
            } else {
                assert!(line.starts_with("export PATH="), "what is `{line}`?");
                continue;
            };
            succeeded(line, &output.expect("it starts"));
        }
    }
    assert_eq!(counts, [2, 15], "make and peristitch commands");
    for inline in README.split('`').filter(|word| word.starts_with("make ")) {
        let arguments = inline.split(' ').skip(1);
        let output = command("make", repository())
            .arg("-n")
            .args(arguments)
            .output();
        succeeded(inline, &output.expect("it starts"));
    }
}

#[test]
fn the_quoted_output_is_what_the_program_prints() {
    let place = workplace();
    let printed = run(&place, &["run", "pipelines/plate_mode_i.yaml", "--brief"]);
    let quoted = fenced(README, "text");
    let quoted = quoted.first().expect("README.md quotes the output");
    assert_eq!(quoted.trim(), printed.trim());
    let peak = &summary(&place, "plate_mode_i")["fracture"]["peak"]["reaction_n"];
    let peak = format!("and {:.4e} N", peak.as_f64().expect("a number"));
    assert!(quoted.contains(&peak), "README.md does not say {peak}");
}

/// `1.0268e-5 m: …` → the number and how it is written.
fn length(cell: &str) -> Option<(f64, &str)> {
    let written = cell.trim().split(' ').next()?;
    Some((written.parse().ok()?, written))
}

/// How the table writes a relative difference.
fn percent(value: f64) -> String {
    let written = format!("{:+.2} %", 100.0 * value).replace('-', "−");
    match written.as_str() {
        "+0.00 %" | "−0.00 %" => "0.00 %".to_owned(),
        _ => written,
    }
}

#[test]
fn the_verification_table_is_measured() {
    let place = workplace();
    let table = README
        .split("## Verification")
        .nth(1)
        .expect("there is such a section");
    let rows = table.lines().filter(|line| line.contains("| `cantilever_"));
    let mut count = 0;
    for row in rows {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let &[_, name, reference, measured, error, against_bar] = cells.as_slice() else {
            panic!("six columns: {row}");
        };
        let name = name.trim_matches('`');
        run(
            &place,
            &[
                "run",
                &format!("pipelines/{name}.yaml"),
                "--until",
                "output",
            ],
        );
        let probe = &summary(&place, name)["probes"][0];
        let u = probe["displacement_m"].as_f64().expect("a number");
        let (_, written) = length(measured).expect("a measured length");
        let digits = written
            .split(['.', 'e'])
            .nth(1)
            .expect("digits behind the point");
        let decimals = digits.len();
        assert_eq!(written, format!("{u:.decimals$e}"), "{name}");
        match length(reference) {
            Some((reference, _)) => assert_eq!(error, percent(u / reference - 1.0), "{name}"),
            None => assert_eq!((reference, error), ("none in the paper", "–"), "{name}"),
        }
        let bar = percent(u / 1.05e-5 - 1.0);
        assert_eq!(against_bar.split(" (").next(), Some(bar.as_str()), "{name}");
        count += 1;
    }
    assert_eq!(count, 5, "one row per pipeline");
}

/// The choices that a message about the unknown key or word `zz` lists.
fn choices(place: &TempDir, setting: &str) -> Vec<String> {
    let path = place.path().join("pipelines/every_key.yaml");
    let error = Plan::read(&path, &[setting.to_owned()], None).expect_err(setting);
    let help = error
        .help
        .unwrap_or_else(|| panic!("{setting}: {}", error.message));
    help.split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_key_and_word_of_a_pipeline_is_described() {
    let place = workplace();
    for (name, text) in pipelines(PIPELINE_PAGE) {
        write_pipeline(&place, name, text);
    }
    let settings = [
        "zz=1",
        "geometry.zz=1",
        "materials.rock.zz=1",
        "regions.0.zz=1",
        "coupling.zz=1",
        "coupling.truss.zz=1",
        "boundary.0.zz=1",
        "boundary.0.where={zz: 1}",
        "boundary.0.displacement.zz=1",
        "loading.zz=1",
        "probes.tip.zz=1",
        "output.zz=1",
        "plane=zz",
        "regions.0.model=zz",
        "regions.1.kernel=zz",
        "regions.1.points=zz",
        "regions.1.cell_area=zz",
        "regions.1.partial_area=zz",
        "coupling=zz",
        "coupling.truss.node_area=zz",
        "loading.control=zz",
        "loading.until=zz",
        "probes.tip.component=zz",
        "output.fields=[zz]",
    ];
    let words: BTreeSet<String> = settings
        .iter()
        .flat_map(|setting| choices(&place, setting))
        .collect();
    assert!(words.len() >= 50, "{words:?}");
    for word in words {
        assert!(
            REFERENCE_PAGE.contains(&format!("`{word}`")),
            "`{word}` is not described"
        );
    }
}

#[test]
fn every_command_and_option_is_described() {
    let place = workplace();
    let help = run(&place, &["--help"]);
    let list = help
        .split("Commands:")
        .nth(1)
        .and_then(|rest| rest.split("Options:").next());
    let commands = list.expect("the help lists the commands").lines();
    let commands: Vec<&str> = commands
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(
        commands.len() >= 10 && commands.ends_with(&["help"]),
        "{commands:?}"
    );
    for command in &commands[..commands.len() - 1] {
        assert!(
            PIPELINE_PAGE.contains(&format!("| `{command}` |")),
            "{command}"
        );
        let help = run(&place, &[command, "--help"]);
        let words = help
            .split_whitespace()
            .filter(|word| word.starts_with("--") && word.len() > 2);
        for option in words {
            assert!(
                PIPELINE_PAGE.contains(&format!("`{option}")),
                "{option} of {command}"
            );
        }
    }
}

#[test]
fn every_field_in_the_files_is_described() {
    let place = workplace();
    let pipeline = "pipelines/cantilever_hybrid_q8.yaml";
    let coarse = [
        "--set",
        "regions.1.spacing=10 mm",
        "--set",
        "output.bonds=true",
        // Meets no bond, but then damage is written.
        "--set",
        "cracks=[load]",
    ];
    run(&place, &[&["run", pipeline], coarse.as_slice()].concat());
    let folder = place.path().join("results/cantilever_hybrid_q8");
    let mut names = BTreeSet::new();
    for part in ["elements", "points", "bonds"] {
        let file = folder.join(format!("cantilever_hybrid_q8_{part}.vtu"));
        let vtu = text(&fs::read(file).expect("a part"));
        let arrays = vtu.split(" Name=\"").skip(1);
        names.extend(arrays.filter_map(|rest| Some(rest.split_once('"')?.0.to_owned())));
    }
    for grid in ["Points", "connectivity", "offsets", "types"] {
        assert!(names.remove(grid), "{grid} is part of every grid");
    }
    let table = PIPELINE_PAGE
        .split("### Fields")
        .nth(1)
        .expect("there is such a section");
    let rows = table.split("## Errors").next().expect("a section").lines();
    let described = rows.filter_map(|row| row.strip_prefix("| `")?.split('`').next());
    assert_eq!(names, described.map(str::to_owned).collect());
    assert_eq!(names.len(), 12);
}

/// Rust files below a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder of sources");
    let paths = entries.map(|entry| entry.expect("readable").path());
    paths
        .flat_map(|path| {
            if path.is_dir() {
                sources(&path)
            } else {
                vec![path]
            }
        })
        .collect()
}

/// The modules that each module directly in `folder` imports from it, serde included; tests and comments
/// are left out. `path` is the folder's own: `crate`, or a module.
fn imports(folder: &Path, path: &str) -> BTreeMap<String, BTreeSet<String>> {
    let path = format!("{path}::");
    let mut imports: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let is_code = |file: &PathBuf| !file.ends_with("tests.rs");
    for file in sources(folder).into_iter().filter(is_code) {
        let inside = file.strip_prefix(folder).expect("it was found there");
        let first = inside.iter().next().expect("a path has a name");
        let module = Path::new(first).with_extension("").display().to_string();
        // Only there does `super` mean the folder.
        let is_direct = inside.components().count() == 1;
        let text = fs::read_to_string(&file).expect("a source is text");
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        let of_module = imports.entry(module.clone()).or_default();
        let is_code = |line: &&str| !line.trim_start().starts_with("//");
        for line in code.lines().filter(is_code) {
            let siblings = line.split("super::").skip(1).filter(|_| is_direct);
            for rest in line.split(&path).skip(1).chain(siblings) {
                let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_');
                of_module.insert(rest[..end.unwrap_or(rest.len())].to_owned());
            }
            // Deriving it is free to all.
            let derives = ["use serde::{Deserialize, Serialize};", "#[serde("];
            let calls = !derives
                .iter()
                .any(|derive| line.trim_start().starts_with(derive));
            if line.contains("serde") && calls {
                of_module.insert("serde".to_owned());
            }
        }
        of_module.remove(&module);
    }
    imports
}

/// A table of docs/architecture.md: a module in each row, and what it imports, which stands above it.
fn import_table(heading: &str) -> BTreeMap<String, BTreeSet<String>> {
    let section = ARCHITECTURE_PAGE.split(&format!("\n{heading}\n")).nth(1);
    let section = section.expect("there is such a section");
    let section = section.split("\n#").next().expect("a section");
    let names = |cell: &str| {
        let words = cell.split('`').skip(1).step_by(2);
        words.map(str::to_owned).collect::<Vec<String>>()
    };
    let mut table: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for row in section.lines().filter(|row| row.starts_with("| `")) {
        let cells: Vec<&str> = row.trim_matches('|').split('|').collect();
        let module = names(cells[0]).remove(0);
        let imported: BTreeSet<String> = names(cells[1]).into_iter().collect();
        assert!(
            imported.iter().all(|name| table.contains_key(name)),
            "{module} imports what comes later: a cycle?"
        );
        table.insert(module, imported);
    }
    table
}

#[test]
fn the_import_tables_are_those_of_the_sources() {
    let src = repository().join("src");
    let mut found = imports(&src, "crate");
    found.retain(|module, _| module != "main" && module != "lib");
    let may_serialise = ["gmsh", "meshio", "pipeline", "cli"];
    for (module, imported) in &mut found {
        let serialises = imported.remove("serde");
        assert!(
            !serialises || may_serialise.contains(&module.as_str()),
            "{module} uses serde"
        );
    }
    assert_eq!(import_table("## Imports"), found);
    assert_eq!(found.len(), 25);
    let mut rooms = imports(&src.join("pipeline"), "crate::pipeline");
    for imported in rooms.values_mut() {
        imported.remove("serde");
    }
    assert_eq!(import_table("### Rooms of the pipeline"), rooms);
}

#[test]
fn the_files_of_fracture_import_each_other_without_a_circle() {
    let mut rest = imports(&repository().join("src/fracture"), "crate::fracture");
    assert!(rest.len() > 20, "{rest:?}");
    // Files that import none of the rest go first, until no file is left.
    while !rest.is_empty() {
        let others = rest.clone();
        rest.retain(|_, imported| imported.iter().any(|name| others.contains_key(name)));
        assert!(
            rest.len() < others.len(),
            "a circle among {:?}",
            rest.keys()
        );
    }
}

#[test]
fn unsafe_code_is_where_the_architecture_says() {
    let allows = |path: &PathBuf| {
        let text = fs::read_to_string(path).expect("a source is text");
        text.contains("allow(unsafe_code)")
    };
    let src = repository().join("src");
    let mut found: Vec<PathBuf> = sources(&src).into_iter().filter(allows).collect();
    found.sort();
    assert_eq!(
        found,
        ["gmsh/ffi.rs", "linear_solver/metis.rs"].map(|file| src.join(file))
    );
}

/// GitHub's anchor of a heading.
fn anchor(heading: &str) -> String {
    let kept = heading
        .chars()
        .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.collect::<String>()
        .trim()
        .to_lowercase()
        .replace(' ', "-")
}

#[test]
fn links_between_pages_lead_somewhere() {
    for (page, text) in pages() {
        let folder = page.parent().expect("a page lies in a folder");
        let links = text
            .split("](")
            .skip(1)
            .filter_map(|rest| rest.split(')').next());
        for link in links.filter(|link| !link.contains("://")) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() {
                page.clone()
            } else {
                folder.join(file)
            };
            assert!(target.exists(), "{}: {link}", page.display());
            if !heading.is_empty() {
                let text = fs::read_to_string(&target).expect("a page");
                let headings = text.lines().filter(|line| line.starts_with('#'));
                let mut anchors = headings.map(|line| anchor(line.trim_start_matches('#')));
                assert!(anchors.any(|a| a == heading), "{}: {link}", page.display());
            }
        }
    }
}
