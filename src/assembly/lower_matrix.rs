//! K where it is symmetric: its lower triangle, and products with it.

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
}

/// Mean of the diagonal: the scale of a stiffness matrix.
pub fn mean_diagonal(matrix: &LowerMatrix) -> f64 {
    let n = matrix.ncols();
    // The lower triangle's columns start at their diagonal.
    (0..n).map(|j| matrix.val_of_col(j)[0]).sum::<f64>() / n as f64
}
