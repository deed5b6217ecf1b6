//! Sparse Cholesky factorisation K = L Lᵀ: the structure of L once, its numbers as often as K changes. K has `B`
//! unknowns for each node of its graph.

use super::amalgamation;
use super::compliance::UnitLoads;
use super::fronts::Fronts;
use super::held::HeldDofs;
use super::multifrontal::{self, NotPositive};
use super::node_blocks::{NodeBlocks, below, inverse};
use super::ordering::{Ordering, elimination_order, postordered};
use super::policy::DIRECT_RESIDUAL;
use super::refactorisation::{self, Kept};
use super::supernodes::Supernodes;
use super::triangular::{self, Wanted};
use super::update_memory::Pool;
use super::{Backend, FactorSize, Factorisation, SolverError, SymmetricSolver};
use crate::assembly::{Lists, LowerMatrix};
use faer::sparse::SymbolicSparseColMatRef;
use std::sync::{Arc, Mutex, PoisonError};

/// The structure of L, from the pattern of K alone.
#[derive(Clone, Debug)]
pub struct Symbolic<const B: usize> {
    structure: Arc<Supernodes>,
    nodes: Arc<NodeBlocks<B>>,
    spare: Spare,
    pool: Arc<Pool>,
}

/// The entries of a factor that is no longer needed, for the next one: to get fresh pages takes longer
/// than to fill them.
type Spare = Arc<Mutex<Option<Vec<f64>>>>;

impl<const B: usize> Symbolic<B> {
    /// # Errors
    /// See [`SolverError`].
    pub fn new(
        pattern: SymbolicSparseColMatRef<'_, u32>,
        graph: &Lists,
        ordering: Ordering,
    ) -> Result<Symbolic<B>, SolverError> {
        let order = elimination_order(ordering, graph).map_err(|status| SolverError::Ordering {
            nodes: graph.len(),
            status,
        })?;
        Ok(Symbolic::with_order(pattern, &order))
    }

    /// `pattern`: the lower triangle of K, columns sorted; `order`: the nodes as they are to be eliminated, of which
    /// subtrees may be reordered.
    pub fn with_order(pattern: SymbolicSparseColMatRef<'_, u32>, order: &[u32]) -> Symbolic<B> {
        let order = postordered::<B>(pattern, order);
        let below = below::<B>(pattern, &inverse(&order));
        let (structure, order) = amalgamation::supernodes::<B>(&order, &below);
        Symbolic {
            nodes: Arc::new(NodeBlocks::new(pattern, order, &structure)),
            structure: Arc::new(structure),
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
        self.structure.total_flops()
    }

    /// L of a matrix with this pattern, on all threads.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`], [`SolverError::OutOfMemory`].
    pub fn factorise(&self, matrix: &LowerMatrix) -> Result<Factor<B>, SolverError> {
        self.numeric(matrix, HeldDofs::NONE, &[])
    }

    /// L of a matrix with some dofs held, which [`Factor::refactorise`] may bring up to changes. `likely`: nodes near
    /// which K will change.
    ///
    /// # Errors
    /// Those of [`Symbolic::factorise`].
    pub fn factorise_held(
        &self,
        matrix: &LowerMatrix,
        held: HeldDofs,
        likely: &[u32],
    ) -> Result<Factor<B>, SolverError> {
        let likely = self.nodes.first_columns(likely);
        let factor = self.numeric(matrix, held, &self.structure.above_columns(likely));
        // What follows needs a little of it.
        self.pool.clear();
        factor
    }

    fn numeric(
        &self,
        matrix: &LowerMatrix,
        held: HeldDofs,
        parents: &[usize],
    ) -> Result<Factor<B>, SolverError> {
        let spare = self
            .spare
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        let mut values = match spare {
            Some(values) => values,
            None => {
                super::zeros(self.factor_entries()).ok_or_else(|| SolverError::OutOfMemory {
                    dofs: matrix.ncols(),
                })?
            }
        };
        let structure = &self.structure;
        let fronts = Fronts {
            structure,
            nodes: &self.nodes,
            matrix: matrix.val(),
            held: held.columns(structure, &self.nodes),
        };
        let kept = multifrontal::factorise(structure, &fronts, &mut values, &self.pool, parents);
        Ok(Factor {
            kept: Kept::new(kept.map_err(|pivot| not_positive(&self.nodes, pivot))?),
            structure: structure.clone(),
            nodes: self.nodes.clone(),
            values,
            pool: self.pool.clone(),
            spare: self.spare.clone(),
        })
    }
}

fn not_positive<const B: usize>(
    nodes: &NodeBlocks<B>,
    NotPositive(column): NotPositive,
) -> SolverError {
    SolverError::NotPositiveDefinite {
        dof: nodes.dof(column),
    }
}

/// L.
#[derive(Clone, Debug)]
pub struct Factor<const B: usize> {
    structure: Arc<Supernodes>,
    nodes: Arc<NodeBlocks<B>>,
    values: Vec<f64>,
    kept: Kept,
    pool: Arc<Pool>,
    spare: Spare,
}

impl<const B: usize> Drop for Factor<B> {
    fn drop(&mut self) {
        let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        *spare = Some(std::mem::take(&mut self.values));
    }
}

impl<const B: usize> Factor<B> {
    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    pub(super) fn supernodes(&self) -> &Supernodes {
        &self.structure
    }

    /// The supernodes of some nodes and those above them, ascending.
    fn above(&self, nodes: &[u32]) -> Vec<usize> {
        (self.structure).above_columns(self.nodes.first_columns(nodes))
    }

    /// Multiplications and additions of the supernodes of some nodes and those above them.
    pub fn flops_above(&self, nodes: &[u32]) -> f64 {
        self.above(nodes)
            .into_iter()
            .map(|s| self.structure.flops(s))
            .sum()
    }

    /// L of a matrix that differs between some nodes only: the same bits as of a whole factorisation.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`]: this is no factor until it has followed another change.
    pub fn refactorise(
        &mut self,
        matrix: &LowerMatrix,
        held: HeldDofs,
        nodes: &[u32],
    ) -> Result<(), SolverError> {
        let path = self.above(nodes);
        let structure = &self.structure;
        let fronts = Fronts {
            structure,
            nodes: &self.nodes,
            matrix: matrix.val(),
            held: held.columns(structure, &self.nodes),
        };
        let (values, kept) = (&mut self.values, &mut self.kept);
        refactorisation::refactorise(structure, &fronts, values, &self.pool, kept, &path)
            .map_err(|pivot| not_positive(&self.nodes, pivot))
    }

    /// The column of L that eliminates a dof.
    pub fn column(&self, dof: usize) -> usize {
        self.nodes.column(dof)
    }

    /// Overwrites `rhs`, right-hand sides one after the other, by K⁻¹ rhs: eight cost twice as much as one.
    pub fn solve_in_place(&self, rhs: &mut [f64]) {
        let dof = |column| self.nodes.dof(column);
        triangular::solve(&self.structure, &self.values, rhs, Wanted::All, dof);
    }

    /// Solves where only the unknowns of some nodes are needed; the others may become zero. Reads no more of L than
    /// the supernodes above the nodes and above those with forces.
    pub fn solve_at(&self, nodes: &[u32], rhs: &mut [f64]) {
        let mut wanted = vec![false; self.structure.len()];
        for s in self.above(nodes) {
            wanted[s] = true;
        }
        let (wanted, dof) = (Wanted::Some(&wanted), |column| self.nodes.dof(column));
        triangular::solve(&self.structure, &self.values, rhs, wanted, dof);
    }
}

impl<const B: usize> SymmetricSolver for Symbolic<B> {
    fn backend(&self) -> Backend {
        Backend::Multifrontal
    }

    fn size(&self) -> FactorSize {
        FactorSize {
            entries: self.factor_entries(),
            waiting_entries: self.structure.waiting_entries(),
            flops: self.flops(),
        }
    }

    fn factorise(
        &self,
        stiffness: &LowerMatrix,
        held: HeldDofs,
        likely: &[u32],
    ) -> Result<Box<dyn Factorisation>, SolverError> {
        Ok(Box::new(self.factorise_held(stiffness, held, likely)?))
    }
}

impl<const B: usize> Factorisation for Factor<B> {
    fn solve_in_place(&self, rhs: &mut [f64], _: &[f64]) {
        Factor::solve_in_place(self, rhs);
    }

    fn residual_goal(&self) -> f64 {
        DIRECT_RESIDUAL
    }

    fn entries(&self) -> usize {
        self.values.len()
    }

    fn refactorise(
        &mut self,
        stiffness: &LowerMatrix,
        held: HeldDofs,
        nodes: &[u32],
    ) -> Result<bool, SolverError> {
        Factor::refactorise(self, stiffness, held, nodes).map(|()| true)
    }

    fn refactorisation_flops(&self, nodes: &[u32]) -> Option<f64> {
        Some(self.flops_above(nodes))
    }

    fn has_compliances(&self) -> bool {
        true
    }

    fn unit_loads(&self, dofs: &[usize], is_loaded: &dyn Fn(usize) -> bool) -> Option<UnitLoads> {
        Some(Factor::unit_loads(self, dofs, is_loaded))
    }

    fn elimination(&self, dof: usize) -> Option<usize> {
        Some(self.column(dof))
    }

    fn solve_at(&self, nodes: &[u32], rhs: &mut [f64]) -> bool {
        Factor::solve_at(self, nodes, rhs);
        true
    }
}
