//! The solve stage's result, as it is kept in `solution.bin`.

use super::history::HistoryLine;
use super::sparse_integrity::SparseIntegrity;
use super::stored::fits_model;
use crate::fracture::control::Ending;
use crate::model::Model;
use crate::statics::Solution;
use serde::{Deserialize, Serialize};

/// The solve stage's result.
#[derive(Serialize, Deserialize)]
pub struct Solved {
    /// The last state.
    pub solution: Solution,
    /// Integrity of every interaction in it.
    pub integrity: SparseIntegrity,
    /// The fracture run that led there.
    pub fracture: Option<FractureRun>,
}

/// The course of a fracture run.
#[derive(Serialize, Deserialize)]
pub struct FractureRun {
    pub history: Vec<HistoryLine>,
    /// Steps that have a frame.
    pub frames: Vec<usize>,
    pub ending: Ending,
    /// Number of nodes of each part that has come off.
    pub fragments: Vec<usize>,
    /// Why there is no solution any more, where the run ended so.
    pub reason: Option<String>,
    /// The interaction that broke first, one of those that broke together.
    pub first_broken: Option<u32>,
    /// Share of the largest force along the prescribed displacements of this phase that is left at the end [-];
    /// `None` where nothing is displaced.
    pub force_left: Option<f64>,
    /// Warnings of the run.
    pub warnings: Vec<String>,
}

impl Solved {
    /// Whether it can be a solution of this model.
    pub(crate) fn fits(&self, model: &Model) -> bool {
        let Solution {
            displacement,
            reaction,
            ..
        } = &self.solution;
        fits_model(model, &[displacement, reaction], &self.integrity)
    }
}
