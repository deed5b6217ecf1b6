//! The dofs that springs which are gone acted on, and their system: I − G S of `update.rs`.

use super::dense::Lu;
use super::lost::{self, Loss, Spring};
use super::problem::Problem;
use super::state::Change;
use crate::linear_solver::columns::{slice, slice_mut};
use crate::linear_solver::compliance::UnitLoads;
use crate::statics::{Factorised, Solution};
use faer::Mat;
use std::collections::{BTreeMap, BTreeSet};

/// A pivot of I − G S below this share of the largest: what is left is a mechanism, or too close to one.
/// The factorisation that follows finds out.
const LEAST_PIVOT: f64 = 1e-7;

/// A motion moves a dof that goes farther than this share of the largest.
const STILL: f64 = 1e-6;

/// So many dofs come in at a time if there are springs to expect them from.
const FILL: usize = 64;

/// Dofs in the order in which they came in: those that springs which are gone acted on are *active*, others
/// are expected to be.
pub struct Touched {
    dofs: Vec<usize>,
    place: BTreeMap<usize, usize>,
    active: Vec<usize>,
    is_active: Vec<bool>,
    /// G [m/N].
    compliance: Mat<f64>,
    /// L⁻¹ E of Cholesky's factor, or K⁻¹ E, column by column, where K is not symmetric [m/N].
    loads: UnitLoads,
    columns: Vec<f64>,
    /// What is gone, and I − G S; columns that are not active are those of I.
    springs: Vec<Spring>,
    system: Mat<f64>,
}

impl Touched {
    pub fn new() -> Touched {
        Touched {
            dofs: Vec::new(),
            place: BTreeMap::new(),
            active: Vec::new(),
            is_active: Vec::new(),
            compliance: Mat::new(),
            loads: UnitLoads::default(),
            columns: Vec::new(),
            springs: Vec::new(),
            system: Mat::new(),
        }
    }

    /// How many of the dofs are active.
    pub fn active(&self) -> usize {
        self.active.len()
    }

    /// Makes the dofs of changed interactions, and pins, active; how many are new.
    pub fn enter(&mut self, problem: &Problem, changes: &[Change], pins: &[usize]) -> usize {
        let before = self.dofs.len();
        let of_change = |change: &Change| problem.model.springs.nodes(change.interaction as usize);
        let nodes = changes.iter().flat_map(of_change);
        let dofs = nodes.flat_map(|&node| [2 * node as usize, 2 * node as usize + 1]);
        for dof in dofs.chain(pins.iter().copied()) {
            let place = self.add(dof);
            if !std::mem::replace(&mut self.is_active[place], true) {
                self.active.push(place);
            }
        }
        self.dofs.len() - before
    }

    /// Where a dof stands, now if not before.
    fn add(&mut self, dof: usize) -> usize {
        let next = self.dofs.len();
        let place = *self.place.entry(dof).or_insert(next);
        if place == next {
            self.dofs.push(dof);
            self.is_active.push(false);
        }
        place
    }

    /// Adds dofs of springs that may go soon, where others come in anyway: up to [`FILL`] of them cost
    /// little more than one.
    pub fn expect(&mut self, problem: &Problem, near: &[usize]) {
        let known = self.compliance.nrows();
        if self.dofs.len() == known {
            return;
        }
        for &spring in near {
            for &node in problem.model.springs.nodes(spring) {
                if self.dofs.len() >= known + FILL {
                    return;
                }
                self.add(2 * node as usize);
                self.add(2 * node as usize + 1);
            }
        }
    }

    /// Brings G and the system up to the dofs.
    pub fn extend(&mut self, factorised: &Factorised) {
        let (size, known) = (self.dofs.len(), self.compliance.nrows());
        self.extend_compliance(factorised, size, known);
        let identity = |i: usize, j: usize| f64::from(u8::from(i == j));
        self.system.resize_with(size, size, identity);
        self.subtract(0, known);
    }

    fn extend_compliance(&mut self, factorised: &Factorised, size: usize, known: usize) {
        let new = &self.dofs[known..];
        self.compliance.resize_with(size, size, |_, _| 0.0);
        let mut compliance = self.compliance.as_mut();
        if let Some(loads) = factorised.unit_loads(new) {
            let (between, own) = (self.loads.product(&loads), loads.square());
            let (old, added) = compliance.split_at_row_mut(known);
            let (_, mut above) = old.split_at_col_mut(known);
            let (mut beside, mut corner) = added.split_at_col_mut(known);
            above.copy_from(&between);
            beside.copy_from(between.transpose());
            corner.copy_from(&own);
            self.loads.extend(loads);
            return;
        }
        let dofs = factorised.dofs();
        let mut columns = vec![0.0; dofs * new.len()];
        for (column, &dof) in columns.chunks_exact_mut(dofs).zip(new) {
            column[dof] = 1.0;
        }
        factorised.respond(&mut columns);
        self.columns.extend(columns);
        for (j, column) in self.columns.chunks_exact(dofs).enumerate() {
            for (i, &dof) in self.dofs.iter().enumerate() {
                compliance[(i, j)] = column[dof];
            }
        }
    }

    /// Adds changes to S.
    pub fn lose(&mut self, problem: &Problem, changes: &[Change]) {
        let known = self.springs.len();
        for loss in losses(problem, changes) {
            self.springs.push(self.spring(problem, loss));
        }
        self.subtract(known, 0);
    }

    /// Takes k G w wᵀ of the springs from one on off the rows of I − G S from one on.
    fn subtract(&mut self, first_spring: usize, first_row: usize) {
        let rows = self.dofs.len() - first_row;
        let system = self.system.subrows_mut(first_row, rows);
        let compliance = self.compliance.subrows(first_row, rows);
        lost::subtract(system, compliance, &self.springs[first_spring..]);
    }

    fn spring(&self, problem: &Problem, loss: Loss) -> Spring {
        let model = problem.model;
        let mut terms = Vec::new();
        model.for_each_term(loss.interaction, |node, w| {
            for (axis, w) in w.into_iter().enumerate() {
                let place = self.place[&(2 * node as usize + axis)];
                terms.push((place, w));
            }
        });
        Spring {
            stiffness: loss.stiffness,
            terms,
        }
    }

    /// I − G S of the active dofs, with −G in the columns of the pins.
    ///
    /// # Errors
    /// z, and r at the pins, of a motion without force.
    pub fn factorise(&self, pins: &[usize]) -> Result<Lu, Vec<f64>> {
        let size = self.active.len();
        let mut system = Mat::zeros(size, size);
        let mut gather = |j: usize, scale: f64, column: &[f64]| {
            let own = slice_mut(system.col_mut(j));
            let rows = own.iter_mut().zip(&self.active);
            rows.for_each(|(own, &place)| *own = scale * column[place]);
        };
        let pins: BTreeSet<usize> = pins.iter().map(|dof| self.place[dof]).collect();
        for (j, &place) in self.active.iter().enumerate() {
            match pins.contains(&place) {
                true => gather(
                    j,
                    -self.force_unit(place),
                    slice(self.compliance.col(place)),
                ),
                false => gather(j, 1.0, slice(self.system.col(place))),
            }
        }
        Lu::new(system, LEAST_PIVOT)
    }

    /// What the unknown r at a pin is counted in, so that the system is of one scale [N/m].
    fn force_unit(&self, place: usize) -> f64 {
        1.0 / self.compliance[(place, place)]
    }

    /// Of the dofs that a motion without force moves, the last to be eliminated: whose pivot would vanish.
    pub fn last_to_move(
        &self,
        factorised: &Factorised,
        pins: &[usize],
        motion: Vec<f64>,
    ) -> Option<usize> {
        let moved = self.change(factorised, &self.forces_of(pins, motion));
        let largest = moved.iter().fold(0.0, |a, b| f64::max(a, b.abs()));
        let moves = (0..moved.len()).filter(|&dof| moved[dof].abs() > STILL * largest);
        let moves = moves.filter(|dof| !pins.contains(dof));
        let places = moves.map(|dof| factorised.elimination(dof).map(|place| (place, dof)));
        places.max().flatten().map(|(_, dof)| dof)
    }

    /// S z, and r at the pins, after `before` [N].
    pub fn forces(&self, system: &Lu, pins: &[usize], before: &Solution) -> Vec<f64> {
        let dofs = self.active.iter().map(|&place| self.dofs[place]);
        let mut z: Vec<f64> = dofs.map(|d| before.displacement[d / 2][d % 2]).collect();
        system.solve_in_place(&mut z);
        self.forces_of(pins, z)
    }

    /// S z, and r at the pins, from both on the active dofs; on all dofs [N].
    fn forces_of(&self, pins: &[usize], active: Vec<f64>) -> Vec<f64> {
        let mut z = vec![0.0; self.dofs.len()];
        for (&place, value) in self.active.iter().zip(active) {
            z[place] = value;
        }
        let mut forces = vec![0.0; z.len()];
        for place in pins.iter().map(|dof| self.place[dof]) {
            forces[place] = self.force_unit(place) * std::mem::take(&mut z[place]);
        }
        lost::add_forces(&self.springs, &z, &mut forces);
        forces
    }

    /// K⁻¹ E times forces on the touched dofs, everywhere [m].
    pub fn change(&self, factorised: &Factorised, forces: &[f64]) -> Vec<f64> {
        let dofs = factorised.dofs();
        let mut change = vec![0.0; dofs];
        if self.columns.is_empty() {
            for (&dof, force) in self.dofs.iter().zip(forces) {
                change[dof] = *force;
            }
            factorised.respond(&mut change);
        } else {
            for (column, force) in self.columns.chunks_exact(dofs).zip(forces) {
                let add = change.iter_mut().zip(column);
                add.for_each(|(u, column)| *u += force * column);
            }
        }
        change
    }
}

/// What each of these changes takes from its interaction.
pub fn losses(problem: &Problem, changes: &[Change]) -> Vec<Loss> {
    let loss = |change: &Change| {
        let interaction = change.interaction as usize;
        let [before, after] = change.integrity;
        Loss {
            interaction,
            stiffness: (before - after) * problem.model.springs.stiffness[interaction],
        }
    };
    changes.iter().map(loss).collect()
}
