//! Constraints: displacements that are prescribed on physical groups.
//!
//! A node that is held along neither x nor y gets axes of its own ([`super::axes`]) along which one dof or
//! both are prescribed. Where supports of different axes meet at a node, two independent directions fix it
//! altogether, and it keeps x and y; directions that are parallel must agree.

use super::axes::{Directions, PARALLEL, axes_of};
use super::groups::nodes_of;
use super::{Boundary, BoundaryError};
use crate::model::Model;
use crate::model::node_axes::direction;
use std::collections::BTreeMap;

/// Values that differ by a smaller share agree.
const SAME: f64 = 1e-9;

/// One prescribed component at a node.
struct HeldComponent {
    direction: [f64; 2],
    /// Displacement along the direction [m].
    value: f64,
    group: String,
}

impl Boundary {
    /// Prescribes the given components [m] on a physical curve or point.
    ///
    /// # Errors
    /// [`BoundaryError::NothingThere`], [`BoundaryError::Conflict`].
    pub fn displace(
        &mut self,
        model: &Model,
        group: &str,
        components: [Option<f64>; 2],
    ) -> Result<(), BoundaryError> {
        let nodes = nodes_of(model, group);
        if nodes.is_empty() {
            return Err(BoundaryError::NothingThere {
                group: group.to_owned(),
            });
        }
        for node in nodes {
            for (axis, component) in components.into_iter().enumerate() {
                if let Some(value) = component {
                    let mut alone = [None; 2];
                    alone[axis] = Some(value);
                    self.constrain(model, group, node, [1.0, 0.0], alone)?;
                }
            }
        }
        Ok(())
    }

    /// Prescribes zero for the given components of a physical curve or point, except where
    /// something is prescribed already.
    ///
    /// # Errors
    /// [`BoundaryError::NothingThere`].
    pub fn hold(
        &mut self,
        model: &Model,
        group: &str,
        components: [bool; 2],
    ) -> Result<(), BoundaryError> {
        let nodes = nodes_of(model, group);
        if nodes.is_empty() && components != [false; 2] {
            return Err(BoundaryError::NothingThere {
                group: group.to_owned(),
            });
        }
        for node in nodes {
            for axis in (0..2).filter(|&axis| components[axis]) {
                if self.node_axes.contains_key(&node) {
                    let mut zero = [false; 2];
                    zero[axis] = true;
                    self.hold_turned(model, group, node, [1.0, 0.0], zero)?;
                    continue;
                }
                let held = self.prescribed.entry(2 * node + axis);
                held.or_insert_with(|| (0.0, group.to_owned()));
            }
        }
        Ok(())
    }

    fn prescribe(
        &mut self,
        model: &Model,
        group: &str,
        node: usize,
        axis: usize,
        value: f64,
    ) -> Result<(), BoundaryError> {
        let entry = (value, group.to_owned());
        match self.prescribed.insert(2 * node + axis, entry) {
            Some((other_value, other)) if other_value != value => {
                let [x, y] = model.positions[node];
                Err(BoundaryError::Conflict {
                    group: group.to_owned(),
                    other,
                    axis: ['x', 'y'][axis],
                    x,
                    y,
                    value,
                    other_value,
                })
            }
            _ => Ok(()),
        }
    }

    /// Prescribes components along `directions` [m] on a physical curve or point.
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

    /// Prescribes zero for components along `directions`, except where something is prescribed already.
    ///
    /// # Errors
    /// See [`Boundary::displace_along`].
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

    /// Prescribes zero for components along axes at one node, except along what is prescribed already.
    fn hold_turned(
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
    fn constrain(
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
                held.push(HeldComponent {
                    direction: direction(&BTreeMap::from([(0, axes)]), axis),
                    value,
                    group: group.to_owned(),
                });
            }
        }
        self.merge(model, node, &held)
    }

    fn held_at(&self, node: usize) -> Vec<HeldComponent> {
        let dofs = [2 * node, 2 * node + 1].into_iter();
        dofs.filter_map(|dof| {
            let (value, group) = self.prescribed.get(&dof)?;
            Some(HeldComponent {
                direction: direction(&self.node_axes, dof),
                value: *value,
                group: group.clone(),
            })
        })
        .collect()
    }

    /// Combines the supports of one node that have different axes.
    fn merge(
        &mut self,
        model: &Model,
        node: usize,
        held: &[HeldComponent],
    ) -> Result<(), BoundaryError> {
        let first = &held[0];
        let other = held
            .iter()
            .find(|h| cross(first.direction, h.direction).abs() >= PARALLEL);
        let scale = held.iter().map(|h| h.value.abs()).fold(0.0, f64::max);
        let contradiction = |h: &HeldComponent| {
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
            let differs = |h: &&HeldComponent| {
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
        let differs = |h: &&HeldComponent| (dot(h.direction, u) - h.value).abs() > SAME * scale;
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
