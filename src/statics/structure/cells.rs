//! Cells of nodes that may move as one on the coarse level of a two-level solution: material points within a
//! square as wide as their horizon, along the lattice's axes. Nodes of finite elements stay apart: they
//! are few, and their elements are as large as such squares.

use crate::linear_solver::policy::LEAST_CELL_SPACINGS;
use crate::model::{Method, Model};

/// A number per node, the same for those in one square.
pub(super) fn cells(model: &Model) -> Vec<u32> {
    let mut cells: Vec<u32> = (0..model.node_count() as u32).collect();
    for points in &model.points {
        let Method::Peridynamics(settings) = model.regions[points.region].method else {
            continue;
        };
        let axes = settings.lattice.axes();
        let local: Vec<[f64; 2]> = model.positions[points.nodes.clone()]
            .iter()
            .map(|&x| axes.local(x))
            .collect();
        let bound = |axis: usize, pick: fn(f64, f64) -> f64, from: f64| {
            local.iter().map(|x| x[axis]).fold(from, pick)
        };
        let spacing = settings.lattice.spacing;
        // Half a spacing below the first points, so that none lies between two squares.
        let low = [0, 1].map(|axis| bound(axis, f64::min, f64::INFINITY) - 0.5 * spacing);
        let side = spacing * settings.horizon_ratio.floor().max(LEAST_CELL_SPACINGS);
        let square = |x: &[f64; 2]| [0, 1].map(|axis| ((x[axis] - low[axis]) / side) as usize);
        let columns = 1 + local.iter().map(|x| square(x)[0]).max().unwrap_or(0);
        // Numbered by the first point in each.
        let mut first = std::collections::BTreeMap::new();
        for (node, x) in points.nodes.clone().zip(&local) {
            let [column, row] = square(x);
            let number = first.entry(row * columns + column).or_insert(node as u32);
            cells[node] = *number;
        }
    }
    cells
}
