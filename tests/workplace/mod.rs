//! A folder with a small hybrid bar and the binary to drive it, as a user would.
#![allow(dead_code)]

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::SystemTime;
use tempfile::TempDir;

pub const BINARY: &str = env!("CARGO_BIN_EXE_peristitch");

/// 64 elements of 50 mm on both sides of 256 material points: a run takes a tenth of a second.
pub const PIPELINE: &str = "\
name: bar
geometry:
  file: geo/bar.geo
  unit: mm
  parameters: { element: 50, order: 2 }
plane: stress
materials:
  solid: { young: 100 GPa, poisson: 1/3 }
regions:
  - { group: [left, right], model: fem, material: solid }
  - group: band
    model: peridynamics
    material: solid
    spacing: 12.5 mm
    horizon: 4
coupling: truss
boundary:
  - { group: clamp, displacement: { x: 0, y: 0 } }
  - { group: load, traction: { x: 1.05 MPa } }
probes:
  tip: { at: [1000 mm, 100 mm], component: x, reference: 1.05e-5 m }
";

/// The paper's plate with one crack, 50 × 20 points: separated after 145 steps, in a third of a
/// second.
pub const PLATE: &str = "\
name: plate
geometry:
  file: geo/plate.geo
  unit: mm
  parameters: { element: 5, order: 2, crack: 10, band: 20 }
materials:
  rock: { young: 30 GPa, poisson: 1/3, tensile_strength: 2.01 MPa, compressive_strength: 20.1 MPa }
regions:
  - { group: grips, model: fem, material: rock }
  - { group: band, model: peridynamics, material: rock, spacing: 1 mm, horizon: 3, micromodulus: raw, surface_correction: none }
cracks: [crack]
boundary:
  - { group: top, displacement: { x: 0, y: 2.0e-8 m } }
  - { group: bottom, displacement: { x: 0, y: -2.0e-8 m } }
loading: { control: one-pass, steps: 200 }
output: { every: 7, pictures: false }
";

pub fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

pub struct Workplace {
    folder: TempDir,
}

/// How the binary ended.
#[derive(Debug)]
pub struct Ended {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl From<Output> for Ended {
    fn from(output: Output) -> Ended {
        Ended {
            code: output.status.code(),
            out: String::from_utf8(output.stdout).expect("UTF-8"),
            err: String::from_utf8(output.stderr).expect("UTF-8"),
        }
    }
}

impl Ended {
    #[track_caller]
    pub fn succeeded(self) -> Ended {
        assert_eq!(self.code, Some(0), "{}", self.err);
        self
    }

    /// The stages that ran, or would run, in their order.
    pub fn stages(&self) -> Vec<&str> {
        let ran = |line: &str| line.contains(" s  ") || line.ends_with("would run");
        let lines = self
            .err
            .lines()
            .chain(self.out.lines())
            .filter(|line| ran(line));
        lines
            .filter_map(|line| line.split_whitespace().nth(1))
            .collect()
    }
}

/// What a run took, in its summary.
const COSTS: [&str; 6] = [
    "phases",
    "seconds",
    "behind",
    "written",
    "memory",
    "peak_memory_bytes",
];

/// A summary without times and memory.
fn without_costs(bytes: &[u8]) -> Vec<u8> {
    let mut summary: Value = serde_json::from_slice(bytes).expect("JSON");
    let entries = summary.as_object_mut().expect("an object");
    for cost in COSTS {
        entries.remove(cost);
    }
    summary.to_string().into_bytes()
}

impl Workplace {
    pub fn new() -> Workplace {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let place = Workplace { folder };
        let geometry = repository().join("geo/cantilever.geo");
        std::fs::create_dir(place.path("geo")).expect("a new folder");
        std::fs::copy(geometry, place.path("geo/bar.geo")).expect("the geometry");
        place.write("bar.yaml", PIPELINE);
        place
    }

    /// The same with the small plate, as `plate.yaml`.
    pub fn with_plate() -> Workplace {
        let place = Workplace::new();
        let geometry = repository().join("geo/plate_mode_i.geo");
        std::fs::copy(geometry, place.path("geo/plate.geo")).expect("the geometry");
        place.write("plate.yaml", PLATE);
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), text).expect("writable");
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Replaces the one place that holds `old`.
    #[track_caller]
    pub fn edit(&self, name: &str, old: &str, new: &str) {
        let text = String::from_utf8(self.read(name)).expect("UTF-8");
        assert_eq!(text.matches(old).count(), 1, "{old:?} in {name}");
        self.write(name, text.replace(old, new));
    }

    /// The program fails with `code` and one message, which has every part of `message`; not a byte has
    /// changed.
    #[track_caller]
    pub fn assert_refused(&self, arguments: &[&str], code: i32, message: &[&str]) {
        let before = self.snapshot();
        let Ended {
            code: ended, err, ..
        } = self.call(arguments);
        assert_eq!(ended, Some(code), "{err}");
        for part in message {
            assert!(err.contains(part), "{part:?} is not in\n{err}");
        }
        assert_eq!(err.matches("  × ").count(), 1, "one message, not\n{err}");
        assert!(!err.contains("panicked"), "{err}");
        assert_eq!(self.snapshot(), before);
        assert!(!self.path("results").exists());
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(BINARY);
        command
            .args(arguments)
            .current_dir(self.folder.path())
            .env("NO_COLOR", "1");
        command.env_remove("RUST_BACKTRACE").stdin(Stdio::null());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    pub fn call(&self, arguments: &[&str]) -> Ended {
        self.command(arguments)
            .output()
            .expect("the binary starts")
            .into()
    }

    /// `run bar.yaml` with more arguments, which must succeed.
    #[track_caller]
    pub fn run(&self, more: &[&str]) -> Ended {
        self.call(&[&["run", "bar.yaml"], more].concat())
            .succeeded()
    }

    pub fn summary(&self) -> Value {
        serde_json::from_slice(&self.read("results/bar/summary.json")).expect("JSON")
    }

    /// A folder of its own with the same files.
    pub fn copy(&self) -> Workplace {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let place = Workplace { folder };
        let mut pending = vec![PathBuf::new()];
        while let Some(below) = pending.pop() {
            for entry in std::fs::read_dir(self.folder.path().join(&below)).expect("readable") {
                let entry = entry.expect("an entry");
                let to = below.join(entry.file_name());
                if entry.path().is_dir() {
                    std::fs::create_dir_all(place.folder.path().join(&to)).expect("a new folder");
                    pending.push(to);
                } else {
                    std::fs::copy(entry.path(), place.folder.path().join(&to)).expect("a copy");
                }
            }
        }
        place
    }

    /// Every file of a results folder but the stamps; of summaries what is no cost.
    pub fn results(&self, folder: &str) -> BTreeMap<String, Vec<u8>> {
        let root = self.path(folder);
        let mut files = BTreeMap::new();
        let mut pending = vec![root.clone()];
        while let Some(folder) = pending.pop() {
            for entry in std::fs::read_dir(&folder).expect("readable") {
                let path = entry.expect("an entry").path();
                if path.is_dir() {
                    pending.extend((!path.ends_with(".stamps")).then_some(path));
                    continue;
                }
                let mut bytes = std::fs::read(&path).expect("a file");
                if path.ends_with("summary.json") {
                    bytes = without_costs(&bytes);
                }
                let name = path.strip_prefix(&root).expect("below it");
                files.insert(name.to_string_lossy().into_owned(), bytes);
            }
        }
        files
    }

    /// Every file below the folder with the hash of its content and its time of modification.
    pub fn snapshot(&self) -> BTreeMap<PathBuf, (String, SystemTime)> {
        let mut files = BTreeMap::new();
        let mut pending = vec![self.folder.path().to_owned()];
        while let Some(folder) = pending.pop() {
            for entry in std::fs::read_dir(folder).expect("readable") {
                let path = entry.expect("an entry").path();
                if path.is_dir() {
                    pending.push(path);
                } else {
                    let time = path
                        .metadata()
                        .and_then(|meta| meta.modified())
                        .expect("a time");
                    let hash =
                        peristitch::pipeline::record::stamp::hash_file(&path).expect("readable");
                    let name = path.strip_prefix(self.folder.path()).expect("below it");
                    files.insert(name.to_owned(), (hash, time));
                }
            }
        }
        files
    }
}
