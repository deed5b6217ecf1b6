//! The response of the body with the bonds that are intact, linear in the load: it serves until the
//! next bond breaks.
//!
//! ```text
//! u(μ, λ) = μ (u_held + λ u_unit)
//! ```
//!
//! λ is the load factor of the current phase, u_held the response to what the phases before it have
//! left in place. μ = 1, but for the moments in which the body cannot carry what is held.

use super::control::Problem;
use super::state::State;
use crate::model::Model;
use crate::phases::Phases;
use crate::statics::{Solution, Solver, StaticsError};
use rayon::prelude::*;

/// A point in the space of loads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// μ, the share of all loads that acts [-].
    pub share: f64,
    /// λ of the current phase [-].
    pub factor: f64,
}

impl Load {
    /// All that is held acts in full.
    pub fn full(factor: f64) -> Load {
        Load { share: 1.0, factor }
    }
}

/// What the event-driven control finds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A bond reaches its limit.
    Break(Load),
    /// The phase ends before that.
    PhaseEnd,
    /// No load breaks another bond.
    None,
}

/// u_held and u_unit.
pub struct Response {
    pub held: Option<Solution>,
    pub unit: Solution,
}

impl Response {
    /// # Errors
    /// What the solver reports.
    pub fn new(
        solver: &Solver,
        problem: &Problem,
        state: &mut State,
        phases: &mut Phases,
    ) -> Result<Response, StaticsError> {
        let programme = problem.programme;
        let held = programme.held(state.phase);
        let mut cases = vec![&programme.phases[state.phase].boundary];
        cases.extend(&held);
        let mut solutions = solver.solve_broken(
            &cases,
            &state.intact,
            &state.fragments,
            &mut state.mechanisms,
            phases,
        )?;
        let held = held.and_then(|_| solutions.pop());
        let unit = solutions.pop().expect("a solution for every case");
        Ok(Response { held, unit })
    }

    /// The larger relative residual of the two.
    pub fn residual(&self) -> f64 {
        let held = self.held.as_ref().map_or(0.0, |held| held.residual);
        held.max(self.unit.residual)
    }

    /// Displacement [m] and, where one is prescribed, reaction [N] of a node.
    pub fn at(&self, load: Load, node: usize) -> ([f64; 2], [f64; 2]) {
        let combine = |field: fn(&Solution) -> &Vec<[f64; 2]>| {
            [0, 1].map(|axis| {
                let unit = load.factor * field(&self.unit)[node][axis];
                let held = self.held.as_ref();
                load.share * held.map_or(unit, |held| field(held)[node][axis] + unit)
            })
        };
        (combine(|s| &s.displacement), combine(|s| &s.reaction))
    }

    /// Q = Σ reaction · prescribed displacement of the unit load: conjugate to λ [J].
    pub fn stiffness(&self, problem: &Problem, phase: usize) -> f64 {
        let prescribed = &problem.programme.phases[phase].boundary.prescribed;
        let terms = prescribed.iter();
        terms
            .map(|(&dof, (value, _))| value * self.unit.reaction[dof / 2][dof % 2])
            .sum()
    }

    /// Stretch of a spring [-].
    pub fn stretch(&self, problem: &Problem, spring: usize, load: Load) -> f64 {
        let [held, unit] = self.stretches(problem, spring);
        load.share * (held + load.factor * unit)
    }

    /// Stretches of a spring under what is held, and per unit of λ.
    fn stretches(&self, problem: &Problem, spring: usize) -> [f64; 2] {
        let Model {
            springs, positions, ..
        } = problem.model;
        let stretch = |u: &Solution| springs.stretch(spring, positions, &u.displacement);
        [self.held.as_ref().map_or(0.0, stretch), stretch(&self.unit)]
    }

    /// The load at which the next bond breaks, bounded from both sides: where something is held, λ may
    /// also have to stay above a limit. If no λ can carry what is held, all loads together recede until
    /// only one bond is at its limit (proportional unloading, DeJong et al. 2008).
    pub fn next_event(&self, problem: &Problem, state: &State) -> Event {
        let bounds = self.map_intact(problem, state, |[held, unit], limit| {
            let (mut lower, mut upper) = (f64::NEG_INFINITY, f64::INFINITY);
            for limit in [limit.tension, -limit.compression] {
                let at = (limit - held) / unit;
                // Where the stretch runs towards this limit as λ grows, it bounds λ from above.
                if unit != 0.0 && (unit > 0.0) == (limit > 0.0) {
                    upper = upper.min(at);
                } else if unit != 0.0 {
                    lower = lower.max(at);
                }
            }
            [lower, upper]
        });
        let lower = bounds
            .iter()
            .map(|b| b[0])
            .fold(f64::NEG_INFINITY, f64::max);
        let upper = bounds.iter().map(|b| b[1]).fold(f64::INFINITY, f64::min);
        let last = state.load.factor;
        let excess = self.largest_utilisation(problem, state, Load::full(last));
        let end = problem.programme.phases[state.phase].end;
        if lower > upper && excess > 1.0 {
            Event::Break(Load {
                share: 1.0 / excess,
                factor: last,
            })
        } else if end.is_some_and(|end| upper >= end) {
            Event::PhaseEnd
        } else if upper.is_finite() {
            Event::Break(Load::full(upper))
        } else {
            Event::None
        }
    }

    /// The largest stretch of an intact bond over its limit.
    fn largest_utilisation(&self, problem: &Problem, state: &State, load: Load) -> f64 {
        let utilisations = self.map_intact(problem, state, |[held, unit], limit| {
            limit.utilisation(load.share * (held + load.factor * unit))
        });
        utilisations.into_iter().fold(0.0, f64::max)
    }

    /// Bonds at their limit, or within the share `tie` of it and bound to reach it.
    pub fn bonds_at_limit(
        &self,
        problem: &Problem,
        state: &State,
        load: Load,
        tie: f64,
    ) -> Vec<usize> {
        let is_share = load.share < 1.0;
        let reached = self.map_intact(problem, state, |[held, unit], limit| {
            let stretch = load.share * (held + load.factor * unit);
            let outwards = is_share || stretch * unit > 0.0;
            outwards && limit.utilisation(stretch) * (1.0 + tie) >= 1.0
        });
        let intact = (0..state.intact.len()).filter(|&s| state.intact[s]);
        intact
            .zip(reached)
            .filter(|&(_, at)| at)
            .map(|(s, _)| s)
            .collect()
    }

    /// `f` of the stretches and the limit of every intact spring, in order.
    fn map_intact<T: Send>(
        &self,
        problem: &Problem,
        state: &State,
        f: impl Fn([f64; 2], super::failure::CriticalStretch) -> T + Sync,
    ) -> Vec<T> {
        (0..problem.model.springs.len())
            .into_par_iter()
            .filter(|&s| state.intact[s])
            .map(|s| f(self.stretches(problem, s), problem.limits.of(s)))
            .collect()
    }
}
