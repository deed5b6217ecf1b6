//! T K Tᵀ: the rotation of the dofs of some nodes to axes of their own.

use super::LowerMatrix;
use faer::sparse::SymbolicSparseColMatRef;
use std::collections::BTreeMap;
use std::ops::Range;

impl LowerMatrix {
    /// T K Tᵀ, T the rotation of the dofs of some nodes to their own axes: cosine and sine of the angle.
    pub fn turn(&mut self, axes: &BTreeMap<usize, [f64; 2]>) {
        if axes.is_empty() {
            return;
        }
        let (symbolic, values) = self.parts_mut();
        turn_rows(symbolic, values, axes);
        axes.iter()
            .for_each(|(&node, &own)| turn_columns(symbolic, values, node, own));
    }
}

/// A pair of components along axes with the cosine c and the sine s.
fn turned([c, s]: [f64; 2], x: f64, y: f64) -> [f64; 2] {
    [c * x + s * y, c * y - s * x]
}

/// The range of a column's entries.
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

/// Turns both columns of a node of a lower triangle, after its rows: in the first column they are turned,
/// above the diagonal of the second nothing is stored.
fn turn_columns(
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
