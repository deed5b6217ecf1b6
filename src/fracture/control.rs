//! How the load grows while bonds break.

use super::event::{Event, Load};
use super::functional::Values;
use super::response::Response;
use super::state::State;
use super::unbreakable::UnbreakableNodes;
use crate::phases::measure;
use crate::statics::{Solver, StaticsError};

pub use super::ending::Ending;
pub use super::problem::{Control, Problem, Resolution, Until};

/// One step of the run.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Changes of integrity, and those of them that broke an interaction.
    pub changed: usize,
    pub broken: usize,
    pub passes: usize,
    pub residual: f64,
    /// Resultants and works of the first pass, before bonds broke in the step.
    pub first_pass: Values,
}

/// Loads `state` until the run ends. `observe` is called after each step; an error
/// that it returns ends the run.
///
/// # Errors
/// Errors of the solver and of `observe`.
pub fn run<E: From<StaticsError>>(
    problem: &Problem,
    state: &mut State,
    mut observe: impl FnMut(&State, Record, &Response) -> Result<(), E>,
) -> Result<Ending, E> {
    // Decided from the state alone, so that a run resumed after its last step ends there too.
    state.begin_phase_if_due(problem.model, problem.programme);
    let unbreakable = UnbreakableNodes::new(problem);
    if let Some(ending) = ending(problem, state, &unbreakable) {
        return Ok(ending);
    }
    let (supports, backend) = (problem.programme.supports(), problem.resolution.backend());
    let solver = Solver::with_backend(problem.model, supports, backend)?;
    let mut response = match Response::new(&solver, problem, state) {
        Ok(response) => response,
        // Before the first step it is the problem that has no solution.
        Err(error) if state.step == 0 && !matches!(error, StaticsError::Swings { .. }) => {
            return Err(error.into());
        }
        Err(error) => return Ok(state.stop(&error)),
    };
    while let Some(mut load) = next_load(problem, state, &response) {
        state.step += 1;
        let mut record = Record {
            first_pass: response.values().clone(),
            ..Record::default()
        };
        let last_changed = loop {
            state.advance(problem, &response, load);
            let [changed, broken] = change_bonds(problem, state, &mut response, load);
            state.settle_if_due(problem, &response);
            record.changed += changed;
            record.broken += broken;
            record.passes += 1;
            record.residual = f64::max(record.residual, response.residual());
            if state.load_lost || changed == 0 || !passes_again(problem.control, record.passes) {
                break changed;
            }
            if let Err(error) = response.renew(&solver, problem, state) {
                state.stop(&error);
                break changed;
            }
            load = load_of_step(problem, state, state.step, &response);
        };
        observe(state, record, &response)?;
        let is_new_phase = state.begin_phase_if_due(problem.model, problem.programme);
        if let Some(ending) = ending(problem, state, &unbreakable) {
            state.settle(problem, &response);
            return Ok(ending);
        }
        let is_stale = last_changed > 0 || is_new_phase;
        if is_stale && let Err(error) = response.renew(&solver, problem, state) {
            return Ok(state.stop(&error));
        }
    }
    Ok(Ending::NothingLeftToBreak)
}

/// Whether bonds that broke call for another solve at the same load.
fn passes_again(control: Control, passes: usize) -> bool {
    matches!(control, Control::Equilibrium { most_passes } if passes < most_passes)
}

/// Whether the run ends with this state.
fn ending(problem: &Problem, state: &State, unbreakable: &UnbreakableNodes) -> Option<Ending> {
    let Problem { control, until, .. } = problem;
    let is_equilibrium = matches!(control, Control::Equilibrium { .. });
    if state.load_lost || (until.separated && state.force.is_spent()) {
        Some(Ending::Separated)
    } else if let Some((ending, _)) = &state.stopped {
        Some(*ending)
    } else if is_equilibrium && state.fresh > 0 {
        // The passes did not suffice: a step that has settled leaves no fresh change.
        Some(Ending::PassLimit)
    } else if problem.programme.is_over(state.phase, state.load) {
        Some(Ending::LoadLimit)
    } else if until.separated && unbreakable.have_stopped(problem, state) {
        Some(Ending::ReachedUnbreakable)
    } else if state.step == until.steps {
        Some(Ending::StepLimit)
    } else {
        None
    }
}

/// The load of the next step, or of the next event; `None` where no load breaks a bond.
fn next_load(problem: &Problem, state: &State, response: &Response) -> Option<Load> {
    match problem.control {
        // A number of steps is a number of lines: those that can break nothing are among them.
        Control::OnePass | Control::Equilibrium { .. }
            if problem.until.steps == Until::NO_LIMIT && response.carries_any_load() =>
        {
            None
        }
        Control::OnePass | Control::Equilibrium { .. } => {
            Some(load_of_step(problem, state, state.step + 1, response))
        }
        Control::EventDriven => match response.next_event(problem, state) {
            Event::Break(load) => Some(load),
            Event::PhaseEnd => problem.programme.phases[state.phase].end.map(Load::full),
            Event::None => None,
        },
    }
}

/// The load of a load step. Passes of one step differ where a probe controls it.
fn load_of_step(problem: &Problem, state: &State, step: usize, response: &Response) -> Load {
    let step = step - state.phase_start;
    let values = response.values();
    (problem.programme).load_of_step(state.phase, step, values)
}

/// Changes the bonds that the load brings to a limit; returns how many interactions have changed, and how many
/// bonds have broken.
fn change_bonds(
    problem: &Problem,
    state: &mut State,
    response: &mut Response,
    load: Load,
) -> [usize; 2] {
    let bonds = measure("stretches", || match problem.control {
        Control::EventDriven => response.bonds_at_limit(problem, state, load),
        _ => response.bonds_over_limit(problem, state, load),
    });
    measure("loose parts", || {
        let changes = state.change(problem, Some(response), &bonds);
        let bonds = problem.model.interactions.axial();
        let broken = changes.iter().filter(|change| change.is_break());
        let broken = broken.filter(|change| bonds.contains(&(change.interaction as usize)));
        [changes.len(), broken.count()]
    })
}
