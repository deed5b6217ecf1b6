//! What is linked into the program: licences, where it comes from, what is there twice; Python packages
//! pinned with their hashes; and where the code is `unsafe`. From `cargo metadata`, so that neither network nor tool is needed;
//! `make audit` asks cargo-deny as well.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn text(file: &str) -> String {
    std::fs::read_to_string(repository().join(file))
        .unwrap_or_else(|error| panic!("{file}: {error}"))
}

/// All packages of the lock file, those of other systems too, which a build has not fetched.
fn packages() -> Vec<Value> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked"])
        .current_dir(repository())
        .output()
        .expect("cargo starts");
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{told}");
    let mut metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    match metadata["packages"].take() {
        Value::Array(packages) => packages,
        other => panic!("{other}"),
    }
}

/// `allow` of `deny.toml`: one list for both.
fn allowed() -> BTreeSet<String> {
    let text = text("deny.toml");
    let list = text.split("allow = [").nth(1).expect("a list");
    let list = list.split(']').next().expect("its end");
    list.split('"')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect()
}

/// Whether a licence expression can be met with the allowed ones; AND binds closer than OR, and the only
/// brackets are around one of the two.
fn may_be_used(expression: &str, allowed: &BTreeSet<String>) -> bool {
    if let (Some(open), Some(close)) = (expression.find('('), expression.find(')')) {
        let inside = may_be_used(&expression[open + 1..close], allowed);
        let word = if inside { "MIT" } else { "none" };
        let flat = format!("{}{word}{}", &expression[..open], &expression[close + 1..]);
        return may_be_used(&flat, allowed);
    }
    let any = expression.replace('/', " OR ");
    any.split(" OR ").any(|all| {
        let mut words = all.split(" AND ").map(str::trim);
        words.all(|word| allowed.contains(word))
    })
}

#[test]
fn every_licence_is_permissive() {
    let allowed = allowed();
    let refused: Vec<String> = (packages().iter())
        .filter(|p| {
            !p["license"]
                .as_str()
                .is_some_and(|l| may_be_used(l, &allowed))
        })
        .map(|p| format!("{} {}: {}", p["name"], p["version"], p["license"]))
        .collect();
    assert!(refused.is_empty(), "{refused:#?}");
    for (expression, is_free) in [
        ("GPL-3.0", false),
        ("MIT AND GPL-3.0", false),
        ("GPL-3.0 OR MIT", true),
        ("(MIT OR Apache-2.0) AND OFL-1.1", true),
        ("(MIT OR Apache-2.0) AND GPL-2.0", false),
        ("Unlicense/MIT", true),
    ] {
        assert_eq!(may_be_used(expression, &allowed), is_free, "{expression}");
    }
}

#[test]
fn everything_comes_from_the_registry_with_a_checksum() {
    let foreign: Vec<String> = (packages().iter())
        .filter(|p| p["name"] != "peristitch")
        .filter(|p| {
            !p["source"].as_str().is_some_and(|s| {
                s.starts_with("registry+https://github.com/rust-lang/crates.io-index")
            })
        })
        .map(|p| p["name"].to_string())
        .collect();
    assert!(foreign.is_empty(), "{foreign:?}");
    let lock = text("Cargo.lock");
    assert_eq!(
        lock.matches("\nsource = ").count(),
        lock.matches("\nchecksum = ").count()
    );
}

/// Packages that are there in several versions, none of them ours to choose; a new one has to be looked at.
const TWICE: [&str; 12] = [
    // nalgebra's optional conversions from each version of glam: never built.
    "glam",
    "embedded-io",
    "equator",
    "equator-macro",
    "foldhash",
    "hashbrown",
    "miniz_oxide",
    "syn",
    "thiserror",
    "thiserror-impl",
    "unicode-width",
    "windows-sys",
];

#[test]
fn nothing_new_is_there_twice() {
    let mut versions: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for package in packages() {
        let [name, version] =
            ["name", "version"].map(|key| package[key].as_str().expect("text").to_owned());
        versions.entry(name).or_default().insert(version);
    }
    let twice = versions.iter().filter(|(_, versions)| versions.len() > 1);
    let new: Vec<_> = twice
        .filter(|(name, _)| !TWICE.contains(&name.as_str()))
        .collect();
    assert!(new.is_empty(), "{new:?}");
}

/// `name==version` of each package in a list of Python packages, names written as PyPI compares them.
fn pins(list: &str) -> BTreeSet<String> {
    let lines = list
        .lines()
        .filter(|line| line.starts_with(char::is_alphanumeric));
    lines
        .map(|line| {
            let pin = line.trim_end_matches('\\').trim();
            let (name, version) = pin
                .split_once("==")
                .unwrap_or_else(|| panic!("no version: {line}"));
            format!(
                "{}=={version}",
                name.to_lowercase().replace(['_', '.'], "-")
            )
        })
        .collect()
}

/// `.ci/setup` installs from hashes.txt alone.
#[test]
fn python_packages_are_pinned_with_hashes() {
    let hashes = text("tests/python/hashes.txt");
    let [asked, snakemake] = ["requirements.txt", "snakemake.txt"]
        .map(|file| pins(&text(&format!("tests/python/{file}"))));
    let asked: BTreeSet<String> = asked.union(&snakemake).cloned().collect();
    assert!(asked.len() > 50);
    assert_eq!(
        asked,
        pins(&hashes),
        "`make hashes` brings hashes.txt up to date"
    );
    let joined = hashes.replace("\\\n", " ");
    for package in joined.lines().filter(|line| !line.starts_with('#')) {
        let hashes: Vec<&str> = package
            .split("--hash=sha256:")
            .skip(1)
            .map(str::trim)
            .collect();
        assert!(!hashes.is_empty(), "{package}");
        assert!(hashes.iter().all(|hash| hash.len() == 64), "{package}");
    }
}

/// The two files that docs/architecture.md names.
#[test]
fn unsafe_code_stands_in_the_bindings_of_gmsh_and_metis() {
    let mut found = BTreeSet::new();
    let mut pending = vec![repository().join("src")];
    while let Some(folder) = pending.pop() {
        for entry in std::fs::read_dir(folder).expect("readable") {
            let path: PathBuf = entry.expect("an entry").path();
            if path.is_dir() {
                pending.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let source = std::fs::read_to_string(&path).expect("UTF-8");
                let is_used = source.lines().any(|line| {
                    let code = line.split("//").next().unwrap_or_default();
                    [
                        "unsafe {",
                        "unsafe fn",
                        "unsafe impl",
                        "unsafe extern",
                        "allow(unsafe_code)",
                    ]
                    .iter()
                    .any(|word| code.contains(word))
                });
                if is_used {
                    let name = path.strip_prefix(repository().join("src")).expect("below");
                    found.insert(name.to_string_lossy().into_owned());
                }
            }
        }
    }
    let expected = [
        "gmsh/ffi.rs",
        "gmsh/ffi/copies.rs",
        "gmsh/ffi/functions.rs",
        "linear_solver/metis.rs",
    ];
    assert_eq!(found, BTreeSet::from(expected.map(str::to_owned)));
    assert!(text("src/lib.rs").contains("#![deny(unsafe_code)]"));
}
