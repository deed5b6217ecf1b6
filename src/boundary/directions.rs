//! Displacements along directions that are neither x nor y: rollers on slopes and on curves.
//!
//! A node on such a support gets axes of its own ([`crate::model::node_axes`]) along which one dof or both
//! are prescribed. Where supports of different axes meet at a node, two independent directions fix it
//! altogether, and it keeps x and y; directions that are parallel must agree.

use super::{Boundary, BoundaryError, layer, nodes_of, outline_edges};
use crate::fem::edge::{EdgeLoad, consistent_load};
use crate::model::Model;
use crate::model::node_axes::direction;
use std::collections::BTreeMap;

/// The directions of the two components of a prescribed displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Directions {
    /// Along x and y turned counter-clockwise by this angle [rad].
    Turned(f64),
    /// Along the outward normal of the curve, and along the curve with the body on the left.
    Curve,
}

/// Directions whose sine is less are parallel.
const PARALLEL: f64 = 1e-9;

/// Values that differ by a smaller share agree.
const SAME: f64 = 1e-9;

/// One prescribed component at a node.
struct Held {
    direction: [f64; 2],
    /// [m].
    value: f64,
    group: String,
}

impl Boundary {
    /// Prescribes the components that `directions` says [m] on a physical curve or point.
    ///
    /// # Errors
    /// [`BoundaryError::NothingThere`], [`BoundaryError::Conflict`], [`BoundaryError::Contradiction`];
    /// [`BoundaryError::NoNormal`] where a point has none.
    pub fn displace_along(
        &mut self,
        model: &Model,
        group: &str,
        directions: Directions,
        components: [Option<f64>; 2],
    ) -> Result<(), BoundaryError> {
        if directions == Directions::Turned(0.0) {
            return self.displace(model, group, components);
        }
        for (node, axes) in axes_of(model, group, directions)? {
            self.constrain(model, group, node, axes, components)?;
        }
        Ok(())
    }

    /// Prescribes zero for those components, but where something is prescribed already.
    ///
    /// # Errors
    /// As [`Boundary::displace_along`].
    pub fn hold_along(
        &mut self,
        model: &Model,
        group: &str,
        directions: Directions,
        components: [bool; 2],
    ) -> Result<(), BoundaryError> {
        if directions == Directions::Turned(0.0) {
            return self.hold(model, group, components);
        }
        for (node, axes) in axes_of(model, group, directions)? {
            self.hold_turned(model, group, node, axes, components)?;
        }
        Ok(())
    }

    /// The same at one node.
    pub(super) fn hold_turned(
        &mut self,
        model: &Model,
        group: &str,
        node: usize,
        axes: [f64; 2],
        components: [bool; 2],
    ) -> Result<(), BoundaryError> {
        for axis in (0..2).filter(|&axis| components[axis]) {
            let along = direction(&BTreeMap::from([(0, axes)]), axis);
            let held = self.held_at(node);
            let is_held = held.len() == 2
                || held
                    .iter()
                    .any(|h| cross(h.direction, along).abs() < PARALLEL);
            if !is_held {
                let mut zero = [None; 2];
                zero[axis] = Some(0.0);
                self.constrain(model, group, node, axes, zero)?;
            }
        }
        Ok(())
    }

    /// Prescribes components along axes at one node.
    pub(super) fn constrain(
        &mut self,
        model: &Model,
        group: &str,
        node: usize,
        axes: [f64; 2],
        components: [Option<f64>; 2],
    ) -> Result<(), BoundaryError> {
        let mut held = self.held_at(node);
        let now = self.node_axes.get(&node).copied().unwrap_or([1.0, 0.0]);
        let is_same =
            cross(now, axes).abs() < PARALLEL && now[0] * axes[0] + now[1] * axes[1] > 0.0;
        if held.is_empty() || is_same {
            if !is_same {
                self.node_axes.insert(node, axes);
            }
            for (axis, value) in components.into_iter().enumerate() {
                if let Some(value) = value {
                    self.prescribe(model, group, node, axis, value)?;
                }
            }
            return Ok(());
        }
        for (axis, value) in components.into_iter().enumerate() {
            if let Some(value) = value {
                held.push(Held {
                    direction: direction(&BTreeMap::from([(0, axes)]), axis),
                    value,
                    group: group.to_owned(),
                });
            }
        }
        self.merge(model, node, &held)
    }

    fn held_at(&self, node: usize) -> Vec<Held> {
        let dofs = [2 * node, 2 * node + 1].into_iter();
        dofs.filter_map(|dof| {
            let (value, group) = self.prescribed.get(&dof)?;
            Some(Held {
                direction: direction(&self.node_axes, dof),
                value: *value,
                group: group.clone(),
            })
        })
        .collect()
    }

    /// Combines several supports with different axes at one node.
    fn merge(&mut self, model: &Model, node: usize, held: &[Held]) -> Result<(), BoundaryError> {
        let first = &held[0];
        let other = held
            .iter()
            .find(|h| cross(first.direction, h.direction).abs() >= PARALLEL);
        let scale = held.iter().map(|h| h.value.abs()).fold(0.0, f64::max);
        let contradiction = |h: &Held| {
            let [x, y] = model.positions[node];
            BoundaryError::Contradiction {
                group: h.group.clone(),
                other: first.group.clone(),
                x,
                y,
            }
        };
        let Some(other) = other else {
            // All are parallel, and the first stands.
            let differs = |h: &&Held| {
                let same = dot(first.direction, h.direction).signum();
                (same * h.value - first.value).abs() > SAME * scale
            };
            return match held.iter().find(differs) {
                Some(h) => Err(contradiction(h)),
                None => Ok(()),
            };
        };
        let ([a, b], [c, d]) = (first.direction, other.direction);
        let determinant = a * d - b * c;
        let u = [
            (d * first.value - b * other.value) / determinant,
            (a * other.value - c * first.value) / determinant,
        ];
        let differs = |h: &&Held| (dot(h.direction, u) - h.value).abs() > SAME * scale;
        if let Some(h) = held.iter().find(differs) {
            return Err(contradiction(h));
        }
        self.node_axes.remove(&node);
        let group = held.last().map_or(&first.group, |h| &h.group);
        for (axis, value) in u.into_iter().enumerate() {
            self.prescribed
                .insert(2 * node + axis, (value, group.clone()));
        }
        Ok(())
    }
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// The nodes of a group, ascending, and their axes.
fn axes_of(
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
