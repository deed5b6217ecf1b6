//! The part of L on the way of a few dofs to the root of the elimination tree.
//!
//! With K = L Lᵀ, a force at one dof enters L⁻¹ f at its column and in those above it in the tree:
//!
//! ```text
//! L y = f upwards from the columns of f
//! ```
//!
//! supernode by supernode, in products of dense blocks for all right-hand sides at once.

use super::cholesky::Factor;
use super::supernodes::Supernodes;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, MatMut, MatRef, Par};
use std::collections::BTreeSet;

/// The supernodes above a set of columns, these included, and where their rows stand in a compact
/// right-hand side.
pub(super) struct Path {
    /// Ascending: children before parents.
    pub(super) steps: Vec<Step>,
    pub(super) rows: usize,
}

pub(super) struct Step {
    supernode: usize,
    /// Its first column, how many there are, and where the first stands.
    pub(super) begin: usize,
    pub(super) width: usize,
    pub(super) first_row: usize,
    /// Where the rows of L below its own stand.
    pub(super) below: Vec<u32>,
}

impl Path {
    pub(super) fn new(structure: &Supernodes, columns: &[usize]) -> Path {
        let mut path = Path {
            steps: Vec::new(),
            rows: 0,
        };
        for supernode in above(structure, columns) {
            let begin = structure.columns(supernode).start;
            let width = structure.width(supernode);
            path.steps.push(Step {
                supernode,
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

    /// Where ascending columns above step `k` stand.
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

    /// Where a column of the path stands.
    pub(super) fn row(&self, column: usize) -> usize {
        let k = self.steps.partition_point(|s| s.begin + s.width <= column);
        self.steps[k].first_row + column - self.steps[k].begin
    }
}

/// The supernodes of columns and those above them, ascending.
fn above(structure: &Supernodes, columns: &[usize]) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    for &column in columns {
        let mut next = Some(structure.supernode_of(column));
        while let Some(s) = next.filter(|&s| found.insert(s)) {
            next = structure.parent(s);
        }
    }
    found
}

impl Factor {
    /// The diagonal block of a supernode, and what is below.
    fn blocks(&self, step: &Step) -> (MatRef<'_, f64>, MatRef<'_, f64>) {
        let height = step.width + step.below.len();
        let values = &self.values()[self.supernodes().block(step.supernode)];
        MatRef::from_column_major_slice(values, height, step.width).split_at_row(step.width)
    }

    pub(super) fn step_up(&self, step: &Step, mut x: MatMut<f64>, mut beside: MatMut<f64>) {
        let (diagonal, below) = self.blocks(step);
        let mut own = x.as_mut().subcols_mut(step.first_row, step.width);
        solve_lower_triangular_in_place(diagonal, own.as_mut().transpose_mut(), Par::Seq);
        matmul(
            beside.as_mut(),
            Accum::Replace,
            own.as_ref(),
            below.transpose(),
            1.0,
            Par::Seq,
        );
        for (i, &row) in step.below.iter().enumerate() {
            let passed_on = beside.as_ref().col(i).try_as_col_major();
            let to = x.as_mut().col_mut(row as usize).try_as_col_major_mut();
            let (to, passed_on) = to.zip(passed_on).expect("stored by columns");
            let both = to.as_slice_mut().iter_mut().zip(passed_on.as_slice());
            both.for_each(|(x, passed_on)| *x -= passed_on);
        }
    }
}
