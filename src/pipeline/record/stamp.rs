//! Is a stage's result still good? One manifest per stage: the stage's version, its settings, the
//! hashes of its inputs and of its outputs. Fresh means that all of it is the same now; times of
//! modification play no part.

use crate::output::{WriteError, write_durable};
use crate::pipeline::account::costs::Costs;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Component, Path, PathBuf};

/// The stages in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Geometry → mesh.
    Mesh,
    /// Mesh → displacements.
    Solve,
    /// Displacements → VTU, pictures, summary.
    Output,
}

impl Stage {
    pub const ALL: [Stage; 3] = [Stage::Mesh, Stage::Solve, Stage::Output];

    /// Raised whenever the stage's results change for the same input.
    fn version(self) -> u32 {
        match self {
            Stage::Mesh => 3,
            Stage::Solve => 10,
            Stage::Output => 7,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Stage::Mesh => "mesh",
            Stage::Solve => "solve",
            Stage::Output => "output",
        }
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Settings and inputs from which a stage was made.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Recipe {
    version: u32,
    /// Key in the pipeline file → canonical value.
    pub settings: BTreeMap<String, String>,
    /// Input → hash of its content.
    pub inputs: BTreeMap<String, String>,
}

impl Recipe {
    pub fn new(
        stage: Stage,
        settings: BTreeMap<String, String>,
        inputs: BTreeMap<String, String>,
    ) -> Recipe {
        Recipe {
            version: stage.version(),
            settings,
            inputs,
        }
    }

    /// Leaves out of a comparison with `manifest` what earlier stages deliver.
    pub fn assume_inputs_of(&mut self, manifest: Option<Manifest>) {
        if let Some(old) = manifest.and_then(|manifest| manifest.recipe) {
            self.inputs = old.inputs;
        }
    }

    /// Differences from the recipe `now`, one line each.
    fn differences(&self, now: &Recipe) -> Vec<String> {
        let mut lines = Vec::new();
        if self.version != now.version {
            lines.push("this version of peristitch computes it differently".to_owned());
        }
        lines.extend(map_differences(
            &self.settings,
            &now.settings,
            |key, old, new| {
                format!(
                    "{key}: {} → {}",
                    old.unwrap_or("(none)"),
                    new.unwrap_or("(none)")
                )
            },
        ));
        lines.extend(map_differences(
            &self.inputs,
            &now.inputs,
            |key, old, new| match (old, new) {
                (None, _) => format!("{key} is a new input"),
                (_, None) => format!("{key} is no longer an input"),
                _ => format!("{key} has changed"),
            },
        ));
        lines
    }
}

fn map_differences(
    old: &BTreeMap<String, String>,
    new: &BTreeMap<String, String>,
    describe: impl Fn(&str, Option<&str>, Option<&str>) -> String,
) -> Vec<String> {
    let keys: std::collections::BTreeSet<&String> = old.keys().chain(new.keys()).collect();
    keys.into_iter()
        .filter(|key| old.get(*key) != new.get(*key))
        .map(|key| {
            describe(
                key,
                old.get(key).map(String::as_str),
                new.get(key).map(String::as_str),
            )
        })
        .collect()
}

/// A recipe and what came of it, as it stands in `.stamps/STAGE.json`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Manifest {
    /// Absent while the stage is writing.
    pub recipe: Option<Recipe>,
    /// File in the results folder → hash of its content.
    pub outputs: BTreeMap<String, String>,
    /// Costs of the stage. They stand here, and not in the outputs, so that equal work gives equal bytes.
    #[serde(default)]
    pub costs: Costs,
}

/// Why a stage must run; empty where its result is good.
pub type Reasons = Vec<String>;

pub fn path(folder: &Path, stage: Stage) -> PathBuf {
    folder.join(".stamps").join(format!("{stage}.json"))
}

/// `None` as well for one that no stage has written: outputs are hashed, replaced and removed by
/// these names.
pub fn read(folder: &Path, stage: Stage) -> Option<Manifest> {
    let bytes = std::fs::read(path(folder, stage)).ok()?;
    let manifest: Manifest = serde_json::from_slice(&bytes).ok()?;
    let stays_inside = manifest.outputs.keys().all(|name| is_inside(name));
    stays_inside.then_some(manifest)
}

/// Whether a name leads to a file below the results folder, and not to the stamps.
fn is_inside(name: &str) -> bool {
    let mut parts = Path::new(name).components().peekable();
    parts
        .peek()
        .is_some_and(|first| first.as_os_str() != ".stamps")
        && parts.all(|part| matches!(part, Component::Normal(_)))
}

/// # Errors
/// A folder that cannot be written to.
pub fn write(folder: &Path, stage: Stage, manifest: &Manifest) -> Result<(), WriteError> {
    let text = serde_json::to_string_pretty(manifest).expect("a manifest is plain data");
    write_durable(&path(folder, stage), text.as_bytes())
}

/// Compares the manifest on disk with the recipe of now and with the files that it lists.
pub fn stale(folder: &Path, stage: Stage, recipe: &Recipe) -> Reasons {
    let Some(manifest) = read(folder, stage) else {
        return vec!["it has not run yet".to_owned()];
    };
    let Some(old) = &manifest.recipe else {
        return vec!["its last run was interrupted".to_owned()];
    };
    let mut reasons = old.differences(recipe);
    for (name, hash) in &manifest.outputs {
        match hash_file(&folder.join(name)) {
            None => reasons.push(format!("{name} is missing")),
            Some(now) if now != *hash => {
                reasons.push(format!("{name} is not what the stage wrote"))
            }
            Some(_) => {}
        }
    }
    reasons
}

/// The hash of a file's content, if it can be read. A device or a pipe, which may never end, cannot.
pub fn hash_file(path: &Path) -> Option<String> {
    if !path.is_file() {
        return None;
    }
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(std::fs::File::open(path).ok()?).ok()?;
    Some(hasher.finalize().to_hex().to_string())
}

pub fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}
