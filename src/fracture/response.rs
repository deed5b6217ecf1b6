//! The response of the body with the bonds that are intact, linear in the load: it serves until the
//! next bond breaks.
//!
//! ```text
//! u(μ, λ) = μ (u_held + λ u_unit)
//! ```
//!
//! λ is the load factor of the current phase, u_held the response to what the phases before it have
//! left in place. μ = 1, but for the moments in which the body cannot carry what is held.
//!
//! Under the event-driven control the response looks ahead (`active_zone.rs`): it knows a number
//! of events that follow from one factorisation, and goes from one to the next without solving again.
//! Elsewhere it is updated from the last factorisation (`update.rs`), one solution for each pass in which
//! bonds broke. Without factors, on a large lattice, conjugate gradients start from what the state was last
//! settled to.

use super::active_zone::{Ahead, look_ahead};
use super::event::{Bounds, Event, Load, TIE, is_at_limit};
use super::functional::Values;
use super::problem::{Control, Problem, Resolution};
use super::solutions::{Solutions, nan_max};
use super::state::State;
use super::update::Update;
use crate::boundary::Boundary;
use crate::phases::Phases;
use crate::statics::{Factorised, Solution, Solver, StaticsError};
use rayon::prelude::*;
use std::time::Instant;

/// A bond at this share of its limit may break soon.
const NEAR: f64 = 0.8;

/// The response, and what is known of those that follow.
pub struct Response {
    solved: Solutions,
    values: Values,
    /// The events that follow, and which of them is next.
    ahead: Option<Ahead>,
    next: usize,
    update: Option<Update>,
    /// Bonds that were near their limit when they were last asked for, and what all of them allow where
    /// none was over it.
    near: Vec<usize>,
    carries: Option<Bounds>,
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
        let factorised = solver.factorise_broken(
            &state.integrity,
            &state.fragments,
            &mut state.mechanisms,
            phases,
        )?;
        Response::of(factorised, solver, problem, state, phases)
    }

    fn of(
        factorised: Factorised,
        solver: &Solver,
        problem: &Problem,
        state: &State,
        phases: &mut Phases,
    ) -> Result<Response, StaticsError> {
        let solved = solve(solver, problem, state, &factorised, phases)?;
        let mut response = Response {
            values: solved.values(problem),
            solved,
            ahead: None,
            next: 0,
            update: None,
            near: Vec::new(),
            carries: None,
        };
        if problem.resolution == Resolution::Reference || !factorised.has_compliances() {
            return Ok(response);
        }
        if problem.control == Control::EventDriven
            && let Event::Break(load) = response.next_event(problem, state)
        {
            let start = Instant::now();
            let (solved, values) = (&response.solved, &response.values);
            response.ahead = look_ahead(problem, state, factorised, solved, values, load);
            phases.note("active zone", start);
        } else {
            response.update = Some(Update::new(
                problem,
                factorised,
                response.solved.clone(),
                state,
            ));
        }
        Ok(response)
    }

    /// The response after the bonds of an event have broken, or a new phase has begun.
    ///
    /// # Errors
    /// What the solver reports.
    pub fn renew(
        &mut self,
        solver: &Solver,
        problem: &Problem,
        state: &mut State,
        phases: &mut Phases,
    ) -> Result<(), StaticsError> {
        if self.foresees_next() {
            self.next += 1;
            return Ok(());
        }
        if let Some(update) = &mut self.update
            && let Some(solved) = update.renew(problem, state, &self.near, phases)
        {
            self.carries = None;
            self.values = solved.values(problem);
            self.solved = solved;
            return Ok(());
        }
        // Two factors at a time are more than may fit.
        self.ahead = None;
        let factorised = match self.update.take() {
            Some(update) => update.refactorise(solver, state, phases)?,
            None => None,
        };
        *self = match factorised {
            Some(factorised) => Response::of(factorised, solver, problem, state, phases)?,
            None => Response::new(solver, problem, state, phases)?,
        };
        Ok(())
    }

    /// Whether the response after the next event is known already.
    pub fn foresees_next(&self) -> bool {
        let ahead = self.ahead.as_ref();
        ahead.is_some_and(|ahead| self.next + 1 < ahead.count())
    }

    /// Whether a run that begins with `state`, and so with a factorisation, goes on with the same bits.
    pub fn is_reproducible(&self, state: &State) -> bool {
        match (&self.ahead, &self.update) {
            (Some(_), _) => !self.foresees_next(),
            (None, Some(update)) => update.is_reproducible(state),
            (None, None) => true,
        }
    }

    fn now(&self) -> Option<(&Ahead, usize)> {
        self.ahead.as_ref().map(|ahead| (ahead, self.next))
    }

    /// u_held and u_unit everywhere.
    pub fn solutions(&self, problem: &Problem, phase: usize) -> Solutions {
        match self.now() {
            Some((ahead, next)) if next > 0 => ahead.solutions(problem, phase, &self.solved, next),
            _ => self.solved.clone(),
        }
    }

    /// Largest backward error since the last factorisation [-].
    pub fn residual(&self) -> f64 {
        let ahead = self.now().map_or(0.0, |(ahead, _)| ahead.residual);
        nan_max(ahead, self.solved.residual())
    }

    /// Resultants and works.
    pub fn values(&self) -> &Values {
        match self.now() {
            Some((ahead, next)) => &ahead.moment(next).values,
            None => &self.values,
        }
    }

    /// Stretch of a spring, broken in this event or the last one [-].
    pub fn stretch(&self, problem: &Problem, spring: usize, load: Load) -> f64 {
        let ahead = self.now().filter(|&(_, next)| next > 0);
        let foreseen = ahead.and_then(|(ahead, next)| ahead.stretches(next, spring));
        load.combine(foreseen.unwrap_or_else(|| self.solved.stretches(problem, spring)))
    }

    /// The load at which the next bond breaks.
    pub fn next_event(&self, problem: &Problem, state: &State) -> Event {
        if let Some((ahead, next)) = self.now() {
            return Event::Break(ahead.moment(next).load);
        }
        let end = problem.programme.phases[state.phase].end;
        let bounds = self.bounds(problem, state);
        bounds.event(state.load.factor, end)
    }

    /// What the intact bonds allow.
    fn bounds(&self, problem: &Problem, state: &State) -> Bounds {
        let of = |s| {
            let stretches = self.solved.stretches(problem, s);
            Bounds::of(
                stretches,
                problem.laws.limits(s, state.integrity[s]),
                state.load.factor,
            )
        };
        // Maxima and minima: the same in any order.
        let all = intact(problem, state).map(of);
        all.reduce(|| Bounds::NONE, Bounds::and)
    }

    /// Intact bonds that are over their limit under a load.
    pub fn bonds_over_limit(&mut self, problem: &Problem, state: &State, load: Load) -> Vec<usize> {
        if self.carries.is_some_and(|bounds| bounds.allow(load)) {
            return Vec::new();
        }
        let is_near = |&s: &usize| {
            let stretch = load.combine(self.solved.rough_stretches(problem, s));
            problem
                .laws
                .limits(s, state.integrity[s])
                .is_exceeded(stretch / NEAR)
        };
        let is_over = |&s: &usize| {
            let stretch = load.combine(self.solved.stretches(problem, s));
            problem
                .laws
                .limits(s, state.integrity[s])
                .is_exceeded(stretch)
        };
        self.near = intact(problem, state).filter(is_near).collect();
        let over: Vec<usize> = self.near.iter().copied().filter(is_over).collect();
        if over.is_empty() {
            self.carries = Some(self.bounds(problem, state));
        }
        over
    }

    /// Bonds at their limit, or within a small share of it and bound to reach it.
    pub fn bonds_at_limit(&self, problem: &Problem, state: &State, load: Load) -> Vec<usize> {
        if let Some((ahead, next)) = self.now() {
            return ahead.moment(next).bonds.clone();
        }
        let reaches = |&s: &usize| {
            let stretches = self.solved.stretches(problem, s);
            is_at_limit(
                stretches,
                problem.laws.limits(s, state.integrity[s]),
                load,
                TIE,
            )
        };
        intact(problem, state).filter(reaches).collect()
    }
}

fn intact<'a>(
    problem: &Problem,
    state: &'a State,
) -> impl ParallelIterator<Item = usize> + use<'a> {
    let springs = (0..problem.model.springs.len()).into_par_iter();
    springs
        .with_min_len(4096)
        .filter(|&s| state.integrity[s] > 0.0)
}

fn solve(
    solver: &Solver,
    problem: &Problem,
    state: &State,
    factorised: &Factorised,
    phases: &mut Phases,
) -> Result<Solutions, StaticsError> {
    let programme = problem.programme;
    let mut solve = |case: &Boundary, guess: Option<&[[f64; 2]]>| {
        solver.solve_with(factorised, case, guess, &state.mechanisms, phases)
    };
    let held = match programme.held(state.phase) {
        Some(held) => Some(solve(&held, None)?),
        None => None,
    };
    let guess = unit_guess(state, held.as_ref());
    let unit = solve(&programme.phases[state.phase].boundary, guess.as_deref())?;
    Ok(Solutions { held, unit })
}

/// What u_unit was when the state was last settled, as far as the state tells: a run that goes on from a
/// checkpoint knows no more.
fn unit_guess(state: &State, held: Option<&Solution>) -> Option<Vec<[f64; 2]>> {
    let Load { share, factor } = state.load;
    let scale = 1.0 / (share * factor);
    let of = |(node, u): (usize, &[f64; 2])| {
        [0, 1].map(|axis| {
            let held = held.map_or(0.0, |held| held.displacement[node][axis]);
            scale * (u[axis] - share * held)
        })
    };
    let nodes = state.displacement.iter().enumerate();
    scale.is_finite().then(|| nodes.map(of).collect())
}
