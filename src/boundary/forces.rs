//! Total forces, and forces per volume.
//!
//! A force F on a *curve* is the traction F/(L h_t) over its length L along the body. On a *point* it acts
//! on the finite-element node there; in a peridynamic region it is spread over the material points within δ
//! that the point sees, in proportion to A_i (1 − r²/δ²), since a load on one point would pull it out of
//! its family. Their centroid c is not the point p where that lies on a surface, so that a couple is
//! added which restores the moment about p:
//!
//! ```text
//! f_i = w_i [F + ω ẑ×(x_i − c)],   Σ w_i = 1,   ω = (c − p)×F / Σ w_i |x_i − c|² · (−1)
//! ```
//!
//! A force per *volume* b acts on elements by ∫ N_a b h_t dA and on material points by b h_t times the part
//! of their squares in the surface that it is given for, slivers as in [`crate::peridynamics::lattice`]; so
//! the resultant is exact, whatever the areas A_i.

use super::{Boundary, BoundaryError, length, outline_edges};
use crate::fem::edge::EdgeLoad;
use crate::fem::element;
use crate::geometry::Outline;
use crate::model::{Method, Model, PointRegion};
use crate::peridynamics::axes::Axes;
use crate::peridynamics::lattice::areas_within;
use std::collections::BTreeSet;

impl Boundary {
    /// Adds a total force [N] on a physical curve, or on a physical point; on several points of one group
    /// in equal parts.
    ///
    /// # Errors
    /// [`BoundaryError::NoOutline`], [`BoundaryError::NothingThere`].
    pub fn push(
        &mut self,
        model: &Model,
        group: &str,
        force: [f64; 2],
    ) -> Result<(), BoundaryError> {
        if let Some(curve) = model.mesh.curves.get(group) {
            let (on_elements, on_points) = outline_edges(model, curve);
            let beside = on_points.iter().map(|(_, edges)| length(model, edges));
            let total = length(model, &on_elements) + beside.sum::<f64>();
            if total == 0.0 {
                return Err(BoundaryError::NoOutline {
                    group: group.to_owned(),
                });
            }
            let area = total * model.settings.thickness;
            return self.press(model, group, EdgeLoad::Traction(force.map(|f| f / area)));
        }
        let points = model.mesh.points.get(group).map_or(&[][..], Vec::as_slice);
        if points.is_empty() {
            return Err(BoundaryError::NothingThere {
                group: group.to_owned(),
            });
        }
        let share = force.map(|f| f / points.len() as f64);
        for &point in points {
            if !self.push_point(model, point, share) {
                return Err(BoundaryError::NothingThere {
                    group: group.to_owned(),
                });
            }
        }
        Ok(())
    }

    /// Whether there is anything that takes the force at a node of the mesh.
    fn push_point(&mut self, model: &Model, mesh_node: usize, force: [f64; 2]) -> bool {
        if let Some(node) = model.node_of[mesh_node] {
            self.add_force(node as usize, force);
            return true;
        }
        let at = model.mesh.nodes[mesh_node];
        let Some(points) = points_at(model, at) else {
            return false;
        };
        for (node, force) in spread(model, points, at, force) {
            self.add_force(node, force);
        }
        true
    }

    /// Adds a force per volume [N/m³] on the body's cells of a physical surface.
    ///
    /// # Errors
    /// [`BoundaryError::NothingThere`].
    pub fn weigh(
        &mut self,
        model: &Model,
        group: &str,
        density: [f64; 2],
    ) -> Result<(), BoundaryError> {
        let nothing = || BoundaryError::NothingThere {
            group: group.to_owned(),
        };
        let surface = model.mesh.surfaces.get(group).ok_or_else(nothing)?;
        let cells: BTreeSet<usize> = surface.iter().copied().collect();
        let in_body = model.regions.iter().flat_map(|region| &region.cells);
        if !in_body.clone().any(|cell| cells.contains(cell)) {
            return Err(nothing());
        }
        for element in 0..model.elements.len() {
            if cells.contains(&model.elements[element].1) {
                let nodes = model.element_nodes(element);
                for (node, share) in nodes.into_iter().zip(self.volumes(model, element)) {
                    self.add_force(node as usize, density.map(|b| b * share));
                }
            }
        }
        for points in &model.points {
            for (node, volume) in volumes_of_points(model, points, &cells) {
                self.add_force(node, density.map(|b| b * volume));
            }
        }
        Ok(())
    }

    /// ∫ N_a h_t dA of an element's nodes [m³].
    fn volumes(&self, model: &Model, element: usize) -> Vec<f64> {
        let coordinates = model.element_coordinates(element);
        let shares = element::shape_integrals(model.cell(element).kind, &coordinates);
        let thickness = model.settings.thickness;
        shares.into_iter().map(|share| share * thickness).collect()
    }
}

/// The lattice whose points are near to a position.
fn points_at(model: &Model, at: [f64; 2]) -> Option<&PointRegion> {
    let near = |points: &&PointRegion| {
        let reach = super::POINT_REACH * points.micromodulus.spacing;
        let mut nodes = points.nodes.clone();
        nodes.any(|node| distance(model.positions[node], at) <= reach)
    };
    model.points.iter().find(near)
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// The forces on the material points around a position.
fn spread(
    model: &Model,
    points: &PointRegion,
    at: [f64; 2],
    force: [f64; 2],
) -> Vec<(usize, [f64; 2])> {
    let horizon = points.micromodulus.horizon;
    let visibility = model.visibility(&Axes::new(0.0), &points.micromodulus);
    let weight = |node: usize| {
        let x = model.positions[node];
        let share = 1.0 - (distance(x, at) / horizon).powi(2);
        let is_seen = share > 0.0 && visibility.sees(at, x);
        is_seen.then(|| (node, model.areas[node - model.fe_node_count()] * share))
    };
    let weights: Vec<(usize, f64)> = points.nodes.clone().filter_map(weight).collect();
    let total: f64 = weights.iter().map(|(_, w)| w).sum();
    let mean = |value: &dyn Fn([f64; 2]) -> f64| {
        let terms = weights
            .iter()
            .map(|&(node, w)| w * value(model.positions[node]));
        terms.sum::<f64>() / total
    };
    let centroid = [mean(&|x| x[0] - at[0]), mean(&|x| x[1] - at[1])];
    let arm = |x: [f64; 2]| [0, 1].map(|k| x[k] - at[k] - centroid[k]);
    let inertia = mean(&|x| arm(x).iter().map(|r| r * r).sum());
    let moment = centroid[0] * force[1] - centroid[1] * force[0];
    let turn = if inertia > 0.0 {
        -moment / inertia
    } else {
        0.0
    };
    let on_point = |&(node, w): &(usize, f64)| {
        let [x, y] = arm(model.positions[node]);
        let share = w / total;
        (
            node,
            [share * (force[0] - turn * y), share * (force[1] + turn * x)],
        )
    };
    weights.iter().map(on_point).collect()
}

/// Volume of some cells that each material point represents [m³].
fn volumes_of_points(
    model: &Model,
    points: &PointRegion,
    cells: &BTreeSet<usize>,
) -> Vec<(usize, f64)> {
    let Method::Peridynamics(settings) = model.regions[points.region].method else {
        return Vec::new();
    };
    let own = model.lattice_cells(points.region);
    let part: Vec<usize> = own.into_iter().filter(|c| cells.contains(c)).collect();
    if part.is_empty() {
        return Vec::new();
    }
    let axes = settings.lattice.axes();
    let thickness = model.settings.thickness;
    let positions: Vec<[f64; 2]> = points
        .nodes
        .clone()
        .map(|node| axes.local(model.positions[node]))
        .collect();
    let part = axes.outline(&Outline::of_cells(&model.mesh, &part));
    let anchor = axes.outline(&points.outline);
    let areas = areas_within(&part, &anchor, &settings.lattice.along_axes(), &positions);
    let areas = areas.into_iter().zip(points.nodes.clone());
    areas
        .map(|(area, node)| (node, area * thickness))
        .filter(|(_, volume)| *volume > 0.0)
        .collect()
}
