//! K⁻¹ between a few dofs, by no more of L than what lies on their way to the root of the elimination
//! tree.
//!
//! With K = L Lᵀ, a force at one dof enters L⁻¹ f at its column and in those above it in the tree, and
//! u at one dof follows from those above it alone:
//!
//! ```text
//! L y = f upwards from the columns of f,   Lᵀ u = y downwards to the columns of u
//! ```
//!
//! Both go supernode by supernode, in products of dense blocks for all right-hand sides at once.

use super::cholesky::Factor;
use super::supernodes::Supernodes;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Right-hand sides that one thread carries at a time.
const BLOCK: usize = 32;

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
    /// K⁻¹ at `rows` for unit forces at `columns`, dofs that are among `rows` each: rows × columns.
    /// On all threads, with the same bits on any number of them.
    pub fn inverse_between(&self, rows: &[usize], columns: &[usize]) -> Mat<f64> {
        let structure = self.supernodes();
        let [row_columns, force_columns] =
            [rows, columns].map(|dofs| dofs.iter().map(|&d| self.column(d)).collect::<Vec<_>>());
        let path = Path::new(structure, &row_columns);
        let places: Vec<usize> = row_columns.iter().map(|&c| path.row(c)).collect();
        // Neighbours in the elimination tree share a block.
        let mut order: Vec<usize> = (0..columns.len()).collect();
        order.sort_by_key(|&k| force_columns[k]);
        let blocks: Vec<Mat<f64>> = (order.par_chunks(BLOCK))
            .map(|block| {
                let columns: Vec<usize> = block.iter().map(|&k| force_columns[k]).collect();
                let x = self.between(&path, &columns);
                Mat::from_fn(rows.len(), block.len(), |i, j| x[(j, places[i])])
            })
            .collect();
        let mut inverse = Mat::zeros(rows.len(), columns.len());
        for (block, x) in order.chunks(BLOCK).zip(&blocks) {
            for (j, &k) in block.iter().enumerate() {
                inverse.col_mut(k).copy_from(x.col(j));
            }
        }
        inverse
    }

    /// K⁻¹ at the rows of the path for unit forces at some of its columns; transposed, so that what all
    /// right-hand sides have at one row lies together.
    fn between(&self, path: &Path, columns: &[usize]) -> Mat<f64> {
        let mut x = Mat::zeros(columns.len(), path.rows);
        for (j, &column) in columns.iter().enumerate() {
            x[(j, path.row(column))] = 1.0;
        }
        let most = path.steps.iter().map(|s| s.below.len()).max();
        let mut beside = Mat::zeros(columns.len(), most.unwrap_or(0));
        let loaded = above(self.supernodes(), columns);
        for step in path.steps.iter().filter(|s| loaded.contains(&s.supernode)) {
            self.step_up(
                step,
                x.as_mut(),
                beside.as_mut().subcols_mut(0, step.below.len()),
            );
        }
        for step in path.steps.iter().rev() {
            self.step_down(
                step,
                x.as_mut(),
                beside.as_mut().subcols_mut(0, step.below.len()),
            );
        }
        x
    }

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

    fn step_down(&self, step: &Step, x: MatMut<f64>, mut beside: MatMut<f64>) {
        let (diagonal, below) = self.blocks(step);
        for (i, &row) in step.below.iter().enumerate() {
            let above = x.as_ref().col(row as usize);
            beside.as_mut().col_mut(i).copy_from(above);
        }
        let mut own = x.subcols_mut(step.first_row, step.width);
        matmul(
            own.as_mut(),
            Accum::Add,
            beside.as_ref(),
            below,
            -1.0,
            Par::Seq,
        );
        solve_upper_triangular_in_place(diagonal.transpose(), own.transpose_mut(), Par::Seq);
    }
}
