//! Low-rank change of K since a factorisation, and the response and compliance after it (Woodbury).
//!
//! Interactions have lost the stiffnesses t = (φ − φ') k, of any sign and size. With E the dofs T on which
//! they act, A = Eᵀ K⁻¹ E and S = Σ t w wᵀ there,
//!
//! ```text
//! K' = K − E S Eᵀ,   M = S (I − A S)⁻¹
//! u' = u + K⁻¹ E M Eᵀ u,   A'_zz = A_zz + A_zT M A_Tz
//! ```
//!
//! for an S of any rank, singular or not, and the dofs z of any zone. A = Xᵀ X with X = L⁻¹ E grows by the dofs
//! that come in (`linear_solver/compliance.rs`), and I − A S with it.
//!
//! A dof may be *pinned* since the factorisation, u'_p = 0: its unknown is the force that holds it, and its
//! column −A_p stands in place of that of (I − A S)_p.

use super::dense::Lu;
use super::policy::LEAST_PIVOT;
use super::problem::Problem;
use super::state::Change;
use crate::linear_solver::columns::{add, slice, slice_mut, symmetric};
use crate::linear_solver::compliance::UnitLoads;
use crate::model::Model;
use crate::statics::{Factorised, Solution};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, Par};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Columns that one thread takes at a time.
const COLUMNS: usize = 128;

/// Rows that one thread takes at a time: pieces of columns that stay in the cache.
const ROWS: usize = 256;

/// Stiffness that an interaction has lost since a factorisation, (φ − φ') k [N/m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    pub interaction: usize,
    pub stiffness: f64,
}

impl Loss {
    pub fn of(problem: &Problem, change: &Change) -> Loss {
        let interaction = change.interaction as usize;
        let [before, after] = change.integrity;
        Loss {
            interaction,
            stiffness: (before - after) * problem.model.interactions.stiffness[interaction],
        }
    }

    /// The interaction, and the stiffness that it has lost [N/m].
    pub fn parts(&self) -> (usize, f64) {
        (self.interaction, self.stiffness)
    }
}

/// A loss, with w by places among the touched dofs.
struct Term {
    stiffness: f64,
    w: Vec<(usize, f64)>,
}

/// Stiffness lost since a factorisation.
pub struct LowRankChange {
    /// T, in the order in which the dofs came in. Those on which losses act are *active*; others may be
    /// there in advance.
    dofs: Vec<usize>,
    place: BTreeMap<usize, usize>,
    active: Vec<usize>,
    is_active: Vec<bool>,
    /// X and A [m/N].
    loads: UnitLoads,
    compliance: Mat<f64>,
    terms: Vec<Term>,
    /// I − A S; columns that are not active are those of I.
    system: Mat<f64>,
}

/// I − A S of the active dofs, factorised.
pub struct ReducedSystem {
    lu: Lu,
    /// Places of the pinned dofs.
    pins: BTreeSet<usize>,
}

impl Default for LowRankChange {
    fn default() -> LowRankChange {
        LowRankChange {
            dofs: Vec::new(),
            place: BTreeMap::new(),
            active: Vec::new(),
            is_active: Vec::new(),
            loads: UnitLoads::default(),
            compliance: Mat::new(),
            terms: Vec::new(),
            system: Mat::new(),
        }
    }
}

impl LowRankChange {
    /// T.
    pub fn dofs(&self) -> &[usize] {
        &self.dofs
    }

    /// How many of the dofs are active.
    pub fn active(&self) -> usize {
        self.active.len()
    }

    /// Dofs whose compliance is not known yet.
    pub fn new_dofs(&self) -> &[usize] {
        &self.dofs[self.compliance.nrows()..]
    }

    /// Adds a dof if it is not there; returns its place.
    pub fn add(&mut self, dof: usize) -> usize {
        let next = self.dofs.len();
        let place = *self.place.entry(dof).or_insert(next);
        if place == next {
            self.dofs.push(dof);
            self.is_active.push(false);
        }
        place
    }

    /// Makes dofs active; returns how many of them are new.
    pub fn activate(&mut self, dofs: impl Iterator<Item = usize>) -> usize {
        let before = self.dofs.len();
        for dof in dofs {
            let place = self.add(dof);
            if !std::mem::replace(&mut self.is_active[place], true) {
                self.active.push(place);
            }
        }
        self.dofs.len() - before
    }

    /// Finds the compliance of the new dofs. `None` where the factor is not Cholesky's.
    pub fn extend(&mut self, factorised: &Factorised) -> Option<()> {
        let loads = factorised.unit_loads(self.new_dofs())?;
        let (between, own) = (self.loads.product(&loads), loads.square());
        self.loads.extend(loads);
        self.grow(&between, &own);
        Some(())
    }

    /// The same from what is known of more dofs: their X, A_Tz and A_zz; `places`: of the new ones there.
    pub fn extend_from(
        &mut self,
        loads: &UnitLoads,
        between: &Mat<f64>,
        own: &Mat<f64>,
        places: &[usize],
    ) {
        self.loads.append(loads, places);
        let count = places.len();
        let between = Mat::from_fn(between.nrows(), count, |i, j| between[(i, places[j])]);
        let own = Mat::from_fn(count, count, |i, j| own[(places[i], places[j])]);
        self.grow(&between, &own);
    }

    fn grow(&mut self, between: &Mat<f64>, own: &Mat<f64>) {
        let (size, known) = (self.dofs.len(), self.compliance.nrows());
        self.compliance.resize_with(size, size, |_, _| 0.0);
        let (old, added) = self.compliance.as_mut().split_at_row_mut(known);
        let (_, mut above) = old.split_at_col_mut(known);
        let (mut beside, mut corner) = added.split_at_col_mut(known);
        above.copy_from(between);
        beside.copy_from(between.transpose());
        corner.copy_from(own);
        let identity = |i: usize, j: usize| f64::from(u8::from(i == j));
        self.system.resize_with(size, size, identity);
        self.subtract(0, known);
    }

    /// Adds losses to S, all of whose dofs have come in.
    pub fn lose(&mut self, model: &Model, losses: &[Loss]) {
        let known = self.terms.len();
        for loss in losses {
            let mut w = Vec::new();
            model.for_each_term(loss.interaction, |node, parts| {
                for (axis, part) in parts.into_iter().enumerate() {
                    w.push((self.place[&(2 * node as usize + axis)], part));
                }
            });
            self.terms.push(Term {
                stiffness: loss.stiffness,
                w,
            });
        }
        self.subtract(known, 0);
    }

    /// Takes t A w wᵀ of the terms from one on off the rows of I − A S from one on.
    fn subtract(&mut self, first_term: usize, first_row: usize) {
        let rows = self.dofs.len() - first_row;
        let terms = &self.terms[first_term..];
        let compliance = self.compliance.subrows(first_row, rows);
        let chunks = self.system.subrows_mut(first_row, rows);
        let chunks = chunks.par_row_chunks_mut(ROWS).enumerate();
        chunks.for_each(|(k, mut system)| {
            let compliance = compliance.subrows(ROWS * k, system.nrows());
            let mut column = vec![0.0; system.nrows()];
            for term in terms {
                column.fill(0.0);
                for &(place, w) in &term.w {
                    add(
                        &mut column,
                        term.stiffness * w,
                        slice(compliance.col(place)),
                    );
                }
                for &(place, w) in &term.w {
                    add(slice_mut(system.as_mut().col_mut(place)), -w, &column);
                }
            }
        });
    }

    /// I − A S of the active dofs, with −A in the columns of the pinned dofs.
    ///
    /// # Errors
    /// z, and the forces at the pins, of a motion without force.
    pub fn factorise(&self, pins: &[usize]) -> Result<ReducedSystem, Vec<f64>> {
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
        let lu = Lu::new(system, LEAST_PIVOT)?;
        Ok(ReducedSystem { lu, pins })
    }

    /// Unit of the unknown force at a pinned dof, so that the system is of one scale [N/m].
    fn force_unit(&self, place: usize) -> f64 {
        1.0 / self.compliance[(place, place)]
    }

    /// M Eᵀ u, and the forces at the pins, by place [N].
    pub fn forces(&self, system: &ReducedSystem, u: &Solution) -> Vec<f64> {
        let dofs = self.active.iter().map(|&place| self.dofs[place]);
        let mut z: Vec<f64> = dofs.map(|d| u.displacement[d / 2][d % 2]).collect();
        system.lu.solve_in_place(&mut z);
        self.forces_of(&system.pins, z)
    }

    /// The forces of a motion that [`LowRankChange::factorise`] has found, by place [N].
    pub fn forces_of_motion(&self, pins: &[usize], motion: Vec<f64>) -> Vec<f64> {
        self.forces_of(&pins.iter().map(|dof| self.place[dof]).collect(), motion)
    }

    /// S z, and the forces at the pins, from both on the active dofs; by place [N].
    fn forces_of(&self, pins: &BTreeSet<usize>, active: Vec<f64>) -> Vec<f64> {
        let mut z = vec![0.0; self.dofs.len()];
        for (&place, value) in self.active.iter().zip(active) {
            z[place] = value;
        }
        let mut forces = vec![0.0; z.len()];
        for &place in pins {
            forces[place] = self.force_unit(place) * std::mem::take(&mut z[place]);
        }
        self.add_forces(&z, &mut forces);
        forces
    }

    /// Adds S z.
    fn add_forces(&self, z: &[f64], forces: &mut [f64]) {
        for term in &self.terms {
            let elongation: f64 = term.w.iter().map(|&(place, w)| w * z[place]).sum();
            for &(place, w) in &term.w {
                forces[place] += term.stiffness * elongation * w;
            }
        }
    }

    /// K⁻¹ E times forces by place, everywhere [m].
    pub fn respond(&self, factorised: &Factorised, forces: &[f64]) -> Vec<f64> {
        let mut change = vec![0.0; factorised.dofs()];
        for (&dof, force) in self.dofs.iter().zip(forces) {
            change[dof] = *force;
        }
        factorised.respond(&mut change);
        change
    }

    /// A_Tz of other dofs, from their X.
    pub fn between(&self, loads: &UnitLoads) -> Mat<f64> {
        self.loads.product(loads)
    }

    /// Overwrites columns c on T, all of them active, by M c.
    pub fn reduce(&self, system: &ReducedSystem, columns: MatMut<f64>) {
        columns.par_col_chunks_mut(COLUMNS).for_each(|mut block| {
            system.lu.solve_many_in_place(block.as_mut());
            for mut column in block.col_iter_mut() {
                let z: Vec<f64> = column.as_ref().iter().copied().collect();
                column.fill(0.0);
                self.add_forces(&z, slice_mut(column));
            }
        });
    }
}

/// A'_zz from A_zz, A_Tz and M A_Tz.
pub fn changed_compliance(own: &Mat<f64>, between: &Mat<f64>, moved: &Mat<f64>) -> Mat<f64> {
    let mut upper = own.clone();
    let blocks = upper.par_col_chunks_mut(COLUMNS).enumerate();
    blocks.for_each(|(k, block)| {
        let (first, count) = (COLUMNS * k, block.ncols());
        let moved = moved.subcols(first, count);
        let rows = between.subcols(0, first + count).transpose();
        let own = block.subrows_mut(0, first + count);
        matmul(own, Accum::Add, rows, moved, 1.0, Par::Seq);
    });
    symmetric(&upper)
}

#[cfg(test)]
mod tests;
