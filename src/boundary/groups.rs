//! Physical groups of the mesh to nodes, and to the edges that bound the body.

use super::layer::layer;
use crate::fem::edge::edge_points;
use crate::mesh::Edge;
use crate::model::topology::Part;
use crate::model::{Method, Model, PointRegion};
use std::collections::HashSet;

/// Largest distance, in spacings, of a physical point from the material point that stands for it: half
/// a diagonal, with room for rounding errors.
pub(super) const POINT_REACH: f64 = 0.71;

/// The nodes that a physical curve or point stands for, ascending.
pub fn nodes_of(model: &Model, group: &str) -> Vec<usize> {
    let mut nodes: Vec<usize> = Vec::new();
    if let Some(curve) = model.mesh.curves.get(group) {
        nodes.extend(
            curve
                .iter()
                .flat_map(Edge::nodes)
                .filter_map(|n| model.node_of[n])
                .map(|n| n as usize),
        );
        let (_, on_points) = outline_edges(model, curve);
        for (points, edges) in &on_points {
            nodes.extend(layer(model, points, edges).iter().map(|point| point.node));
        }
    }
    for &point in model.mesh.points.get(group).into_iter().flatten() {
        nodes.extend(node_at(model, point));
    }
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// The finite-element node at a mesh node, or the nearest material point within half a diagonal of
/// its square.
fn node_at(model: &Model, mesh_node: usize) -> Option<usize> {
    if let Some(node) = model.node_of[mesh_node] {
        return Some(node as usize);
    }
    let at = model.mesh.nodes[mesh_node];
    let near = |points: &PointRegion| {
        let reach = POINT_REACH * points.micromodulus.spacing;
        let distance = |node: usize| {
            let x = model.positions[node];
            (x[0] - at[0]).hypot(x[1] - at[1])
        };
        let within = points.nodes.clone().map(|node| (distance(node), node));
        within
            .filter(|&(d, _)| d <= reach)
            .min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let candidates = model.points.iter().filter_map(near);
    candidates
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, node)| node)
}

/// The edges of a curve that bound the body, with the region on their left: those of finite-element
/// regions, and those of each peridynamic region. An edge between two regions bounds neither.
pub fn outline_edges<'a>(
    model: &'a Model,
    curve: &[Edge],
) -> (Vec<Edge>, Vec<(&'a PointRegion, Vec<Edge>)>) {
    let on_curve: HashSet<[usize; 2]> = curve.iter().map(Edge::key).collect();
    let topology = &model.topology;
    let outer = topology.body.edges.iter().map(Edge::key);
    let outer: HashSet<[usize; 2]> = outer.filter(|key| on_curve.contains(key)).collect();
    let of_part = |part: &Part| -> Vec<Edge> {
        let edges = part.edges.iter().copied();
        edges.filter(|edge| outer.contains(&edge.key())).collect()
    };
    let regions = model.regions.iter().zip(&topology.regions);
    let elements = regions.filter(|(region, _)| region.method == Method::FiniteElements);
    let on_elements = elements.flat_map(|(_, part)| of_part(part)).collect();
    let lattices = model.points.iter().zip(&topology.lattices);
    let on_points = lattices.map(|(points, lattice)| (points, of_part(&lattice.part)));
    (
        on_elements,
        on_points.filter(|(_, edges)| !edges.is_empty()).collect(),
    )
}

/// Length of the edges [m].
pub(super) fn length(model: &Model, edges: &[Edge]) -> f64 {
    let points = edges
        .iter()
        .flat_map(|edge| edge_points(edge, &model.mesh.nodes));
    points.map(|point| point.length).sum()
}
