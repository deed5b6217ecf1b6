//! Columns of dense matrices as slices.

use faer::{ColMut, ColRef, Mat};
use rayon::prelude::*;

/// # Panics
/// Panics where the matrix is not stored column by column, as a `Mat` is.
pub fn slice(column: ColRef<'_, f64>) -> &[f64] {
    let column = column.try_as_col_major();
    column.expect("stored by columns").as_slice()
}

/// # Panics
/// Panics where the matrix is not stored column by column.
pub fn slice_mut(column: ColMut<'_, f64>) -> &mut [f64] {
    let column = column.try_as_col_major_mut();
    column.expect("stored by columns").as_slice_mut()
}

/// The symmetric matrix with this upper triangle.
pub fn symmetric(upper: &Mat<f64>) -> Mat<f64> {
    let size = upper.nrows();
    let mut all = Mat::zeros(size, size);
    all.par_col_iter_mut().enumerate().for_each(|(j, column)| {
        let (above, below) = slice_mut(column).split_at_mut(j);
        above.copy_from_slice(&slice(upper.col(j))[..j]);
        let row = (j..size).map(|i| upper[(j, i)]);
        below.iter_mut().zip(row).for_each(|(to, from)| *to = from);
    });
    all
}

/// u += scale · a.
pub fn add(u: &mut [f64], scale: f64, a: &[f64]) {
    u.iter_mut().zip(a).for_each(|(u, a)| *u += scale * a);
}
