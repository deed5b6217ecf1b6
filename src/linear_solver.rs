//! K U = R, Qian et al. (2021), eq. (11): ordering, symbolic and numeric factorisation, Cholesky where K
//! is symmetric and LU where it is not, solution and its residual, each apart from the others.

pub mod cholesky;
pub mod compliance;
mod elimination_tree;
mod kernels;
pub mod lu;
mod metis;
mod multifrontal;
pub mod ordering;
mod partial_pivoting;
mod path;
pub mod supernodes;
mod triangular;

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

/// Factors of K.
#[derive(Clone, Debug)]
pub enum Factor {
    Cholesky(cholesky::Factor),
    Lu(Box<lu::Factor>),
}

impl Factor {
    /// Overwrites `rhs` by K⁻¹ rhs.
    pub fn solve_in_place(&self, rhs: &mut [f64]) {
        match self {
            Factor::Cholesky(factor) => factor.solve_in_place(rhs),
            Factor::Lu(factor) => factor.solve_in_place(rhs),
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
