//! Small dense systems: LU with partial pivoting.

use crate::linear_solver::tiles;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::solve;
use faer::linalg::triangular_solve::solve_upper_triangular_in_place;
use faer::perm::PermRef;
use faer::{Conj, Mat, MatMut, Par};

/// A = P⁻¹ L U.
pub struct Lu {
    factors: Mat<f64>,
    /// The permutation of the rows and its inverse.
    rows: [Vec<u32>; 2],
}

impl Lu {
    /// # Errors
    /// x with A x = 0 where a pivot is below `least` times the largest, or not a number.
    pub fn new(mut matrix: Mat<f64>, least: f64) -> Result<Lu, Vec<f64>> {
        let n = matrix.nrows();
        let mut memory = MemBuffer::new(tiles::lu_scratch(n));
        let forward = tiles::lu(matrix.as_mut(), MemStack::new(&mut memory));
        let mut inverse = vec![0; n];
        (0..)
            .zip(&forward)
            .for_each(|(k, &row)| inverse[row as usize] = k);
        let rows = [forward, inverse];
        let pivots = || (0..n).map(|k| matrix[(k, k)].abs());
        let largest = pivots().fold(0.0, f64::max);
        // Also what is not a number is no pivot.
        let is_pivot = |pivot: f64| pivot > least * largest;
        match pivots().position(|pivot| !is_pivot(pivot)) {
            Some(k) => Err(null_vector(&matrix, k)),
            None => Ok(Lu {
                factors: matrix,
                rows,
            }),
        }
    }

    pub fn size(&self) -> usize {
        self.factors.nrows()
    }

    /// Overwrites b by A⁻¹ b.
    pub fn solve_in_place(&self, rhs: &mut [f64]) {
        let n = rhs.len();
        self.solve_many_in_place(MatMut::from_column_major_slice_mut(rhs, n, 1));
    }

    /// The same for every column.
    pub fn solve_many_in_place(&self, rhs: MatMut<f64>) {
        let n = self.size();
        let [forward, inverse] = &self.rows;
        let scratch = solve::solve_in_place_scratch::<u32, f64>(n, rhs.ncols(), Par::Seq);
        solve::solve_in_place_with_conj(
            self.factors.as_ref(),
            self.factors.as_ref(),
            PermRef::new_checked(forward, inverse, n),
            Conj::No,
            rhs,
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
        );
    }
}

/// x with U x = 0 where the pivot of column k is the first that vanishes.
fn null_vector(factors: &Mat<f64>, k: usize) -> Vec<f64> {
    let mut x = vec![0.0; factors.nrows()];
    for (i, x) in x[..k].iter_mut().enumerate() {
        *x = -factors[(i, k)];
    }
    let head = MatMut::from_column_major_slice_mut(&mut x[..k], k, 1);
    solve_upper_triangular_in_place(factors.submatrix(0, 0, k, k), head, Par::Seq);
    x[k] = 1.0;
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 40 × 40 with entries of order one; the last column is made the sum of the first two for the second.
    #[test]
    fn solves_and_finds_what_a_singular_matrix_lets_go() {
        let n = 40;
        let entry = |i: usize, j: usize| ((7 * i + 3 * j * j + i * j) as f64).sin();
        let matrix = Mat::from_fn(n, n, entry);
        let expected: Vec<f64> = (0..n).map(|k| (k as f64).cos()).collect();
        let product = |x: &[f64]| -> Vec<f64> {
            (0..n)
                .map(|i| (0..n).map(|j| entry(i, j) * x[j]).sum())
                .collect()
        };
        let mut x = product(&expected);
        let regular = Lu::new(matrix.clone(), 1e-12);
        let Ok(lu) = regular else {
            panic!("regular");
        };
        lu.solve_in_place(&mut x);
        // Rounding times a condition of some hundreds.
        assert!(x.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-11));
        let mut singular = matrix;
        for i in 0..n {
            singular[(i, n - 1)] = entry(i, 0) + entry(i, 1);
        }
        let x = Lu::new(singular, 1e-12).err().expect("singular");
        let of = |k: usize| x[k] / x[n - 1];
        assert!((of(0) + 1.0).abs() < 1e-10 && (of(1) + 1.0).abs() < 1e-10);
        assert!((2..n - 1).all(|k| of(k).abs() < 1e-10));
    }
}
