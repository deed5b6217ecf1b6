//! The checkpoint from which a killed run continues: the state after its last step.

use super::history::HistoryLine;
use crate::fracture::control::Problem;
use crate::fracture::state::{Change, State};
use crate::model::Model;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

#[derive(Serialize, Deserialize)]
pub(crate) struct Checkpoint {
    /// Hash of what the run is made from.
    pub recipe: String,
    /// The state, but for its integrity, which follows from the changes.
    state: State,
    /// Lines of the journal that belong to it.
    pub lines: usize,
    pub frames: Vec<usize>,
    /// Hash of both by [`RecordHash::close`].
    pub record_hash: String,
}

/// The lines and frames so far, hashed: a checkpoint counts on them.
#[derive(Clone, Default)]
pub(crate) struct RecordHash {
    lines: blake3::Hasher,
    frames: blake3::Hasher,
}

impl RecordHash {
    pub fn add_line(&mut self, bytes: &[u8]) {
        self.lines.update(bytes);
    }

    /// `hash`: of the frame's file, as [`stamp::hash`](super::stamp::hash) has it.
    pub fn add_frame(&mut self, hash: &str) {
        self.frames.update(hash.as_bytes());
    }

    pub fn close(&self) -> String {
        format!("{} {}", self.lines.finalize(), self.frames.finalize())
    }
}

impl Checkpoint {
    pub fn new(recipe: &str, state: &State, lines: usize, frames: &[usize]) -> Checkpoint {
        let mut state = state.clone();
        // It is not kept, and a checkpoint that waits for the disk would make the next change copy it.
        state.integrity = Arc::default();
        Checkpoint {
            recipe: recipe.to_owned(),
            state,
            lines,
            frames: frames.to_vec(),
            record_hash: String::new(),
        }
    }

    /// Whether it can be a state of this problem, after these lines.
    pub fn fits(&self, problem: &Problem, lines: &[HistoryLine]) -> bool {
        let Problem {
            model, programme, ..
        } = problem;
        let state = &self.state;
        let (nodes, interactions) = (model.node_count(), model.interactions.len());
        let fields = [state.displacement.as_slice(), &state.reaction];
        let is_possible = |change: &Change| {
            (change.interaction as usize) < interactions
                && change.integrity.iter().all(|phi| (0.0..=1.0).contains(phi))
        };
        let phases = programme.phases.len();
        let is_sound = |line: &HistoryLine| {
            line.phase < phases && line.bonds_broken_total <= state.changes.len()
        };
        fields.iter().all(|values| values.len() == nodes)
            && lines.iter().all(is_sound)
            && state.changes.iter().all(is_possible)
            && state.fresh <= state.changes.len()
            && state.fragments.iter().flatten().all(|&node| node < nodes)
            && state.mechanisms.iter().all(|&dof| dof < 2 * nodes)
            && state.phase < phases
            && state.work.len() == phases
    }

    pub fn into_state(self, model: &Model) -> State {
        let mut state = self.state;
        state.restore_integrity(model);
        state
    }
}
