//! The response of the body with the integrity of now, linear in the load: it serves until the next bond
//! changes.
//!
//! ```text
//! u(μ, λ) = μ (u_held + λ u_unit)
//! ```
//!
//! λ is the load factor of the current phase, u_held the response to what the phases before it have
//! left in place. μ = 1, but for the moments in which the body cannot carry what is held.
//!
//! Under the event-driven control the response looks ahead (`predictor.rs`): it knows a number of events that
//! follow from one factorisation, and goes from one to the next without solving again. Elsewhere it is updated
//! from the last factorisation (`update.rs`), one solution for each pass in which bonds changed. Without
//! factors, on a large lattice, conjugate gradients start from the displacements to which the state was last
//! settled.

use super::event::{Bounds, Event, Load, is_at_limit};
use super::functional::Values;
use super::look_ahead::LookAhead;
use super::policy::{FEWEST_EVENTS, NEAR, TIE};
use super::predictor::look_ahead;
use super::problem::{Control, Problem, Resolution};
use super::solutions::{Solutions, nan_max};
use super::state::State;
use super::update::Update;
use crate::boundary::Boundary;
use crate::phases::measure;
use crate::statics::{Factorised, Solution, Solver, StaticsError};
use rayon::prelude::*;

/// The response, and how the next one is found.
pub struct Response {
    solved: Solutions,
    values: Values,
    next: NextResponse,
    /// Bounds of the load that all bonds allow, where none was over its limit when they were last asked for.
    carries: Option<Bounds>,
}

/// How the next response is found.
enum NextResponse {
    /// It is predicted; and which of the predicted events is next.
    LookAhead(Box<LookAhead>, usize),
    /// By an update of the factorisation; and the bonds that were near their limit when they were last asked
    /// for.
    Update(Box<Update>, Vec<usize>),
    /// By a new factorisation, or by conjugate gradients.
    Anew,
}

impl NextResponse {
    /// By updates of a factorisation, after which the state had `first` changes and the response `solved`.
    fn update(
        problem: &Problem,
        factorised: Factorised,
        solved: &Solutions,
        first: usize,
        state: &State,
    ) -> NextResponse {
        let update = Update::new(problem, factorised, solved.clone(), first, state);
        NextResponse::Update(Box::new(update), Vec::new())
    }
}

impl Response {
    /// # Errors
    /// Errors of the solver.
    pub fn new(
        solver: &Solver,
        problem: &Problem,
        state: &mut State,
    ) -> Result<Response, StaticsError> {
        let factorised =
            solver.factorise_broken(&state.integrity, &state.fragments, &mut state.mechanisms)?;
        Response::of(factorised, solver, problem, state)
    }

    fn of(
        factorised: Factorised,
        solver: &Solver,
        problem: &Problem,
        state: &State,
    ) -> Result<Response, StaticsError> {
        let solved = solve(solver, problem, state, &factorised)?;
        let mut response = Response {
            values: solved.values(problem),
            solved,
            next: NextResponse::Anew,
            carries: None,
        };
        if problem.resolution == Resolution::Reference || !factorised.has_compliances() {
            return Ok(response);
        }
        if problem.control == Control::EventDriven
            && let Event::Break(load) = response.next_event(problem, state)
        {
            let (solved, values) = (&response.solved, &response.values);
            response.next = measure("active zone", || {
                match look_ahead(problem, state, factorised, solved, values, load) {
                    Ok(ahead) => NextResponse::LookAhead(ahead, 0),
                    Err(factorised) => {
                        let first = state.changes.len();
                        NextResponse::update(problem, *factorised, solved, first, state)
                    }
                }
            });
        } else {
            let (first, solved) = (state.changes.len(), &response.solved);
            response.next = NextResponse::update(problem, factorised, solved, first, state);
        }
        Ok(response)
    }

    /// The response after the bonds of an event have broken, or a new phase has begun.
    ///
    /// # Errors
    /// Errors of the solver.
    pub fn renew(
        &mut self,
        solver: &Solver,
        problem: &Problem,
        state: &mut State,
    ) -> Result<(), StaticsError> {
        self.next = match std::mem::replace(&mut self.next, NextResponse::Anew) {
            NextResponse::LookAhead(ahead, next) if next + 1 < ahead.count() => {
                self.next = NextResponse::LookAhead(ahead, next + 1);
                return Ok(());
            }
            NextResponse::LookAhead(ahead, _) if ahead.count() < FEWEST_EVENTS => {
                let (factorised, first) = (ahead.factorised, ahead.first);
                NextResponse::update(problem, factorised, &self.solved, first, state)
            }
            next => next,
        };
        if let NextResponse::Update(update, near) = &mut self.next
            && let Some(solved) = update.renew(problem, state, near)
        {
            self.carries = None;
            self.values = solved.values(problem);
            self.solved = solved;
            return Ok(());
        }
        // Two factors at a time are more than may fit: the old one goes before the new one comes.
        let factorised = match std::mem::replace(&mut self.next, NextResponse::Anew) {
            NextResponse::Update(update, _) => update.refactorise(solver, state)?,
            _ => None,
        };
        *self = match factorised {
            Some(factorised) => Response::of(factorised, solver, problem, state)?,
            None => Response::new(solver, problem, state)?,
        };
        Ok(())
    }

    /// Whether the response after the next event is known already.
    pub(super) fn foresees_next(&self) -> bool {
        matches!(&self.next, NextResponse::LookAhead(ahead, next) if next + 1 < ahead.count())
    }

    /// Whether a run that begins with `state`, and so with a factorisation, goes on with the same bits.
    pub fn is_reproducible(&self, state: &State) -> bool {
        match &self.next {
            NextResponse::LookAhead(ahead, _) => {
                !self.foresees_next() && ahead.count() >= FEWEST_EVENTS
            }
            NextResponse::Update(update, _) => update.is_reproducible(state),
            NextResponse::Anew => true,
        }
    }

    /// The predicted events, and which of them is next.
    fn predicted(&self) -> Option<(&LookAhead, usize)> {
        match &self.next {
            NextResponse::LookAhead(ahead, next) => Some((ahead, *next)),
            _ => None,
        }
    }

    /// u_held and u_unit everywhere.
    pub fn solutions(&self, problem: &Problem, phase: usize) -> Solutions {
        match self.predicted() {
            Some((ahead, next)) if next > 0 => ahead.solutions(problem, phase, &self.solved, next),
            _ => self.solved.clone(),
        }
    }

    /// Largest backward error since the last factorisation [-].
    pub fn residual(&self) -> f64 {
        let ahead = self.predicted().map_or(0.0, |(ahead, _)| ahead.residual);
        nan_max(ahead, self.solved.residual())
    }

    /// Resultants and works.
    pub fn values(&self) -> &Values {
        match self.predicted() {
            Some((ahead, next)) => &ahead.event(next).values,
            None => &self.values,
        }
    }

    /// Stretch of an interaction, broken in this event or the last one [-].
    pub fn stretch(&self, problem: &Problem, interaction: usize, load: Load) -> f64 {
        let ahead = self.predicted().filter(|&(_, next)| next > 0);
        let foreseen = ahead.and_then(|(ahead, next)| ahead.stretches(next, interaction));
        load.combine(foreseen.unwrap_or_else(|| self.solved.stretches(problem, interaction)))
    }

    /// The load at which the next bond breaks.
    pub fn next_event(&self, problem: &Problem, state: &State) -> Event {
        if let Some((ahead, next)) = self.predicted() {
            return Event::Break(ahead.event(next).load);
        }
        let end = problem.programme.phases[state.phase].end;
        let bounds = self.bounds(problem, state);
        bounds.event(state.load.factor, end)
    }

    /// Bounds of the load factor that all bonds allow.
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

    /// Bonds that are over a limit of their branch under a load.
    pub fn bonds_over_limit(&mut self, problem: &Problem, state: &State, load: Load) -> Vec<usize> {
        if self.carries.is_some_and(|bounds| bounds.allow(load)) {
            return Vec::new();
        }
        let is_over = |&s: &usize| {
            let stretch = load.combine(self.solved.stretches(problem, s));
            problem
                .laws
                .limits(s, state.integrity[s])
                .is_exceeded(stretch)
        };
        let close = self.bonds_near_limit(problem, state, load);
        let over: Vec<usize> = close.iter().copied().filter(is_over).collect();
        if let NextResponse::Update(_, near) = &mut self.next {
            *near = close;
        }
        if over.is_empty() {
            self.carries = Some(self.bounds(problem, state));
        }
        over
    }

    /// Whether no larger load breaks a bond, as far as it is known.
    pub(super) fn carries_any_load(&self) -> bool {
        self.carries
            .is_some_and(|bounds| bounds.upper == f64::INFINITY)
    }

    /// Bonds near a limit of their branch under a load.
    fn bonds_near_limit(&self, problem: &Problem, state: &State, load: Load) -> Vec<usize> {
        let is_near = |&s: &usize| {
            let stretch = load.combine(self.solved.rough_stretches(problem, s));
            let limits = problem.laws.limits(s, state.integrity[s]);
            limits.is_exceeded(stretch / NEAR)
        };
        intact(problem, state).filter(is_near).collect()
    }

    /// Bonds at a limit of their branch, or within a small share of it and bound to reach it.
    pub fn bonds_at_limit(&mut self, problem: &Problem, state: &State, load: Load) -> Vec<usize> {
        if let Some((ahead, next)) = self.predicted() {
            let bonds = problem.model.interactions.axial();
            let changed = ahead.event(next).interactions.iter();
            return changed.copied().filter(|s| bonds.contains(s)).collect();
        }
        let close = self.bonds_near_limit(problem, state, load);
        if let NextResponse::Update(_, near) = &mut self.next {
            *near = close;
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
    let interactions = problem.model.interactions.axial().into_par_iter();
    interactions
        .with_min_len(4096)
        .filter(|&s| state.integrity[s] > 0.0)
}

fn solve(
    solver: &Solver,
    problem: &Problem,
    state: &State,
    factorised: &Factorised,
) -> Result<Solutions, StaticsError> {
    let programme = problem.programme;
    let solve = |case: &Boundary, guess: Option<&[[f64; 2]]>| {
        solver.solve_with(factorised, case, guess, &state.mechanisms)
    };
    let held = match programme.held(state.phase) {
        Some(held) => Some(solve(&held, None)?),
        None => None,
    };
    let guess = unit_guess(state, held.as_ref());
    let unit = solve(&programme.phases[state.phase].boundary, guess.as_deref())?;
    Ok(Solutions { held, unit })
}

/// u_unit when the state was last settled, as far as the state determines it: a run that goes on from a
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
