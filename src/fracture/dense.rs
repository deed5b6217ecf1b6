//! Small dense systems: LU with partial pivoting by faer.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::perm::PermRef;
use faer::{Conj, Mat, MatMut, Par};

/// Products are cut into so many parts, whatever the number of threads: the cuts decide the bits.
const PARTS: usize = 8;

/// Below this size one thread is faster.
const PARALLEL_SIZE: usize = 512;

/// A = P⁻¹ L U.
pub struct Lu {
    factors: Mat<f64>,
    /// The permutation of the rows and its inverse.
    rows: [Vec<usize>; 2],
}

impl Lu {
    /// `None` where a pivot is below `least` times the largest, or not a number.
    pub fn new(mut matrix: Mat<f64>, least: f64) -> Option<Lu> {
        let n = matrix.nrows();
        let par = match n < PARALLEL_SIZE {
            true => Par::Seq,
            false => Par::rayon(PARTS),
        };
        let mut rows = [vec![0; n], vec![0; n]];
        let [forward, inverse] = &mut rows;
        let scratch = factor::lu_in_place_scratch::<usize, f64>(n, n, par, Default::default());
        factor::lu_in_place(
            matrix.as_mut(),
            forward,
            inverse,
            par,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Default::default(),
        );
        let pivots = || (0..n).map(|k| matrix[(k, k)].abs());
        let largest = pivots().fold(0.0, f64::max);
        // Also what is not a number is no pivot.
        let is_pivot = |pivot: f64| pivot > least * largest;
        pivots().all(is_pivot).then_some(Lu {
            factors: matrix,
            rows,
        })
    }

    pub fn size(&self) -> usize {
        self.factors.nrows()
    }

    /// Overwrites every column b by A⁻¹ b.
    pub fn solve_many_in_place(&self, rhs: MatMut<f64>) {
        let n = self.size();
        let [forward, inverse] = &self.rows;
        let scratch = solve::solve_in_place_scratch::<usize, f64>(n, rhs.ncols(), Par::Seq);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// 40 × 40 with entries of order one; the last column is made the sum of the first two for the second.
    #[test]
    fn solves_and_refuses_a_singular_matrix() {
        let n = 40;
        let entry = |i: usize, j: usize| ((7 * i + 3 * j * j + i * j) as f64).sin();
        let matrix = Mat::from_fn(n, n, entry);
        let expected = Mat::from_fn(n, 2, |k, c| ((k + c) as f64).cos());
        let mut x = &matrix * &expected;
        let lu = Lu::new(matrix.clone(), 1e-12).expect("regular");
        lu.solve_many_in_place(x.as_mut());
        // Rounding times a condition of some hundreds.
        assert!((x - expected).norm_max() < 1e-11);
        let mut singular = matrix;
        for i in 0..n {
            singular[(i, n - 1)] = entry(i, 0) + entry(i, 1);
        }
        assert!(Lu::new(singular, 1e-12).is_none());
    }
}
