//! Files between the stages and between runs, read back. They may have come from anywhere, damaged or
//! forged: what cannot be read is taken for missing, and what does not fit the model likewise.

use super::checkpoint::Checkpoint;
use super::format::without_format;
use super::frames::Frame;
use super::history::HistoryLine;
use super::solved::Solved;
use super::sparse_integrity::SparseIntegrity;
use super::stamp::Manifest;
use super::writer::unsealed;
use crate::gmsh::Extract;
use crate::model::Model;
use serde::Deserialize;
use std::fs;
use std::path::Path;

/// Content and bytes of a file.
pub(crate) fn read_stored<T: for<'de> Deserialize<'de>>(path: &Path) -> Option<(T, Vec<u8>)> {
    let bytes = fs::read(path).ok()?;
    Some((postcard::from_bytes(&bytes).ok()?, bytes))
}

/// Whether there is a number for every node and an integrity for every interaction.
pub(crate) fn fits_model(
    model: &Model,
    nodes: &[&[[f64; 2]]],
    integrity: &SparseIntegrity,
) -> bool {
    let counts = nodes.iter().map(|values| values.len());
    counts.into_iter().all(|count| count == model.node_count())
        && integrity.fits(model.interactions.len())
}

/// The kinds of stored files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Mesh,
    Solution,
    Frame,
    Checkpoint,
    Journal,
    Manifest,
}

impl Kind {
    pub const ALL: [Kind; 6] = [
        Kind::Mesh,
        Kind::Solution,
        Kind::Frame,
        Kind::Checkpoint,
        Kind::Journal,
        Kind::Manifest,
    ];

    /// Whether these bytes can be read as such a file; a mesh must also be one that can be computed on.
    pub fn reads(self, bytes: &[u8]) -> bool {
        fn is<T: for<'de> Deserialize<'de>>(bytes: &[u8]) -> bool {
            postcard::from_bytes::<T>(bytes).is_ok()
        }
        match self {
            Kind::Mesh => postcard::from_bytes::<Extract>(bytes)
                .is_ok_and(|extract| extract.to_mesh_of(1e-3, &|_| false).is_ok()),
            Kind::Solution => is::<Solved>(bytes),
            Kind::Frame => Frame::from_file(bytes).is_ok(),
            // What the seal lets through, and what a forger could seal.
            Kind::Checkpoint => {
                let bytes = without_format(bytes).unwrap_or(bytes);
                let inside = bytes.get(32..).unwrap_or_default();
                is::<Checkpoint>(unsealed(bytes).unwrap_or(inside))
            }
            Kind::Journal => {
                let mut rest = bytes;
                while let Ok((_, after)) = postcard::take_from_bytes::<HistoryLine>(rest) {
                    rest = after;
                }
                rest.is_empty()
            }
            Kind::Manifest => serde_json::from_slice::<Manifest>(bytes).is_ok(),
        }
    }
}
