//! What has gone since a factorisation, and what that does to the compliance of a zone.
//!
//! The springs that are gone took S = Σ k w wᵀ at the dofs T which they touch. With A = Eᵀ K⁻¹ E of the
//! factorised K and z the dofs of a zone,
//!
//! ```text
//! K' = K − S,   M = S (I − A_TT S)⁻¹
//! A'_zz = A_zz + A_zT M A_Tz,   u' = u + K⁻¹ E_T M u_T
//! ```
//!
//! for an S of any rank. M is formed anew for each zone: rounding of the updates there does not pile up from zone
//! to zone.

use super::compliance::Compliance;
use super::dense::Lu;
use super::lost::{self, Loss, Spring, pairs};
use super::problem::Problem;
use super::solutions::Solutions;
use super::zone::Zone;
use crate::boundary::Boundary;
use crate::linear_solver::columns::{add, slice, slice_mut, symmetric};
use crate::linear_solver::compliance::UnitLoads;
use crate::statics::{Factorised, Solution};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, Par};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A pivot of I − A_TT S below this share of the largest: what is left is a mechanism, or too close to one.
const LEAST_PIVOT: f64 = 1e-7;

/// Columns that one thread takes at a time.
const BLOCK: usize = 128;

/// What had gone when a zone began.
pub struct Gone {
    springs: Vec<Spring>,
    /// T, in the order in which they were first touched.
    dofs: Vec<usize>,
    place: BTreeMap<usize, usize>,
    /// L⁻¹ E_T, and A_TT [m/N].
    loads: UnitLoads,
    compliance: Mat<f64>,
    /// Of the last zone.
    before: Option<Compliance>,
}

/// A zone when it begins.
pub struct Start {
    /// A_zz and A_Tz of the factorised K.
    compliance: Compliance,
    between: Mat<f64>,
    /// Multiplications and additions that it took.
    pub flops: f64,
}

/// How springs that were gone before a zone answer what happens there.
pub struct Earlier {
    /// M A_Tz.
    moved: Mat<f64>,
    /// M u_T of each case when the zone began [N].
    forces: [Vec<f64>; 2],
}

impl Default for Gone {
    fn default() -> Gone {
        Gone {
            springs: Vec::new(),
            dofs: Vec::new(),
            place: BTreeMap::new(),
            loads: UnitLoads::default(),
            compliance: Mat::new(),
            before: None,
        }
    }
}

impl Gone {
    /// T.
    pub fn dofs(&self) -> &[usize] {
        &self.dofs
    }

    /// `None` where what is left is a mechanism, or the factor not Cholesky's.
    pub fn start(
        &mut self,
        factorised: &Factorised,
        zone: &Zone,
        base: &Solutions,
    ) -> Option<(Start, Earlier)> {
        let compliance = Compliance::new(factorised, &zone.dofs, self.before.take())?;
        let [touched, n] = [self.dofs.len(), zone.dofs.len()];
        let mut start = Start {
            flops: compliance.flops
                + flops(n as f64, touched as f64, compliance.loads.rows() as f64),
            between: Mat::zeros(touched, n),
            compliance,
        };
        let mut earlier = Earlier {
            moved: Mat::zeros(touched, n),
            forces: [Vec::new(), Vec::new()],
        };
        if touched > 0 {
            start.between = self.loads.product(&start.compliance.loads);
            let system = self.system()?;
            earlier.moved.copy_from(&start.between);
            self.take(&system, earlier.moved.as_mut());
            earlier.forces = self.forces(&system, base);
        }
        Some((start, earlier))
    }

    /// I − A_TT S, factorised.
    fn system(&self) -> Option<Lu> {
        let touched = self.dofs.len();
        let mut system = Mat::<f64>::identity(touched, touched);
        lost::subtract(system.as_mut(), self.compliance.as_ref(), &self.springs);
        Lu::new(system, LEAST_PIVOT).ok()
    }

    /// Overwrites columns c on T by M c.
    fn take(&self, system: &Lu, columns: MatMut<f64>) {
        columns.par_col_chunks_mut(BLOCK).for_each(|mut block| {
            system.solve_many_in_place(block.as_mut());
            for mut column in block.col_iter_mut() {
                let z: Vec<f64> = column.as_ref().iter().copied().collect();
                column.fill(0.0);
                lost::add_forces(&self.springs, &z, slice_mut(column));
            }
        });
    }

    /// M u_T of each case: the forces of the springs that are gone [N].
    fn forces(&self, system: &Lu, base: &Solutions) -> [Vec<f64>; 2] {
        let of = |u: Option<&Solution>| -> Vec<f64> {
            let Some(u) = u else { return Vec::new() };
            let touched = system.size();
            let on_dof = |i: usize| u.displacement[self.dofs[i] / 2][self.dofs[i] % 2];
            let mut forces = Mat::from_fn(touched, 1, |i, _| on_dof(i));
            self.take(system, forces.as_mut());
            forces.col(0).iter().copied().collect()
        };
        [of(base.held.as_ref()), of(Some(&base.unit))]
    }

    /// Leaves a zone, where some bonds have gone.
    pub fn lose(&mut self, problem: &Problem, zone: &Zone, start: Start, losses: &[Loss]) {
        let model = problem.model;
        let (known, mut new) = (self.dofs.len(), Vec::new());
        for &loss in losses {
            let mut terms = Vec::new();
            model.for_each_term(loss.interaction, |node, w| {
                for (axis, w) in w.into_iter().enumerate() {
                    let dof = 2 * node as usize + axis;
                    let next = self.dofs.len();
                    let place = *self.place.entry(dof).or_insert(next);
                    if place == next {
                        self.dofs.push(dof);
                        new.push(zone.dofs.binary_search(&dof).expect("a dof of the zone"));
                    }
                    terms.push((place, w));
                }
            });
            self.springs.push(Spring {
                stiffness: loss.stiffness,
                terms,
            });
        }
        self.loads.append(&start.compliance.loads, &new);
        let size = self.dofs.len();
        let Gone { compliance, .. } = self;
        compliance.resize_with(size, size, |_, _| 0.0);
        for (j, &place) in new.iter().enumerate() {
            for i in 0..known {
                let a = start.between[(i, place)];
                compliance[(i, known + j)] = a;
                compliance[(known + j, i)] = a;
            }
            for (i, &other) in new.iter().enumerate() {
                compliance[(known + i, known + j)] = start.compliance.own[(other, place)];
            }
        }
        self.before = Some(start.compliance);
    }
}

/// u_held and u_unit everywhere, from those when K was factorised, where some springs are gone and exert these
/// forces of each case at all dofs [N].
pub fn respond(
    problem: &Problem,
    phase: usize,
    factorised: &Factorised,
    base: &Solutions,
    [held, unit]: [Vec<f64>; 2],
    losses: &[Loss],
) -> Solutions {
    let (model, programme) = (problem.model, problem.programme);
    let after = |mut change: Vec<f64>, case: &Boundary, before: &Solution| {
        factorised.respond(&mut change);
        let case = (case, factorised.load_norm(case));
        factorised.without(model, case, before, &change, pairs(losses))
    };
    let before = (base.held.as_ref()).zip(programme.held(phase));
    Solutions {
        unit: after(unit, &programme.phases[phase].boundary, &base.unit),
        held: before.map(|(u, case)| after(held, &case, u)),
    }
}

impl Start {
    /// A'_zz.
    pub fn compliance(&self, earlier: &Earlier) -> Mat<f64> {
        let mut upper = self.compliance.own.clone();
        let blocks = upper.par_col_chunks_mut(BLOCK).enumerate();
        blocks.for_each(|(k, block)| {
            let (first, count) = (BLOCK * k, block.ncols());
            let moved = earlier.moved.subcols(first, count);
            let rows = self.between.subcols(0, first + count).transpose();
            let own = block.subrows_mut(0, first + count);
            matmul(own, Accum::Add, rows, moved, 1.0, Par::Seq);
        });
        symmetric(&upper)
    }
}

impl Earlier {
    /// v' on the zone: v there, a response to loads that stay, and what the springs add that are gone.
    pub fn field(&self, touched: &[usize], zone: &Zone, v: &[f64]) -> Vec<f64> {
        let mut own: Vec<f64> = zone.dofs.iter().map(|&d| v[d]).collect();
        for (j, own) in own.iter_mut().enumerate() {
            let moved = self.moved.col(j).iter().zip(touched);
            *own += moved.map(|(m, &dof)| m * v[dof]).sum::<f64>();
        }
        own
    }

    /// Adds to the forces at all dofs [N] those of the springs that were gone when the zone began, which
    /// `touched` some, and of those of the zone that are gone since, which exert `own` on its dofs [N].
    pub fn add_forces(
        &self,
        touched: &[usize],
        zone: &Zone,
        case: usize,
        own: &[f64],
        all: &mut [f64],
    ) {
        for (&dof, f) in zone.dofs.iter().zip(own) {
            all[dof] += f;
        }
        let mut before = self.forces[case].clone();
        for (j, &f) in own.iter().enumerate().filter(|(_, f)| **f != 0.0) {
            add(&mut before, f, slice(self.moved.col(j)));
        }
        for (&dof, f) in touched.iter().zip(before) {
            all[dof] += f;
        }
    }
}

/// Multiplications and additions for a zone of `n` dofs with `p` rows of X, when `t` are touched: X_TᵀX,
/// I − A_TT S factorised and applied, A'.
fn flops(n: f64, t: f64, p: f64) -> f64 {
    2.0 * t * n * p + 2.0 / 3.0 * t * t * t + 2.0 * t * t * n + n * n * t
}
