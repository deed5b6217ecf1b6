//! When a factorisation is due: as soon as the next update, or the next bond in a zone, costs more than all since
//! the last factorisation have cost on average, that one included. From counts of operations and the rates of
//! `rates.rs` alone.

use super::problem::Problem;
use super::rates::{
    FEWEST_ZONE_DOFS, UPDATE_DOF, UPDATE_FACTORISATION, UPDATE_REFINEMENT, UPDATE_SOLUTION,
    UPDATE_SYSTEM, ZONE_ASSEMBLY, ZONE_BOND, ZONE_DOFS, ZONE_END, ZONE_FACTORISATION,
};
use super::state::{Change, State};
use crate::statics::Factorised;

/// Costs since a factorisation, and the updates or bonds that they were for.
struct Account {
    spent: f64,
    gained: f64,
}

impl Account {
    /// Begins with what the factorisation costs.
    fn new(factorisation: f64) -> Account {
        Account {
            spent: factorisation,
            gained: 0.0,
        }
    }

    /// Spends `cost` on updates, or bonds.
    fn spend(&mut self, cost: f64, gain: f64) {
        self.spent += cost;
        self.gained += gain;
    }

    /// Whether a factorisation is due: `cost` for a `gain` is more per gain than all since the last one has
    /// cost on average, that one included.
    fn is_due(&self, cost: f64, gain: f64) -> bool {
        cost * self.gained > self.spent * gain
    }
}

/// Costs of updates after a pass.
pub struct UpdateCosts {
    factorisation: f64,
    /// Cost of a dof that comes in, and of a solution.
    per_dof: f64,
    solution: f64,
    /// More dofs than these would take as much memory as the factor.
    most_dofs: usize,
    account: Account,
    updates: usize,
    /// Dofs of the last update, and how many of them were new.
    last: [usize; 2],
}

impl UpdateCosts {
    pub fn new(problem: &Problem, factorised: &Factorised, state: &State) -> UpdateCosts {
        let entries = factorised.entries as f64;
        // The next factorisation follows what will have changed until then: no less than what changed last.
        let of_change = |change: &Change| {
            problem
                .model
                .interactions
                .nodes(change.interaction as usize)
        };
        let nodes = state.fresh_changes().iter().flat_map(of_change);
        let nodes: Vec<u32> = nodes.copied().collect();
        let flops = match nodes.is_empty() {
            true => factorised.flops,
            false => factorised.flops_above(&nodes),
        };
        let factorisation = UPDATE_FACTORISATION * flops + UPDATE_REFINEMENT * entries;
        UpdateCosts {
            factorisation,
            per_dof: UPDATE_DOF * entries,
            solution: UPDATE_SOLUTION * entries,
            // A, I − A S and its factors, and X with some more rows than these.
            most_dofs: (entries / 9.0).sqrt() as usize,
            account: Account::new(factorisation),
            updates: 0,
            last: [0, 0],
        }
    }

    fn of(&self, size: usize, new: usize) -> f64 {
        let size = size as f64;
        UPDATE_SYSTEM * size * size * size + self.per_dof * new as f64 + self.solution
    }

    /// One more update; returns whether it is worth it.
    pub fn add(&mut self, size: usize, new: usize) -> bool {
        let cost = self.of(size, new);
        self.account.spend(cost, 1.0);
        self.updates += 1;
        self.last = [size, new];
        size <= self.most_dofs && cost < self.factorisation
    }

    pub fn is_due(&self) -> bool {
        let [size, new] = self.last;
        let next = self.of(size + new, new);
        self.updates > 0 && (self.account.is_due(next, 1.0) || size + new > self.most_dofs)
    }
}

/// Costs of zones, per bond.
pub struct ZoneCosts {
    /// Dofs of a zone.
    pub dofs: usize,
    /// More touched dofs than these would take more memory than the factor.
    most_touched: f64,
    /// Entries of L.
    entries: f64,
    account: Account,
    bonds: usize,
    /// Cost of the last zone apart from the losses before it, and its bonds.
    last: [f64; 2],
}

impl ZoneCosts {
    pub fn new(factorised: &Factorised) -> ZoneCosts {
        let (entries, flops) = (factorised.entries as f64, factorised.flops);
        ZoneCosts {
            dofs: (ZONE_DOFS * entries).cbrt().max(FEWEST_ZONE_DOFS) as usize,
            most_touched: entries.sqrt(),
            entries,
            account: Account::new(ZONE_FACTORISATION * flops + ZONE_ASSEMBLY * entries),
            bonds: 0,
            last: [0.0; 2],
        }
    }

    /// Cost of what comes after the compliance of a zone of `n` dofs.
    pub fn end(&self, n: usize, bonds: usize) -> f64 {
        ZONE_END * self.entries + ZONE_BOND * (bonds * n * n) as f64
    }

    pub fn add(&mut self, cost: f64, bonds: usize) {
        self.last = [cost, (bonds - self.bonds) as f64];
        self.account.spend(cost, self.last[1]);
        self.bonds = bonds;
    }

    pub fn is_due(&self, touched: usize) -> bool {
        let touched = touched as f64;
        let [cost, bonds] = self.last;
        let next = cost + touched * touched * touched;
        self.account.is_due(next, bonds) || touched > self.most_touched
    }
}
