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
//! - [`parameter`]: what a parameter may be.
//! - [`extract`]: the physical groups that Gmsh delivered, as they are cached.
//! - [`to_mesh`]: the checks and the conversion to metres.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::child::{self, ChildError, End, describe, last_lines};

pub mod extract;
mod ffi;
pub mod geo_script;
pub mod guard;
pub mod library;
pub mod parameter;
mod sandbox;
pub mod to_mesh;
mod worker;

pub use extract::{Block, Extract, Group, Origin};
pub use geo_script::{GeoScript, ScriptError};
use guard::Deed;
pub use to_mesh::ExtractError;
pub use worker::{Message, worker_main};

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

/// How Gmsh is run.
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
}

impl Default for Options {
    fn default() -> Options {
        Options {
            worker: None,
            library: None,
            time_limit: Duration::from_secs(600),
            trust: false,
        }
    }
}

/// Why there is no mesh.
#[derive(Debug, Error)]
pub enum GmshError {
    #[error("the geometry file {} does not exist", .file.display())]
    FileMissing { file: PathBuf },
    #[error(
        "{}: not a kind of file that Gmsh reads here; geometries: .{}; meshes: .msh",
        .file.display(), GEOMETRIES.join(", .")
    )]
    FileKind { file: PathBuf },
    #[error("the path {} is not UTF-8 text, which Gmsh needs", .file.display())]
    PathNotText { file: PathBuf },
    #[error(transparent)]
    Script(#[from] ScriptError),
    #[error("{}:{}: {}, and a geometry may only draw", .0.file.display(), .0.line, .0.what)]
    Deed(Deed),
    #[error("{} has no parameter '{name}'{}", .file.display(), unknown_hint(.nearest, .available))]
    UnknownParameter {
        file: PathBuf,
        name: String,
        nearest: Option<String>,
        available: Vec<String>,
    },
    #[error(
        "'{name}' in {} is defined by DefineNumber or DefineString, which Gmsh does not let be \
         set; write DefineConstant[ {name} = {{...}} ]; instead",
        .file.display()
    )]
    FixedParameter { file: PathBuf, name: String },
    #[error("{} is not a script, so its parameter '{name}' cannot be set", .file.display())]
    ParameterOfMesh { file: PathBuf, name: String },
    #[error("parameter '{name}' of {} must be {expected}, not {given}", .file.display())]
    ParameterValue {
        file: PathBuf,
        name: String,
        expected: String,
        given: String,
    },
    #[error(
        "Gmsh's library is not found. Run `make setup`, or install Gmsh (Debian: apt install \
         gmsh), or set ${} to the path of libgmsh.so. Tried:{}",
        library::VARIABLE, lines(.tried)
    )]
    LibraryNotFound { tried: Vec<String> },
    #[error("Gmsh's library cannot be loaded:{}{}", attempts(.tried), load_hint(.tried))]
    LibraryNotLoaded { tried: Vec<(PathBuf, String)> },
    #[error("Gmsh fails on {}:{}", .geometry.display(), lines(.errors))]
    Failed {
        geometry: PathBuf,
        errors: Vec<Message>,
        /// The last lines of Gmsh's log.
        log: Vec<String>,
    },
    #[error("Gmsh crashed on {} ({ending}); its last words:{}", .geometry.display(), lines(.log))]
    Crashed {
        geometry: PathBuf,
        ending: String,
        log: Vec<String>,
    },
    #[error(
        "Gmsh had not finished {} after {} s and was stopped; is an element size far too small, \
         or does a loop not end? Its last words:{}",
        .geometry.display(), .limit.as_secs_f64(), lines(.log)
    )]
    TimeLimit {
        geometry: PathBuf,
        limit: Duration,
        log: Vec<String>,
    },
    #[error(
        "Gmsh wrote more than {} MB of messages about {} and was stopped; the last:{}",
        child::LONGEST_LOG / 1_000_000, .geometry.display(), lines(.log)
    )]
    Flood { geometry: PathBuf, log: Vec<String> },
    #[error("cannot run the mesh worker: {action}: {source}")]
    Worker {
        action: &'static str,
        source: io::Error,
    },
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
    if let (false, Some(deed)) = (options.trust, first_deed(script.as_ref())) {
        return Err(GmshError::Deed(deed));
    }
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
    };
    let log_file = folder.path().join("log");
    let end = run_worker(&request, &log_file, options)?;
    let log = last_lines(&log_file);
    let concluded = conclude(geometry, &request, end, log, options.time_limit);
    let mut extract = concluded.map_err(|error| locate_absent(error, script.as_ref()))?;
    if let Some(script) = script {
        add_known_values(&mut extract.parameters, &script, parameters);
        extract.warnings.extend(script.warnings);
    }
    Ok(extract)
}

/// Gmsh does not tell where a script names a file that cannot be opened.
fn locate_absent(mut error: GmshError, script: Option<&GeoScript>) -> GmshError {
    let (GmshError::Failed { errors, .. }, Some(script)) = (&mut error, script) else {
        return error;
    };
    for message in errors.iter_mut().filter(|message| message.file.is_none()) {
        let is_named = |named: &&geo_script::Named| {
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

/// Adds to the values that Gmsh tells (from 4.9 on) those that are known without it.
fn add_known_values(
    values: &mut BTreeMap<String, Value>,
    script: &GeoScript,
    given: &BTreeMap<String, Value>,
) {
    for (name, parameter) in &script.parameters {
        let known = given.get(name).cloned().or(parameter.default.value());
        if let Some(value) = known {
            values.entry(name.clone()).or_insert(value);
        }
    }
}

/// What can be read of a script without running it; None for other files.
pub fn read_script(file: &Path) -> Result<Option<GeoScript>, GmshError> {
    let extension = file.extension().and_then(|extension| extension.to_str());
    let is_script = extension.is_some_and(|extension| {
        ["geo", "geo_unrolled"]
            .iter()
            .any(|known| extension.eq_ignore_ascii_case(known))
    });
    Ok(is_script.then(|| GeoScript::scan(file)).transpose()?)
}

fn first_deed(script: Option<&GeoScript>) -> Option<Deed> {
    script?.deeds.first().cloned()
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

fn check_parameters(
    file: &Path,
    script: Option<&GeoScript>,
    parameters: &BTreeMap<String, Value>,
) -> Result<(), GmshError> {
    for (name, value) in parameters {
        let Some(script) = script else {
            return Err(GmshError::ParameterOfMesh {
                file: file.to_owned(),
                name: name.clone(),
            });
        };
        check_parameter(file, script, name, value)?;
    }
    Ok(())
}

fn check_parameter(
    file: &Path,
    script: &GeoScript,
    name: &str,
    value: &Value,
) -> Result<(), GmshError> {
    let file = file.to_owned();
    let Some(parameter) = script.parameters.get(name) else {
        let name = name.to_owned();
        if script.fixed.contains(&name) {
            return Err(GmshError::FixedParameter { file, name });
        }
        return Err(GmshError::UnknownParameter {
            file,
            nearest: script.nearest(&name).map(str::to_owned),
            available: script.parameters.keys().cloned().collect(),
            name,
        });
    };
    match parameter.refuses(value) {
        None => Ok(()),
        Some(expected) => Err(GmshError::ParameterValue {
            file,
            name: name.to_owned(),
            expected,
            given: value.to_string(),
        }),
    }
}

/// Gmsh's command line. Only there do values override `DefineConstant`.
fn arguments(parameters: &BTreeMap<String, Value>) -> Vec<String> {
    let words = parameters.iter().flat_map(|(name, value)| match value {
        Value::Number(number) => ["-setnumber".to_owned(), name.clone(), number.to_string()],
        Value::Text(text) => ["-setstring".to_owned(), name.clone(), text.clone()],
    });
    words.collect()
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

fn lines(items: &[impl std::fmt::Display]) -> String {
    items.iter().map(|item| format!("\n  {item}")).collect()
}

fn attempts(tried: &[(PathBuf, String)]) -> String {
    let line = |(library, reason): &(PathBuf, String)| {
        let path = library.display().to_string();
        let reason = reason.strip_prefix(&path).unwrap_or(reason);
        format!("\n  {path}: {}", reason.trim_start_matches([':', ' ']))
    };
    tried.iter().map(line).collect()
}

fn load_hint(tried: &[(PathBuf, String)]) -> String {
    let mut reasons = tried.iter();
    let missing = reasons.find_map(|(path, reason)| library::missing_dependency(path, reason));
    match missing {
        Some(missing) => format!(
            "\nThe system library {missing} is missing. On Debian: apt install {}",
            library::DEBIAN_PACKAGES
        ),
        None => format!(
            "\nRun `make setup`, or install Gmsh (Debian: apt install gmsh), or set ${} to the \
             path of libgmsh.so",
            library::VARIABLE
        ),
    }
}

fn unknown_hint(nearest: &Option<String>, available: &[String]) -> String {
    let meant = nearest
        .as_ref()
        .map(|name| format!("; did you mean '{name}'?"));
    let listed = match available {
        [] => " It defines none: write DefineConstant[ name = {value} ]; in it".to_owned(),
        names => format!(" It defines: {}", names.join(", ")),
    };
    meant.unwrap_or_else(|| ".".to_owned()) + &listed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_reach_gmsh_without_loss() {
        let parameters = BTreeMap::from([
            ("a".to_owned(), Value::Number(0.1 + 0.2)),
            ("b".to_owned(), Value::from("two words")),
        ]);
        let words = arguments(&parameters);
        assert_eq!(words[..2], ["-setnumber", "a"]);
        assert_eq!(words[2].parse(), Ok(0.1 + 0.2));
        assert_eq!(words[3..], ["-setstring", "b", "two words"]);
    }

    #[test]
    fn missing_system_library_gives_the_packages() {
        let reason = "libGLU.so.1: cannot open shared object file: No such file or directory";
        let tried = vec![(PathBuf::from("/v/libgmsh.so.4.15"), reason.to_owned())];
        let message = GmshError::LibraryNotLoaded { tried }.to_string();
        for part in [
            "/v/libgmsh.so.4.15: libGLU",
            "library libGLU.so.1 is missing",
            "libgl1",
        ] {
            assert!(message.contains(part), "{message}");
        }
    }
}
