//! From a `.geo` file to a mesh, by Gmsh.
//!
//! Gmsh is loaded at run time and runs in a child process of our own binary, one per mesh, because
//! its state is global, an error poisons it, and it can crash or run away: all of that becomes a
//! [`GmshError`] with Gmsh's log. The way of the data:
//!
//! ```text
//! .geo, parameters ─ mesh() ─▶ child: worker ─ ffi ─▶ Extract ─ to_mesh() ─▶ Mesh
//! ```
//!
//! - [`library`]: where the shared library is sought.
//! - [`geo_script`]: which parameters a `.geo` offers, and which files it depends upon.
//! - [`parameter`]: which values a parameter may have; `given_parameters`: those of the pipeline.
//! - [`extract`]: the physical groups that Gmsh delivered, as they are cached.
//! - [`to_mesh`]: the checks and the conversion to metres.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::child::{self, ChildError, End, describe, last_lines};
use serde::{Deserialize, Serialize};

mod error;
pub mod extract;
mod extract_check;
mod ffi;
mod ffi_types;
mod gather;
pub mod geo_script;
mod given_parameters;
pub mod guard;
pub mod library;
mod message;
pub mod parameter;
mod sandbox;
mod script_files;
mod script_text;
pub mod to_mesh;
mod worker;

pub use error::GmshError;
pub use extract::{Block, Extract, Group, Origin, WHOLE};
pub use extract_check::ExtractError;
pub use geo_script::{GeoScript, ScriptError};
use given_parameters::{add_known_values, arguments, check_parameters};
use guard::ScriptCommand;
pub use message::Message;
pub use worker::worker_main;

/// The hidden subcommand under which the binary runs [`worker_main`].
pub const WORKER_COMMAND: &str = "mesh-worker";

/// Extensions of the files that Gmsh has to mesh.
const GEOMETRIES: [&str; 5] = ["geo", "geo_unrolled", "brep", "step", "stp"];

/// A value for a parameter of the geometry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Value {
    Number(f64),
    Text(String),
}

impl Value {
    pub fn number(self) -> Option<f64> {
        match self {
            Value::Number(number) => Some(number),
            Value::Text(_) => None,
        }
    }
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Value::Number(number) => write!(f, "{number}"),
            Value::Text(text) => write!(f, "'{text}'"),
        }
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Value {
        Value::Number(number)
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Value {
        Value::Text(text.to_owned())
    }
}

/// Settings for running Gmsh.
#[derive(Clone, Debug)]
pub struct Options {
    /// The executable that serves [`WORKER_COMMAND`]; None for the running one.
    pub worker: Option<PathBuf>,
    /// The library to use; None for the search of [`library::Places`].
    pub library: Option<PathBuf>,
    /// Time after which the worker is killed.
    pub time_limit: Duration,
    /// Let a script run programs and write files.
    pub trust: bool,
    /// Physical groups that must exist; a missing one is reported before the model is meshed. [`WHOLE`] is made
    /// of all surfaces if none is in a group.
    pub groups: Vec<String>,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            worker: None,
            library: None,
            time_limit: Duration::from_secs(600),
            trust: false,
            groups: Vec::new(),
        }
    }
}

/// Meshes `geometry` in two dimensions (a `.msh` is taken as it is), with `parameters` in place of
/// the defaults of its `DefineConstant`s.
pub fn mesh(
    geometry: &Path,
    parameters: &BTreeMap<String, Value>,
    options: &Options,
) -> Result<Extract, GmshError> {
    if !geometry.is_file() {
        return Err(GmshError::FileMissing {
            file: geometry.to_owned(),
        });
    }
    let mesh_dimension = mesh_dimension(geometry)?;
    let script = read_script(geometry)?;
    let saves = match &script {
        Some(script) if !options.trust => {
            if let Some(command) = script.unsafe_commands.first() {
                return Err(GmshError::UnsafeCommand(command.clone()));
            }
            script.saves.as_slice()
        }
        _ => &[],
    };
    check_parameters(geometry, script.as_ref(), parameters)?;
    let libraries = libraries(options)?;
    let folder = tempfile::tempdir().map_err(worker_error("create a temporary folder"))?;
    let request = worker::Request {
        geometry: absolute_text(geometry)?,
        mesh_dimension,
        arguments: arguments(parameters),
        parameters: script
            .iter()
            .flat_map(|script| script.parameters.keys().cloned())
            .collect(),
        libraries,
        outcome: folder.path().join("outcome"),
        trust: options.trust,
        first_save: saves.first().cloned(),
        // The triangles of a merged scan are then the drawing, and not the mesh.
        anew: script
            .as_ref()
            .is_some_and(|script| script.creates_geometry && !script.meshes),
        groups: options.groups.clone(),
    };
    let log_file = folder.path().join("log");
    let end = run_worker(&request, &log_file, options)?;
    let log = last_lines(&log_file);
    let concluded = conclude(geometry, &request, end, log, options.time_limit);
    let mut extract = concluded.map_err(|error| locate_absent(error, script.as_ref()))?;
    if let Some(script) = &script {
        add_known_values(&mut extract.parameters, script, parameters);
        let note =
            |save: &ScriptCommand| format!("{}:{}: {}", save.file.display(), save.line, save.what);
        let of_script = script.warnings.iter().cloned();
        let notes = of_script.chain(saves.iter().map(note));
        extract.warnings.splice(0..0, notes);
    }
    Ok(extract)
}

/// Gmsh does not tell where a script names a file that cannot be opened.
fn locate_absent(mut error: GmshError, script: Option<&GeoScript>) -> GmshError {
    let (GmshError::Failed { errors, .. }, Some(script)) = (&mut error, script) else {
        return error;
    };
    for message in errors.iter_mut().filter(|message| message.file.is_none()) {
        let is_named = |named: &&script_files::NamedFile| {
            let name = named.path.file_name().and_then(|name| name.to_str());
            message.text.starts_with("Unable to open")
                && name.is_some_and(|n| message.text.contains(n))
        };
        if let Some(named) = script.absent.iter().find(is_named) {
            message.file = Some(named.file.clone());
            message.line = u32::try_from(named.line).ok();
        }
    }
    error
}

/// Reads a script without running it; None for other files.
pub fn read_script(file: &Path) -> Result<Option<GeoScript>, GmshError> {
    let extension = file.extension().and_then(|extension| extension.to_str());
    let is_script = extension.is_some_and(|extension| {
        ["geo", "geo_unrolled"]
            .iter()
            .any(|known| extension.eq_ignore_ascii_case(known))
    });
    Ok(is_script.then(|| GeoScript::scan(file)).transpose()?)
}

fn conclude(
    geometry: &Path,
    request: &worker::Request,
    end: End,
    log: Vec<String>,
    limit: Duration,
) -> Result<Extract, GmshError> {
    let geometry = geometry.to_owned();
    match (worker::read_outcome(&request.outcome), end) {
        (Some(worker::Outcome::Done(extract)), _) => Ok(extract),
        (Some(worker::Outcome::NoLibrary(tried)), _) => Err(GmshError::LibraryNotLoaded { tried }),
        (
            Some(worker::Outcome::GroupMissing {
                available,
                surfaces,
            }),
            _,
        ) => Err(GmshError::GroupMissing {
            geometry,
            available,
            surfaces,
        }),
        (Some(worker::Outcome::CannotPassOver(save)), _) => {
            let what = "Save writes a file, which this kernel cannot prevent".to_owned();
            Err(GmshError::UnsafeCommand(ScriptCommand { what, ..save }))
        }
        (Some(worker::Outcome::Failed(mut errors)), _) => {
            for error in &mut errors {
                // The user's own name for the file reads better than its absolute path.
                let file = error.file.as_deref();
                if file == Some(Path::new(&request.geometry)) {
                    error.file = Some(geometry.clone());
                }
            }
            Err(GmshError::Failed {
                geometry,
                errors,
                log,
            })
        }
        (None, End::TimeLimit) => Err(GmshError::TimeLimit {
            geometry,
            limit,
            log,
        }),
        (None, End::Flood) => Err(GmshError::Flood { geometry, log }),
        (None, End::Exit(status)) => Err(GmshError::Crashed {
            geometry,
            ending: describe(status),
            log,
        }),
    }
}

/// 2 for a geometry, None for what is a mesh already.
fn mesh_dimension(file: &Path) -> Result<Option<i32>, GmshError> {
    let extension = file.extension().and_then(|extension| extension.to_str());
    match extension.map(str::to_ascii_lowercase).as_deref() {
        Some("msh") => Ok(None),
        Some(known) if GEOMETRIES.contains(&known) => Ok(Some(2)),
        _ => Err(GmshError::FileKind {
            file: file.to_owned(),
        }),
    }
}

/// The libraries to try, as absolute paths: the loader seeks a bare file name elsewhere.
fn libraries(options: &Options) -> Result<Vec<PathBuf>, GmshError> {
    let candidates = match &options.library {
        Some(library) => vec![library.clone()],
        None => {
            let search = library::Places::of_this_process().search();
            if search.found.is_empty() {
                return Err(GmshError::LibraryNotFound {
                    tried: search.tried,
                });
            }
            search.found
        }
    };
    let absolute = candidates.iter().map(std::path::absolute);
    absolute
        .collect::<io::Result<_>>()
        .map_err(worker_error("find the current directory"))
}

fn absolute_text(file: &Path) -> Result<String, GmshError> {
    let absolute = std::path::absolute(file).map_err(worker_error("find the current directory"))?;
    absolute
        .into_os_string()
        .into_string()
        .map_err(|file| GmshError::PathNotText {
            file: PathBuf::from(file),
        })
}

/// Runs the worker to its end.
fn run_worker(
    request: &worker::Request,
    log_file: &Path,
    options: &Options,
) -> Result<End, GmshError> {
    let executable = match &options.worker {
        Some(executable) => executable.clone(),
        None => std::env::current_exe().map_err(worker_error("find our own executable"))?,
    };
    let request = serde_json::to_vec(request)
        .map_err(io::Error::from)
        .map_err(worker_error("write the request"))?;
    let mut command = Command::new(executable);
    command.arg(WORKER_COMMAND);
    let end = child::run(&mut command, &request, log_file, options.time_limit);
    end.map_err(|ChildError { action, source }| GmshError::Worker { action, source })
}

fn worker_error(action: &'static str) -> impl Fn(io::Error) -> GmshError {
    move |source| GmshError::Worker { action, source }
}
