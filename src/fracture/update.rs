//! The response after bonds have gone, from the factorisation before them (Woodbury).
//!
//! The springs gone since K was factorised took S = Σ k w wᵀ. With E the dofs that they touch,
//!
//! ```text
//! K' = K − E S Eᵀ,   G = Eᵀ K⁻¹ E,   z = Eᵀ u'
//! (I − G S) z = Eᵀ u,   u' = u + K⁻¹ E S z
//! ```
//!
//! holds for an S of any rank, singular or not. G = Xᵀ X with X = L⁻¹ E grows by the dofs that a pass adds, and
//! costs what lies on their way through the elimination tree (`linear_solver/compliance.rs`); the dense system is
//! small; then one solution finds u' everywhere, and its true residual is checked.
//!
//! Where the next update would cost more than that, the factorisation itself follows the bonds that are
//! gone (`linear_solver/refactorisation.rs`): the supernodes above them are factorised anew, with the bits of
//! a whole factorisation.
//!
//! A fragment that has come off does not move, z_F = 0: the unknowns there are the forces r that hold it,
//! with columns −G_F in place of those of z_F.

use super::dense::Lu;
use super::lost::pairs;
use super::problem::Problem;
use super::solutions::Solutions;
use super::state::{Change, State};
use super::touched::{Touched, losses};
use crate::boundary::Boundary;
use crate::phases::Phases;
use crate::statics::{Factorised, Solution, Solver, StaticsError};

/// The largest backward error that is not worth a factorisation: one leaves some 1e-17.
const DRIFT: f64 = 1e-14;

/// More hinges than these at once are for a factorisation to find.
const MOST_HINGES: usize = 16;

/// Weights of [`Costs`], measured (docs/performance.md): a sparse factorisation runs at some fifth of the
/// rate of a dense product, a solution at a hundredth.
const FACTORISATION: f64 = 4.0;
const REFINEMENT: f64 = 200.0;
const SOLUTION: f64 = 100.0;
const PER_DOF: f64 = 0.6;
const DENSE: f64 = 2.0;

/// What happened since a factorisation, and the response then.
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
    touched: Touched,
    costs: Costs,
}

impl Update {
    pub fn new(
        problem: &Problem,
        factorised: Factorised,
        base: Solutions,
        state: &State,
    ) -> Update {
        let held = problem.programme.held(state.phase);
        let unit = &problem.programme.phases[state.phase].boundary;
        Update {
            load_norms: [
                held.map_or(0.0, |case| factorised.load_norm(&case)),
                factorised.load_norm(unit),
            ],
            costs: Costs::new(problem, &factorised, state),
            factorised,
            base,
            phase: state.phase,
            first: state.changes.len(),
            known: state.changes.len(),
            touched: Touched::new(),
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

    /// u_held and u_unit with the bonds that are gone; `None` where a factorisation is due. `near`: springs
    /// that may go soon.
    pub fn renew(
        &mut self,
        problem: &Problem,
        state: &mut State,
        near: &[usize],
        phases: &mut Phases,
    ) -> Option<Solutions> {
        if self.costs.is_due() || state.phase != self.phase {
            return None;
        }
        let mut pins = self.pins(state);
        let changes = &state.changes[self.known..];
        let new = self.touched.enter(problem, changes, &pins);
        if !self.costs.add(self.touched.active(), new) {
            return None;
        }
        self.touched.expect(problem, near);
        phases.measure("compliance", || self.touched.extend(&self.factorised));
        phases.measure("update", || self.touched.lose(problem, changes));
        self.known = state.changes.len();
        let mut mechanisms = Vec::new();
        let system = loop {
            match phases.measure("update", || self.touched.factorise(&pins)) {
                Ok(system) => break system,
                Err(_) if mechanisms.len() == MOST_HINGES => return None,
                Err(motion) => {
                    let dof = self.touched.last_to_move(&self.factorised, &pins, motion)?;
                    mechanisms.push(dof);
                    pins.push(dof);
                    self.touched.enter(problem, &[], &[dof]);
                    self.touched.extend(&self.factorised);
                }
            }
        };
        let solutions =
            phases.measure("solution", || self.solve(problem, state, &system, &pins))?;
        state.mechanisms.extend(mechanisms);
        Some(solutions)
    }

    /// The factorisation brought up to the bonds that are gone: the supernodes above them factorised anew.
    /// `None` where K is to be factorised as a whole.
    ///
    /// # Errors
    /// What the solver reports.
    pub fn refactorise(
        self,
        solver: &Solver,
        state: &mut State,
        phases: &mut Phases,
    ) -> Result<Option<Factorised>, StaticsError> {
        let Update {
            mut factorised,
            first,
            touched,
            ..
        } = self;
        let changes = state.changes[first..].iter();
        let changed: Vec<u32> = changes.map(|change| change.interaction).collect();
        // The memory is needed for what supernodes pass up.
        drop(touched);
        let done = solver.refactorise(
            &mut factorised,
            &changed,
            &state.integrity,
            &state.fragments,
            &mut state.mechanisms,
            phases,
        )?;
        Ok(done.then_some(factorised))
    }

    fn solve(
        &self,
        problem: &Problem,
        state: &State,
        system: &Lu,
        pins: &[usize],
    ) -> Option<Solutions> {
        let (model, programme) = (problem.model, problem.programme);
        let losses = losses(problem, &state.changes[self.first..]);
        let after = |before: &Solution, case: (&Boundary, f64)| {
            let forces = self.touched.forces(system, pins, before);
            let mut change = self.touched.change(&self.factorised, &forces);
            for &dof in pins {
                change[dof] = -before.displacement[dof / 2][dof % 2];
            }
            let solution = self
                .factorised
                .without(model, case, before, &change, pairs(&losses));
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

/// When a factorisation is due: as soon as the next update would cost more than all since the last one
/// have on average, that one included. From counts alone, in units of a multiplication in a dense product.
struct Costs {
    factorisation: f64,
    /// Of one dof that comes in, and of a solution.
    per_dof: f64,
    solution: f64,
    /// More dofs than these would take as much memory as the factor.
    most_dofs: usize,
    spent: f64,
    updates: usize,
    /// Dofs of the last update, and how many of them were new.
    last: [usize; 2],
}

impl Costs {
    fn new(problem: &Problem, factorised: &Factorised, state: &State) -> Costs {
        let entries = factorised.entries as f64;
        // The next one follows what will have broken until then: no less than what broke last. From what a
        // checkpoint holds as well.
        let of_change = |change: &Change| problem.model.springs.nodes(change.interaction as usize);
        let nodes = state.fresh_changes().iter().flat_map(of_change);
        let nodes: Vec<u32> = nodes.copied().collect();
        let flops = match nodes.is_empty() {
            true => factorised.flops,
            false => factorised.flops_above(&nodes),
        };
        // G, I − G S and its factors, and X with some more rows than these.
        let most_dofs = (entries / 9.0).sqrt();
        Costs {
            factorisation: FACTORISATION * flops + REFINEMENT * entries,
            per_dof: PER_DOF * entries,
            solution: SOLUTION * entries,
            most_dofs: most_dofs as usize,
            spent: 0.0,
            updates: 0,
            last: [0, 0],
        }
    }

    fn of(&self, size: usize, new: usize) -> f64 {
        let size = size as f64;
        DENSE * size * size * size + self.per_dof * new as f64 + self.solution
    }

    /// One more update; whether it is worth it.
    fn add(&mut self, size: usize, new: usize) -> bool {
        let cost = self.of(size, new);
        self.spent += cost;
        self.updates += 1;
        self.last = [size, new];
        size <= self.most_dofs && cost < self.factorisation
    }

    fn is_due(&self) -> bool {
        let [size, new] = self.last;
        let next = self.of(size + new, new);
        let average = (self.factorisation + self.spent) / self.updates as f64;
        self.updates > 0 && (next > average || size + new > self.most_dofs)
    }
}
