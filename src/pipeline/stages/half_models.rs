//! A note on rollers that may be meant as planes of symmetry, as in finite elements.

use crate::boundary::{Directions, outline_edges};
use crate::mesh::Edge;
use crate::model::Model;
use crate::pipeline::read::plan::{Condition, Plan};
use crate::pipeline::show::results::lattice_name;
use std::collections::HashSet;

/// Edges whose directions differ by a smaller sine are on one line: coordinates of meshes carry noise.
const PARALLEL: f64 = 1e-6;

/// One note for each roller on a straight side of a lattice whose bonds can break.
pub(super) fn notes(plan: &Plan, model: &Model) -> Vec<String> {
    let conditions = plan.conditions.iter();
    let conditions = conditions.filter(|_| plan.loading.is_some());
    conditions.filter_map(|c| note(plan, model, c)).collect()
}

fn note(plan: &Plan, model: &Model, condition: &Condition) -> Option<String> {
    let group = &condition.group;
    let (_, on_points) = outline_edges(model, model.mesh.curves.get(group)?);
    let safe = unbreakable_edges(plan, model);
    let (points, _) = on_points.iter().find(|(points, edges)| {
        let mut members = model.members(points.region);
        members.any(|region| plan.regions[region].strength.is_some())
            && edges.iter().any(|edge| !safe.contains(&edge.key()))
            && is_roller(model, condition, edges)
    })?;
    Some(format!(
        "`{group}` holds a straight side of `{}` along its normal. If it is meant as a plane of symmetry: it is none \
         in a lattice, where the bonds across it are missing and none breaks on it, so that the body is too strong \
         (by a third in a notched strip). Model the whole body",
        lattice_name(model, points)
    ))
}

/// The edges of surfaces that never break.
fn unbreakable_edges(plan: &Plan, model: &Model) -> HashSet<[usize; 2]> {
    let cells = plan
        .no_fail
        .iter()
        .filter_map(|group| model.mesh.surfaces.get(group));
    let edges = cells
        .flatten()
        .flat_map(|&cell| model.mesh.cells[cell].edges());
    edges.map(|edge| edge.key()).collect()
}

/// Whether edges that lie on one line are held at zero along their normal, and free along the line.
fn is_roller(model: &Model, condition: &Condition, edges: &[Edge]) -> bool {
    let Some(displaced) = condition.displacement else {
        return false;
    };
    let direction = |edge: &Edge| {
        let [a, b] = edge.ends.map(|node| model.mesh.nodes[node]);
        let (x, y) = (b[0] - a[0], b[1] - a[1]);
        [x / x.hypot(y), y / x.hypot(y)]
    };
    let [x, y] = direction(&edges[0]);
    let sine = |[a, b]: [f64; 2]| (x * b - y * a).abs();
    let is_straight = edges.iter().all(|edge| sine(direction(edge)) < PARALLEL);
    let first = match displaced.components {
        [Some(0.0), None] => true,
        [None, Some(0.0)] => false,
        _ => return false,
    };
    let is_normal = match displaced.directions {
        Directions::Curve => first,
        Directions::Turned(angle) => {
            let (s, c) = angle.sin_cos();
            // The other component is along the line.
            sine(if first { [-s, c] } else { [c, s] }) < PARALLEL
        }
    };
    is_straight && is_normal
}
