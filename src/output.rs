//! Files of results: VTU parts, their time series, pictures.
//!
//! The layer takes plain data in SI units and knows no mechanics. Every file appears under its
//! name only when it is complete.

pub mod animation;
pub mod colour;
pub mod field;
pub mod markup;
pub mod number;
mod packed;
pub mod picture;
pub mod pvd;
pub mod vtu;

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}", path.display())]
pub struct WriteError {
    pub path: PathBuf,
    pub source: std::io::Error,
}

/// Writes `bytes` under a temporary name beside `path`, then renames: a reader, or a killed run,
/// sees the old file or the new one, never a half.
///
/// # Errors
/// The file cannot be written; then `path` is as it was.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    write_and_rename(path, bytes, |_| Ok(()))
}

/// [`write_whole`] that also outlives a loss of power.
///
/// # Errors
/// Same as for [`write_whole`].
pub fn write_durable(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    write_and_rename(path, bytes, File::sync_data)?;
    // The name too; a file system that cannot sync a folder keeps its names in another way.
    if let Some(Ok(folder)) = path.parent().map(File::open) {
        let _ = folder.sync_all();
    }
    Ok(())
}

fn write_and_rename(
    path: &Path,
    bytes: &[u8],
    settle: impl Fn(&File) -> io::Result<()>,
) -> Result<(), WriteError> {
    let partial = partial_name(path);
    let write = || {
        let mut file = File::create(&partial)?;
        file.write_all(bytes)?;
        settle(&file)?;
        std::fs::rename(&partial, path)
    };
    write().map_err(|source| {
        // The first failure is the one to report; the remains may not even exist.
        let _ = std::fs::remove_file(&partial);
        WriteError {
            path: path.to_path_buf(),
            source,
        }
    })
}

/// The name under which [`write_whole`] writes; a killed run may leave a file of this name.
pub fn partial_name(path: &Path) -> PathBuf {
    let mut name = path.file_name().map_or_else(OsString::new, OsString::from);
    name.push(".partial");
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whole_file_replaces_the_old_one_and_leaves_no_partial() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.txt");
        write_whole(&path, b"old").expect("writable");
        write_whole(&path, b"new").expect("writable");
        assert_eq!(std::fs::read(&path).expect("written"), b"new");
        assert_eq!(std::fs::read_dir(folder.path()).expect("exists").count(), 1);
    }

    #[test]
    fn a_missing_folder_is_named_with_its_cause() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("missing/a.txt");
        let error = write_whole(&path, b"").expect_err("no such folder");
        assert!(error.to_string().contains("a.txt"));
        assert_eq!(error.source.kind(), std::io::ErrorKind::NotFound);
    }
}
