//! K in either form: symmetric, of which the lower triangle is stored, or full.

use super::full::FullMatrix;
use super::{LowerMatrix, column_parts, mean_diagonal};
use faer::sparse::SymbolicSparseColMatRef;
use rayon::prelude::*;
use std::ops::Range;

/// K [N/m].
#[derive(Clone, Debug)]
pub enum Stiffness {
    Symmetric(LowerMatrix),
    Full(FullMatrix),
}

impl Stiffness {
    pub fn dofs(&self) -> usize {
        match self {
            Stiffness::Symmetric(matrix) => matrix.ncols(),
            Stiffness::Full(matrix) => matrix.ncols(),
        }
    }

    /// Mean of the diagonal: the scale of K.
    pub fn mean_diagonal(&self) -> f64 {
        match self {
            Stiffness::Symmetric(lower) => mean_diagonal(lower),
            Stiffness::Full(full) => super::full::mean_diagonal(full),
        }
    }

    /// Clears the rows and columns of held dofs and puts the mean diagonal there, on the same pattern.
    pub fn hold(&self, is_held: &[bool]) -> Stiffness {
        let diagonal = self.mean_diagonal();
        let mut held = self.clone();
        let is_held = |dof: usize| is_held[dof];
        match &mut held {
            Stiffness::Symmetric(lower) => hold(lower.parts_mut(), is_held, diagonal),
            Stiffness::Full(full) => hold(full.parts_mut(), is_held, diagonal),
        }
        held
    }

    /// K u.
    pub fn multiply(&self, u: &[f64]) -> Vec<f64> {
        match self {
            Stiffness::Symmetric(lower) => lower.multiply(u),
            Stiffness::Full(full) => multiply_full(full, u),
        }
    }
}

/// Clears the rows and columns of held dofs and puts a number on their diagonal.
pub fn hold(
    (symbolic, values): (SymbolicSparseColMatRef<'_, u32>, &mut [f64]),
    is_held: impl Fn(usize) -> bool + Sync,
    diagonal: f64,
) {
    let mut rest = values;
    let mut part = |columns: Range<usize>| {
        let (start, end) = (
            symbolic.col_ptr()[columns.start],
            symbolic.col_ptr()[columns.end],
        );
        let (values, after) = std::mem::take(&mut rest).split_at_mut((end - start) as usize);
        rest = after;
        (columns, values)
    };
    let parts: Vec<Range<usize>> = column_parts(symbolic.ncols()).collect();
    let parts: Vec<_> = parts.into_iter().map(&mut part).collect();
    parts.into_par_iter().for_each(|(columns, mut values)| {
        for column in columns {
            let rows = symbolic.row_idx_of_col_raw(column);
            let (here, after) = values.split_at_mut(rows.len());
            values = after;
            for (&row, value) in rows.iter().zip(here) {
                if is_held(column) || is_held(row as usize) {
                    *value = if row as usize == column {
                        diagonal
                    } else {
                        0.0
                    };
                }
            }
        }
    });
}

fn multiply_full(matrix: &FullMatrix, u: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; u.len()];
    for (column, &u) in u.iter().enumerate() {
        let rows = matrix.row_idx_of_col_raw(column).iter();
        for (&row, &value) in rows.zip(matrix.val_of_col(column)) {
            product[row as usize] += value * u;
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::sparse::{SparseColMat, Triplet};

    /// [[4, 1, 0], [1, 3, 2], [0, 2, 5]] in both forms.
    #[test]
    fn both_forms_of_one_matrix_multiply_and_hold_alike() {
        let entries = [
            (0, 0, 4.0),
            (1, 0, 1.0),
            (1, 1, 3.0),
            (2, 1, 2.0),
            (2, 2, 5.0),
        ];
        let lower = entries.map(|(i, j, value)| Triplet::new(i, j, value));
        let upper = entries.iter().filter(|(i, j, _)| i != j);
        let upper = upper.map(|&(i, j, value)| Triplet::new(j, i, value));
        let full: Vec<_> = lower.into_iter().chain(upper).collect();
        let matrix = |t: &[Triplet<u32, u32, f64>]| {
            SparseColMat::try_new_from_triplets(3, 3, t).expect("a matrix")
        };
        let (symbolic, values) = matrix(&lower).into_parts();
        let symmetric = Stiffness::Symmetric(LowerMatrix::new(symbolic.into(), values));
        let full = Stiffness::Full(matrix(&full));
        assert_eq!(symmetric.mean_diagonal(), 4.0);
        for stiffness in [&symmetric, &full] {
            assert_eq!(stiffness.multiply(&[1.0, 2.0, 3.0]), [6.0, 13.0, 19.0]);
            let held = stiffness.hold(&[false, true, false]);
            assert_eq!(held.multiply(&[1.0, 2.0, 3.0]), [4.0, 8.0, 15.0]);
        }
    }
}
