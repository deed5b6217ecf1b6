//! Conjugate gradients with a preconditioner of two levels, where the factor of K would be too large.
//!
//! ```text
//! M⁻¹ = D⁻¹ + P (Pᵀ K P)⁻¹ Pᵀ
//! ```
//!
//! D is the 2 × 2 diagonal of K, one block per node. P moves *aggregates* of nodes: two shifts, a turn and
//! a growth in all directions each; Pᵀ K P is factorised by Cholesky. Bonds reach as far as the aggregates are
//! wide, so that neither level leaves an error to the other that grows with the system: on a lattice the
//! number of iterations does not depend on its size (docs/performance.md). An additive method of Schwarz
//! (Toselli & Widlund 2005, section 3) with the coarse space of smoothed aggregation (Vaněk, Mandel &
//! Brezina 1996), unsmoothed.
//!
//! Aggregates are what K still ties together within a cell of the caller's: a crack through a cell makes
//! two of it. Where a chunk has come loose of all supports, Pᵀ K P has a pivot that vanishes, which is
//! told as Cholesky tells it.

mod aggregates;
mod coarse;

use super::cholesky;
use super::held::HeldDofs;
use super::policy::{ITERATIVE_RESIDUAL, MOST_ITERATIONS, PIECE};
use super::{
    Backend, FactorSize, Factorisation, SolverError, SymmetricSolver, expected_factor_entries,
};
use crate::assembly::{Lists, LowerMatrix};
use aggregates::{Aggregates, MODES};
use coarse::{NodeBlocks, factorise_coarse};
use rayon::prelude::*;
use std::sync::Arc;

/// The nodes that the coarse level may move as one.
#[derive(Clone, Debug)]
pub struct Coarsening {
    /// Neighbours of each node in the pattern of K.
    pub graph: Arc<Lists>,
    /// A number per node, the same for nodes that may share an aggregate.
    pub cells: Vec<u32>,
    /// x of every node [m].
    pub positions: Vec<[f64; 2]>,
}

impl SymmetricSolver for Coarsening {
    fn backend(&self) -> Backend {
        Backend::TwoLevel
    }

    /// An estimate: aggregates are taken to be connected to the eight around them.
    fn size(&self) -> FactorSize {
        let is_first = |&(node, cell): &(usize, &u32)| node == *cell as usize;
        let aggregates = self.cells.iter().enumerate().filter(is_first).count();
        FactorSize {
            entries: expected_factor_entries::<MODES>(aggregates, 8 * aggregates) as usize,
            ..FactorSize::default()
        }
    }

    fn factorise(
        &self,
        stiffness: &LowerMatrix,
        held: HeldDofs,
        _: &[u32],
    ) -> Result<Box<dyn Factorisation>, SolverError> {
        Ok(Box::new(TwoLevel::new(self, stiffness, held.is_held)?))
    }
}

/// K, ready to be solved with.
#[derive(Clone, Debug)]
struct TwoLevel {
    matrix: LowerMatrix,
    is_held: Vec<bool>,
    /// D⁻¹ of each node, xx, xy, yy; zero where it is held.
    smoother: Vec<[f64; 3]>,
    aggregates: Aggregates,
    /// L of Pᵀ K P.
    coarse: cholesky::Factor<MODES>,
}

impl TwoLevel {
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`], with the dof that a motion without force moves the most.
    fn new(
        coarsening: &Coarsening,
        matrix: &LowerMatrix,
        is_held: &[bool],
    ) -> Result<TwoLevel, SolverError> {
        let Coarsening {
            graph,
            cells,
            positions,
        } = coarsening;
        let blocks = NodeBlocks { matrix, graph };
        let aggregates = Aggregates::new(&blocks, cells, positions, is_held);
        let coarse = factorise_coarse(&blocks, &aggregates)?;
        let smoother = (0..graph.len()).into_par_iter();
        let smoother = smoother.map(|node| {
            inverse(
                blocks.diagonal(node),
                [0, 1].map(|axis| is_held[2 * node + axis]),
            )
        });
        Ok(TwoLevel {
            smoother: smoother.collect(),
            matrix: matrix.clone(),
            is_held: is_held.to_vec(),
            aggregates,
            coarse,
        })
    }

    /// Overwrites `rhs` by an x with ‖K x − rhs‖₂ ≤ `goal` and no motion at held dofs. Where rounding or a
    /// singular K does not let the residual fall so far, x is the last iterate.
    fn iterate(&self, rhs: &mut [f64], goal: f64) {
        let mut residual = rhs.to_vec();
        self.clear_held(&mut residual);
        let x = rhs;
        x.fill(0.0);
        let mut z = self.precondition(&residual);
        let mut direction = z.clone();
        let mut product = dot(&residual, &z);
        for _ in 0..MOST_ITERATIONS {
            if dot(&residual, &residual).sqrt() <= goal {
                return;
            }
            let mut force = self.matrix.multiply(&direction);
            self.clear_held(&mut force);
            let energy = dot(&direction, &force);
            // Also for what is not a number.
            if !(energy > 0.0 && product > 0.0) {
                return;
            }
            let step = product / energy;
            add(x, step, &direction);
            add(&mut residual, -step, &force);
            z = self.precondition(&residual);
            let next = dot(&residual, &z);
            let share = next / product;
            product = next;
            let pieces = direction.par_chunks_mut(PIECE).zip(z.par_chunks(PIECE));
            pieces.for_each(|(direction, z)| {
                let dofs = direction.iter_mut().zip(z);
                dofs.for_each(|(d, z)| *d = z + share * *d);
            });
        }
    }

    fn clear_held(&self, force: &mut [f64]) {
        let dofs = force.iter_mut().zip(&self.is_held);
        dofs.filter(|(_, held)| **held).for_each(|(f, _)| *f = 0.0);
    }

    /// M⁻¹ r.
    fn precondition(&self, residual: &[f64]) -> Vec<f64> {
        let Aggregates {
            of,
            members,
            motion,
        } = &self.aggregates;
        let sum = |aggregate: usize| {
            let mut sum = [0.0; MODES];
            for &node in members.of(aggregate) {
                let node = node as usize;
                for (axis, row) in motion[node].iter().enumerate() {
                    let r = residual[2 * node + axis];
                    (0..MODES).for_each(|mode| sum[mode] += row[mode] * r);
                }
            }
            sum
        };
        let sums: Vec<[f64; MODES]> = (0..members.len()).into_par_iter().map(sum).collect();
        let mut coarse = sums.into_flattened();
        self.coarse.solve_in_place(&mut coarse);
        let mut z = vec![0.0; residual.len()];
        let nodes = z.par_chunks_mut(2).enumerate().with_min_len(PIECE / 2);
        nodes.for_each(|(node, z)| {
            let [xx, xy, yy] = self.smoother[node];
            let [x, y] = [residual[2 * node], residual[2 * node + 1]];
            let rigid = &coarse[MODES * of[node] as usize..][..MODES];
            let moved =
                motion[node].map(|row| row.iter().zip(rigid).map(|(p, u)| p * u).sum::<f64>());
            z[0] = xx * x + xy * y + moved[0];
            z[1] = xy * x + yy * y + moved[1];
        });
        z
    }
}

impl Factorisation for TwoLevel {
    fn solve_in_place(&self, rhs: &mut [f64], goals: &[f64]) {
        let cases = rhs.chunks_exact_mut(self.is_held.len()).zip(goals);
        cases.for_each(|(rhs, &goal)| self.iterate(rhs, goal));
    }

    fn residual_goal(&self) -> f64 {
        ITERATIVE_RESIDUAL
    }

    fn entries(&self) -> usize {
        self.coarse.values().len()
    }

    fn gains_by_guess(&self) -> bool {
        true
    }
}

/// The inverse of a node's block on what is not held.
fn inverse([xx, xy, yy]: [f64; 3], is_held: [bool; 2]) -> [f64; 3] {
    let over = |x: f64| if x > 0.0 { 1.0 / x } else { 0.0 };
    let determinant = xx * yy - xy * xy;
    match is_held {
        [true, true] => [0.0; 3],
        [false, true] => [over(xx), 0.0, 0.0],
        [true, false] => [0.0, 0.0, over(yy)],
        // A point whose bonds are parallel has a singular block.
        [false, false] if determinant > f64::EPSILON * xx * yy => {
            [yy, -xy, xx].map(|x| x / determinant)
        }
        [false, false] => [over(xx + yy), 0.0, over(xx + yy)],
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let pieces = a.par_chunks(PIECE).zip(b.par_chunks(PIECE));
    let sums = pieces.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>());
    // Collected, so that the pieces are summed in their order.
    sums.collect::<Vec<f64>>().into_iter().sum()
}

/// x + factor y, in x.
fn add(x: &mut [f64], factor: f64, y: &[f64]) {
    let pieces = x.par_chunks_mut(PIECE).zip(y.par_chunks(PIECE));
    pieces.for_each(|(x, y)| x.iter_mut().zip(y).for_each(|(x, y)| *x += factor * y));
}
