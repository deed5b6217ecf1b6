//! One static solve, without artificial damping: K U = R, Qian et al. (2021), eq. (11).

mod error;
mod estimate;
mod factorised;
mod residual;
mod solver;
mod structure;
mod system;

use crate::boundary::Boundary;
use crate::model::Model;
use crate::model::node_axes::direction;
use crate::phases::measure;
use crate::support::{self, NotHeld};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

pub use crate::linear_solver::Backend;
pub use error::StaticsError;
pub use estimate::{Breaks, Estimate};
pub use factorised::Factorised;
pub use solver::Solver;

/// Displacements of all nodes, and the forces that hold them; from a [`Solver`] in the axes of the nodes
/// ([`crate::model::node_axes`]), from [`solve`] along x and y.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Solution {
    /// u of every node [m].
    pub displacement: Vec<[f64; 2]>,
    /// Force that the supports exert at every node [N]; zero where nothing is prescribed.
    pub reaction: Vec<[f64; 2]>,
    /// Normwise backward error ‖f − K u‖ / (‖K‖ ‖u‖ + ‖f‖) [-], see `statics/residual.rs`.
    pub residual: f64,
    pub size: SystemSize,
}

/// Sizes of the linear system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct SystemSize {
    pub dofs: usize,
    /// Stored entries of the lower triangle of K.
    pub stiffness_entries: usize,
    /// Stored entries of L; of the coarse level's L where the system is solved on two levels.
    pub factor_entries: usize,
    pub backend: Backend,
}

/// Assembles and solves once, initial cracks open.
///
/// # Errors
/// See [`StaticsError`].
pub fn solve(model: &Model, boundary: &Boundary) -> Result<Solution, StaticsError> {
    solve_by(model, boundary, None)
}

/// Assembles and solves once by a given backend; `None` for the one that suits the size of K.
///
/// # Errors
/// See [`StaticsError`].
pub fn solve_by(
    model: &Model,
    boundary: &Boundary,
    backend: Option<Backend>,
) -> Result<Solution, StaticsError> {
    let unsupported = measure("support", || {
        support::check(model, boundary)?;
        Ok::<_, NotHeld>(support::loose_parts(model, boundary, &model.integrity))
    })?;
    let pinned: Vec<Vec<usize>> = unsupported.into_iter().map(|part| part.nodes).collect();
    let solver = Solver::with_backend(model, boundary, backend)?;
    let solution = solver.solve(&model.integrity, &pinned)?;
    Ok(Solution {
        displacement: model.in_space(&solution.displacement),
        reaction: model.in_space(&solution.reaction),
        ..solution
    })
}

/// Sum of the nodes' reactions on each group that prescribes a displacement, from those along x and y [N].
pub fn group_reactions(boundary: &Boundary, reaction: &[[f64; 2]]) -> BTreeMap<String, [f64; 2]> {
    let mut sums: BTreeMap<String, [f64; 2]> = BTreeMap::new();
    for (&dof, (_, group)) in &boundary.prescribed {
        let sum = sums.entry(group.clone()).or_default();
        let [x, y] = direction(&boundary.node_axes, dof);
        let along = x * reaction[dof / 2][0] + y * reaction[dof / 2][1];
        *sum = [sum[0] + along * x, sum[1] + along * y];
    }
    sums
}
