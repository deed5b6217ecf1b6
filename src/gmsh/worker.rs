//! The child process in which Gmsh runs, and the messages between it and its parent.
//!
//! The parent writes one line of JSON, a [`Request`], to the worker's standard input and keeps that
//! pipe open: at its end the worker exits at once, so that it never outlives its parent. Gmsh's log
//! goes to the standard output and error as it arises, so that it survives a crash. The
//! [`Outcome`] goes to a file that appears under its name only when it is complete.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::{Deserialize, Serialize};

use super::Value;
use super::extract::{Block, Extract, Group, Origin};
use super::ffi::{self, FfiError, Session};
use super::sandbox;

/// What the parent asks for.
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
}

/// What the worker answers.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Outcome {
    Done(Extract),
    /// No library could be loaded: each with its reason.
    NoLibrary(Vec<(PathBuf, String)>),
    Failed(Vec<Message>),
}

/// An error message of Gmsh, with the place in a file if it names one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Message {
    pub file: Option<PathBuf>,
    /// Counted from 1.
    pub line: Option<u32>,
    pub text: String,
}

impl Message {
    /// Reads "'FILE', line N: TEXT"; any other text has no place.
    pub(super) fn parse(text: &str) -> Message {
        let located = || {
            let (file, rest) = text.strip_prefix('\'')?.split_once("', line ")?;
            let (line, message) = rest.split_once(':')?;
            let line = line.trim().parse().ok()?;
            Some((file, line, message.trim()))
        };
        match located() {
            Some((file, line, message)) => Message {
                file: Some(PathBuf::from(file)),
                line: Some(line),
                text: message.to_owned(),
            },
            None => Message {
                file: None,
                line: None,
                text: text.to_owned(),
            },
        }
    }
}

impl std::fmt::Display for Message {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}:", file.display())?;
            if let Some(line) = self.line {
                write!(f, "{line}:")?;
            }
            write!(f, " ")?;
        }
        write!(f, "{}", self.text)
    }
}

impl From<FfiError> for Message {
    fn from(error: FfiError) -> Message {
        Message::parse(&error.to_string())
    }
}

/// The worker's whole life: for `peristitch mesh-worker`, which takes its request from the
/// standard input.
pub fn worker_main() -> ExitCode {
    match serve() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("mesh-worker: {error}");
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
    if !request.trust {
        let folder = request.outcome.parent().unwrap_or(Path::new("."));
        sandbox::shut_in(folder).map_err(io::Error::other)?;
    }
    let outcome = mesh(&request);
    let bytes = postcard::to_stdvec(&outcome).map_err(io::Error::other)?;
    let unfinished = request.outcome.with_extension("part");
    std::fs::write(&unfinished, bytes)?;
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
            Ok(session) => {
                return run(&session, request).map_or_else(Outcome::Failed, Outcome::Done);
            }
            Err(FfiError::Load { library, reason }) => failures.push((library, reason)),
            Err(error) => return Outcome::Failed(vec![error.into()]),
        }
    }
    Outcome::NoLibrary(failures)
}

fn run(session: &Session, request: &Request) -> Result<Extract, Vec<Message>> {
    step(session, |session| {
        session.set_number(c"General.Terminal", 1.0)?;
        // Errors then end neither the process nor the reading: the log has them all, with places.
        session.set_number(c"General.AbortOnError", 0.0)?;
        session.start_log()?;
        session.open(&request.geometry)
    })?;
    if let Some(dimension) = request.mesh_dimension {
        step(session, |session| session.generate(dimension))?;
    }
    let mut extract = step(session, gather)?;
    extract.warnings = messages(session, "Warning: ").map_err(|error| vec![error.into()])?;
    extract.parameters = values(session, &request.parameters);
    Ok(extract)
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
    let found = log.iter().filter_map(|line| line.strip_prefix(level));
    Ok(found
        .filter(|text| seen.insert(*text))
        .map(|text| text.trim().to_owned())
        .collect())
}

fn gather(session: &Session) -> Result<Extract, FfiError> {
    let mut entity_counts = [0; 4];
    for (dimension, count) in (0..).zip(&mut entity_counts) {
        *count = session.entity_count(dimension)?;
    }
    let mut tags = session.groups()?;
    tags.sort_unstable();
    let mut groups = Vec::new();
    for (dimension, tag) in tags {
        groups.push(gather_group(session, dimension, tag)?);
    }
    let nodes = number_nodes(session, &mut groups)?;
    Ok(Extract {
        origin: Origin {
            program: "Gmsh".to_owned(),
            version: session.version()?,
        },
        warnings: Vec::new(),
        parameters: BTreeMap::new(),
        entity_counts,
        nodes,
        groups,
    })
}

/// A physical group, its nodes still under Gmsh's tags.
fn gather_group(session: &Session, dimension: i32, tag: i32) -> Result<Group, FfiError> {
    let mut entities: Vec<i32> = session.group_entities(dimension, tag)?;
    entities
        .iter_mut()
        .for_each(|entity| *entity = entity.abs());
    entities.sort_unstable();
    entities.dedup();
    let mut elements: BTreeMap<i32, BTreeMap<usize, Vec<usize>>> = BTreeMap::new();
    let mut properties = BTreeMap::new();
    for entity in entities {
        for block in session.elements(dimension, entity)? {
            let property = session.element_properties(block.kind)?;
            let nodes = block.nodes.chunks_exact(property.node_count.max(1));
            let members = elements.entry(block.kind).or_default();
            members.extend(block.tags.into_iter().zip(nodes.map(<[usize]>::to_vec)));
            properties.insert(block.kind, property);
        }
    }
    let blocks = elements.into_iter().zip(properties.into_values());
    Ok(Group {
        dimension: u8::try_from(dimension).expect("Gmsh's dimensions are 0 to 3"),
        tag,
        name: session.group_name(dimension, tag)?,
        blocks: blocks
            .map(|((kind, members), property)| Block {
                kind,
                kind_name: property.name,
                order: property.order,
                nodes_per_element: property.node_count,
                tags: members.keys().map(|&tag| tag as u64).collect(),
                nodes: members.into_values().flatten().collect(),
            })
            .collect(),
    })
}

/// Replaces node tags by indices into the positions returned: the used nodes, ascending by tag.
fn number_nodes(session: &Session, groups: &mut [Group]) -> Result<Vec<[f64; 3]>, FfiError> {
    let used: BTreeSet<usize> = groups
        .iter()
        .flat_map(|group| &group.blocks)
        .flat_map(|block| block.nodes.iter().copied())
        .collect();
    let mut nodes = session.nodes()?;
    nodes.retain(|(tag, _)| used.contains(tag));
    nodes.sort_by_key(|(tag, _)| *tag);
    nodes.dedup_by_key(|(tag, _)| *tag);
    for block in groups.iter_mut().flat_map(|group| &mut group.blocks) {
        for node in &mut block.nodes {
            *node = nodes
                .binary_search_by_key(node, |(tag, _)| *tag)
                .map_err(|_| FfiError::NodeMissing { node: *node })?;
        }
    }
    Ok(nodes.into_iter().map(|(_, position)| position).collect())
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
    fn messages_carry_file_and_line() {
        let message = Message::parse("'/a/it's.geo', line 12: syntax error (})");
        assert_eq!(message.file.as_deref(), Some(Path::new("/a/it's.geo")));
        assert_eq!(message.line, Some(12));
        assert_eq!(message.to_string(), "/a/it's.geo:12: syntax error (})");
        let plain = Message::parse("Unable to open file 'x'");
        assert_eq!((&plain.file, plain.line), (&None, None));
        assert_eq!(plain.to_string(), "Unable to open file 'x'");
    }
}
