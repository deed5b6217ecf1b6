//! What a killed run goes on from: the state behind its last step, as it is kept.

use super::history::Line;
use super::sparse_integrity::SparseIntegrity;
use super::stored::fits_model;
use crate::fracture::control::{Ending, Problem};
use crate::fracture::event::Load;
use crate::fracture::state::{Change, Energy, LoadForce, State};
use crate::statics::SystemSize;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

#[derive(Serialize, Deserialize)]
pub(crate) struct Checkpoint {
    /// Hash of what the run is made from.
    pub recipe: String,
    state: StoredState,
    /// Lines of the journal that belong to it.
    pub lines: usize,
    pub frames: Vec<usize>,
    /// What [`Ledger::close`] says of both.
    pub ledger: String,
}

/// The lines and frames so far, hashed: a checkpoint counts on them.
#[derive(Clone, Default)]
pub(crate) struct Ledger {
    lines: blake3::Hasher,
    frames: blake3::Hasher,
}

impl Ledger {
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

#[derive(Serialize, Deserialize)]
struct StoredState {
    step: usize,
    phase: usize,
    phase_start: usize,
    load: [f64; 2],
    envelope: f64,
    displacement: Vec<[f64; 2]>,
    reaction: Vec<[f64; 2]>,
    residual: f64,
    size: Option<[usize; 4]>,
    integrity: SparseIntegrity,
    fragments: Vec<Vec<usize>>,
    load_lost: bool,
    mechanisms: BTreeSet<usize>,
    /// [`Ending::describe`], and the reason.
    stopped: Option<(String, String)>,
    energy: [f64; 3],
    force: ([f64; 4], bool),
    work: Vec<[f64; 2]>,
    /// Interaction, integrity before and after, elongation, as [`Change`] has them.
    changes: Vec<(u32, [f64; 2], f64)>,
    fresh: usize,
}

impl Checkpoint {
    pub fn new(recipe: &str, state: &State, lines: usize, frames: &[usize]) -> Checkpoint {
        Checkpoint {
            recipe: recipe.to_owned(),
            state: StoredState::from(state),
            lines,
            frames: frames.to_vec(),
            ledger: String::new(),
        }
    }

    /// Whether it can be a state of this problem, behind these lines.
    pub fn fits(&self, problem: &Problem, lines: &[Line]) -> bool {
        let Problem {
            model, programme, ..
        } = problem;
        let state = &self.state;
        let (nodes, springs) = (model.node_count(), model.springs.len());
        let fields = [state.displacement.as_slice(), &state.reaction];
        let mut changes = state.changes.iter();
        let phases = programme.phases.len();
        let is_sound =
            |line: &Line| line.phase < phases && line.bonds_broken_total <= state.changes.len();
        fits_model(model, &fields, &state.integrity)
            && lines.iter().all(is_sound)
            && changes.all(|&(interaction, ..)| (interaction as usize) < springs)
            && state.fresh <= state.changes.len()
            && state.fragments.iter().flatten().all(|&node| node < nodes)
            && state.mechanisms.iter().all(|&dof| dof < 2 * nodes)
            && state.phase < phases
            && state.work.len() == phases
    }

    pub fn into_state(self) -> State {
        self.state.into()
    }
}

impl From<&State> for StoredState {
    fn from(state: &State) -> StoredState {
        let Energy {
            external,
            elastic,
            dissipated,
        } = state.energy;
        let LoadForce {
            now,
            peak,
            stiffness: [first, last],
            is_on_top,
        } = state.force;
        StoredState {
            step: state.step,
            phase: state.phase,
            phase_start: state.phase_start,
            load: [state.load.share, state.load.factor],
            envelope: state.envelope,
            displacement: state.displacement.clone(),
            reaction: state.reaction.clone(),
            residual: state.residual,
            size: state.size.map(SystemSize::numbers),
            integrity: SparseIntegrity::new(&state.integrity),
            fragments: state.fragments.clone(),
            load_lost: state.load_lost,
            mechanisms: state.mechanisms.clone(),
            stopped: (state.stopped.as_ref())
                .map(|(ending, reason)| (ending.describe().to_owned(), reason.clone())),
            energy: [external, elastic, dissipated],
            force: ([now, peak, first, last], is_on_top),
            work: state.work.clone(),
            changes: (state.changes.iter())
                .map(|change| (change.interaction, change.integrity, change.elongation))
                .collect(),
            fresh: state.fresh,
        }
    }
}

impl From<StoredState> for State {
    fn from(stored: StoredState) -> State {
        let [external, elastic, dissipated] = stored.energy;
        let ([now, peak, first, last], is_on_top) = stored.force;
        State {
            step: stored.step,
            phase: stored.phase,
            phase_start: stored.phase_start,
            load: Load {
                share: stored.load[0],
                factor: stored.load[1],
            },
            envelope: stored.envelope,
            displacement: stored.displacement,
            reaction: stored.reaction,
            residual: stored.residual,
            size: stored.size.map(SystemSize::from_numbers),
            integrity: stored.integrity.to_vec(),
            fragments: stored.fragments,
            load_lost: stored.load_lost,
            mechanisms: stored.mechanisms,
            stopped: (stored.stopped)
                .and_then(|(name, reason)| Some((Ending::from_description(&name)?, reason))),
            energy: Energy {
                external,
                elastic,
                dissipated,
            },
            force: LoadForce {
                now,
                peak,
                stiffness: [first, last],
                is_on_top,
            },
            work: stored.work,
            changes: (stored.changes.into_iter())
                .map(|(interaction, integrity, elongation)| Change {
                    interaction,
                    integrity,
                    elongation,
                })
                .collect(),
            fresh: stored.fresh,
        }
    }
}
