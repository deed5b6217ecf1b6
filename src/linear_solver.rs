//! K u = f, Qian et al. (2021), eq. (11), where K is symmetric and positive definite.
//!
//! A [`SymmetricSolver`] knows the pattern of K; from the numbers in it comes a [`Factorisation`], which solves.
//! There are three backends: the program's own Cholesky factorisation, conjugate gradients for systems whose
//! factors would be too large, and the factorisation of the crate faer, which the own one is compared with.

mod amalgamation;
pub mod cholesky;
pub mod columns;
pub mod compliance;
mod elimination_tree;
mod extend_add;
pub mod faer;
mod fronts;
pub mod held;
mod kernels;
mod metis;
mod multifrontal;
mod node_blocks;
pub mod ordering;
mod path;
pub(crate) mod policy;
pub(crate) mod rates;
mod refactorisation;
mod supernodes;
pub mod tiles;
mod triangular;
pub mod two_level;
mod update_memory;

use crate::assembly::{Lists, LowerMatrix};
use compliance::UnitLoads;
use held::HeldDofs;
use policy::MOST_FACTOR_ENTRIES;
use rates::ENTRIES_PER_LINK;
use serde::{Deserialize, Serialize};
use thiserror::Error;

#[derive(Debug, Error)]
pub enum SolverError {
    #[error("METIS could not order {nodes} nodes (status {status})")]
    Ordering { nodes: usize, status: i32 },
    #[error("not enough memory to analyse a system of {dofs} unknowns")]
    OutOfMemory { dofs: usize },
    /// The pivot of this dof is not positive: K is singular or indefinite.
    #[error("the stiffness matrix is not positive definite at dof {dof}")]
    NotPositiveDefinite { dof: usize },
}

/// A backend that solves systems.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Backend {
    /// The program's own multifrontal Cholesky factorisation, [`cholesky`].
    Multifrontal,
    /// Conjugate gradients on two levels, [`two_level`].
    TwoLevel,
    /// The supernodal Cholesky factorisation of the crate faer, [`mod@faer`].
    Faer,
}

impl Backend {
    pub const ALL: [Backend; 3] = [Backend::Multifrontal, Backend::TwoLevel, Backend::Faer];

    /// The backend that suits the size of L, with `B` unknowns for each node of the graph.
    pub fn choose<const B: usize>(graph: &Lists) -> Backend {
        let links = graph.parts().1.len();
        if expected_factor_entries::<B>(graph.len(), links) <= MOST_FACTOR_ENTRIES {
            Backend::Multifrontal
        } else {
            Backend::TwoLevel
        }
    }

    /// The backend's name in `summary.json`.
    pub fn describe(self) -> &'static str {
        match self {
            Backend::Multifrontal => "direct",
            Backend::TwoLevel => "two-level",
            Backend::Faer => "faer",
        }
    }
}

/// Entries of L that nested dissection leaves of a graph in the plane of n nodes with d neighbours each,
/// some B² n d (log2(n/d) − 2) for B unknowns of a node: the law is George's (1973), the numbers are fitted to
/// lattices (docs/performance.md). `links`: n d.
pub fn expected_factor_entries<const B: usize>(nodes: usize, links: usize) -> f64 {
    let (nodes, links) = (nodes as f64, links as f64);
    (B * B) as f64 * ENTRIES_PER_LINK * links * ((nodes * nodes / links).log2() - 2.0).max(1.0)
}

/// The size of a factorisation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FactorSize {
    /// Stored entries of L; on two levels those that L of the coarse level is expected to have.
    pub entries: usize,
    /// Entries that the factorisation holds besides those of L.
    pub waiting_entries: usize,
    /// Multiplications and additions.
    pub flops: f64,
}

/// A backend that has analysed the pattern of K.
pub trait SymmetricSolver: Send + Sync {
    fn backend(&self) -> Backend;

    fn size(&self) -> FactorSize;

    /// Factorises K with some dofs held. `likely`: nodes near which K will change, if it is to be followed by
    /// [`Factorisation::refactorise`].
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`] for a mechanism, [`SolverError::OutOfMemory`].
    fn factorise(
        &self,
        stiffness: &LowerMatrix,
        held: HeldDofs,
        likely: &[u32],
    ) -> Result<Box<dyn Factorisation>, SolverError>;
}

/// Factors of K, or a preconditioner that takes their place. Every backend solves; the other methods are capabilities, which a
/// backend without them answers by the methods written here.
pub trait Factorisation: Send + Sync {
    /// Overwrites each of some right-hand sides, one after the other, by a solution x. An iterative backend ends
    /// where ‖K x − f‖₂ is no more than the right-hand side's goal; factors leave rounding errors.
    fn solve_in_place(&self, rhs: &mut [f64], goals: &[f64]);

    /// The residual over the norm of the right-hand side that solutions are refined to [-].
    fn residual_goal(&self) -> f64;

    /// Stored entries of L; of the coarse level's L on two levels.
    fn entries(&self) -> usize;

    /// Whether a displacement near the solution saves time.
    fn gains_by_guess(&self) -> bool {
        false
    }

    /// Follows a change of K between some nodes: the same bits as of a whole factorisation. False if the backend
    /// cannot.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`]: the factors are not valid until another change has been followed.
    fn refactorise(
        &mut self,
        _stiffness: &LowerMatrix,
        _held: HeldDofs,
        _nodes: &[u32],
    ) -> Result<bool, SolverError> {
        Ok(false)
    }

    /// Multiplications and additions of [`Factorisation::refactorise`].
    fn refactorisation_flops(&self, _nodes: &[u32]) -> Option<f64> {
        None
    }

    /// True if the backend has [`Factorisation::unit_loads`], and with them the compliances of few dofs.
    fn has_compliances(&self) -> bool {
        false
    }

    /// L⁻¹ E of unit loads at some dofs, and nothing for those that are not loaded.
    fn unit_loads(&self, _dofs: &[usize], _is_loaded: &dyn Fn(usize) -> bool) -> Option<UnitLoads> {
        None
    }

    /// The place of a dof in the order of elimination.
    fn elimination(&self, _dof: usize) -> Option<usize> {
        None
    }

    /// Solves where only the unknowns of some nodes are needed, and may leave out others. False if the backend
    /// cannot, and has solved nothing.
    fn solve_at(&self, _nodes: &[u32], _rhs: &mut [f64]) -> bool {
        false
    }
}

/// Zeros in pages that the system has yet to give; `None` where it has no room.
fn zeros(count: usize) -> Option<Vec<f64>> {
    let mut room = Vec::<f64>::new();
    room.try_reserve_exact(count).ok()?;
    drop(room);
    Some(vec![0.0; count])
}
