//! Meshes of other programs, read by meshio (Python) in a child process.
//!
//! ```text
//! .inp, .bdf, .med, .vtu ─ mesh() ─▶ child: import_mesh.py ─▶ Container ─ convert ─▶ Extract ─ to_mesh() ─▶ Mesh
//! ```
//!
//! Sets become physical groups: element sets surfaces (or curves and points, by the elements in them), sides of
//! elements and node sets that trace edges curves, other nodes points.
//!
//! - [`python`]: which Python has meshio.
//! - [`container`]: what the child writes, checked when read.
//! - [`convert`]: which elements count; `node_order`: the order of their nodes, checked by the Jacobian.
//! - `groups`: sets become groups.
//! - [`curves`]: which edges a node set traces.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use serde::Serialize;
use thiserror::Error;

use crate::child::{self, ChildError, End, describe, last_lines};
use crate::gmsh::Extract;

pub mod container;
pub mod convert;
pub mod curves;
mod groups;
mod node_order;
pub mod python;

pub use convert::ConvertError;

/// The child's program.
const IMPORT: (&str, &str) = ("import_mesh.py", include_str!("meshio/import_mesh.py"));
/// The readers that it imports, of `.inp` and of `.bdf`.
const ABAQUS: (&str, &str) = ("abaqus.py", include_str!("meshio/abaqus.py"));
const NASTRAN: (&str, &str) = ("nastran.py", include_str!("meshio/nastran.py"));

/// Extensions of the files that are read: Abaqus, Nastran, MED, VTK.
pub const MESHES: [&str; 7] = ["inp", "bdf", "nas", "fem", "med", "vtu", "vtk"];

/// Settings for running meshio.
#[derive(Clone, Debug)]
pub struct Options {
    /// Time after which the child is killed.
    pub time_limit: Duration,
    /// The most memory that it may take, at most what the machine has [bytes].
    pub memory_limit: u64,
    /// Make all plane elements one group, [`WHOLE`](crate::gmsh::WHOLE), if no set holds any.
    pub whole: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            time_limit: Duration::from_secs(600),
            memory_limit: 16 << 30,
            whole: false,
        }
    }
}

/// Why there is no mesh.
#[derive(Debug, Error)]
pub enum MeshioError {
    #[error(
        "{} is read by meshio, and no Python that has it is found. Run `make setup`, or set ${} to a \
         Python in which `import meshio` works (`pip install meshio`). Tried:{}",
        .file.display(), python::VARIABLE, attempts(.tried)
    )]
    NoPython {
        file: PathBuf,
        tried: Vec<(PathBuf, String)>,
    },
    #[error(
        "{} needs the Python package `{module}`, which {} lacks: {} -m pip install {module}",
        .file.display(), .python.display(), .python.display()
    )]
    ModuleMissing {
        file: PathBuf,
        module: String,
        python: PathBuf,
    },
    #[error("meshio cannot read {}: {reason}", .file.display())]
    Unreadable { file: PathBuf, reason: String },
    #[error("{}: {feature}", .file.display())]
    Unsupported { file: PathBuf, feature: String },
    #[error(
        "meshio ran out of memory on {}: it may take {} MB", .file.display(), .limit / 1_000_000
    )]
    Memory { file: PathBuf, limit: u64 },
    #[error(
        "meshio had not finished {} after {} s and was stopped; its last words:{}",
        .file.display(), .limit.as_secs_f64(), lines(.log)
    )]
    TimeLimit {
        file: PathBuf,
        limit: Duration,
        log: Vec<String>,
    },
    #[error("meshio crashed on {} ({ending}); its last words:{}", .file.display(), lines(.log))]
    Crashed {
        file: PathBuf,
        ending: String,
        log: Vec<String>,
    },
    #[error("what meshio delivered of {} is damaged: {reason}", .file.display())]
    Garbled { file: PathBuf, reason: String },
    #[error("{}: {source}", .file.display())]
    Convert { file: PathBuf, source: ConvertError },
    #[error("cannot run meshio: {action}: {source}")]
    Child {
        action: &'static str,
        source: std::io::Error,
    },
}

/// Returns whether meshio reads a file, by its extension.
pub fn reads(file: &Path) -> bool {
    let extension = file.extension().and_then(|extension| extension.to_str());
    let extension = extension.map(str::to_ascii_lowercase);
    extension.is_some_and(|extension| MESHES.contains(&extension.as_str()))
}

/// The mesh and all files that it includes.
pub fn files(file: &Path) -> Vec<PathBuf> {
    let mut files = vec![file.to_owned()];
    let mut next = 0;
    while let Some(file) = files.get(next).cloned() {
        for included in included_files(&file) {
            if !files.contains(&included) {
                files.push(included);
            }
        }
        next += 1;
    }
    files.sort();
    files
}

/// The existing files that an `.inp` names in `*INCLUDE, INPUT=…`.
fn included_files(file: &Path) -> Vec<PathBuf> {
    if file
        .extension()
        .is_none_or(|e| !e.eq_ignore_ascii_case("inp"))
    {
        return Vec::new();
    }
    let text = std::fs::read(file).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    let named = |line: &str| {
        let (keyword, options) = line.split_once(',')?;
        let is_include = keyword.trim().eq_ignore_ascii_case("*include");
        let (_, name) = options.split_once('=').filter(|_| is_include)?;
        let name = name.trim().trim_matches('"');
        Some(file.parent().unwrap_or(Path::new("")).join(name))
    };
    let found = text.lines().filter_map(named);
    found.filter(|file| file.is_file()).collect()
}

#[derive(Serialize)]
struct Request<'a> {
    file: &'a Path,
    outcome: &'a Path,
    memory: u64,
}

/// Reads a mesh, with its sets as physical groups.
///
/// # Errors
/// See [`MeshioError`].
pub fn mesh(file: &Path, options: &Options) -> Result<Extract, MeshioError> {
    let python = python::find().map_err(|tried| MeshioError::NoPython {
        file: file.to_owned(),
        tried,
    })?;
    let folder = tempfile::tempdir().map_err(child_error("create a temporary folder"))?;
    for (name, text) in [IMPORT, ABAQUS, NASTRAN] {
        let written = std::fs::write(folder.path().join(name), text);
        written.map_err(child_error("write its program"))?;
    }
    let absolute = std::path::absolute(file).map_err(child_error("find the current directory"))?;
    let outcome = folder.path().join("outcome");
    let request = Request {
        file: &absolute,
        outcome: &outcome,
        memory: options.memory_limit,
    };
    let request = serde_json::to_vec(&request)
        .map_err(std::io::Error::from)
        .map_err(child_error("write the request"))?;
    let log_file = folder.path().join("log");
    let mut command = Command::new(&python.executable);
    command
        .arg(folder.path().join(IMPORT.0))
        .env("PYTHONDONTWRITEBYTECODE", "1");
    let end = child::run(&mut command, &request, &log_file, options.time_limit)
        .map_err(|ChildError { action, source }| MeshioError::Child { action, source })?;
    let bytes = std::fs::read(&outcome).ok();
    conclude(file, options, &python.executable, bytes, end, &log_file)
}

fn conclude(
    file: &Path,
    options: &Options,
    python: &Path,
    bytes: Option<Vec<u8>>,
    end: End,
    log: &Path,
) -> Result<Extract, MeshioError> {
    let file = file.to_owned();
    let Some(bytes) = bytes else {
        let log = last_lines(log);
        return Err(match end {
            End::TimeLimit => MeshioError::TimeLimit {
                file,
                limit: options.time_limit,
                log,
            },
            End::Flood => MeshioError::Crashed {
                file,
                ending: "it wrote too many messages".to_owned(),
                log,
            },
            End::Exit(status) => MeshioError::Crashed {
                file,
                ending: describe(status),
                log,
            },
        });
    };
    let read = match container::read(&bytes) {
        Ok(read) => read,
        Err(reason) => return Err(MeshioError::Garbled { file, reason }),
    };
    let container = match read {
        container::Outcome::Mesh(container) => container,
        container::Outcome::Failed { kind, text } => {
            return Err(match kind.as_str() {
                "memory" => MeshioError::Memory {
                    file,
                    limit: options.memory_limit,
                },
                "module" => MeshioError::ModuleMissing {
                    file,
                    module: text,
                    python: python.to_owned(),
                },
                "unsupported" => MeshioError::Unsupported {
                    file,
                    feature: text,
                },
                _ => MeshioError::Unreadable { file, reason: text },
            });
        }
    };
    convert::extract(&container, options.whole)
        .map_err(|source| MeshioError::Convert { file, source })
}

fn child_error(action: &'static str) -> impl Fn(std::io::Error) -> MeshioError {
    move |source| MeshioError::Child { action, source }
}

fn lines(items: &[String]) -> String {
    items.iter().map(|item| format!("\n  {item}")).collect()
}

fn attempts(tried: &[(PathBuf, String)]) -> String {
    let line = |(path, reason): &(PathBuf, String)| format!("\n  {}: {reason}", path.display());
    tried.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn included_files_belong_to_the_mesh() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let write = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).expect("writable");
            folder.path().join(name)
        };
        let nodes = write(
            "nodes.inp",
            "*Include, INPUT=a.inp\n*include,input=gone.inp\n",
        );
        let a = write(
            "a.inp",
            "** *INCLUDE, INPUT=b.inp\n*INCLUDE, INPUT=nodes.inp\n",
        );
        assert_eq!(files(&a), [a.clone(), nodes]);
        let mesh = write("a.vtu", "*INCLUDE, INPUT=a.inp\n");
        assert_eq!(files(&mesh), [mesh]);
    }
}
