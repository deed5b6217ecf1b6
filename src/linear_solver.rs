//! K U = R, Qian et al. (2021), eq. (11): ordering, symbolic and numeric factorisation by Cholesky's method,
//! solution and its residual, each apart from the others; conjugate gradients where factors would be too large.

pub mod cholesky;
pub mod columns;
pub mod compliance;
mod elimination_tree;
mod extend_add;
pub mod held;
mod kernels;
mod metis;
mod multifrontal;
pub mod ordering;
mod path;
mod refactorisation;
pub mod supernodes;
pub mod tiles;
mod triangular;
pub mod two_level;

use crate::assembly::{Lists, LowerMatrix};
use held::Held;
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
    /// A motion without force moves this dof the most.
    #[error("the stiffness matrix is singular: nothing holds dof {dof}")]
    Singular { dof: usize },
}

/// How K U = R is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// By Cholesky's factors.
    Direct,
    /// By conjugate gradients, see [`two_level`].
    TwoLevel,
}

/// More entries of L than these, 4 GB, leave the direct way.
const MOST_FACTOR_ENTRIES: f64 = 5e8;

impl Method {
    pub const ALL: [Method; 2] = [Method::Direct, Method::TwoLevel];

    /// By what L would take.
    pub fn choose(graph: &Lists) -> Method {
        let links = graph.parts().1.len();
        if expected_factor_entries(graph.len(), links) <= MOST_FACTOR_ENTRIES {
            Method::Direct
        } else {
            Method::TwoLevel
        }
    }

    /// In a word.
    pub fn describe(self) -> &'static str {
        match self {
            Method::Direct => "direct",
            Method::TwoLevel => "two-level",
        }
    }
}

/// Entries of L that nested dissection leaves of a graph in the plane of n nodes with d neighbours each,
/// some 3 n d (log2(n/d) − 2): the law is George's (1973), the numbers are fitted to lattices
/// (docs/performance.md). Two dofs per node; `links`: n d.
pub fn expected_factor_entries(nodes: usize, links: usize) -> f64 {
    let (nodes, links) = (nodes as f64, links as f64);
    3.07 * links * ((nodes * nodes / links).log2() - 2.0).max(1.0)
}

/// Factors of K, or what takes their place.
#[derive(Clone, Debug)]
pub enum Factor {
    Cholesky(cholesky::Factor),
    TwoLevel(Box<two_level::TwoLevel>),
}

impl Factor {
    /// Overwrites `rhs` by K⁻¹ rhs, or by what leaves a residual of no more than `goal`.
    pub fn solve_in_place(&self, rhs: &mut [f64], goal: f64) {
        match self {
            Factor::Cholesky(factor) => factor.solve_in_place(rhs),
            Factor::TwoLevel(solver) => {
                solver.solve_in_place(rhs, goal);
            }
        }
    }

    /// The factors of a K that differs between some nodes only: the same bits as of a whole factorisation.
    /// False where there is no such way.
    ///
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`]: these are no factors until they have followed another change.
    pub fn refactorise(
        &mut self,
        stiffness: &LowerMatrix,
        held: Held,
        nodes: &[u32],
    ) -> Result<bool, SolverError> {
        match self {
            Factor::Cholesky(factor) => factor.refactorise(stiffness, held, nodes).map(|()| true),
            Factor::TwoLevel(_) => Ok(false),
        }
    }

    pub fn method(&self) -> Method {
        match self {
            Factor::Cholesky(_) => Method::Direct,
            Factor::TwoLevel(_) => Method::TwoLevel,
        }
    }
}

/// Zeros in pages that the system has yet to give; `None` where it has no room.
fn zeros(count: usize) -> Option<Vec<f64>> {
    let mut room = Vec::<f64>::new();
    room.try_reserve_exact(count).ok()?;
    drop(room);
    Some(vec![0.0; count])
}
