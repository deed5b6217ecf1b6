//! Sparse Cholesky factorisation K = L Lᵀ: symbolic once, numeric as often as K changes.

use super::SolverError;
use super::multifrontal::{self, NotPositive, Pool};
use super::ordering::{Ordering, elimination_order};
use super::supernodes::Supernodes;
use super::triangular;
use crate::assembly::{Lists, LowerMatrix};
use faer::sparse::SymbolicSparseColMatRef;
use std::sync::{Arc, Mutex, PoisonError};

/// The structure of L, from the pattern of K alone.
#[derive(Clone, Debug)]
pub struct Symbolic {
    structure: Arc<Supernodes>,
    spare: Spare,
    pool: Arc<Pool>,
}

/// The entries of a factor that is no longer needed, for the next one: to get fresh pages takes longer
/// than to fill them.
type Spare = Arc<Mutex<Option<Vec<f64>>>>;

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
        Ok(Symbolic::with_order(pattern, &order))
    }

    /// `order`: the nodes as they are eliminated.
    pub fn with_order(pattern: SymbolicSparseColMatRef<'_, u32>, order: &[u32]) -> Symbolic {
        Symbolic {
            structure: Arc::new(Supernodes::new(pattern, order)),
            spare: Spare::default(),
            pool: Arc::default(),
        }
    }

    /// Stored entries of L; blocks of supernodes count whole.
    pub fn factor_entries(&self) -> usize {
        self.structure.entries()
    }

    /// Multiplications and additions of the numeric factorisation: w³/3 + w²r + wr² for each
    /// supernode of w columns with r rows below them.
    pub fn flops(&self) -> f64 {
        let roots = self.structure.roots().into_iter();
        roots.map(|root| self.structure.subtree_flops(root)).sum()
    }

    /// L of a matrix with this pattern, on all threads.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`], [`SolverError::OutOfMemory`].
    pub fn factorise(&self, matrix: &LowerMatrix) -> Result<Factor, SolverError> {
        let spare = self
            .spare
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        let mut values = match spare {
            Some(values) => values,
            None => zeros(self.factor_entries()).ok_or_else(|| SolverError::OutOfMemory {
                dofs: matrix.ncols(),
            })?,
        };
        multifrontal::factorise(&self.structure, matrix.val(), &mut values, &self.pool).map_err(
            |NotPositive(column)| SolverError::NotPositiveDefinite {
                dof: self.structure.dof(column),
            },
        )?;
        Ok(Factor {
            structure: self.structure.clone(),
            values,
            spare: self.spare.clone(),
        })
    }
}

/// Zeros in pages that the system has yet to give; `None` where it has no room.
fn zeros(count: usize) -> Option<Vec<f64>> {
    let mut room = Vec::<f64>::new();
    room.try_reserve_exact(count).ok()?;
    drop(room);
    Some(vec![0.0; count])
}

/// L.
#[derive(Clone, Debug)]
pub struct Factor {
    structure: Arc<Supernodes>,
    values: Vec<f64>,
    spare: Spare,
}

impl Drop for Factor {
    fn drop(&mut self) {
        let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        *spare = Some(std::mem::take(&mut self.values));
    }
}

impl Factor {
    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    pub(super) fn supernodes(&self) -> &Supernodes {
        &self.structure
    }

    /// The column of L that eliminates a dof.
    pub(super) fn column(&self, dof: usize) -> usize {
        self.structure.column(dof)
    }

    /// Overwrites `rhs` by K⁻¹ rhs.
    pub fn solve_in_place(&self, rhs: &mut [f64]) {
        self.solve_many_in_place(rhs, 1);
    }

    /// The same for `columns` right-hand sides one after the other: eight cost little more than one.
    pub fn solve_many_in_place(&self, rhs: &mut [f64], columns: usize) {
        triangular::solve(&self.structure, &self.values, rhs, columns);
    }
}
