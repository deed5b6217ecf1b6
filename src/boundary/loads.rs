//! Loads on physical curves and points.
//!
//! A *traction* or pressure on a curve acts on finite elements by consistent loads, and on a layer of
//! material points: each takes the part of the curve to which it is the nearest ([`super::nearest`]), or
//! where all areas are dx², as the paper has it, a share in proportion to its area.
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

use super::groups::{POINT_REACH, length, outline_edges};
use super::layer::{LayerPoint, layer};
use super::{Boundary, BoundaryError};
use crate::fem::edge::{EdgeLoad, consistent_load};
use crate::model::{Model, PointRegion};
use crate::peridynamics::axes::Axes;

impl Boundary {
    /// Adds a traction or pressure on a physical curve.
    ///
    /// # Errors
    /// [`BoundaryError::LoadOnPoint`], [`BoundaryError::NoOutline`].
    pub fn add_traction(
        &mut self,
        model: &Model,
        group: &str,
        load: EdgeLoad,
    ) -> Result<(), BoundaryError> {
        let Some(curve) = model.mesh.curves.get(group) else {
            return Err(BoundaryError::LoadOnPoint {
                group: group.to_owned(),
            });
        };
        let (on_elements, on_points) = outline_edges(model, curve);
        if on_elements.is_empty() && on_points.is_empty() {
            return Err(BoundaryError::NoOutline {
                group: group.to_owned(),
            });
        }
        let thickness = model.settings.thickness;
        for edge in &on_elements {
            for (node, force) in consistent_load(edge, &model.mesh.nodes, load, thickness) {
                let node = model.node_of[node].expect("an outline edge has finite-element nodes");
                self.add_nodal_force(node as usize, force);
            }
        }
        for (points, edges) in &on_points {
            if model.has_clipped_areas(points) {
                if !self.add_nearest_traction(model, points, edges, load) {
                    return Err(BoundaryError::NothingThere {
                        group: group.to_owned(),
                    });
                }
                continue;
            }
            let layer = layer(model, points, edges);
            if layer.is_empty() {
                return Err(BoundaryError::NothingThere {
                    group: group.to_owned(),
                });
            }
            self.add_traction_by_area(model, &layer, length(model, edges), load);
        }
        Ok(())
    }

    /// Adds a total force [N] on a physical curve, or on a physical point; on several points of one group
    /// in equal parts.
    ///
    /// # Errors
    /// [`BoundaryError::NoOutline`], [`BoundaryError::NothingThere`].
    pub fn add_force(
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
            return self.add_traction(model, group, EdgeLoad::Traction(force.map(|f| f / area)));
        }
        let points = model.mesh.points.get(group).map_or(&[][..], Vec::as_slice);
        if points.is_empty() {
            return Err(BoundaryError::NothingThere {
                group: group.to_owned(),
            });
        }
        let share = force.map(|f| f / points.len() as f64);
        for &point in points {
            if !self.add_point_force(model, point, share) {
                return Err(BoundaryError::NothingThere {
                    group: group.to_owned(),
                });
            }
        }
        Ok(())
    }

    /// Adds a force [N] at a node of the mesh. Returns whether anything of the body is there.
    fn add_point_force(&mut self, model: &Model, mesh_node: usize, force: [f64; 2]) -> bool {
        if let Some(node) = model.node_of[mesh_node] {
            self.add_nodal_force(node as usize, force);
            return true;
        }
        let at = model.mesh.nodes[mesh_node];
        let Some(points) = points_at(model, at) else {
            return false;
        };
        for (node, force) in spread(model, points, at, force) {
            self.add_nodal_force(node, force);
        }
        true
    }

    /// Adds a traction on a layer of points over a curve's length [m], in proportion to their areas.
    fn add_traction_by_area(
        &mut self,
        model: &Model,
        layer: &[LayerPoint],
        length: f64,
        load: EdgeLoad,
    ) {
        let area = |point: &LayerPoint| model.areas[point.node - model.fe_node_count()];
        let total: f64 = layer.iter().map(area).sum();
        for point in layer {
            let share = length * model.settings.thickness * area(point) / total;
            self.add_nodal_force(point.node, load.traction(point.normal).map(|t| t * share));
        }
    }

    /// Adds a force along x and y at a node [N].
    pub(super) fn add_nodal_force(&mut self, node: usize, force: [f64; 2]) {
        self.load[2 * node] += force[0];
        self.load[2 * node + 1] += force[1];
    }
}

/// The lattice whose points are near to a position.
fn points_at(model: &Model, at: [f64; 2]) -> Option<&PointRegion> {
    let near = |points: &&PointRegion| {
        let reach = POINT_REACH * points.micromodulus.spacing;
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
