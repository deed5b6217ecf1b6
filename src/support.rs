//! Rigid-body motions that no support prevents, reported in the user's words before they become a
//! singular matrix.

use crate::boundary::Boundary;
use crate::model::Model;
use crate::model::node_axes::direction;
use nalgebra::{Matrix3, Vector3};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use thiserror::Error;

/// A rigid-body motion in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigidMotion {
    MoveX,
    MoveY,
    /// A shift along this unit vector.
    Move([f64; 2]),
    /// A turn about this point [m].
    Turn([f64; 2]),
}

impl fmt::Display for RigidMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RigidMotion::MoveX => write!(f, "move in x"),
            RigidMotion::MoveY => write!(f, "move in y"),
            RigidMotion::Move([x, y]) => write!(f, "move along ({x:.3}, {y:.3})"),
            RigidMotion::Turn([x, y]) => write!(f, "turn about ({x}, {y}) m"),
        }
    }
}

/// A connected part of the body that is not held.
#[derive(Debug, Error)]
#[error("{} can {} freely", names(regions, *whole), motions(free))]
pub struct NotHeld {
    /// Names of the regions with nodes in this part.
    pub regions: Vec<String>,
    /// Whether the part is all there is.
    pub whole: bool,
    pub free: Vec<RigidMotion>,
}

fn names(regions: &[String], whole: bool) -> String {
    let list: Vec<String> = regions.iter().map(|name| format!("`{name}`")).collect();
    match (whole, list.len()) {
        (true, _) => "the body".to_owned(),
        (false, 1) => format!("region {} is tied to nothing that is held: it", list[0]),
        (false, _) => format!(
            "regions {} are tied to nothing that is held: they",
            list.join(", ")
        ),
    }
}

fn motions(free: &[RigidMotion]) -> String {
    let list: Vec<String> = free.iter().map(ToString::to_string).collect();
    match list.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => list.concat(),
    }
}

/// Motions whose square is below this, against the best held one, count as free: constraint rows are
/// exact to 1e-15 and their products to 1e-30 plus rounding.
const FREE: f64 = 1e-12;

/// Checks every connected part of the body.
///
/// # Errors
/// The first part that can still move.
pub fn check(model: &Model, boundary: &Boundary) -> Result<(), NotHeld> {
    let uncracked = vec![1.0; model.interactions.len()];
    let parts = connected_parts(model, &uncracked);
    let whole = parts.len() == 1;
    for nodes in &parts {
        let free = FreeMotions::of(model, boundary, nodes).describe();
        if !free.is_empty() {
            return Err(NotHeld {
                regions: region_names(model, nodes),
                whole,
                free,
            });
        }
    }
    Ok(())
}

/// A part of the body that can move as a whole.
pub struct LoosePart {
    /// Ascending.
    pub nodes: Vec<usize>,
    /// Whether some support touches it, though not enough of them to hold it.
    pub touches_support: bool,
    free: FreeMotions,
}

impl LoosePart {
    /// Whether the loads [N, by dof] do work along a free motion: nothing is there to carry them.
    pub fn is_pushed(&self, model: &Model, load: &[f64]) -> bool {
        let FreeMotions {
            centre,
            size,
            motions,
        } = &self.free;
        motions.iter().any(|motion| {
            let (mut work, mut scale) = (0.0, 0.0);
            for &node in &self.nodes {
                let [x, y] = [0, 1].map(|k| (model.positions[node][k] - centre[k]) / size);
                let [fx, fy] = [load[2 * node], load[2 * node + 1]];
                work += fx * (motion[0] - motion[2] * y) + fy * (motion[1] + motion[2] * x);
                scale += fx.abs() + fy.abs();
            }
            work.abs() > PUSHED * scale
        })
    }
}

/// Loads whose work along a unit motion is a smaller share of their sum are in balance: consistent
/// loads are exact to 1e-15, sums over a mesh to some digits less.
const PUSHED: f64 = 1e-10;

/// The parts that no interaction with an `integrity` φ > 0 ties to enough supports: parts that have
/// broken off, or hang on a roller.
pub fn loose_parts(model: &Model, boundary: &Boundary, integrity: &[f64]) -> Vec<LoosePart> {
    let is_held = |&node: &usize| {
        let mut dofs = [2 * node, 2 * node + 1].into_iter();
        dofs.any(|dof| boundary.prescribed.contains_key(&dof))
    };
    let loose = |nodes: Vec<usize>| {
        let free = FreeMotions::of(model, boundary, &nodes);
        let touches_support = nodes.iter().any(is_held);
        (!free.motions.is_empty()).then_some(LoosePart {
            nodes,
            touches_support,
            free,
        })
    };
    let parts = connected_parts(model, integrity).into_iter();
    parts.filter_map(loose).collect()
}

/// The sets of nodes that elements and interactions with stiffness connect, ordered by their
/// lowest node.
fn connected_parts(model: &Model, integrity: &[f64]) -> Vec<Vec<usize>> {
    let mut parent: Vec<u32> = (0..model.node_count() as u32).collect();
    let mut join = |a: u32, b: u32| {
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        parent[a.max(b) as usize] = a.min(b);
    };
    // A cell never holds what its bonds do not.
    for s in model.interactions.axial() {
        if integrity[s] > 0.0 && model.interactions.stiffness[s] != 0.0 {
            let nodes = model.interactions.nodes(s);
            nodes.windows(2).for_each(|pair| join(pair[0], pair[1]));
        }
    }
    for element in 0..model.elements.len() {
        let nodes = model.element_nodes(element);
        nodes.windows(2).for_each(|pair| join(pair[0], pair[1]));
    }
    let mut parts: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for node in 0..model.node_count() as u32 {
        parts
            .entry(root(&mut parent, node))
            .or_default()
            .push(node as usize);
    }
    parts.into_values().collect()
}

fn root(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        parent[node as usize] = parent[parent[node as usize] as usize];
        node = parent[node as usize];
    }
    node
}

fn region_names(model: &Model, nodes: &[usize]) -> Vec<String> {
    let members: BTreeSet<usize> = nodes.iter().copied().collect();
    let of_points = nodes.iter().filter_map(|&node| model.region_of_point(node));
    let of_elements = (0..model.elements.len())
        .filter(|&e| members.contains(&(model.element_nodes(e)[0] as usize)))
        .map(|e| model.elements[e].0);
    let regions: BTreeSet<usize> = of_points.chain(of_elements).collect();
    regions
        .into_iter()
        .map(|r| model.regions[r].name.clone())
        .collect()
}

/// The rigid motions (a_x, a_y, ω R) about a part's centroid that no prescribed dof sees, R being the
/// part's size [m].
struct FreeMotions {
    centre: [f64; 2],
    size: f64,
    motions: Vec<Vector3<f64>>,
}

impl FreeMotions {
    fn of(model: &Model, boundary: &Boundary, nodes: &[usize]) -> FreeMotions {
        let count = nodes.len() as f64;
        let centre =
            [0, 1].map(|axis| nodes.iter().map(|&n| model.positions[n][axis]).sum::<f64>() / count);
        let arm = |n: usize| [0, 1].map(|axis| model.positions[n][axis] - centre[axis]);
        let size = nodes
            .iter()
            .map(|&n| arm(n)[0].hypot(arm(n)[1]))
            .fold(f64::MIN_POSITIVE, f64::max);
        let mut held = Matrix3::zeros();
        for &node in nodes {
            let [x, y] = arm(node).map(|a| a / size);
            let rows = [Vector3::new(1.0, 0.0, -y), Vector3::new(0.0, 1.0, x)];
            for dof in [2 * node, 2 * node + 1] {
                if boundary.prescribed.contains_key(&dof) {
                    let [cx, cy] = direction(&boundary.node_axes, dof);
                    let row = rows[0] * cx + rows[1] * cy;
                    held += row * row.transpose();
                }
            }
        }
        FreeMotions {
            centre,
            size,
            motions: null_space(held),
        }
    }

    fn describe(&self) -> Vec<RigidMotion> {
        let motions = self.motions.iter();
        motions
            .map(|&motion| describe(motion, self.centre, self.size))
            .collect()
    }
}

/// Unit vectors that span the null space, translations apart from rotations where they can be.
fn null_space(held: Matrix3<f64>) -> Vec<Vector3<f64>> {
    let eigen = held.symmetric_eigen();
    let limit = FREE * eigen.eigenvalues.amax();
    let free: Vec<Vector3<f64>> = (0..3)
        .filter(|&k| eigen.eigenvalues[k] <= limit)
        .map(|k| eigen.eigenvectors.column(k).into_owned())
        .collect();
    let project = |v: Vector3<f64>| -> Vector3<f64> { free.iter().map(|f| f * f.dot(&v)).sum() };
    let mut basis: Vec<Vector3<f64>> = Vec::new();
    for candidate in [Vector3::x(), Vector3::y()]
        .into_iter()
        .chain(free.iter().copied())
    {
        let mut rest = project(candidate);
        let is_axis = (rest - candidate).norm() < 1e-6;
        if basis.len() < free.len() && (is_axis || free.contains(&candidate)) {
            for b in &basis {
                rest -= b * b.dot(&rest);
            }
            if rest.norm() > 1e-3 {
                basis.push(rest.normalize());
            }
        }
    }
    basis
}

fn describe(motion: Vector3<f64>, centre: [f64; 2], size: f64) -> RigidMotion {
    let [ax, ay, turn] = [motion[0], motion[1], motion[2] / size];
    if motion[2].abs() > 1e-6 {
        let about = [centre[0] - ay / turn, centre[1] + ax / turn];
        // Digits below a billionth of the body are rounding; the sum makes -0 a 0.
        let digit = 10_f64.powf((1e-9 * size).log10().ceil());
        return RigidMotion::Turn(about.map(|x| (x / digit).round() / (1.0 / digit) + 0.0));
    }
    if ay.abs() < 1e-6 {
        RigidMotion::MoveX
    } else if ax.abs() < 1e-6 {
        RigidMotion::MoveY
    } else {
        RigidMotion::Move([ax, ay])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motions_are_listed_with_one_and() {
        let all = [
            RigidMotion::MoveX,
            RigidMotion::MoveY,
            RigidMotion::Turn([0.0, 0.5]),
        ];
        assert_eq!(motions(&all[..1]), "move in x");
        assert_eq!(motions(&all[..2]), "move in x and move in y");
        assert_eq!(
            motions(&all),
            "move in x, move in y and turn about (0, 0.5) m"
        );
    }
}
