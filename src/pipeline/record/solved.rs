//! What the solve stage delivers, and the form in which it is kept.

use super::history::Line;
use super::sparse_integrity::SparseIntegrity;
use super::stored::fits_model;
use crate::fracture::control::Ending;
use crate::model::Model;
use crate::statics::{Solution, SystemSize};
use serde::{Deserialize, Serialize};

/// The solve stage's result.
pub struct Solved {
    /// The last state.
    pub solution: Solution,
    /// Integrity φ of every interaction in it [-].
    pub integrity: Vec<f64>,
    /// How a fracture run got there.
    pub fracture: Option<Course>,
}

/// The course of a fracture run.
pub struct Course {
    pub history: Vec<Line>,
    /// Steps that have a frame.
    pub frames: Vec<usize>,
    pub ending: Ending,
    /// Number of nodes of each part that has come off.
    pub fragments: Vec<usize>,
    /// Why there is no solution any more, where the run ended so.
    pub reason: Option<String>,
}

/// The solve stage's result, as it is kept.
#[derive(Serialize, Deserialize)]
pub(crate) struct StoredSolution {
    displacement: Vec<[f64; 2]>,
    reaction: Vec<[f64; 2]>,
    residual: f64,
    size: [usize; 4],
    integrity: SparseIntegrity,
    fracture: Option<StoredFracture>,
}

/// What a fracture run adds.
#[derive(Serialize, Deserialize)]
pub(crate) struct StoredFracture {
    history: Vec<Line>,
    frames: Vec<usize>,
    /// As [`Ending::describe`] has it.
    ending: String,
    fragments: Vec<usize>,
    reason: Option<String>,
}

impl StoredSolution {
    /// Whether it can be a solution of this model.
    pub fn fits(&self, model: &Model) -> bool {
        fits_model(
            model,
            &[&self.displacement, &self.reaction],
            &self.integrity,
        )
    }
}

impl From<&Solved> for StoredSolution {
    fn from(solved: &Solved) -> StoredSolution {
        let fracture = |course: &Course| StoredFracture {
            history: course.history.clone(),
            frames: course.frames.clone(),
            ending: course.ending.describe().to_owned(),
            fragments: course.fragments.clone(),
            reason: course.reason.clone(),
        };
        StoredSolution {
            displacement: solved.solution.displacement.clone(),
            reaction: solved.solution.reaction.clone(),
            residual: solved.solution.residual,
            size: solved.solution.size.numbers(),
            integrity: SparseIntegrity::new(&solved.integrity),
            fracture: solved.fracture.as_ref().map(fracture),
        }
    }
}

impl From<StoredSolution> for Solved {
    fn from(stored: StoredSolution) -> Solved {
        let solution = Solution {
            displacement: stored.displacement,
            reaction: stored.reaction,
            residual: stored.residual,
            size: SystemSize::from_numbers(stored.size),
        };
        let course = |stored: StoredFracture| Course {
            history: stored.history,
            frames: stored.frames,
            ending: Ending::from_description(&stored.ending).unwrap_or(Ending::StepLimit),
            fragments: stored.fragments,
            reason: stored.reason,
        };
        Solved {
            solution,
            integrity: stored.integrity.to_vec(),
            fracture: stored.fracture.map(course),
        }
    }
}
