//! Why there is no mesh, in the user's words.

use std::io;
use std::path::PathBuf;
use std::time::Duration;

use thiserror::Error;

use super::geo_script::ScriptError;
use super::guard::ScriptCommand;
use super::message::Message;
use super::{GEOMETRIES, library};
use crate::child;

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
    UnsafeCommand(ScriptCommand),
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
    #[error("{} lacks a physical group that is asked for", .geometry.display())]
    GroupMissing {
        geometry: PathBuf,
        /// Dimension and label of the groups that exist.
        available: Vec<(u8, String)>,
        /// Number of surfaces, in a group or not.
        surfaces: usize,
    },
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
