//! Why a system has no solution, and whether what was found is one.

use super::Solution;
use super::residual::Residual;
use crate::linear_solver::SolverError;
use crate::model::Model;
use crate::support::NotHeld;
use thiserror::Error;

#[derive(Debug, Error)]
pub enum StaticsError {
    #[error(transparent)]
    NotHeld(#[from] NotHeld),
    #[error(transparent)]
    Solver(#[from] SolverError),
    #[error(
        "{what} at ({x:.6e}, {y:.6e}) m is not held in every direction: {interactions} bonds or trusses \
         with stiffness end there"
    )]
    Mechanism {
        what: &'static str,
        x: f64,
        y: f64,
        interactions: usize,
    },
    #[error(
        "what hangs on {what} at ({x:.6e}, {y:.6e}) m swings freely under its load: the residual \
         is {residual:.1e}"
    )]
    Swings {
        what: &'static str,
        x: f64,
        y: f64,
        residual: f64,
    },
    #[error("the solution is not finite at {what} ({x:.6e}, {y:.6e}) m")]
    NotFinite { what: &'static str, x: f64, y: f64 },
    #[error(
        "the solution leaves a residual of {residual:.1e}, more than {limit:.0e}: the system is close to singular"
    )]
    Residual { residual: f64, limit: f64 },
    #[error(
        "the solution of {dofs} equations needs {:.1} GB, and the machine has {:.1}",
        *.bytes as f64 / 1e9, *.machine as f64 / 1e9
    )]
    Memory {
        dofs: usize,
        bytes: u64,
        machine: u64,
    },
}

/// Whether a solution is one: finite, with a small residual. `goal`: the residual that it was refined to [-].
///
/// # Errors
/// [`StaticsError::NotFinite`], [`StaticsError::Residual`].
pub(super) fn check(
    model: &Model,
    solution: &Solution,
    residual: Residual,
    goal: f64,
) -> Result<(), StaticsError> {
    let finite = |u: &[f64; 2]| u[0].is_finite() && u[1].is_finite();
    if let Some(node) = solution.displacement.iter().position(|u| !finite(u)) {
        let [x, y] = model.positions[node];
        return Err(StaticsError::NotFinite {
            what: kind(model, node),
            x,
            y,
        });
    }
    match residual.violation(goal) {
        Some((residual, limit)) => Err(StaticsError::Residual { residual, limit }),
        None => Ok(()),
    }
}

/// The kind of a node, for messages.
pub(super) fn kind(model: &Model, node: usize) -> &'static str {
    if node < model.fe_node_count() {
        "the finite-element node"
    } else {
        "the material point"
    }
}
