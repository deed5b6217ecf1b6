//! The sparse supernodal Cholesky factorisation of the crate faer: a second opinion on [`super::cholesky`], which
//! it shares only the order of METIS and the criterion for a pivot with. It factorises K as a whole and can
//! neither follow a change nor give the compliances of few dofs.

use super::held::HeldDofs;
use super::ordering::{dof_permutation, postordered};
use super::policy::{DIRECT_RESIDUAL, LEAST_PIVOT};
use super::supernodes::flops;
use super::{Backend, FactorSize, Factorisation, SolverError, SymmetricSolver, zeros};
use crate::assembly::LowerMatrix;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::supernodal::{SupernodalLltRef, SymbolicSupernodalCholesky};
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::{Conj, MatMut, Par, Side};
use std::sync::Arc;

/// faer cuts its work by the number of threads, and its last bits change with it: it has one thread.
const THREADS: Par = Par::Seq;

/// The structure of L.
#[derive(Clone, Debug)]
pub struct Symbolic {
    symbolic: Arc<SymbolicCholesky<u32>>,
    /// The dof of each column of L.
    dofs: Arc<[u32]>,
}

impl Symbolic {
    /// `B`: unknowns of a node; `order`: the nodes as they are to be eliminated. Subtrees of the elimination tree are put in one piece,
    /// without which faer finds three times as many supernodes.
    ///
    /// # Errors
    /// [`SolverError::OutOfMemory`].
    pub fn with_order<const B: usize>(
        pattern: SymbolicSparseColMatRef<'_, u32>,
        order: &[u32],
    ) -> Result<Symbolic, SolverError> {
        let permutation = dof_permutation::<B>(&postordered::<B>(pattern, order));
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let ordering = SymmetricOrdering::Custom(permutation.as_ref());
        let symbolic = factorize_symbolic_cholesky(pattern, Side::Lower, ordering, params);
        Ok(Symbolic {
            symbolic: Arc::new(symbolic.map_err(|_| out_of_memory(pattern.ncols()))?),
            dofs: permutation.arrays().0.into(),
        })
    }

    fn supernodes(&self) -> &SymbolicSupernodalCholesky<u32> {
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Supernodal(supernodes) => supernodes,
            SymbolicCholeskyRaw::Simplicial(_) => unreachable!("supernodes were asked for"),
        }
    }

    /// The first of some columns of L whose pivot is not positive beyond rounding.
    fn first_bad_pivot(&self, values: &[f64], columns: usize, k: &LowerMatrix) -> Option<usize> {
        let supernodes = self.supernodes();
        let factor = SupernodalLltRef::new(supernodes, values);
        let pivots = (0..supernodes.n_supernodes()).flat_map(|s| {
            let (first, block) = (factor.supernode(s).start(), factor.supernode(s).val());
            (0..block.ncols()).map(move |j| (first + j, block[(j, j)]))
        });
        let is_sound = |&(column, pivot): &(usize, f64)| {
            let diagonal = k.val_of_col(self.dofs[column] as usize)[0];
            pivot * pivot > LEAST_PIVOT * diagonal
        };
        let mut pivots = pivots.take_while(|&(column, _)| column < columns);
        pivots
            .find(|pivot| !is_sound(pivot))
            .map(|(column, _)| column)
    }
}

fn out_of_memory(dofs: usize) -> SolverError {
    SolverError::OutOfMemory { dofs }
}

impl SymmetricSolver for Symbolic {
    fn backend(&self) -> Backend {
        Backend::Faer
    }

    fn size(&self) -> FactorSize {
        let supernodes = self.supernodes();
        let [begin, end] = [supernodes.supernode_begin(), supernodes.supernode_end()];
        let widths = begin.iter().zip(end).map(|(begin, end)| end - begin);
        let shapes = widths.zip(supernodes.nnz_per_super());
        FactorSize {
            entries: self.symbolic.len_val(),
            // Updates go into L at once.
            waiting_entries: 0,
            flops: shapes
                .map(|(w, &r)| flops(f64::from(w), f64::from(r)))
                .sum(),
        }
    }

    fn factorise(
        &self,
        stiffness: &LowerMatrix,
        held: HeldDofs,
        _: &[u32],
    ) -> Result<Box<dyn Factorisation>, SolverError> {
        let dofs = stiffness.ncols();
        let matrix = match held.is_held {
            [] => stiffness.clone(),
            is_held => stiffness.hold(is_held, held.diagonal),
        };
        let mut values = zeros(self.symbolic.len_val()).ok_or_else(|| out_of_memory(dofs))?;
        let scratch =
            (self.symbolic).factorize_numeric_llt_scratch::<f64>(THREADS, Default::default());
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| out_of_memory(dofs))?;
        let factor = self.symbolic.factorize_numeric_llt(
            &mut values,
            matrix.as_ref(),
            Side::Lower,
            Default::default(),
            THREADS,
            MemStack::new(&mut memory),
            Default::default(),
        );
        // The columns before a pivot that is not positive are done, and may have one of rounding size.
        let failed = factor
            .err()
            .map(|LltError::NonPositivePivot { index }| index);
        let bad = self.first_bad_pivot(&values, failed.unwrap_or(dofs), &matrix);
        match bad.or(failed) {
            Some(column) => Err(SolverError::NotPositiveDefinite {
                dof: self.dofs[column] as usize,
            }),
            None => Ok(Box::new(Factor {
                symbolic: self.symbolic.clone(),
                values,
            })),
        }
    }
}

/// L.
#[derive(Debug)]
struct Factor {
    symbolic: Arc<SymbolicCholesky<u32>>,
    values: Vec<f64>,
}

impl Factorisation for Factor {
    fn solve_in_place(&self, rhs: &mut [f64], _: &[f64]) {
        let dofs = self.symbolic.nrows();
        let columns = rhs.len() / dofs;
        let scratch = self
            .symbolic
            .solve_in_place_scratch::<f64>(columns, THREADS);
        LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, dofs, columns),
            THREADS,
            MemStack::new(&mut MemBuffer::new(scratch)),
        );
    }

    fn residual_goal(&self) -> f64 {
        DIRECT_RESIDUAL
    }

    fn entries(&self) -> usize {
        self.values.len()
    }
}
