//! What a killed run goes on from: the state behind its last step, as it is kept.

use super::bits;
use crate::fracture::control::Ending;
use crate::fracture::event::Load;
use crate::fracture::state::{Energy, LoadForce, State};
use crate::statics::SystemSize;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

#[derive(Serialize, Deserialize)]
pub(super) struct Checkpoint {
    /// Hash of what the run is made from.
    pub recipe: String,
    state: StoredState,
    /// Lines of the journal that belong to it.
    pub lines: usize,
    pub frames: Vec<usize>,
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
    #[serde(with = "bits")]
    intact: Vec<bool>,
    fragments: Vec<Vec<usize>>,
    load_lost: bool,
    mechanisms: BTreeSet<usize>,
    /// [`Ending::describe`], and the reason.
    stopped: Option<(String, String)>,
    energy: [f64; 3],
    force: ([f64; 4], bool),
    broken: Vec<u32>,
    work: Vec<[f64; 2]>,
    just_broken: Vec<(u32, f64)>,
}

impl Checkpoint {
    pub fn new(recipe: &str, state: &State, lines: usize, frames: &[usize]) -> Checkpoint {
        Checkpoint {
            recipe: recipe.to_owned(),
            state: StoredState::from(state),
            lines,
            frames: frames.to_vec(),
        }
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
            intact: state.intact.clone(),
            fragments: state.fragments.clone(),
            load_lost: state.load_lost,
            mechanisms: state.mechanisms.clone(),
            stopped: (state.stopped.as_ref())
                .map(|(ending, reason)| (ending.describe().to_owned(), reason.clone())),
            energy: [external, elastic, dissipated],
            force: ([now, peak, first, last], is_on_top),
            broken: state.broken.clone(),
            work: state.work.clone(),
            just_broken: state.just_broken.clone(),
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
            intact: stored.intact,
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
            broken: stored.broken,
            work: stored.work,
            just_broken: stored.just_broken,
        }
    }
}
