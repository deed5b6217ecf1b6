//! K in either form: symmetric, of which the lower triangle is stored, or full.

use super::full::FullMatrix;
use super::parts::column_parts;
use super::{LowerMatrix, mean_diagonal};
use faer::sparse::SymbolicSparseColMatRef;
use rayon::prelude::*;
use std::collections::BTreeMap;
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

    /// T K Tᵀ, T the rotation of the dofs of some nodes to their own axes: cosine and sine of the angle.
    pub fn turn(&mut self, axes: &BTreeMap<usize, [f64; 2]>) {
        if axes.is_empty() {
            return;
        }
        match self {
            Stiffness::Symmetric(lower) => {
                let (symbolic, values) = lower.parts_mut();
                turn_rows(symbolic, values, axes);
                axes.iter()
                    .for_each(|(&node, &own)| turn_lower_columns(symbolic, values, node, own));
            }
            Stiffness::Full(full) => {
                let (symbolic, values) = full.parts_mut();
                turn_rows(symbolic, values, axes);
                axes.iter()
                    .for_each(|(&node, &own)| turn_columns(symbolic, values, node, own));
            }
        }
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

/// A pair of components along axes with the cosine c and the sine s.
fn turned([c, s]: [f64; 2], x: f64, y: f64) -> [f64; 2] {
    [c * x + s * y, c * y - s * x]
}

/// Where a column's entries are.
fn range(symbolic: SymbolicSparseColMatRef<'_, u32>, column: usize) -> Range<usize> {
    symbolic.col_ptr()[column] as usize..symbolic.col_ptr()[column + 1] as usize
}

/// Turns both rows of each node, in all columns that store them both.
fn turn_rows(
    symbolic: SymbolicSparseColMatRef<'_, u32>,
    values: &mut [f64],
    axes: &BTreeMap<usize, [f64; 2]>,
) {
    let mut own = vec![None; symbolic.ncols() / 2];
    axes.iter()
        .for_each(|(&node, &axes)| own[node] = Some(axes));
    for column in 0..symbolic.ncols() {
        let rows = symbolic.row_idx_of_col_raw(column);
        let values = &mut values[range(symbolic, column)];
        for k in 1..rows.len() {
            let row = rows[k] as usize;
            if row % 2 == 1
                && rows[k - 1] as usize + 1 == row
                && let Some(own) = own[row / 2]
            {
                [values[k - 1], values[k]] = turned(own, values[k - 1], values[k]);
            }
        }
    }
}

/// Turns both columns of a node.
fn turn_columns(
    symbolic: SymbolicSparseColMatRef<'_, u32>,
    values: &mut [f64],
    node: usize,
    own: [f64; 2],
) {
    let [first, second] = [0, 1].map(|axis| range(symbolic, 2 * node + axis));
    for (i, j) in first.zip(second) {
        [values[i], values[j]] = turned(own, values[i], values[j]);
    }
}

/// Turns both columns of a node of a lower triangle, after its rows: in the first column they are turned,
/// above the diagonal of the second nothing is stored.
fn turn_lower_columns(
    symbolic: SymbolicSparseColMatRef<'_, u32>,
    values: &mut [f64],
    node: usize,
    own: [f64; 2],
) {
    let [first, second] = [0, 1].map(|axis| range(symbolic, 2 * node + axis));
    let (a, b) = (first.start, first.start + 1);
    // The block D as it was: its first column R D e_1 turned back, its last entry untouched.
    let [c, s] = own;
    let [xx, xy] = turned([c, -s], values[a], values[b]);
    let yy = values[second.start];
    let [p, q] = [turned(own, xx, xy), turned(own, xy, yy)];
    // R D Rᵀ, whose rows are those of R D turned.
    let [first_row, second_row] = [turned(own, p[0], q[0]), turned(own, p[1], q[1])];
    values[a] = first_row[0];
    values[b] = second_row[0];
    values[second.start] = second_row[1];
    for (i, j) in (a + 2..first.end).zip(second.start + 1..second.end) {
        [values[i], values[j]] = turned(own, values[i], values[j]);
    }
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
