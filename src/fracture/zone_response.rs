//! The response on a zone while its interactions change, one after the other (`predictor.rs`).

use super::event::Bounds;
use super::functional::Values;
use super::laws::StretchLimits;
use super::low_rank::Loss;
use super::policy::LEAST_PIVOT;
use super::problem::Problem;
use super::solutions::Solutions;
use super::zone::Zone;
use crate::linear_solver::columns::{add, slice, slice_mut};
use crate::statics::Solution;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, Par};
use rayon::prelude::*;

/// Interactions that one thread surveys at a time.
const CHUNK: usize = 1024;

/// Updates of A that wait to be applied together.
const PENDING: usize = 48;

/// The response on a zone while its interactions change.
pub struct ZoneResponse {
    /// A as it was before the updates that wait [m/N].
    compliance: Mat<f64>,
    /// √|t/d| a of the updates that wait, the same with the sign of t/d, and how many do.
    pending: [Mat<f64>; 2],
    waiting: usize,
    /// u_held, empty where nothing is held, and u_unit [m].
    pub displacement: [Vec<f64>; 2],
    /// v of the functionals.
    fields: Vec<Vec<f64>>,
    pub values: Values,
    /// Integrity φ of the zone's interactions [-], and the limits of their branches.
    pub integrity: Vec<f64>,
    pub limits: Vec<StretchLimits>,
}

impl ZoneResponse {
    pub fn new(
        problem: &Problem,
        integrity: &[f64],
        zone: &Zone,
        compliance: Mat<f64>,
        solutions: &Solutions,
        fields: Vec<Vec<f64>>,
        values: Values,
    ) -> ZoneResponse {
        let on_zone = |u: &Solution| -> Vec<f64> {
            let dofs = zone.dofs.iter();
            dofs.map(|&d| u.displacement[d / 2][d % 2]).collect()
        };
        ZoneResponse {
            compliance,
            pending: [0; 2].map(|_| Mat::zeros(zone.dofs.len(), PENDING)),
            waiting: 0,
            displacement: [
                solutions.held.as_ref().map(on_zone).unwrap_or_default(),
                on_zone(&solutions.unit),
            ],
            fields,
            values,
            integrity: zone.interactions.iter().map(|&s| integrity[s]).collect(),
            limits: (zone.interactions.iter())
                .map(|&s| problem.laws.limits(s, integrity[s]))
                .collect(),
        }
    }

    /// Finds the stretches of every interaction, zero for broken ones, and the bounds of the load that they allow;
    /// λ is `last` now.
    pub fn survey(&self, zone: &Zone, last: f64, stretches: &mut Vec<[f64; 2]>) -> Bounds {
        stretches.resize(zone.interactions.len(), [0.0; 2]);
        let chunks = stretches.par_chunks_mut(CHUNK).enumerate();
        let bounds = chunks.map(|(chunk, stretches)| {
            let mut bounds = Bounds::NONE;
            for (k, stretch) in (chunk * CHUNK..).zip(stretches) {
                *stretch = match self.integrity[k] > 0.0 {
                    true => zone.stretches(k, &self.displacement),
                    false => [0.0; 2],
                };
                bounds = bounds.and(Bounds::of(*stretch, self.limits[k], last));
            }
            bounds
        });
        bounds.reduce(|| Bounds::NONE, Bounds::and)
    }

    /// Gives an interaction of the zone another integrity, and returns the stiffness that it loses; `None`
    /// where not all is held any more.
    pub fn change(
        &mut self,
        problem: &Problem,
        zone: &Zone,
        place: usize,
        integrity: f64,
    ) -> Option<Loss> {
        let (w, interaction) = (zone.terms(place), zone.interactions[place]);
        let t =
            (self.integrity[place] - integrity) * problem.model.interactions.stiffness[interaction];
        self.integrity[place] = integrity;
        self.limits[place] = problem.laws.limits(interaction, integrity);
        let a = self.column(w);
        let d = 1.0 - t * dot(w, &a);
        // False for what is not a number.
        let is_held = d > LEAST_PIVOT;
        if !is_held {
            return None;
        }
        let force = |u: &Vec<f64>| if u.is_empty() { 0.0 } else { t * dot(w, u) / d };
        let forces = [force(&self.displacement[0]), force(&self.displacement[1])];
        for (value, v) in self.values.0.iter_mut().zip(&mut self.fields) {
            let along = dot(w, v);
            value[0] += forces[0] * along;
            value[1] += forces[1] * along;
            add(v, t * along / d, &a);
        }
        for (u, force) in self.displacement.iter_mut().zip(forces) {
            add(u, force, &a);
        }
        let scale = (t / d).abs().sqrt();
        for (pending, scale) in self.pending.iter_mut().zip([scale, scale.copysign(t)]) {
            let column = slice_mut(pending.col_mut(self.waiting));
            column.iter_mut().zip(&a).for_each(|(p, a)| *p = scale * a);
        }
        self.waiting += 1;
        if self.waiting == PENDING {
            self.flush();
        }
        Some(Loss {
            interaction,
            stiffness: t,
        })
    }

    /// A w.
    fn column(&self, w: &[(u32, f64)]) -> Vec<f64> {
        let mut a = vec![0.0; self.compliance.nrows()];
        for &(dof, w) in w {
            add(&mut a, w, slice(self.compliance.col(dof as usize)));
        }
        let [pending, signed] = &self.pending;
        let pending = pending.subcols(0, self.waiting);
        let along = Mat::from_fn(self.waiting, 1, |j, _| dot(w, slice(signed.col(j))));
        let rows = a.len();
        let sum = MatMut::from_column_major_slice_mut(&mut a, rows, 1);
        matmul(sum, Accum::Add, pending, &along, 1.0, Par::Seq);
        a
    }

    /// Applies the updates that wait, block by block of A's columns.
    fn flush(&mut self) {
        let [pending, signed] = self.pending.each_ref().map(Mat::as_ref);
        self.compliance
            .par_col_chunks_mut(128)
            .enumerate()
            .for_each(|(k, block)| {
                let rows = signed.subrows(128 * k, block.ncols());
                matmul(block, Accum::Add, pending, rows.transpose(), 1.0, Par::Seq);
            });
        self.waiting = 0;
    }
}

/// w·u.
fn dot(w: &[(u32, f64)], u: &[f64]) -> f64 {
    w.iter().map(|&(dof, w)| w * u[dof as usize]).sum()
}
