//! How the load grows while bonds break.

use super::state::{Limits, State};
use crate::boundary::Boundary;
use crate::model::Model;
use crate::phases::Phases;
use crate::statics::{Solution, Solver, StaticsError};
use rayon::prelude::*;

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
    /// Load steps of Δλ = 1, or events.
    pub steps: usize,
    /// Whether a force under [`SEPARATED`] of its peak ends the run.
    pub separated: bool,
}

/// How a run ended; none of these is an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The force fell under 2 % of its peak.
    Separated,
    /// All steps are done.
    StepLimit,
    /// Bonds still broke after the most passes at one load.
    PassLimit,
    /// No load breaks another bond.
    NothingLeftToBreak,
}

impl Ending {
    pub const ALL: [Ending; 4] = [
        Ending::Separated,
        Ending::StepLimit,
        Ending::PassLimit,
        Ending::NothingLeftToBreak,
    ];

    /// In a few words.
    pub fn describe(self) -> &'static str {
        match self {
            Ending::Separated => "separated",
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
const TIE: f64 = 1e-3;

/// Everything that a run needs and does not change.
pub struct Problem<'a> {
    pub model: &'a Model,
    pub boundary: &'a Boundary,
    pub limits: &'a Limits,
    pub control: Control,
    pub until: Until,
}

/// One line of the history.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    mut observe: impl FnMut(&State, Record, &Solution) -> Result<(), E>,
) -> Result<Ending, E> {
    // Decided from the state alone, so that a run resumed behind its last step ends there too.
    if let Some(ending) = ending(problem, state) {
        return Ok(ending);
    }
    let mut response = Response::new(problem, state, phases)?;
    loop {
        let Some(load_factor) = response.next_load(problem, state) else {
            return Ok(Ending::NothingLeftToBreak);
        };
        state.step += 1;
        let mut record = Record {
            broken: 0,
            passes: 0,
            residual: 0.0,
        };
        let last_broken = loop {
            state.advance(problem.model, problem.boundary, &response.unit, load_factor);
            let broken = response.break_bonds(problem, state);
            record.broken += broken;
            record.passes += 1;
            record.residual = f64::max(record.residual, response.unit.residual);
            match problem.control {
                Control::Equilibrium { most_passes } if broken > 0 => {
                    if record.passes == most_passes {
                        break broken;
                    }
                    response.refresh(state, phases)?;
                }
                _ => break broken,
            }
        };
        observe(state, record, &response.unit)?;
        if let Some(ending) = ending(problem, state) {
            return Ok(ending);
        }
        if last_broken > 0 {
            response.refresh(state, phases)?;
        }
    }
}

/// Whether the run ends with this state.
fn ending(problem: &Problem, state: &State) -> Option<Ending> {
    let Problem { control, until, .. } = problem;
    let is_equilibrium = matches!(control, Control::Equilibrium { .. });
    if until.separated && state.energy.force.abs() < SEPARATED * state.peak_force {
        Some(Ending::Separated)
    } else if is_equilibrium && !state.just_broken.is_empty() {
        // The passes did not suffice: a step that has settled leaves no bond freshly broken.
        Some(Ending::PassLimit)
    } else if state.step == until.steps {
        Some(Ending::StepLimit)
    } else {
        None
    }
}

/// The solution for λ = 1 in the given state.
///
/// # Errors
/// What the solver reports.
pub fn unit_response(
    problem: &Problem,
    state: &mut State,
    phases: &mut Phases,
) -> Result<Solution, StaticsError> {
    Ok(Response::new(problem, state, phases)?.unit)
}

/// The solution for λ = 1 with the bonds that are intact.
struct Response<'a> {
    solver: Solver<'a>,
    unit: Solution,
}

impl<'a> Response<'a> {
    fn new(
        problem: &Problem<'a>,
        state: &mut State,
        phases: &mut Phases,
    ) -> Result<Response<'a>, StaticsError> {
        let solver = Solver::new(problem.model, problem.boundary, phases)?;
        let unit = solver.solve_broken(
            &state.intact,
            &state.fragments,
            &mut state.mechanisms,
            phases,
        )?;
        Ok(Response { solver, unit })
    }

    fn refresh(&mut self, state: &mut State, phases: &mut Phases) -> Result<(), StaticsError> {
        let State {
            intact,
            fragments,
            mechanisms,
            ..
        } = state;
        self.unit = self
            .solver
            .solve_broken(intact, fragments, mechanisms, phases)?;
        Ok(())
    }

    /// λ of the next step, or of the next event; `None` where no load breaks a bond.
    fn next_load(&self, problem: &Problem, state: &State) -> Option<f64> {
        match problem.control {
            Control::OnePass | Control::Equilibrium { .. } => Some((state.step + 1) as f64),
            Control::EventDriven => {
                let next = self.load_factors(problem, state);
                let first = next.into_iter().fold(f64::INFINITY, f64::min);
                first.is_finite().then_some(first)
            }
        }
    }

    /// λ at which each spring breaks; infinite for those that are broken or never do.
    fn load_factors(&self, problem: &Problem, state: &State) -> Vec<f64> {
        let Problem { model, limits, .. } = problem;
        let factor = |s: usize| {
            if !state.intact[s] {
                return f64::INFINITY;
            }
            let displacement = &self.unit.displacement;
            let stretch = model.springs.stretch(s, &model.positions, displacement);
            limits.of(s).load_factor(stretch)
        };
        (0..model.springs.len())
            .into_par_iter()
            .map(factor)
            .collect()
    }

    fn break_bonds(&self, problem: &Problem, state: &mut State) -> usize {
        let Problem {
            model,
            boundary,
            limits,
            control,
            ..
        } = problem;
        if *control != Control::EventDriven {
            return state.break_exceeded(model, boundary, limits);
        }
        let reached = state.load_factor * (1.0 + TIE);
        let factors = self.load_factors(problem, state);
        let now: Vec<usize> = (0..factors.len())
            .filter(|&s| factors[s] <= reached)
            .collect();
        state.break_bonds(model, boundary, &now)
    }
}
