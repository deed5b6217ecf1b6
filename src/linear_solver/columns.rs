//! Columns of dense matrices as slices.

use faer::{ColMut, ColRef};

/// # Panics
/// Panics where the matrix is not stored column by column, as a `Mat` is.
pub fn slice(column: ColRef<'_, f64>) -> &[f64] {
    let column = column.try_as_col_major();
    column.expect("stored by columns").as_slice()
}

/// # Panics
/// As [`slice`].
pub fn slice_mut(column: ColMut<'_, f64>) -> &mut [f64] {
    let column = column.try_as_col_major_mut();
    column.expect("stored by columns").as_slice_mut()
}

/// u += scale · a.
pub fn add(u: &mut [f64], scale: f64, a: &[f64]) {
    u.iter_mut().zip(a).for_each(|(u, a)| *u += scale * a);
}
