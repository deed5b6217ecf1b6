//! The frames of a fracture run: states of chosen steps, kept whole in `frames/`.

use super::folder::{file_error, remove};
use super::format::{other_format, without_format};
use super::sparse_integrity::SparseIntegrity;
use super::stored::fits_model;
use crate::fracture::state::State;
use crate::model::Model;
use crate::pipeline::error::RunError;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;

pub(crate) const FRAMES_FOLDER: &str = "frames";

/// A moment of the run that is kept whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    pub step: usize,
    pub load_factor: f64,
    /// Displacement of every node [m].
    pub displacement: Vec<[f64; 2]>,
    pub integrity: SparseIntegrity,
}

impl Frame {
    pub(crate) fn new(model: &Model, state: &State) -> Frame {
        Frame {
            step: state.step,
            load_factor: state.load.factor,
            displacement: model.in_space(&state.displacement),
            integrity: SparseIntegrity::new(&state.integrity),
        }
    }

    /// The frame that a file holds.
    ///
    /// # Errors
    /// Why there is none.
    pub fn from_file(bytes: &[u8]) -> Result<Frame, String> {
        let content = without_format(bytes).map_err(other_format)?;
        postcard::from_bytes(content).map_err(|error| error.to_string())
    }

    /// Bytes that its numbers take in memory.
    pub(crate) fn raw_bytes(&self) -> u64 {
        (16 + 16 * self.displacement.len()) as u64 + self.integrity.raw_bytes()
    }
}

/// The name of a step's frame in the results folder.
pub(crate) fn frame_file(step: usize) -> String {
    format!("{FRAMES_FOLDER}/{step:06}.bin")
}

/// # Errors
/// A frame that cannot be read, or is none of this model.
pub(crate) fn read_frame(folder: &Path, model: &Model, step: usize) -> Result<Frame, RunError> {
    let path = folder.join(frame_file(step));
    let bytes = fs::read(&path).map_err(|source| file_error("read", &path, source))?;
    let refused = |why: String| {
        let why = format!("{why}; --force runs anew");
        file_error("read", &path, std::io::Error::other(why))
    };
    let frame = Frame::from_file(&bytes).map_err(refused)?;
    match fits_model(model, &[&frame.displacement], &frame.integrity) {
        true => Ok(frame),
        false => Err(refused("it is of another model".to_owned())),
    }
}

/// Frames of another recipe, or of an interrupted run that no manifest lists. What else is in their
/// folder is the user's.
pub(crate) fn forget_frames(folder: &Path) -> Result<(), RunError> {
    let frames = folder.join(FRAMES_FOLDER);
    let is_frame = |name: &str| {
        let name = name.strip_suffix(".partial").unwrap_or(name);
        let digits = name.strip_suffix(".bin").unwrap_or_default();
        !digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit())
    };
    for entry in fs::read_dir(&frames).into_iter().flatten().flatten() {
        if entry.file_name().to_str().is_some_and(is_frame) {
            remove(&entry.path())?;
        }
    }
    // Fails where the user keeps something there, or where there is none.
    let _ = fs::remove_dir(&frames);
    Ok(())
}

pub(crate) fn encode(value: &impl Serialize) -> Vec<u8> {
    postcard::to_stdvec(value).expect("plain data in memory can be encoded")
}
