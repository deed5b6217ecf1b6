//! Factors of dense matrices, a panel of columns after the other, in tiles that are shared out to the threads:
//!
//! ```text
//! L11 L11ᵀ = A11,                  L21 = A21 L11⁻ᵀ,             A22 ← A22 − L21 L21ᵀ
//! P [L11; L21] U11 = [A11; A21],   U12 = L11⁻¹ (P A)12,         A22 ← (P A)22 − L21 U12
//! ```
//!
//! The tiles are the same on any number of threads, and each is one thread's: so are the bits.

use super::policy::{PANEL, TILE_ROWS};
use faer::dyn_stack::{MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::{LltError, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place,
};
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

/// Memory that [`cholesky`] works in, for so many columns.
pub fn cholesky_scratch(columns: usize) -> StackReq {
    cholesky_in_place_scratch::<f64>(columns.min(PANEL), Par::Seq, Default::default())
}

/// L of the first columns of a symmetric matrix, in place of its lower triangle there.
///
/// # Errors
/// The column of a pivot that is not positive.
pub fn cholesky(mut front: MatMut<f64>, memory: &mut MemStack) -> Result<(), usize> {
    let (height, width) = (front.nrows(), front.ncols());
    for first in (0..width).step_by(PANEL) {
        let columns = PANEL.min(width - first);
        let rest = (front.as_mut()).submatrix_mut(first, first, height - first, width - first);
        let (panel, right) = rest.split_at_col_mut(columns);
        let (mut own, mut below) = panel.split_at_row_mut(columns);
        let params = Default::default();
        cholesky_in_place(own.as_mut(), params, Par::Seq, memory, Default::default())
            .map_err(|LltError::NonPositivePivot { index }| first + index)?;
        solve_rows(own.as_ref(), below.as_mut());
        let (_, right) = right.split_at_row_mut(columns);
        let (below, right) = (below.as_ref(), right.par_col_chunks_mut(PANEL));
        let columns = right.enumerate();
        columns.for_each(|(k, c)| {
            let first = k * PANEL;
            subtract_square(c.split_at_row_mut(first).1, first, below, Accum::Add);
        });
    }
    Ok(())
}

/// B ← B L⁻ᵀ.
pub fn solve_rows(l: MatRef<f64>, b: MatMut<f64>) {
    let rows = b.par_row_chunks_mut(TILE_ROWS);
    rows.for_each(|b| solve_lower_triangular_in_place(l, b.transpose_mut(), Par::Seq));
}

/// The lower triangle of C − A Aᵀ, or of −A Aᵀ, in some columns of it, from the row and the column `first` on.
pub fn subtract_square(c: MatMut<f64>, first: usize, a: MatRef<f64>, accum: Accum) {
    let a = a.subrows(first, a.nrows() - first);
    let (own, below) = a.split_at_row(c.ncols());
    let (diagonal, c) = c.split_at_row_mut(own.nrows());
    triangular::matmul(
        diagonal,
        BlockStructure::TriangularLower,
        accum,
        own,
        BlockStructure::Rectangular,
        own.transpose(),
        BlockStructure::Rectangular,
        -1.0,
        Par::Seq,
    );
    subtract_product(c, below, own.transpose(), accum);
}

/// C − A B, or −A B.
pub fn subtract_product(c: MatMut<f64>, a: MatRef<f64>, b: MatRef<f64>, accum: Accum) {
    let tiles = c.par_row_chunks_mut(TILE_ROWS).enumerate();
    tiles.for_each(|(k, c)| {
        let a = a.subrows(k * TILE_ROWS, c.nrows());
        matmul(c, accum, a, b, -1.0, Par::Seq);
    });
}

/// Memory that [`lu`] works in, for so many columns.
pub fn lu_scratch(columns: usize) -> StackReq {
    lu_in_place_scratch::<u32, f64>(columns, columns.min(PANEL), Par::Seq, Default::default())
}

/// L, with ones on its diagonal, and U of a square matrix, in its place, and which row of the matrix stands at
/// each place: the largest entry of a column is its pivot.
pub fn lu(mut matrix: MatMut<f64>, memory: &mut MemStack) -> Vec<u32> {
    let size = matrix.nrows();
    let mut order: Vec<u32> = (0..size as u32).collect();
    for first in (0..size).step_by(PANEL) {
        let columns = PANEL.min(size - first);
        let (_, rest) = matrix.as_mut().split_at_row_mut(first);
        let (left, rest) = rest.split_at_col_mut(first);
        let (mut panel, right) = rest.split_at_col_mut(columns);
        let mut places = [vec![0_u32; size - first], vec![0_u32; size - first]];
        let [forward, inverse] = &mut places;
        let params = Default::default();
        lu_in_place(panel.as_mut(), forward, inverse, Par::Seq, memory, params);
        let moved: Vec<[usize; 2]> = (forward.iter().enumerate())
            .map(|(to, &from)| [to, from as usize])
            .filter(|[to, from]| to != from)
            .collect();
        let before = order[first..].to_vec();
        moved
            .iter()
            .for_each(|&[to, from]| order[first + to] = before[from]);
        let left = left.par_col_chunks_mut(PANEL);
        left.for_each(|columns| permute(columns, &moved));
        let (own, below) = panel.as_ref().split_at_row(columns);
        let right = right.par_col_chunks_mut(PANEL);
        right.for_each(|mut right| {
            permute(right.as_mut(), &moved);
            let (mut top, rest) = right.split_at_row_mut(columns);
            solve_unit_lower_triangular_in_place(own, top.as_mut(), Par::Seq);
            subtract_product(rest, below, top.as_ref(), Accum::Add);
        });
    }
    order
}

/// Puts some rows to their places: to, from.
fn permute(columns: MatMut<f64>, moved: &[[usize; 2]]) {
    let mut before = vec![0.0; moved.len()];
    for mut column in columns.col_iter_mut() {
        let pairs = before.iter_mut().zip(moved);
        pairs.for_each(|(before, &[_, from])| *before = column[from]);
        let pairs = before.iter().zip(moved);
        pairs.for_each(|(before, &[to, _])| column[to] = *before);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;
    use faer::dyn_stack::MemBuffer;

    /// Sums of a few hundred products of order one.
    const ROUNDING: f64 = 1e-12;

    fn entry(i: usize, j: usize) -> f64 {
        ((7 * i + 3 * j * j + i * j) as f64).sin()
    }

    /// Several panels, and tiles of a panel, with a rest each.
    #[test]
    fn fronts_are_the_products_of_their_factors() {
        let (width, rows) = (150, 330);
        let height = width + rows;
        let strong = |i: usize, j: usize| match i == j {
            true => 2.0 * height as f64,
            false => entry(i.max(j), i.min(j)),
        };
        let mut front = Mat::from_fn(height, width, strong);
        let mut memory = MemBuffer::new(cholesky_scratch(width));
        cholesky(front.as_mut(), MemStack::new(&mut memory)).expect("it is positive");
        let mut passed = Mat::from_fn(rows, rows, |i, j| strong(width + i, width + j));
        let columns = passed.par_col_chunks_mut(PANEL).enumerate();
        let below = front.subrows(width, rows);
        columns.for_each(|(k, c)| {
            let first = k * PANEL;
            subtract_square(c.split_at_row_mut(first).1, first, below, Accum::Add);
        });
        for j in 0..height {
            for i in j..height {
                let common = 0..width.min(j + 1);
                let product: f64 = common.map(|k| front[(i, k)] * front[(j, k)]).sum();
                let rest = if j < width {
                    0.0
                } else {
                    passed[(i - width, j - width)]
                };
                let error = product + rest - strong(i, j);
                assert!(error.abs() < ROUNDING, "({i}, {j}): {error:e}");
            }
        }
    }

    #[test]
    fn the_first_pivot_that_is_not_positive_is_told() {
        let mut matrix = Mat::from_fn(200, 200, |i, j| f64::from(u8::from(i == j)));
        matrix[(130, 130)] = -1.0;
        matrix[(170, 170)] = -1.0;
        let mut memory = MemBuffer::new(cholesky_scratch(200));
        let found = cholesky(matrix.as_mut(), MemStack::new(&mut memory));
        assert_eq!(found, Err(130));
    }

    #[test]
    fn rows_of_a_matrix_are_the_products_of_its_factors() {
        let size = 210;
        let mut matrix = Mat::from_fn(size, size, entry);
        let mut memory = MemBuffer::new(lu_scratch(size));
        let order = lu(matrix.as_mut(), MemStack::new(&mut memory));
        for i in 0..size {
            for j in 0..size {
                let below = (0..i.min(j + 1)).map(|k| matrix[(i, k)] * matrix[(k, j)]);
                let own = if i <= j { matrix[(i, j)] } else { 0.0 };
                let error = below.sum::<f64>() + own - entry(order[i] as usize, j);
                assert!(error.abs() < ROUNDING, "({i}, {j}): {error:e}");
                // Partial pivoting.
                assert!(i <= j || matrix[(i, j)].abs() <= 1.0);
            }
        }
    }
}
