//! Sparse LU factorisation with partial pivoting by faer, for a K that is not symmetric and for which
//! [`super::lu`] has found no good pivots.
//!
//! Columns are ordered by the nested dissection of K + Kᵀ, as for Cholesky: nearly all pivots stay on
//! or near the diagonal, since most of K is symmetric and positive.
//!
//! LU divides by what it finds: on a singular K it reports success, with huge numbers or infinities
//! behind it. So every factor is probed: K x = b for a fixed pseudo-random b. If K is singular, x is
//! beyond all measure, and is its null vector, as in inverse iteration.

use super::SolverError;
use super::ordering::dof_permutation;
use crate::assembly::full::{FullMatrix, mean_diagonal};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::perm::{Perm, PermRef};
use faer::sparse::linalg::lu::supernodal::{
    SupernodalLu, SymbolicSupernodalLu, factorize_supernodal_numeric_lu,
    factorize_supernodal_numeric_lu_scratch, factorize_supernodal_symbolic_lu,
    factorize_supernodal_symbolic_lu_scratch,
};
use faer::sparse::linalg::qr::{col_etree, column_counts_ata, postorder};
use faer::sparse::{SymbolicSparseColMat, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par};
use std::sync::Arc;

/// ‖K⁻¹‖ times the mean diagonal of K, as far as the probe sees it; a singular K has 1e15 and more. A
/// body that is held has less: beam theory gives some 1e10 for a cantilever a thousand times as
/// long as deep.
pub(super) const MOST_GROWTH: f64 = 1e13;

/// Share of the mean diagonal that is added where LU has found an infinity, so that there is a vector to
/// look at.
const SHIFT: f64 = 1e-14;

/// The structure of the factors, from the pattern of K alone.
#[derive(Clone, Debug)]
pub struct Symbolic {
    order: Perm<u32>,
    structure: Arc<SymbolicSupernodalLu<u32>>,
}

impl Symbolic {
    /// `order`: the nodes as their columns are eliminated.
    ///
    /// # Errors
    /// [`SolverError::OutOfMemory`].
    pub fn new(
        pattern: SymbolicSparseColMatRef<'_, u32>,
        order: &[u32],
    ) -> Result<Symbolic, SolverError> {
        let n = pattern.ncols();
        let out_of_memory = || SolverError::OutOfMemory { dofs: n };
        // Generous: the analyses want at most so many vectors of indices, one at a time.
        let scratch = StackReq::all_of(&[
            StackReq::new::<u32>(n + 1).array(16),
            factorize_supernodal_symbolic_lu_scratch::<u32>(n, n),
        ]);
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| out_of_memory())?;
        let stack = MemStack::new(&mut memory);
        let order = postordered(pattern, dof_permutation(order), stack);
        let mut parents = vec![0; n];
        let tree = col_etree(pattern, Some(order.as_ref()), &mut parents, stack);
        let mut post = vec![0; n];
        postorder(&mut post, tree, stack);
        let rows = transposed(pattern);
        let (mut counts, mut first_column) = (vec![0; n], vec![0; n]);
        column_counts_ata(
            &mut counts,
            &mut first_column,
            rows.as_ref(),
            Some(order.as_ref()),
            tree,
            &post,
            stack,
        );
        let structure = factorize_supernodal_symbolic_lu(
            pattern,
            Some(order.as_ref()),
            &first_column,
            tree,
            &counts,
            stack,
            Default::default(),
        );
        Ok(Symbolic {
            order,
            structure: Arc::new(structure.map_err(|_| out_of_memory())?),
        })
    }

    /// The factors of a matrix with this pattern, on one thread.
    ///
    /// # Errors
    /// [`SolverError::Singular`], [`SolverError::OutOfMemory`].
    pub fn factorise(&self, matrix: &FullMatrix) -> Result<Factor, SolverError> {
        let factor = self.numeric(matrix)?;
        let Some(growth) = factor.probe(matrix) else {
            return Ok(factor);
        };
        let dof = match largest(&growth) {
            Some(dof) => dof,
            None => {
                let shifted = self.numeric(&with_shift(matrix))?;
                let growth = shifted.solved_probe(matrix.ncols());
                largest(&growth).unwrap_or(0)
            }
        };
        Err(SolverError::Singular { dof })
    }

    fn numeric(&self, matrix: &FullMatrix) -> Result<Factor, SolverError> {
        let n = matrix.ncols();
        let out_of_memory = || SolverError::OutOfMemory { dofs: n };
        let transpose = matrix
            .transpose()
            .to_col_major()
            .map_err(|_| out_of_memory())?;
        let params = Default::default();
        let scratch = factorize_supernodal_numeric_lu_scratch::<u32, f64>(&self.structure, params);
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| out_of_memory())?;
        let mut factor = Factor {
            order: self.order.clone(),
            rows: [vec![0; n], vec![0; n]],
            lu: SupernodalLu::new(),
        };
        let [forward, inverse] = &mut factor.rows;
        factorize_supernodal_numeric_lu(
            forward,
            inverse,
            &mut factor.lu,
            matrix.as_ref(),
            transpose.as_ref(),
            self.order.as_ref(),
            &self.structure,
            Par::Seq,
            MemStack::new(&mut memory),
            params,
        )
        .map_err(|_| out_of_memory())?;
        Ok(factor)
    }
}

/// L and U.
#[derive(Clone, Debug)]
pub struct Factor {
    order: Perm<u32>,
    /// The permutation of the rows and its inverse.
    rows: [Vec<u32>; 2],
    lu: SupernodalLu<u32, f64>,
}

impl Factor {
    /// Overwrites `rhs` by K⁻¹ rhs.
    pub fn solve_in_place(&self, rhs: &mut [f64]) {
        let n = rhs.len();
        let mut memory = MemBuffer::new(StackReq::new::<f64>(n).array(4));
        let [forward, inverse] = &self.rows;
        self.lu.solve_in_place_with_conj(
            PermRef::new_checked(forward, inverse, n),
            self.order.as_ref(),
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, n, 1),
            Par::Seq,
            MemStack::new(&mut memory),
        );
    }

    /// K⁻¹ b where it is too large for a K that can be inverted.
    fn probe(&self, matrix: &FullMatrix) -> Option<Vec<f64>> {
        let n = matrix.ncols();
        let x = self.solved_probe(n);
        let growth = norm(&x) / norm(&random(n)) * mean_diagonal(matrix);
        // False for what is not a number.
        let sound = growth < MOST_GROWTH;
        (!sound).then_some(x)
    }

    fn solved_probe(&self, n: usize) -> Vec<f64> {
        let mut x = random(n);
        self.solve_in_place(&mut x);
        x
    }
}

fn with_shift(matrix: &FullMatrix) -> FullMatrix {
    let shift = SHIFT * mean_diagonal(matrix);
    let mut shifted = matrix.clone();
    for j in 0..matrix.ncols() {
        if let Some(entry) = shifted.get_mut(j, j) {
            *entry += shift;
        }
    }
    shifted
}

/// The place of the largest number; `None` if there is one that is not finite.
fn largest(x: &[f64]) -> Option<usize> {
    if x.iter().any(|x| !x.is_finite()) {
        return None;
    }
    (0..x.len()).max_by(|&a, &b| x[a].abs().total_cmp(&x[b].abs()))
}

pub(super) fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Numbers between −1 and 1, always the same (Knuth's linear congruential generator).
pub(super) fn random(n: usize) -> Vec<f64> {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..n).map(|_| next()).collect()
}

/// The same order, children before parents of the column elimination tree and each subtree in one
/// piece, so that supernodes become as large as they can be.
fn postordered(
    pattern: SymbolicSparseColMatRef<'_, u32>,
    order: Perm<u32>,
    stack: &mut MemStack,
) -> Perm<u32> {
    let n = pattern.ncols();
    let mut parents = vec![0; n];
    let tree = col_etree(pattern, Some(order.as_ref()), &mut parents, stack);
    let mut post = vec![0; n];
    postorder(&mut post, tree, stack);
    let (forward, _) = order.arrays();
    let forward: Vec<u32> = post.iter().map(|&k| forward[k as usize]).collect();
    let mut inverse = vec![0; n];
    for (new, &old) in forward.iter().enumerate() {
        inverse[old as usize] = new as u32;
    }
    Perm::new_checked(forward.into(), inverse.into(), n)
}

fn transposed(pattern: SymbolicSparseColMatRef<'_, u32>) -> SymbolicSparseColMat<u32> {
    let n = pattern.ncols();
    let mut start = vec![0_u32; n + 1];
    for &row in pattern.row_idx() {
        start[row as usize + 1] += 1;
    }
    for k in 0..n {
        start[k + 1] += start[k];
    }
    let mut next = start.clone();
    let mut columns = vec![0_u32; pattern.row_idx().len()];
    for column in 0..n {
        for &row in pattern.row_idx_of_col_raw(column) {
            columns[next[row as usize] as usize] = column as u32;
            next[row as usize] += 1;
        }
    }
    SymbolicSparseColMat::new_checked(n, n, start, None, columns)
}
