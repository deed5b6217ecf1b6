//! The response after bonds have gone, from the factorisation before them.
//!
//! A bond is two rows and two columns of K. What it changes of L is above its nodes in the elimination
//! tree: their supernodes' fronts are assembled and factorised anew, up to the root, from what all others pass up,
//! which is kept (`linear_solver/multifrontal.rs`). K itself is assembled anew at these nodes alone. Nothing is
//! approximated and nothing adds up: K and L have the bits that they would have from the beginning, and a
//! hinge shows at the same pivot.

use super::control::{Control, Problem, Resolution};
use super::state::State;
use crate::phases::Phases;
use crate::statics::{Factorised, Solver, StaticsError};

/// The largest relative residual that is not worth a refinement.
const DRIFT: f64 = 1e-11;

/// The residual at which a solution is good enough; `None`: as good as it gets.
pub fn goal(problem: &Problem, factorised: &Factorised) -> Option<f64> {
    let foresees = problem.control == Control::EventDriven && factorised.is_symmetric();
    let follows = problem.resolution != Resolution::Reference && factorised.is_direct();
    (follows && !foresees).then_some(DRIFT)
}

/// A factorisation that follows the bonds that break.
pub struct Update {
    pub factorised: Factorised,
    /// Bonds that had broken when it was brought up to them.
    known: usize,
}

impl Update {
    pub fn new(factorised: Factorised, state: &State) -> Update {
        Update {
            factorised,
            known: state.broken.len(),
        }
    }

    /// Brings it up to the bonds that are gone; false where K is to be factorised as a whole.
    ///
    /// # Errors
    /// What the solver reports.
    pub fn renew(
        &mut self,
        solver: &Solver,
        state: &mut State,
        phases: &mut Phases,
    ) -> Result<bool, StaticsError> {
        let lost = &state.broken[self.known..];
        self.known = state.broken.len();
        solver.refactorise(
            &mut self.factorised,
            lost,
            &state.intact,
            &state.fragments,
            &mut state.mechanisms,
            phases,
        )
    }
}
