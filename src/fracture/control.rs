//! How the load grows while bonds break.

use super::event::{Event, Load};
use super::programme::{LoadPhase, Programme};
use super::response::Response;
use super::state::{Limits, State};
use crate::model::Model;
use crate::phases::Phases;
use crate::statics::{Method, Solver, StaticsError};

/// The three controls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Control {
    /// One solve per load step; all bonds over their limit break, then the next step: Qian et al.
    /// (2021), section 4.2.
    OnePass,
    /// Solves again at the same load until no bond breaks.
    Equilibrium {
        /// More passes than these at one load end the run.
        most_passes: usize,
    },
    /// Scales the load to the next bond's limit: no step size, snap-back is traced.
    EventDriven,
}

/// Where a run ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Until {
    /// Load steps, or events.
    pub steps: usize,
    /// Whether the separation of the body ends the run.
    pub separated: bool,
}

/// How a run ended; none of these is an error but [`Ending::Singular`], behind which the last good state
/// stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The reaction fell under 2 % of its peak, or a loaded part broke off.
    Separated,
    /// A loaded part hangs on a hinge and swings freely.
    Collapsed,
    /// K of what is left is singular, or too close to it for a solution.
    Singular,
    /// The programme has come to its end.
    LoadLimit,
    /// All steps are done.
    StepLimit,
    /// Bonds still broke after the most passes at one load.
    PassLimit,
    /// No load breaks another bond.
    NothingLeftToBreak,
}

impl Ending {
    pub const ALL: [Ending; 7] = [
        Ending::Separated,
        Ending::Collapsed,
        Ending::Singular,
        Ending::LoadLimit,
        Ending::StepLimit,
        Ending::PassLimit,
        Ending::NothingLeftToBreak,
    ];

    /// The one that [`Ending::describe`] calls so.
    pub fn from_description(name: &str) -> Option<Ending> {
        Ending::ALL.into_iter().find(|e| e.describe() == name)
    }

    /// In a few words.
    pub fn describe(self) -> &'static str {
        match self {
            Ending::Separated => "separated",
            Ending::Collapsed => "collapsed",
            Ending::Singular => "stopped, singular",
            Ending::LoadLimit => "load limit",
            Ending::StepLimit => "step limit",
            Ending::PassLimit => "pass limit",
            Ending::NothingLeftToBreak => "nothing left to break",
        }
    }
}

/// A body whose reaction is below this share of its peak is separated.
pub const SEPARATED: f64 = 0.02;

/// Bonds within this relative distance of the first one break with it: ties by symmetry differ by
/// rounding errors only, and none is decided by an index.
pub(super) const TIE: f64 = 1e-3;

/// Everything that a run needs and does not change.
pub struct Problem<'a> {
    pub model: &'a Model,
    pub programme: &'a Programme,
    pub limits: &'a Limits,
    pub control: Control,
    pub until: Until,
    pub resolution: Resolution,
}

/// How the response is found after bonds have broken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Resolution {
    /// By updates of the last factorisation, as long as they do.
    #[default]
    Fast,
    /// By a factorisation for every response: what all else is checked against.
    Reference,
    /// By conjugate gradients on two levels, as large lattices are solved, whatever the size.
    TwoLevel,
}

impl Resolution {
    /// How systems are to be solved; `None`: whichever way their size suggests.
    pub fn method(self) -> Option<Method> {
        match self {
            Resolution::Fast | Resolution::Reference => None,
            Resolution::TwoLevel => Some(Method::TwoLevel),
        }
    }
}

/// One line of the history.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Record {
    pub broken: usize,
    pub passes: usize,
    pub residual: f64,
}

/// Loads `state` until the run ends. After each step `observe` is told what happened; what it
/// returns as an error ends the run.
///
/// # Errors
/// What the solver or `observe` reports.
pub fn run<E: From<StaticsError>>(
    problem: &Problem,
    state: &mut State,
    phases: &mut Phases,
    mut observe: impl FnMut(&State, Record, &Response) -> Result<(), E>,
) -> Result<Ending, E> {
    // Decided from the state alone, so that a run resumed behind its last step ends there too.
    state.begin_phase_if_due(problem.model, problem.programme);
    if let Some(ending) = ending(problem, state) {
        return Ok(ending);
    }
    let (supports, method) = (problem.programme.supports(), problem.resolution.method());
    let solver = Solver::with_method(problem.model, supports, method, phases)?;
    let mut response = match Response::new(&solver, problem, state, phases) {
        Ok(response) => response,
        // Before the first step it is the problem that has no solution.
        Err(error) if state.step == 0 && !matches!(error, StaticsError::Swings { .. }) => {
            return Err(error.into());
        }
        Err(error) => return Ok(state.stop(&error)),
    };
    while let Some(load) = next_load(problem, state, &response) {
        state.step += 1;
        let mut record = Record::default();
        let last_broken = loop {
            state.advance(problem, &response, load);
            let broken = break_bonds(problem, state, &mut response, load, phases);
            if !response.foresees_next() {
                state.settle(problem, &response);
            }
            record.broken += broken;
            record.passes += 1;
            record.residual = f64::max(record.residual, response.residual());
            if state.load_lost || broken == 0 || !passes_again(problem.control, record.passes) {
                break broken;
            }
            if let Err(error) = response.renew(&solver, problem, state, phases) {
                state.stop(&error);
                break broken;
            }
        };
        observe(state, record, &response)?;
        let is_new_phase = state.begin_phase_if_due(problem.model, problem.programme);
        if let Some(ending) = ending(problem, state) {
            if response.foresees_next() {
                state.settle(problem, &response);
            }
            return Ok(ending);
        }
        let is_stale = last_broken > 0 || is_new_phase;
        if is_stale && let Err(error) = response.renew(&solver, problem, state, phases) {
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
fn ending(problem: &Problem, state: &State) -> Option<Ending> {
    let Problem { control, until, .. } = problem;
    let is_equilibrium = matches!(control, Control::Equilibrium { .. });
    if state.load_lost || (until.separated && state.force.is_spent()) {
        Some(Ending::Separated)
    } else if let Some((ending, _)) = &state.stopped {
        Some(*ending)
    } else if is_equilibrium && !state.just_broken.is_empty() {
        // The passes did not suffice: a step that has settled leaves no bond freshly broken.
        Some(Ending::PassLimit)
    } else if problem.programme.is_over(state.phase, state.load) {
        Some(Ending::LoadLimit)
    } else if state.step == until.steps {
        Some(Ending::StepLimit)
    } else {
        None
    }
}

/// The load of the next step, or of the next event; `None` where no load breaks a bond.
fn next_load(problem: &Problem, state: &State, response: &Response) -> Option<Load> {
    let LoadPhase { increment, end, .. } = problem.programme.phases[state.phase];
    let end = end.unwrap_or(f64::INFINITY);
    match problem.control {
        Control::OnePass | Control::Equilibrium { .. } => {
            let next = (state.step - state.phase_start) as f64 + 1.0;
            Some(Load::full(f64::min(next * increment, end)))
        }
        Control::EventDriven => match response.next_event(problem, state) {
            Event::Break(load) => Some(load),
            Event::PhaseEnd => Some(Load::full(end)),
            Event::None => None,
        },
    }
}

fn break_bonds(
    problem: &Problem,
    state: &mut State,
    response: &mut Response,
    load: Load,
    phases: &mut Phases,
) -> usize {
    let bonds = phases.measure("stretches", || match problem.control {
        Control::EventDriven => response.bonds_at_limit(problem, state, load),
        _ => response.bonds_over_limit(problem, state, load),
    });
    phases.measure("loose parts", || {
        state.break_bonds(problem, Some(response), &bonds)
    })
}
