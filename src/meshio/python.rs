//! The search for a Python that has meshio: the one that `$PERISTITCH_PYTHON` names (and then no other), that of the nearest
//! `.venv`, upwards from the current directory and from the executable, or the `python3` on the path.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use crate::gmsh::library::Places;

/// The variable that names the Python to use.
pub const VARIABLE: &str = "PERISTITCH_PYTHON";

/// Tells the version without importing it, which takes as long as all else here.
const PROBE: &str =
    "import importlib.metadata, sys; sys.stdout.write(importlib.metadata.version('meshio'))";

/// A Python that has meshio.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Python {
    pub executable: PathBuf,
    /// Version of meshio.
    pub version: String,
}

/// The first that has it; or what was tried, each with what is the matter.
pub fn find() -> Result<Python, Vec<(PathBuf, String)>> {
    let mut tried = Vec::new();
    for executable in candidates() {
        match version(&executable) {
            Ok(version) => {
                return Ok(Python {
                    executable,
                    version,
                });
            }
            Err(reason) => tried.push((executable, reason)),
        }
    }
    Err(tried)
}

fn candidates() -> Vec<PathBuf> {
    let explicit = std::env::var_os(VARIABLE).filter(|value| !value.is_empty());
    if let Some(explicit) = explicit {
        return vec![PathBuf::from(explicit)];
    }
    let environments = Places::of_this_process().virtual_environments();
    let own = environments.iter().map(|folder| folder.join("bin/python3"));
    own.chain([PathBuf::from("python3")]).collect()
}

fn version(executable: &PathBuf) -> Result<String, String> {
    let probe = Command::new(executable)
        .args(["-c", PROBE])
        .stdin(Stdio::null())
        .output()
        .map_err(|error| error.to_string())?;
    let text = String::from_utf8_lossy(&probe.stdout).trim().to_owned();
    let is_version = text.starts_with(|c: char| c.is_ascii_digit()) && !text.contains('\n');
    match probe.status.success() && is_version {
        true => Ok(text),
        false => Err("it has no meshio".to_owned()),
    }
}
