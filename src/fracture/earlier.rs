//! An earlier state of a run, found again from the changes of integrity up to it.

use super::event::Load;
use super::problem::{Problem, Resolution};
use super::response::Response;
use super::state::State;
use crate::statics::{Solver, StaticsError};
use std::collections::BTreeSet;

/// A step of a run.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    pub step: usize,
    pub phase: usize,
    pub load: Load,
    /// Number of the changes of integrity before the last solve of the step, and after it.
    pub changes: [usize; 2],
}

/// The state after a step, by one solve. Parts that had come off by then are where they are in the `last` state:
/// they stay where they broke off.
///
/// # Errors
/// Errors of the solver.
pub fn state_at(problem: &Problem, last: &State, moment: &Moment) -> Result<State, StaticsError> {
    // One response is wanted, and no look ahead from it.
    let problem = Problem {
        resolution: Resolution::Reference,
        ..*problem
    };
    let Problem {
        model, programme, ..
    } = problem;
    let mut state = State {
        step: moment.step,
        phase: moment.phase,
        load: moment.load,
        mechanisms: BTreeSet::new(),
        ..last.clone()
    };
    let [before, after] = moment.changes;
    state.changes.truncate(before);
    state.restore_integrity(model);
    state.find_loose_parts(model, programme);
    let backend = last.size.map(|size| size.backend);
    let solver = Solver::with_backend(model, programme.supports(), backend)?;
    let response = Response::new(&solver, &problem, &mut state)?;
    state.settle(&problem, &response);
    state.changes.clone_from(&last.changes);
    state.changes.truncate(after);
    state.restore_integrity(model);
    Ok(state)
}
