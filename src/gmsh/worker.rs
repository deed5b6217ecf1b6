//! The child process in which Gmsh runs, and the messages between it and its parent.
//!
//! The parent writes one line of JSON, a [`Request`], to the worker's standard input and keeps that
//! pipe open: at its end the worker exits at once, so that it never outlives its parent. Gmsh's log
//! goes to the standard output and error as it arises, so that it survives a crash. The
//! [`Outcome`] goes to a file that appears under its name only when it is complete.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, BufRead, Read, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::{Deserialize, Serialize};

use super::Value;
use super::extract::{self, Extract, WHOLE};
use super::ffi::{self, Session};
use super::ffi_types::FfiError;
use super::gather::gather;
use super::guard::ScriptCommand;
use super::message::Message;
use super::sandbox;

/// The parent's request.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Request {
    /// Absolute path of the geometry or mesh.
    pub geometry: String,
    /// The highest dimension to mesh; None for a file that is a mesh already.
    pub mesh_dimension: Option<i32>,
    /// Gmsh's command line.
    pub arguments: Vec<String>,
    /// Variables whose values are wanted.
    pub parameters: Vec<String>,
    /// Libraries to try, best first.
    pub libraries: Vec<PathBuf>,
    pub outcome: PathBuf,
    /// Let the script run programs and write files.
    pub trust: bool,
    /// A `Save` of a script that is not trusted: the kernel must be able to prevent it.
    #[serde(default)]
    pub first_save: Option<ScriptCommand>,
    /// Mesh all surfaces, also those that have a mesh.
    #[serde(default)]
    pub anew: bool,
    /// Physical groups that must exist before the model is meshed.
    #[serde(default)]
    pub groups: Vec<String>,
}

/// The worker's answer.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Outcome {
    Done(Extract),
    /// No library could be loaded: each with its reason.
    NoLibrary(Vec<(PathBuf, String)>),
    /// The kernel cannot prevent the script from writing a file.
    CannotPassOver(ScriptCommand),
    /// One of the requested groups is missing.
    GroupMissing {
        /// Dimension and label of the groups that exist.
        available: Vec<(u8, String)>,
        /// Number of surfaces, in a group or not.
        surfaces: usize,
    },
    Failed(Vec<Message>),
}

/// The worker's whole life: for `peristitch mesh-worker`, which takes its request from the
/// standard input.
pub fn worker_main() -> ExitCode {
    match serve() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // `eprintln` would panic where the log cannot take it: on a full disk.
            let _ = writeln!(io::stderr(), "mesh-worker: {error}");
            ExitCode::FAILURE
        }
    }
}

fn serve() -> io::Result<()> {
    let mut line = String::new();
    io::stdin().lock().read_line(&mut line)?;
    let request: Request = serde_json::from_str(&line)?;
    std::thread::spawn(|| exit_with_parent());
    sandbox::limit_memory();
    let is_shut_in = !request.trust && {
        let folder = request.outcome.parent().unwrap_or(Path::new("."));
        sandbox::shut_in(folder).map_err(io::Error::other)?
    };
    let outcome = match &request.first_save {
        Some(save) if !is_shut_in => Outcome::CannotPassOver(save.clone()),
        _ => mesh(&request),
    };
    let bytes = postcard::to_stdvec(&outcome).map_err(io::Error::other)?;
    let unfinished = request.outcome.with_extension("part");
    std::fs::write(&unfinished, bytes).map_err(|error| {
        let text = format!("cannot write {}: {error}", unfinished.display());
        io::Error::new(error.kind(), text)
    })?;
    std::fs::rename(&unfinished, &request.outcome)
}

fn exit_with_parent() -> ! {
    let mut rest = [0; 64];
    let mut input = io::stdin().lock();
    loop {
        match input.read(&mut rest) {
            Ok(0) => ffi::exit_now(1),
            // A signal interrupts the waiting, and is no reason to end.
            Err(error) if error.kind() != io::ErrorKind::Interrupted => ffi::exit_now(1),
            _ => {}
        }
    }
}

fn mesh(request: &Request) -> Outcome {
    let mut failures = Vec::new();
    for library in &request.libraries {
        match Session::start(library, &request.arguments) {
            Ok(session) => return run(&session, request).unwrap_or_else(Outcome::Failed),
            Err(FfiError::Load { library, reason }) => failures.push((library, reason)),
            Err(error) => return Outcome::Failed(vec![error.into()]),
        }
    }
    Outcome::NoLibrary(failures)
}

fn run(session: &Session, request: &Request) -> Result<Outcome, Vec<Message>> {
    step(session, |session| {
        session.set_number(c"General.Terminal", 1.0)?;
        // Errors then end neither the process nor the reading: the log has them all, with places.
        session.set_number(c"General.AbortOnError", 0.0)?;
        session.start_log()?;
        session.open(&request.geometry)
    })?;
    let mut labels = step(session, group_labels)?;
    let is_whole = request.groups.iter().any(|group| group == WHOLE)
        && labels.iter().all(|(dimension, _)| *dimension != 2);
    if is_whole {
        labels.push((2, WHOLE.to_owned()));
    }
    let exists = |group: &String| labels.iter().any(|(_, label)| label == group);
    if !request.groups.iter().all(exists) {
        let surfaces = step(session, |session| session.entities(2))?.len();
        return Ok(Outcome::GroupMissing {
            available: labels,
            surfaces,
        });
    }
    if let Some(dimension) = request.mesh_dimension {
        step(session, |session| match request.anew {
            true => session.generate(dimension),
            false => complete_mesh(session, dimension),
        })?;
    }
    let mut extract = step(session, |session| gather(session, is_whole))?;
    extract.warnings = messages(session, "Warning: ").map_err(|error| vec![error.into()])?;
    extract.parameters = values(session, &request.parameters);
    Ok(Outcome::Done(extract))
}

fn group_labels(session: &Session) -> Result<Vec<(u8, String)>, FfiError> {
    let mut labels = Vec::new();
    for (dimension, tag) in session.groups()? {
        let name = session.group_name(dimension, tag)?;
        labels.push((extract::dimension(dimension), extract::label(&name, tag)));
    }
    Ok(labels)
}

/// Meshes the surfaces that the script has left without a mesh. What it has meshed stays as it is: a
/// `Plugin(Crack)`, `SetOrder` or `RecombineMesh` after its `Mesh 2` would be lost by meshing again.
fn complete_mesh(session: &Session, dimension: i32) -> Result<(), FfiError> {
    let mut is_complete = true;
    let mut made = BTreeSet::new();
    for surface in surfaces_to_mesh(session)? {
        let blocks = session.elements(2, surface)?;
        is_complete &= !blocks.is_empty();
        made.extend(blocks.iter().map(|block| block.kind));
    }
    if made.is_empty() {
        return session.generate(dimension);
    }
    if is_complete {
        return Ok(());
    }
    session.set_number(c"Mesh.MeshOnlyEmpty", 1.0)?;
    // Gmsh gives all elements the order of the options, those that it did not make now included.
    let mut order = 1;
    for &kind in &made {
        order = order.max(session.element_properties(kind)?.order);
    }
    session.set_number(c"Mesh.ElementOrder", order as f64)?;
    if made.contains(&EIGHT_NODE_QUADRILATERAL) {
        session.set_number(c"Mesh.SecondOrderIncomplete", 1.0)?;
    }
    session.generate(dimension)
}

/// Gmsh's number of the eight-node quadrilateral.
const EIGHT_NODE_QUADRILATERAL: i32 = 16;

/// The surfaces of physical groups; all surfaces where there is no such group.
fn surfaces_to_mesh(session: &Session) -> Result<BTreeSet<i32>, FfiError> {
    let mut surfaces = BTreeSet::new();
    for (dimension, tag) in session.groups()? {
        if dimension == 2 {
            let entities = session.group_entities(dimension, tag)?;
            surfaces.extend(entities.iter().map(|entity| entity.abs()));
        }
    }
    if surfaces.is_empty() {
        surfaces.extend(session.entities(2)?);
    }
    Ok(surfaces)
}

/// The values of those variables that have one.
fn values(session: &Session, names: &[String]) -> BTreeMap<String, Value> {
    let value = |name: &String| {
        let number = session.variable(name).map(Value::Number);
        number.or_else(|| session.text_variable(name).map(Value::Text))
    };
    let known = |name: &String| Some((name.clone(), value(name)?));
    names.iter().filter_map(known).collect()
}

/// Runs a part of the work. It has failed if a call says so, and also if Gmsh's log holds an error:
/// after one Gmsh goes on, but what it then does is of no use.
fn step<T>(
    session: &Session,
    work: impl FnOnce(&Session) -> Result<T, FfiError>,
) -> Result<T, Vec<Message>> {
    let result = work(session);
    let logged = messages(session, "Error: ").unwrap_or_default();
    if !logged.is_empty() {
        return Err(logged.iter().map(|text| Message::parse(text)).collect());
    }
    result.map_err(|error| vec![error.into()])
}

/// The messages of a level, each once.
fn messages(session: &Session, level: &str) -> Result<Vec<String>, FfiError> {
    let mut seen = BTreeSet::new();
    let log = session.log()?;
    let lines = without_saves(&log).into_iter();
    let found = lines.filter_map(|line| line.strip_prefix(level));
    Ok(found
        .filter(|text| seen.insert(*text))
        .map(|text| text.trim().to_owned())
        .collect())
}

/// The log without what Gmsh says while it saves a file. The kernel lets no file be written, so that a
/// `Save` fails and changes nothing; a script that is trusted has no such errors.
fn without_saves(log: &[String]) -> Vec<&str> {
    let mut is_saving = false;
    let is_outside = |line: &&str| {
        if line.starts_with("Info: Writing '") {
            is_saving = true;
        }
        let is_outside = !is_saving;
        if line.starts_with("Info: Done writing '") || line.starts_with("Info: Reading '") {
            is_saving = false;
        }
        is_outside
    };
    log.iter().map(String::as_str).filter(is_outside).collect()
}

/// Reads the outcome that a worker left; None if it did not come so far.
pub(super) fn read_outcome(file: &Path) -> Option<Outcome> {
    let bytes = std::fs::read(file).ok()?;
    postcard::from_bytes(&bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_a_save_are_passed_over_and_others_are_not() {
        let log = [
            "Info: Reading 'a.geo'...",
            "Error: before",
            "Info: Writing 'a.msh'...",
            "Error: Unable to open file 'a.msh'",
            "Info: Done writing 'a.msh'",
            "Error: behind",
        ]
        .map(str::to_owned);
        assert_eq!(
            without_saves(&log),
            ["Info: Reading 'a.geo'...", "Error: before", "Error: behind"]
        );
    }
}
