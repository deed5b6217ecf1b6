//! The response after bonds have gone, from the factorisation before them.
//!
//! Where bonds will break next is known: around the tips, and ahead of them. These nodes are eliminated
//! last (theirs is the root of the elimination tree), so that a pass changes the last front alone. It is
//! assembled from what the rest passes up, which is kept, and factorised anew; one solution then finds u
//! everywhere. Nothing is approximated and nothing adds up: the factor has the bits of a whole
//! factorisation of what is left.
//!
//! Where a bond breaks elsewhere, K is factorised as a whole, with new nodes last. Which ones follows from the
//! state alone, so that a run that is taken up there goes on with the same bits.

use super::control::{Control, Problem, Resolution};
use super::corridor;
use super::response::Solutions;
use super::state::State;
use crate::boundary::Boundary;
use crate::phases::Phases;
use crate::statics::{Factorised, Solver};

/// The largest relative residual that is not worth a refinement.
const DRIFT: f64 = 1e-11;

/// The nodes between which bonds will break next: to be eliminated last.
pub fn zone(problem: &Problem, solver: &Solver, state: &State) -> Vec<u32> {
    let foresees = problem.control == Control::EventDriven && solver.is_symmetric();
    let follows = problem.resolution != Resolution::Reference && solver.is_direct();
    if state.broken.is_empty() || foresees || !follows {
        return Vec::new();
    }
    let utilisation = |spring: usize| {
        let limit = problem.limits.of(spring);
        limit.utilisation(state.stretch(problem.model, spring))
    };
    let nodes = corridor::nodes(problem, &state.intact, utilisation, solver.zone());
    nodes.into_iter().map(|node| node as u32).collect()
}

/// A factorisation that follows the bonds that break.
pub struct Update {
    factorised: Factorised,
    phase: usize,
    /// Bonds that had broken when K was last factorised.
    known: usize,
}

impl Update {
    pub fn new(factorised: Factorised, state: &State) -> Update {
        Update {
            factorised,
            phase: state.phase,
            known: state.broken.len(),
        }
    }

    /// Whether a run that starts from `state` with a whole factorisation goes on with the same bits: the next
    /// response is from one, or nothing has broken yet.
    pub fn is_reproducible(&self, problem: &Problem, state: &State) -> bool {
        let lost = &state.broken[self.known..];
        match lost.is_empty() {
            true => state.broken.is_empty(),
            false => !(self.factorised).reaches(problem.model, lost, &state.fragments),
        }
    }

    /// u_held and u_unit with the bonds that are gone; `None` where K is to be factorised as a whole.
    pub fn renew(
        &mut self,
        solver: &Solver,
        problem: &Problem,
        state: &State,
        phases: &mut Phases,
    ) -> Option<Solutions> {
        if state.phase != self.phase {
            return None;
        }
        let lost = &state.broken[self.known..];
        let (factorised, fragments) = (&mut self.factorised, &state.fragments);
        if !solver.refactorise(factorised, lost, &state.intact, fragments, phases) {
            return None;
        }
        self.known = state.broken.len();
        let mut solve = |case: &Boundary| solver.solve_once(&self.factorised, case, DRIFT, phases);
        let programme = problem.programme;
        let held = match programme.held(state.phase) {
            Some(held) => Some(solve(&held)?),
            None => None,
        };
        let unit = solve(&programme.phases[state.phase].boundary)?;
        Some(Solutions { held, unit })
    }
}
