//! K where it is symmetric: its lower triangle, and products with it.

use super::Lists;
use super::parts::column_parts;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Lower triangle of a symmetric matrix, columns sorted; all matrices of one pattern share it.
#[derive(Clone, Debug)]
pub struct LowerMatrix {
    symbolic: Arc<SymbolicSparseColMat<u32>>,
    values: Arc<Vec<f64>>,
}

impl LowerMatrix {
    /// `values`: in the order of the pattern's rows.
    pub fn new(symbolic: Arc<SymbolicSparseColMat<u32>>, values: Vec<f64>) -> LowerMatrix {
        assert_eq!(symbolic.row_idx().len(), values.len());
        LowerMatrix {
            symbolic,
            values: Arc::new(values),
        }
    }

    pub fn ncols(&self) -> usize {
        self.symbolic.ncols()
    }

    pub fn as_ref(&self) -> SparseColMatRef<'_, u32, f64> {
        SparseColMatRef::new(SymbolicSparseColMat::as_ref(&self.symbolic), &self.values)
    }

    pub fn row_idx_of_col_raw(&self, column: usize) -> &[u32] {
        self.symbolic.row_idx_of_col_raw(column)
    }

    /// All stored values.
    pub fn val(&self) -> &[f64] {
        &self.values
    }

    pub fn val_of_col(&self, column: usize) -> &[f64] {
        &self.values[self.symbolic.col_range(column)]
    }

    /// The pattern, and the values to change.
    pub fn parts_mut(&mut self) -> (SymbolicSparseColMatRef<'_, u32>, &mut [f64]) {
        (
            SymbolicSparseColMat::as_ref(&self.symbolic),
            Arc::<Vec<f64>>::make_mut(&mut self.values),
        )
    }

    /// The matrix, the part above the diagonal included, times u. What a part of the columns adds is
    /// summed apart: the bits do not depend on the number of threads.
    pub fn multiply(&self, u: &[f64]) -> Vec<f64> {
        let of_part = |columns: Range<usize>| {
            let first = columns.start;
            let mut product = vec![0.0; self.last_row(&columns) - first];
            for column in columns {
                let rows = self.row_idx_of_col_raw(column).iter();
                let mut entries = rows.zip(self.val_of_col(column));
                // The lower triangle's columns start at their diagonal.
                let diagonal = entries.next().map_or(0.0, |(_, &value)| value);
                let mut sum = diagonal * u[column];
                for (&row, &value) in entries {
                    let row = row as usize;
                    sum += value * u[row];
                    product[row - first] += value * u[column];
                }
                product[column - first] += sum;
            }
            (first, product)
        };
        let parts: Vec<(usize, Vec<f64>)> = column_parts(self.ncols()).map(of_part).collect();
        let mut product = vec![0.0; u.len()];
        for (first, part) in parts {
            let rows = product[first..].iter_mut().zip(part);
            rows.for_each(|(sum, share)| *sum += share);
        }
        product
    }

    /// One past the last row in some columns; no less than one past the last of them.
    fn last_row(&self, columns: &Range<usize>) -> usize {
        // The rows of a column are sorted.
        let last = |column| self.row_idx_of_col_raw(column).last();
        let last = columns.clone().filter_map(last).max();
        last.map_or(0, |&row| row as usize + 1).max(columns.end)
    }

    /// The entry at (i, j) with i ≥ j, if it is stored.
    pub fn get(&self, i: usize, j: usize) -> Option<&f64> {
        let place = self.row_idx_of_col_raw(j).binary_search(&(i as u32));
        place.ok().map(|place| &self.val_of_col(j)[place])
    }

    /// ‖K‖∞, the largest sum of magnitudes in a row.
    pub fn infinity_norm(&self) -> f64 {
        let mut sums = vec![0.0; self.ncols()];
        for column in 0..self.ncols() {
            let entries = self.row_idx_of_col_raw(column).iter();
            for (&row, value) in entries.zip(self.val_of_col(column)) {
                sums[column] += value.abs();
                if row as usize != column {
                    sums[row as usize] += value.abs();
                }
            }
        }
        sums.into_iter().fold(0.0, f64::max)
    }

    /// Mean of the diagonal: the scale of a stiffness matrix.
    pub fn mean_diagonal(&self) -> f64 {
        let n = self.ncols();
        // The lower triangle's columns start at their diagonal.
        (0..n).map(|j| self.val_of_col(j)[0]).sum::<f64>() / n as f64
    }

    /// A copy with the rows and columns of held dofs cleared and one number on their diagonal.
    pub fn hold(&self, is_held: &[bool], diagonal: f64) -> LowerMatrix {
        let mut held = self.clone();
        let (symbolic, values) = held.parts_mut();
        for column in 0..symbolic.ncols() {
            let rows = symbolic.row_idx_of_col_raw(column);
            let entries = rows.iter().zip(&mut values[symbolic.col_range(column)]);
            for (&row, value) in entries {
                let row = row as usize;
                if is_held[column] || is_held[row] {
                    *value = if row == column { diagonal } else { 0.0 };
                }
            }
        }
        held
    }
}

/// The pattern of a symmetric matrix with `B` unknowns for each node of a graph, lower triangle: of the columns of
/// a node, the triangle of its own block, then the blocks of its higher neighbours.
pub fn lower_pattern<const B: usize>(graph: &Lists) -> SymbolicSparseColMat<u32> {
    let n = graph.len();
    let mut start = Vec::with_capacity(B * n + 1);
    start.push(0);
    let mut next = 0;
    for node in 0..n {
        let below = (B * above_diagonal(graph, node).len()) as u32;
        for own in (1..=B as u32).rev() {
            next += own + below;
            start.push(next);
        }
    }
    let mut rows = vec![0; next as usize];
    let mut rest = rows.as_mut_slice();
    let columns = (0..n).map(|node| {
        let length = (start[B * (node + 1)] - start[B * node]) as usize;
        let (columns, after) = std::mem::take(&mut rest).split_at_mut(length);
        rest = after;
        columns
    });
    let columns: Vec<&mut [u32]> = columns.collect();
    let fill = |(node, rows): (usize, &mut [u32])| {
        let mut rows = rows.iter_mut();
        let mut push = |row| *rows.next().expect("rows are counted") = row;
        let unknowns = |node: u32| B as u32 * node..B as u32 * (node + 1);
        let own = unknowns(node as u32);
        for first in own.clone() {
            (first..own.end).for_each(&mut push);
            for &neighbour in above_diagonal(graph, node) {
                unknowns(neighbour).for_each(&mut push);
            }
        }
    };
    let columns = columns.into_par_iter().enumerate();
    columns.with_min_len(64).for_each(fill);
    SymbolicSparseColMat::new_checked(B * n, B * n, start, None, rows)
}

/// The neighbours of a node with a larger number.
pub fn above_diagonal(graph: &Lists, node: usize) -> &[u32] {
    let neighbours = graph.of(node);
    &neighbours[neighbours.partition_point(|&n| (n as usize) < node)..]
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::sparse::{SparseColMat, Triplet};

    /// [[4, 1, 0], [1, 3, 2], [0, 2, 5]].
    #[test]
    fn a_matrix_multiplies_with_its_upper_triangle_and_with_a_dof_held() {
        let entries = [
            (0, 0, 4.0),
            (1, 0, 1.0),
            (1, 1, 3.0),
            (2, 1, 2.0),
            (2, 2, 5.0),
        ];
        let entries = entries.map(|(i, j, value)| Triplet::new(i, j, value));
        let matrix = SparseColMat::try_new_from_triplets(3, 3, &entries).expect("a matrix");
        let (symbolic, values) = matrix.into_parts();
        let matrix = LowerMatrix::new(Arc::new(symbolic), values);
        assert_eq!(matrix.mean_diagonal(), 4.0);
        assert_eq!(matrix.multiply(&[1.0, 2.0, 3.0]), [6.0, 13.0, 19.0]);
        let held = matrix.hold(&[false, true, false], matrix.mean_diagonal());
        assert_eq!(held.multiply(&[1.0, 2.0, 3.0]), [4.0, 8.0, 15.0]);
    }
}
