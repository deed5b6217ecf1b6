//! The path of a few dofs to the root of the elimination tree, and the supernodes of L on it.
//!
//! With K = L Lᵀ, a force at one dof enters L⁻¹ f at its column and in those above it in the tree:
//!
//! ```text
//! L y = f upwards from the columns of f
//! ```
//!
//! supernode by supernode, in products of dense blocks for all right-hand sides at once.

use super::cholesky::Factor;
use super::columns::{slice, slice_mut};
use super::supernodes::Supernodes;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, MatMut, MatRef, Par};
use std::ops::Range;

/// The supernodes above a set of columns, these included, and the places of their rows in a compact
/// right-hand side.
pub(super) struct Path {
    /// Its supernodes, ascending: children before parents.
    pub(super) steps: Vec<Step>,
    pub(super) rows: usize,
}

pub(super) struct Step {
    supernode: usize,
    /// The columns that the path begins at which lie in this supernode or below it, by their places.
    pub(super) members: Range<usize>,
    /// Its first column, the number of its columns, and the row of the first.
    pub(super) begin: usize,
    pub(super) width: usize,
    pub(super) first_row: usize,
    /// The rows of the right-hand side that belong to the rows of L below its own.
    pub(super) below: Vec<u32>,
}

impl Path {
    /// The path from ascending columns.
    pub(super) fn new(structure: &Supernodes, columns: &[usize]) -> Path {
        let mut path = Path {
            steps: Vec::new(),
            rows: 0,
        };
        for supernode in structure.above_columns(columns.iter().copied()) {
            let begin = structure.columns(supernode).start;
            let width = structure.width(supernode);
            let first = structure.columns(structure.subtree(supernode).start).start;
            let before = |limit: usize| columns.partition_point(|&column| column < limit);
            path.steps.push(Step {
                supernode,
                members: before(first)..before(begin + width),
                begin,
                width,
                first_row: path.rows,
                below: Vec::new(),
            });
            path.rows += width;
        }
        for k in 0..path.steps.len() {
            let pattern = structure.rows(path.steps[k].supernode);
            path.steps[k].below = path.places(pattern, k);
        }
        path
    }

    /// The rows of ascending columns above step `k`.
    fn places(&self, columns: &[u32], k: usize) -> Vec<u32> {
        let mut k = k;
        let place = |&column: &u32| {
            let column = column as usize;
            while column >= self.steps[k].begin + self.steps[k].width {
                k += 1;
            }
            (self.steps[k].first_row + column - self.steps[k].begin) as u32
        };
        columns.iter().map(place).collect()
    }

    /// The row of a column of the path.
    pub(super) fn row(&self, column: usize) -> usize {
        let k = self.steps.partition_point(|s| s.begin + s.width <= column);
        self.steps[k].first_row + column - self.steps[k].begin
    }
}

impl<const B: usize> Factor<B> {
    /// The diagonal block of a supernode, and the block below it.
    fn blocks(&self, step: &Step) -> (MatRef<'_, f64>, MatRef<'_, f64>) {
        let height = step.width + step.below.len();
        let values = &self.values()[self.supernodes().block(step.supernode)];
        MatRef::from_column_major_slice(values, height, step.width).split_at_row(step.width)
    }

    /// Takes right-hand sides, path rows × members, past a supernode. `beside`: rows below × members.
    pub(super) fn step_up(&self, step: &Step, x: MatMut<f64>, mut beside: MatMut<f64>) {
        let (diagonal, below) = self.blocks(step);
        let (own, mut above) = x.split_at_row_mut(step.first_row + step.width);
        let mut own = own.subrows_mut(step.first_row, step.width);
        solve_lower_triangular_in_place(diagonal, own.as_mut(), Par::Seq);
        let (sum, own) = (beside.as_mut(), own.as_ref());
        matmul(sum, Accum::Replace, below, own, 1.0, Par::Seq);
        let first = step.first_row + step.width;
        for (to, passed_on) in above.as_mut().col_iter_mut().zip(beside.col_iter()) {
            let to = slice_mut(to);
            for (&row, passed_on) in step.below.iter().zip(slice(passed_on)) {
                to[row as usize - first] -= passed_on;
            }
        }
    }
}
