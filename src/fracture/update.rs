//! The response after bonds have changed, from the factorisation before them (`low_rank.rs`): one solution finds
//! u' everywhere, and its backward error is checked.
//!
//! If the next update would cost more than that, the factorisation itself follows the changes
//! (`linear_solver/refactorisation.rs`): the supernodes above them are factorised anew, with the bits of a whole
//! factorisation.
//!
//! A fragment that has come off does not move, and a hinge that is left is held: their dofs are pinned.

use super::costs::UpdateCosts;
use super::low_rank::{Loss, LowRankChange, ReducedSystem};
use super::policy::{DRIFT, MOST_HINGES, STILL};
use super::problem::Problem;
use super::rates::DOFS_AT_A_TIME;
use super::solutions::Solutions;
use super::state::{Change, State};
use crate::boundary::Boundary;
use crate::phases::measure;
use crate::statics::{Factorised, Solution, Solver, StaticsError};

/// A factorisation, the response then, and the changes since.
pub struct Update {
    factorised: Factorised,
    /// u_held and u_unit then, with ‖f‖ of both cases [N].
    base: Solutions,
    load_norms: [f64; 2],
    phase: usize,
    /// Number of the state's changes when K was factorised.
    first: usize,
    /// Number of its changes when the response was last updated.
    known: usize,
    change: LowRankChange,
    costs: UpdateCosts,
}

impl Update {
    /// `base`: the response when K was factorised, and `first`: the number of the state's changes then.
    pub fn new(
        problem: &Problem,
        factorised: Factorised,
        base: Solutions,
        first: usize,
        state: &State,
    ) -> Update {
        let held = problem.programme.held(state.phase);
        let unit = &problem.programme.phases[state.phase].boundary;
        Update {
            load_norms: [
                held.map_or(0.0, |case| factorised.load_norm(&case)),
                factorised.load_norm(unit),
            ],
            costs: UpdateCosts::new(problem, &factorised, state),
            factorised,
            base,
            phase: state.phase,
            first,
            known: first,
            change: LowRankChange::default(),
        }
    }

    /// Whether a run that starts from `state` with a factorisation goes on with the same bits: either the
    /// next response is from a factorisation, or this one is.
    pub fn is_reproducible(&self, state: &State) -> bool {
        if state.changes.len() > self.known {
            self.costs.is_due()
        } else {
            self.known == self.first
        }
    }

    /// u_held and u_unit after the changes; `None` where a factorisation is due. `near`: interactions that
    /// may change soon.
    pub fn renew(
        &mut self,
        problem: &Problem,
        state: &mut State,
        near: &[usize],
    ) -> Option<Solutions> {
        if self.costs.is_due() || state.phase != self.phase {
            return None;
        }
        let mut pins = self.pins(state);
        let model = problem.model;
        let changes = &state.changes[self.known..];
        let of_change = |change: &Change| model.interactions.nodes(change.interaction as usize);
        let dofs = changes.iter().flat_map(of_change).flat_map(dofs_of);
        let new = self.change.activate(dofs.chain(pins.iter().copied()));
        if !self.costs.add(self.change.active(), new) {
            return None;
        }
        self.expect(problem, near);
        measure("compliance", || self.change.extend(&self.factorised))?;
        let losses: Vec<Loss> = changes.iter().map(|c| Loss::of(problem, c)).collect();
        measure("update", || self.change.lose(model, &losses));
        self.known = state.changes.len();
        let mut mechanisms = Vec::new();
        let system = loop {
            match measure("update", || self.change.factorise(&pins)) {
                Ok(system) => break system,
                Err(_) if mechanisms.len() == MOST_HINGES => return None,
                Err(motion) => {
                    let dof = self.last_to_move(&pins, motion)?;
                    mechanisms.push(dof);
                    pins.push(dof);
                    self.change.activate([dof].into_iter());
                    self.change.extend(&self.factorised)?;
                }
            }
        };
        let solutions = measure("solution", || self.solve(problem, state, &system, &pins))?;
        state.mechanisms.extend(mechanisms);
        Some(solutions)
    }

    /// Adds dofs of interactions that may change soon, where others come in anyway.
    fn expect(&mut self, problem: &Problem, near: &[usize]) {
        if self.change.new_dofs().is_empty() {
            return;
        }
        let nodes = near
            .iter()
            .flat_map(|&s| problem.model.interactions.nodes(s));
        for node in nodes {
            if self.change.new_dofs().len() >= DOFS_AT_A_TIME {
                return;
            }
            dofs_of(node).for_each(|dof| {
                self.change.add(dof);
            });
        }
    }

    /// The last dof to be eliminated among those that a motion without force moves: its pivot would vanish.
    fn last_to_move(&self, pins: &[usize], motion: Vec<f64>) -> Option<usize> {
        let forces = self.change.forces_of_motion(pins, motion);
        let moved = self.change.respond(&self.factorised, &forces);
        let largest = moved.iter().fold(0.0, |a, b| f64::max(a, b.abs()));
        let moves = (0..moved.len()).filter(|&dof| moved[dof].abs() > STILL * largest);
        let moves = moves.filter(|dof| !pins.contains(dof));
        let places = moves.map(|dof| {
            let place = self.factorised.elimination(dof);
            place.map(|place| (place, dof))
        });
        places.max().flatten().map(|(_, dof)| dof)
    }

    /// The factorisation brought up to the changes: the supernodes above them are factorised anew.
    /// `None` where K is to be factorised as a whole.
    ///
    /// # Errors
    /// Errors of the solver.
    pub fn refactorise(
        self,
        solver: &Solver,
        state: &mut State,
    ) -> Result<Option<Factorised>, StaticsError> {
        let Update {
            mut factorised,
            first,
            change,
            ..
        } = self;
        let changes = state.changes[first..].iter();
        let changed: Vec<u32> = changes.map(|change| change.interaction).collect();
        // The memory is needed for what supernodes pass up.
        drop(change);
        let done = solver.refactorise(
            &mut factorised,
            &changed,
            &state.integrity,
            &state.fragments,
            &mut state.mechanisms,
        )?;
        Ok(done.then_some(factorised))
    }

    fn solve(
        &self,
        problem: &Problem,
        state: &State,
        system: &ReducedSystem,
        pins: &[usize],
    ) -> Option<Solutions> {
        let (model, programme) = (problem.model, problem.programme);
        let changes = state.changes[self.first..].iter();
        let losses: Vec<Loss> = changes.map(|change| Loss::of(problem, change)).collect();
        let after = |before: &Solution, case: (&Boundary, f64)| {
            let forces = self.change.forces(system, before);
            let mut change = self.change.respond(&self.factorised, &forces);
            for &dof in pins {
                change[dof] = -before.displacement[dof / 2][dof % 2];
            }
            let solution = self.factorised.changed(
                model,
                case,
                before,
                &change,
                losses.iter().map(Loss::parts),
            );
            // False for what is not a number.
            (solution.residual <= DRIFT).then_some(solution)
        };
        let [of_held, of_unit] = self.load_norms;
        let unit = (&programme.phases[self.phase].boundary, of_unit);
        let unit = after(&self.base.unit, unit)?;
        let held = match (&self.base.held, programme.held(self.phase)) {
            (Some(before), Some(case)) => Some(after(before, (&case, of_held))?),
            _ => None,
        };
        Some(Solutions { held, unit })
    }

    /// Dofs that are held since the factorisation: fragments that have come off, and hinges.
    fn pins(&self, state: &State) -> Vec<usize> {
        let nodes = state.fragments.iter().flatten();
        let dofs = nodes.flat_map(|&node| [2 * node, 2 * node + 1]);
        let all = dofs.chain(state.mechanisms.iter().copied());
        all.filter(|&dof| !self.factorised.is_held(dof)).collect()
    }
}

/// Dofs of a node.
fn dofs_of(node: &u32) -> impl Iterator<Item = usize> + use<> {
    let first = 2 * *node as usize;
    [first, first + 1].into_iter()
}
