//! Supports and loads: physical groups to prescribed dofs and nodal forces.
//!
//! A curve acts on the finite-element nodes on it, and on the layer of material points beside it where it
//! bounds their region: those within dx/2, and the nearest to any piece that has none so near, as when
//! dx does not divide the region; none of them behind a notch or a hole, though near. A load is shared by
//! who is the nearest (`boundary/arc.rs`); where all areas are dx², as the paper has it, in proportion to
//! these.

mod arc;
mod directions;
mod forces;

use crate::fem::edge::{EdgeLoad, consistent_load, edge_points};
use crate::geometry::{chords, nearest_on_segment};
use crate::mesh::Edge;
use crate::model::node_axes::{NodeAxes, to_own};
use crate::model::{Method, Model, PointRegion};
use crate::peridynamics::axes::Axes;
use crate::peridynamics::bonds::Bins;
use crate::peridynamics::lattice::CellArea;
use crate::peridynamics::visibility::Visibility;
use std::collections::{BTreeMap, HashMap, HashSet};
use thiserror::Error;

pub use directions::Directions;

#[derive(Debug, Error)]
pub enum BoundaryError {
    #[error("group `{group}` touches no node and no material point of any region")]
    NothingThere { group: String },
    #[error("group `{group}` cannot carry a load: it bounds no region")]
    NoOutline { group: String },
    #[error("group `{group}` is a point: a traction or pressure needs a curve")]
    LoadOnPoint { group: String },
    #[error("group `{group}` has no normal everywhere")]
    NoNormal { group: String },
    #[error(
        "`{group}` and `{other}` prescribe displacements at ({x:.6e}, {y:.6e}) m that contradict \
         each other"
    )]
    Contradiction {
        group: String,
        other: String,
        x: f64,
        y: f64,
    },
    #[error(
        "`{group}` prescribes {value} m for the displacement {axis} at ({x:.6e}, {y:.6e}) m, \
         where `{other}` prescribes {other_value} m"
    )]
    Conflict {
        group: String,
        other: String,
        axis: char,
        x: f64,
        y: f64,
        value: f64,
        other_value: f64,
    },
}

/// Prescribed displacements and nodal forces, by dof.
#[derive(Clone, Debug, Default)]
pub struct Boundary {
    /// Axes of nodes that are held along neither x nor y; the model must have them too
    /// ([`Model::with_node_axes`]).
    pub node_axes: NodeAxes,
    /// Displacement [m] and the group that prescribes it, by dof in the axes of the nodes.
    pub prescribed: BTreeMap<usize, (f64, String)>,
    /// Force on every node along x and y, dof by dof [N].
    pub load: Vec<f64>,
}

/// A material point beside a curve.
struct LayerPoint {
    node: usize,
    /// Outward normal of the curve at its nearest point.
    normal: [f64; 2],
}

/// An edge of a region's outline, cut into chords: [from, to].
type Segment = [[f64; 2]; 2];

/// Points as far as this from a curve, in spacings, belong to its layer; the excess over 1/2 covers
/// rounding errors.
const LAYER_DEPTH: f64 = 0.5 + 1e-6;

/// Where no point is within the depth, the nearest belong to the layer, up to this distance, in spacings:
/// a square's diagonal.
const LAYER_REACH: f64 = 1.42;

/// Sides whose distances differ by less, in spacings, are equally near.
const EQUALLY_NEAR: f64 = 1e-9;

/// How far, in spacings, a physical point may be from the material point that stands for it: half
/// a diagonal, with room for rounding errors.
const POINT_REACH: f64 = 0.71;

impl Boundary {
    pub fn new(model: &Model) -> Boundary {
        Boundary {
            node_axes: NodeAxes::new(),
            prescribed: BTreeMap::new(),
            load: vec![0.0; 2 * model.node_count()],
        }
    }

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

    /// Prescribes zero for the given components of a physical curve or point, but where something is
    /// prescribed already.
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

    /// Adds a traction or pressure on a physical curve.
    ///
    /// # Errors
    /// [`BoundaryError::LoadOnPoint`], [`BoundaryError::NoOutline`].
    pub fn press(
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
                self.add_force(node as usize, force);
            }
        }
        for (points, edges) in &on_points {
            if has_clipped_areas(model, points) {
                if !self.press_arc(model, points, edges, load) {
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
            self.press_layer(model, &layer, length(model, edges), load);
        }
        Ok(())
    }

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

    fn press_layer(&mut self, model: &Model, layer: &[LayerPoint], length: f64, load: EdgeLoad) {
        let area = |point: &LayerPoint| model.areas[point.node - model.fe_node_count()];
        let total: f64 = layer.iter().map(area).sum();
        for point in layer {
            let share = length * model.settings.thickness * area(point) / total;
            self.add_force(point.node, load.traction(point.normal).map(|t| t * share));
        }
    }

    fn add_force(&mut self, node: usize, force: [f64; 2]) {
        self.load[2 * node] += force[0];
        self.load[2 * node + 1] += force[1];
    }
}

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
fn outline_edges<'a>(
    model: &'a Model,
    curve: &[Edge],
) -> (Vec<Edge>, Vec<(&'a PointRegion, Vec<Edge>)>) {
    let on_curve: HashSet<[usize; 2]> = curve.iter().map(Edge::key).collect();
    let all: Vec<usize> = model
        .regions
        .iter()
        .flat_map(|r| r.cells.iter().copied())
        .collect();
    let outer: HashMap<[usize; 2], Edge> = model
        .mesh
        .outline(&all)
        .into_iter()
        .filter(|edge| on_curve.contains(&edge.key()))
        .map(|edge| (edge.key(), edge))
        .collect();
    let of_cells = |cells: &[usize]| {
        let mut edges = model.mesh.outline(cells);
        edges.retain(|edge| outer.contains_key(&edge.key()));
        edges
    };
    let fem = model
        .regions
        .iter()
        .filter(|r| r.method == Method::FiniteElements);
    let on_elements = fem.flat_map(|region| of_cells(&region.cells)).collect();
    let on_points = model
        .points
        .iter()
        .map(|p| (p, of_cells(&model.lattice_cells(p.region))));
    (
        on_elements,
        on_points.filter(|(_, edges)| !edges.is_empty()).collect(),
    )
}

/// Length of the edges [m].
fn length(model: &Model, edges: &[Edge]) -> f64 {
    let points = edges
        .iter()
        .flat_map(|edge| edge_points(edge, &model.mesh.nodes));
    points.map(|point| point.length).sum()
}

/// Whether the points' areas are those of their squares in the region, and not dx² wherever they are.
fn has_clipped_areas(model: &Model, points: &PointRegion) -> bool {
    match model.regions[points.region].method {
        Method::Peridynamics(settings) => settings.lattice.cell_area == CellArea::Clipped,
        Method::FiniteElements => false,
    }
}

/// The layer of material points beside the edges, ascending.
///
/// Where a corner of the curve is nearest, or two sides are equally near, the normal is their mean:
/// the choice of one would turn the loads on a hole all the same way round.
fn layer(model: &Model, points: &PointRegion, edges: &[Edge]) -> Vec<LayerPoint> {
    let same = EQUALLY_NEAR * points.micromodulus.spacing;
    let positions = &model.positions[points.nodes.clone()];
    let bins = Bins::new(positions, 2.0 * points.micromodulus.spacing);
    let visibility = model.visibility(&Axes::new(0.0), &points.micromodulus);
    let points_beside = |segment: Segment| {
        let spacing = points.micromodulus.spacing;
        beside(segment, positions, &bins, spacing, &visibility)
    };
    let mut nearest: BTreeMap<u32, (f64, [f64; 2])> = BTreeMap::new();
    for segment in edges
        .iter()
        .flat_map(|edge| short_segments(model, edge, points))
    {
        let normal = right_of(segment);
        for (i, distance) in points_beside(segment) {
            let (other, sum) = nearest.entry(i).or_insert((distance, [0.0; 2]));
            if distance < *other - same {
                (*other, *sum) = (distance, normal);
            } else if distance < *other + same {
                *sum = [sum[0] + normal[0], sum[1] + normal[1]];
            }
        }
    }
    let point = |(i, (_, sum)): (u32, (f64, [f64; 2]))| LayerPoint {
        node: points.nodes.start + i as usize,
        normal: mean_direction(sum),
    };
    nearest.into_iter().map(point).collect()
}

/// The points within dx/2 of a short segment, or else the nearest, each with its distance [m].
fn beside(
    segment: Segment,
    positions: &[[f64; 2]],
    bins: &Bins,
    spacing: f64,
    visibility: &Visibility,
) -> Vec<(u32, f64)> {
    let middle = [0, 1].map(|axis| 0.5 * (segment[0][axis] + segment[1][axis]));
    let mut around = Vec::new();
    bins.visit_around(middle, |i| {
        let x = positions[i as usize];
        let (foot, distance) = nearest_on_segment(x, segment);
        if distance <= LAYER_REACH * spacing && visibility.sees(foot, x) {
            around.push((i, distance));
        }
    });
    let least = around.iter().map(|&(_, d)| d).fold(f64::INFINITY, f64::min);
    let depth = if least <= LAYER_DEPTH * spacing {
        LAYER_DEPTH * spacing
    } else {
        (least + EQUALLY_NEAR * spacing).min(LAYER_REACH * spacing)
    };
    around.retain(|&(_, distance)| distance <= depth);
    around
}

/// Unit normal to the right of a segment's direction.
fn right_of([a, b]: Segment) -> [f64; 2] {
    let along = [b[0] - a[0], b[1] - a[1]];
    let length = along[0].hypot(along[1]);
    [along[1] / length, -along[0] / length]
}

/// The direction of a sum of unit normals; none where opposite sides are equally near, whose pressures
/// cancel.
fn mean_direction(sum: [f64; 2]) -> [f64; 2] {
    let length = sum[0].hypot(sum[1]);
    if length > 1e-6 {
        sum.map(|n| n / length)
    } else {
        [0.0; 2]
    }
}

/// An edge in pieces no longer than dx, so that the bins of 2 dx around a piece's middle hold its layer.
fn short_segments(model: &Model, edge: &Edge, points: &PointRegion) -> Vec<Segment> {
    let mut pieces = Vec::new();
    for chord in chords(edge, &model.mesh.nodes).windows(2) {
        let [a, b] = [chord[0], chord[1]];
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let count = (length / points.micromodulus.spacing).ceil().max(1.0) as usize;
        let at = |k: usize| [0, 1].map(|x| a[x] + (b[x] - a[x]) * k as f64 / count as f64);
        pieces.extend((0..count).map(|k| [at(k), at(k + 1)]));
    }
    pieces
}
