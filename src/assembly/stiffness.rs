//! K in either form: symmetric, of which the lower triangle is stored, or full.

use super::full::FullMatrix;
use super::{LowerMatrix, mean_diagonal};
use faer::sparse::SparseColMat;

/// K [N/m].
#[derive(Clone, Debug)]
pub enum Stiffness {
    Symmetric(LowerMatrix),
    Full(FullMatrix),
}

impl Stiffness {
    pub fn dofs(&self) -> usize {
        match self {
            Stiffness::Symmetric(matrix) | Stiffness::Full(matrix) => matrix.ncols(),
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
        match self {
            Stiffness::Symmetric(lower) => Stiffness::Symmetric(hold(lower, is_held, diagonal)),
            Stiffness::Full(full) => Stiffness::Full(hold(full, is_held, diagonal)),
        }
    }

    /// K u.
    pub fn multiply(&self, u: &[f64]) -> Vec<f64> {
        match self {
            Stiffness::Symmetric(lower) => multiply_symmetric(lower, u),
            Stiffness::Full(full) => multiply_full(full, u),
        }
    }
}

fn hold(
    matrix: &SparseColMat<u32, f64>,
    is_held: &[bool],
    diagonal: f64,
) -> SparseColMat<u32, f64> {
    let mut held = matrix.clone();
    let (symbolic, values) = held.parts_mut();
    for column in 0..symbolic.ncols() {
        let range = symbolic.col_range(column);
        let rows = &symbolic.row_idx()[range.clone()];
        for (&row, value) in rows.iter().zip(&mut values[range]) {
            if is_held[column] || is_held[row as usize] {
                *value = if row as usize == column {
                    diagonal
                } else {
                    0.0
                };
            }
        }
    }
    held
}

/// K u from the lower triangle of K.
fn multiply_symmetric(matrix: &LowerMatrix, u: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; u.len()];
    for column in 0..matrix.ncols() {
        let mut sum = 0.0;
        let rows = matrix.row_idx_of_col_raw(column).iter();
        for (&row, &value) in rows.zip(matrix.val_of_col(column)) {
            let row = row as usize;
            sum += value * u[row];
            if row != column {
                product[row] += value * u[column];
            }
        }
        product[column] += sum;
    }
    product
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
    use faer::sparse::Triplet;

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
        let symmetric = Stiffness::Symmetric(matrix(&lower));
        let full = Stiffness::Full(matrix(&full));
        assert_eq!(symmetric.mean_diagonal(), 4.0);
        for stiffness in [&symmetric, &full] {
            assert_eq!(stiffness.multiply(&[1.0, 2.0, 3.0]), [6.0, 13.0, 19.0]);
            let held = stiffness.hold(&[false, true, false]);
            assert_eq!(held.multiply(&[1.0, 2.0, 3.0]), [4.0, 8.0, 15.0]);
        }
    }
}
