//! The results folder: one writer at a time, drafts, and removal of what the stages wrote.

use super::frames::forget_frames;
use super::stamp::{self, Stage};
use super::writer::forget_checkpoint;
use crate::output::partial_name;
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::Plan;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Held until it is dropped, or until the process ends in whatever way.
pub(crate) fn lock(folder: &Path) -> Result<File, RunError> {
    fs::create_dir_all(folder.join(".stamps"))
        .map_err(|source| file_error("create", folder, source))?;
    let path = folder.join(LOCK_FILE);
    let open = File::options()
        .write(true)
        .create(true)
        .truncate(false)
        .open(&path);
    let mut file = open.map_err(|source| file_error("create", &path, source))?;
    match file.try_lock() {
        Ok(()) => {
            // Only for people: who cannot read it is told less.
            let _ = file.set_len(0).and_then(|()| write!(file, "{}", holder()));
            Ok(file)
        }
        Err(fs::TryLockError::WouldBlock) => Err(RunError::Busy {
            folder: folder.to_owned(),
            holder: fs::read_to_string(&path).unwrap_or_default(),
        }),
        Err(fs::TryLockError::Error(source)) => Err(file_error("lock", &path, source)),
    }
}

/// `process 4711 on the computer saturn`.
fn holder() -> String {
    let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let process = format!("process {}", std::process::id());
    match host.trim() {
        "" => process,
        host => format!("{process} on the computer {host}"),
    }
}

pub(crate) const LOCK_FILE: &str = ".stamps/lock";
pub(crate) const DRAFT_FOLDER: &str = ".draft";

/// An empty folder for files that are not yet results. One that a killed run left is removed.
pub(crate) fn draft(folder: &Path) -> Result<TempDir, RunError> {
    remove_folder(&folder.join(DRAFT_FOLDER))?;
    let draft = tempfile::Builder::new()
        .prefix(DRAFT_FOLDER)
        .rand_bytes(0)
        .tempdir_in(folder);
    draft.map_err(|source| file_error("create a folder in", folder, source))
}

/// The hash of a result, which outlives a loss of power from now on.
pub(crate) fn settled(path: &Path) -> Result<String, RunError> {
    let synced = File::open(path).and_then(|file| file.sync_data());
    synced.map_err(|source| file_error("keep", path, source))?;
    hash_of(path)
}

pub(crate) fn hash_of(path: &Path) -> Result<String, RunError> {
    let unreadable = || file_error("read", path, io::ErrorKind::NotFound.into());
    stamp::hash_file(path).ok_or_else(unreadable)
}

pub(crate) fn remove(path: &Path) -> Result<(), RunError> {
    match fs::remove_file(path) {
        Err(source) if source.kind() != io::ErrorKind::NotFound => {
            Err(file_error("remove", path, source))
        }
        _ => Ok(()),
    }
}

pub(crate) fn remove_folder(path: &Path) -> Result<(), RunError> {
    match fs::remove_dir_all(path) {
        Err(source) if source.kind() != io::ErrorKind::NotFound => {
            Err(file_error("remove", path, source))
        }
        _ => Ok(()),
    }
}

pub(crate) fn file_error(action: &'static str, path: &Path, source: io::Error) -> RunError {
    RunError::File {
        action,
        path: path.to_owned(),
        source,
    }
}

/// The stages' manifests and the files that they list.
fn written(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for stage in Stage::ALL {
        let manifest = stamp::read(folder, stage);
        let outputs = manifest
            .into_iter()
            .flat_map(|manifest| manifest.outputs.into_keys());
        files.extend(outputs.map(|name| folder.join(name)));
        files.push(stamp::path(folder, stage));
    }
    files
}

/// Removes files that a killed run left half written, unless another run is writing them now.
///
/// # Errors
/// A file that cannot be removed.
pub(crate) fn sweep(folder: &Path) -> Result<(), RunError> {
    let mut halves = written(folder).into_iter().map(|file| partial_name(&file));
    if !halves.any(|half| half.exists()) {
        return Ok(());
    }
    let _lock = match lock(folder) {
        Err(RunError::Busy { .. }) => return Ok(()),
        lock => lock?,
    };
    let halves = written(folder).into_iter().map(|file| partial_name(&file));
    halves.into_iter().try_for_each(|half| remove(&half))
}

/// Removes what the stages have written, finished or not, and the folder if nothing else is in it.
/// Returns the number of results removed.
///
/// # Errors
/// A file that cannot be removed; another run that is writing.
pub fn clean(plan: &Plan) -> Result<usize, RunError> {
    let folder = &plan.folder;
    if !folder.join(".stamps").is_dir() {
        return Ok(0);
    }
    let lock = lock(folder)?;
    let mut removed = 0;
    for file in written(folder) {
        removed += usize::from(file.exists() && !file.starts_with(folder.join(".stamps")));
        remove(&file)?;
        remove(&partial_name(&file))?;
    }
    remove_folder(&folder.join(DRAFT_FOLDER))?;
    forget_checkpoint(folder)?;
    forget_frames(folder)?;
    drop(lock);
    remove(&folder.join(LOCK_FILE))?;
    // Both fail where the user keeps something there.
    let _ = fs::remove_dir(folder.join(".stamps"));
    let _ = fs::remove_dir(folder);
    Ok(removed)
}
