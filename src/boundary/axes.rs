//! Local axes: the directions along which the components of a prescribed displacement count.

use super::groups::{nodes_of, outline_edges};
use super::layer::layer;
use super::{Boundary, BoundaryError};
use crate::fem::edge::{EdgeLoad, consistent_load};
use crate::model::Model;
use crate::model::node_axes::to_own;
use std::collections::BTreeMap;

/// Directions of the two components of a prescribed displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Directions {
    /// Directions x and y turned counter-clockwise by this angle [rad].
    Turned(f64),
    /// The outward normal of the curve, and its tangent with the body on the left.
    Curve,
}

/// Directions whose sine is less are parallel.
pub(super) const PARALLEL: f64 = 1e-9;

impl Boundary {
    /// The loads in the axes of the nodes, dof by dof [N].
    pub fn own_load(&self) -> Vec<f64> {
        self.in_own_axes(self.load.clone())
    }

    /// Forces by dof in the axes of the nodes, from those along x and y.
    pub fn in_own_axes(&self, mut forces: Vec<f64>) -> Vec<f64> {
        for (&node, &axes) in &self.node_axes {
            let own = to_own(axes, [forces[2 * node], forces[2 * node + 1]]);
            forces[2 * node..2 * node + 2].copy_from_slice(&own);
        }
        forces
    }
}

/// The nodes of a group, ascending, and their axes.
pub(super) fn axes_of(
    model: &Model,
    group: &str,
    directions: Directions,
) -> Result<BTreeMap<usize, [f64; 2]>, BoundaryError> {
    let nodes = nodes_of(model, group);
    if nodes.is_empty() {
        return Err(BoundaryError::NothingThere {
            group: group.to_owned(),
        });
    }
    if let Directions::Turned(angle) = directions {
        let axes = [angle.cos(), angle.sin()];
        return Ok(nodes.into_iter().map(|node| (node, axes)).collect());
    }
    let no_normal = || BoundaryError::NoNormal {
        group: group.to_owned(),
    };
    let curve = model.mesh.curves.get(group).ok_or_else(no_normal)?;
    let (mut on_elements, on_points) = outline_edges(model, curve);
    // A node of finite elements has the mean normal of the edges beside it, ∫ N n ds.
    on_elements.extend(on_points.iter().flat_map(|(_, edges)| edges).copied());
    if on_elements.is_empty() {
        on_elements.extend(curve);
    }
    let mut normals: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
    for edge in &on_elements {
        let push = EdgeLoad::Pressure(-1.0);
        for (mesh_node, normal) in consistent_load(edge, &model.mesh.nodes, push, 1.0) {
            if let Some(node) = model.node_of[mesh_node] {
                let sum = normals.entry(node as usize).or_default();
                (0..2).for_each(|axis| sum[axis] += normal[axis]);
            }
        }
    }
    for (points, edges) in &on_points {
        let layer = layer(model, points, edges).into_iter();
        normals.extend(layer.map(|point| (point.node, point.normal)));
    }
    let mut axes = BTreeMap::new();
    for node in nodes {
        let [x, y] = normals.get(&node).copied().unwrap_or_default();
        let size = x.hypot(y);
        if size == 0.0 {
            return Err(no_normal());
        }
        axes.insert(node, snapped([x / size, y / size]));
    }
    Ok(axes)
}

/// A normal along x or y but for rounding is along it.
fn snapped(normal: [f64; 2]) -> [f64; 2] {
    let is_zero = normal.map(|n| n.abs() < PARALLEL);
    match is_zero {
        [true, _] => [0.0, normal[1].signum()],
        [_, true] => [normal[0].signum(), 0.0],
        _ => normal,
    }
}
