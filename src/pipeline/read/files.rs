//! The pipeline file on the disk: its text, what lies beside it, and where its results go.

use super::nesting::{MOST_BRACKETS, too_many_brackets};
use super::source::{InputError, choices};
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

/// The text of a pipeline file.
///
/// # Errors
/// A file that is not there, or no text; a folder.
pub(crate) fn read_text(path: &Path) -> Result<String, InputError> {
    let name = path.display();
    if path.is_dir() {
        let pipelines = files_in(path, &["yaml", "yml"]);
        let list: Vec<String> = pipelines
            .iter()
            .map(|file| format!("`{}`", path.join(file).display()))
            .collect();
        let help = match list.as_slice() {
            [] => "it holds no `.yaml` file".to_owned(),
            list => format!("name a file: {}", list.join(", ")),
        };
        return Err(InputError::plain(
            format!("{name} is a folder, not a pipeline file"),
            Some(help),
        ));
    }
    let open = || {
        let mut bytes = Vec::new();
        let mut start = File::open(path)?.take(LONGEST + 1);
        start.read_to_end(&mut bytes)?;
        Ok::<_, std::io::Error>(bytes)
    };
    let bytes = open().map_err(|error| match error.kind() {
        ErrorKind::NotFound => {
            let message = format!("there is no pipeline file {name}");
            InputError::plain(message, similar_file(path, &["yaml", "yml"]))
        }
        _ => InputError::plain(format!("the pipeline {name} cannot be read: {error}"), None),
    })?;
    if bytes.len() as u64 > LONGEST {
        let message = format!("{name} is longer than {} MB: no pipeline is", LONGEST >> 20);
        let help = "is it another file? Meshes and geometries are named under `geometry`";
        return Err(InputError::plain(message, Some(help.to_owned())));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + valid.iter().filter(|&&byte| byte == b'\n').count();
        let message = format!("{name}:{line}: the pipeline is not UTF-8 text");
        InputError::plain(message, Some("save it as UTF-8 in your editor".to_owned()))
    })?;
    match too_many_brackets(&text) {
        None => Ok(text),
        Some(line) => {
            let message =
                format!("{name}:{line}: more than {MOST_BRACKETS} brackets are open here");
            let help = "a pipeline needs three or four in each other: is one not closed?";
            Err(InputError::plain(message, Some(help.to_owned())))
        }
    }
}

/// A pipeline is some kilobytes long.
const LONGEST: u64 = 4 << 20;

/// The file beside `path` that was perhaps meant, or a list of the files there.
pub(crate) fn similar_file(path: &Path, extensions: &[&str]) -> Option<String> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let given = path.file_name()?.to_str()?;
    if !folder.is_dir() {
        return Some(format!("there is no folder {} either", folder.display()));
    }
    let names = files_in(folder, extensions);
    let list = choices(given, names.iter().map(String::as_str));
    let place = folder.display();
    Some(if names.is_empty() {
        format!("no such file is in {place}")
    } else {
        format!("in {place}: {list}")
    })
}

/// Names of the files in a folder that have one of the extensions, sorted.
fn files_in(folder: &Path, extensions: &[&str]) -> Vec<String> {
    let known = |name: &String| {
        let extension = Path::new(name)
            .extension()
            .and_then(|extension| extension.to_str());
        extension.is_some_and(|extension| extensions.contains(&extension))
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut names: Vec<String> = names.filter(known).collect();
    names.sort();
    names
}

/// `results/` beside the folder `pipelines/` that holds the file, or beside the file.
pub(crate) fn default_results(pipeline: &Path) -> PathBuf {
    let folder = pipeline.parent().unwrap_or(Path::new(""));
    if folder.file_name().is_some_and(|name| name == "pipelines") {
        folder.parent().unwrap_or(Path::new("")).join("results")
    } else if folder.as_os_str().is_empty() && in_pipelines_folder() {
        PathBuf::from("../results")
    } else {
        folder.join("results")
    }
}

fn in_pipelines_folder() -> bool {
    std::env::current_dir().is_ok_and(|d| d.file_name().is_some_and(|name| name == "pipelines"))
}
