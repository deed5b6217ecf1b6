//! Sparse Cholesky factorisation K = L Lᵀ by faer: symbolic once, numeric as often as K changes.

use super::SolverError;
use super::ordering::{Ordering, dof_permutation, elimination_order};
use crate::assembly::{Lists, LowerMatrix};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::perm::Perm;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::{Conj, MatMut, Par, Side};
use std::sync::Arc;

/// Below this a second thread costs more than it brings (docs/performance.md).
const PARALLEL_FLOPS: f64 = 1e10;

/// Products of dense blocks are cut into this many parts, whatever the number of threads: the cuts
/// decide the order of sums, and so the bits. Measured on one and two threads, where it costs no more
/// than a few percent; threads past the eighth find no part of a product.
const PARTS: usize = 8;

/// The least pivot L_jj² over K_jj. A singular K leaves pivots of rounding size, some 1e-16, of either
/// sign. A body that is held has larger ones: beam theory gives some 1e-10 for a cantilever a thousand
/// times as long as deep, and they fall with the cube of that ratio.
const LEAST_PIVOT: f64 = 1e-13;

/// The structure of L, from the pattern of K alone.
#[derive(Clone, Debug)]
pub struct Symbolic {
    structure: Arc<SymbolicCholesky<u32>>,
}

impl Symbolic {
    /// # Errors
    /// See [`SolverError`].
    pub fn new(
        pattern: SymbolicSparseColMatRef<'_, u32>,
        graph: &Lists,
        ordering: Ordering,
    ) -> Result<Symbolic, SolverError> {
        let order = elimination_order(ordering, graph).map_err(|status| SolverError::Ordering {
            nodes: graph.len(),
            status,
        })?;
        Symbolic::with_order(pattern, order.as_deref())
    }

    /// `order`: the nodes as they are eliminated; `None` leaves it to faer's AMD.
    ///
    /// # Errors
    /// See [`SolverError`].
    pub fn with_order(
        pattern: SymbolicSparseColMatRef<'_, u32>,
        order: Option<&[u32]>,
    ) -> Result<Symbolic, SolverError> {
        Symbolic::with_permutation(pattern, order.map(|order| dof_permutation(order, 2)))
    }

    /// `permutation`: of the dofs as they are eliminated; `None` leaves it to faer's AMD.
    ///
    /// # Errors
    /// See [`SolverError`].
    pub fn with_permutation(
        pattern: SymbolicSparseColMatRef<'_, u32>,
        permutation: Option<Perm<u32>>,
    ) -> Result<Symbolic, SolverError> {
        let ordering = match &permutation {
            Some(permutation) => SymmetricOrdering::Custom(permutation.as_ref()),
            None => SymmetricOrdering::Amd,
        };
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let structure = factorize_symbolic_cholesky(pattern, Side::Lower, ordering, params);
        let out_of_memory = |_| SolverError::OutOfMemory {
            dofs: pattern.ncols(),
        };
        let structure = structure.map_err(out_of_memory)?;
        Ok(Symbolic {
            structure: Arc::new(structure),
        })
    }

    /// Stored entries of L; blocks of supernodes count whole.
    pub fn factor_entries(&self) -> usize {
        self.structure.len_val()
    }

    /// Multiplications and additions of the numeric factorisation: w³/3 + w²r + wr² for each
    /// supernode of w columns with r rows below them.
    pub fn flops(&self) -> f64 {
        let SymbolicCholeskyRaw::Supernodal(supernodes) = self.structure.raw() else {
            return 0.0;
        };
        let columns = supernodes
            .supernode_begin()
            .iter()
            .zip(supernodes.supernode_end());
        let widths = columns.map(|(&begin, &end)| f64::from(end - begin));
        let rows = supernodes
            .col_ptr_for_row_idx()
            .windows(2)
            .map(|w| f64::from(w[1] - w[0]));
        widths
            .zip(rows)
            .map(|(w, r)| w * w * w / 3.0 + w * w * r + w * r * r)
            .sum()
    }

    /// L of a matrix with this pattern, on all threads where the work is worth it.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`], [`SolverError::OutOfMemory`].
    pub fn factorise(&self, matrix: &LowerMatrix) -> Result<Factor, SolverError> {
        let worth_it = self.flops() > PARALLEL_FLOPS;
        let par = if worth_it {
            Par::rayon(PARTS)
        } else {
            Par::Seq
        };
        self.factorise_with(matrix, par)
    }

    /// L of a matrix with this pattern.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`], [`SolverError::OutOfMemory`].
    pub fn factorise_with(&self, matrix: &LowerMatrix, par: Par) -> Result<Factor, SolverError> {
        let out_of_memory = || SolverError::OutOfMemory {
            dofs: matrix.ncols(),
        };
        let scratch = self
            .structure
            .factorize_numeric_llt_scratch::<f64>(par, Default::default());
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| out_of_memory())?;
        let mut values = Vec::new();
        values
            .try_reserve_exact(self.factor_entries())
            .map_err(|_| out_of_memory())?;
        values.resize(self.factor_entries(), 0.0);
        self.structure
            .factorize_numeric_llt(
                &mut values,
                matrix.as_ref(),
                Side::Lower,
                Default::default(),
                par,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .map_err(|LltError::NonPositivePivot { index }| self.not_positive(index))?;
        self.check_pivots(matrix, &values)?;
        Ok(Factor {
            structure: self.structure.clone(),
            values,
        })
    }

    /// L_jj² against K_jj, for what rounding has left of a zero pivot.
    fn check_pivots(&self, matrix: &LowerMatrix, values: &[f64]) -> Result<(), SolverError> {
        let SymbolicCholeskyRaw::Supernodal(supernodes) = self.structure.raw() else {
            return Ok(());
        };
        for s in 0..supernodes.n_supernodes() {
            let supernode = supernodes.supernode(s);
            let columns = supernode.start()..supernodes.supernode_end()[s] as usize;
            let rows = columns.len() + supernode.pattern().len();
            let block = &values[supernodes.col_ptr_for_val()[s] as usize..];
            for (j, column) in columns.enumerate() {
                // The lower triangle's columns start at their diagonal.
                let diagonal = matrix.val_of_col(self.dof(column))[0];
                // False for a pivot that is not a number.
                let sound = block[j * (rows + 1)].powi(2) > LEAST_PIVOT * diagonal;
                if !sound {
                    return Err(self.not_positive(column));
                }
            }
        }
        Ok(())
    }

    fn not_positive(&self, index: usize) -> SolverError {
        SolverError::NotPositiveDefinite {
            dof: self.dof(index),
        }
    }

    /// The dof that is eliminated at `index`.
    fn dof(&self, index: usize) -> usize {
        let order = self.structure.perm().map(|p| p.arrays().0);
        order.map_or(index, |order| order[index] as usize)
    }
}

/// L.
#[derive(Clone, Debug)]
pub struct Factor {
    structure: Arc<SymbolicCholesky<u32>>,
    values: Vec<f64>,
}

impl Factor {
    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    pub(super) fn supernodes(&self) -> &SymbolicSupernodalCholesky<u32> {
        match self.structure.raw() {
            SymbolicCholeskyRaw::Supernodal(supernodes) => supernodes,
            SymbolicCholeskyRaw::Simplicial(_) => unreachable!("supernodes are forced"),
        }
    }

    /// The column of L that eliminates a dof.
    pub fn column(&self, dof: usize) -> usize {
        let place = self.structure.perm().map(|p| p.arrays().1);
        place.map_or(dof, |place| place[dof] as usize)
    }

    /// Overwrites `rhs` by K⁻¹ rhs, on one thread: the work is bound by memory, and a second thread
    /// was slower at every size measured (docs/performance.md).
    pub fn solve_in_place(&self, rhs: &mut [f64]) {
        self.solve_many_in_place(rhs, 1);
    }

    /// The same for `columns` right-hand sides one after the other: eight cost little more than one.
    pub fn solve_many_in_place(&self, rhs: &mut [f64], columns: usize) {
        let scratch = self
            .structure
            .solve_in_place_scratch::<f64>(columns, Par::Seq);
        let mut memory = MemBuffer::new(scratch);
        let rows = rhs.len() / columns;
        LltRef::new(&self.structure, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, rows, columns),
            Par::Seq,
            MemStack::new(&mut memory),
        );
    }
}
