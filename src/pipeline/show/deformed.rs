//! The body on its deformed shape, for pictures.

use super::lattice_cells::{LatticeCell, lattice_cells};
use crate::fem::element::MappedPoint;
use crate::geometry::chords_of;
use crate::model::Model;
use crate::output::picture::{self, Facet, Piece, Square};
use crate::pipeline::read::plan::Plan;
use std::collections::BTreeSet;

pub(crate) struct Deformed<'a> {
    pub model: &'a Model,
    /// [m]
    displacement: &'a [[f64; 2]],
    /// Factor of the displacements; `None` where nothing is displaced.
    pub exaggeration: Option<f64>,
}

impl<'a> Deformed<'a> {
    /// The body in still pictures: true in shape unless the pipeline exaggerates displacements, so that
    /// places can be read off the axes.
    pub fn new(plan: &Plan, model: &'a Model, displacement: &'a [[f64; 2]]) -> Deformed<'a> {
        let exaggeration = plan.output.exaggeration.unwrap_or(1.0);
        Deformed::by(Some(exaggeration), model, displacement)
    }

    /// The body with displacements multiplied by `exaggeration`.
    pub fn by(
        exaggeration: Option<f64>,
        model: &'a Model,
        displacement: &'a [[f64; 2]],
    ) -> Deformed<'a> {
        Deformed {
            model,
            displacement,
            exaggeration,
        }
    }

    /// Position of a node in the picture [m].
    pub fn moved(&self, node: usize) -> [f64; 2] {
        self.moved_with(node, self.model.positions[node])
    }

    /// Position in the picture of a place that moves with a node [m].
    fn moved_with(&self, node: usize, place: [f64; 2]) -> [f64; 2] {
        let scale = self.exaggeration.unwrap_or(0.0);
        let u = self.displacement[node];
        [0, 1].map(|k| place[k] + scale * u[k])
    }

    /// The elements; `value` of an element's node, by its number within the element.
    pub fn facets(&self, value: impl Fn(usize, usize) -> f64) -> Vec<Facet> {
        let mut facets = Vec::new();
        for element in 0..self.model.elements.len() {
            let kind = self.model.cell(element).kind;
            let nodes = self.model.element_nodes(element).into_iter();
            let shape: Vec<[f64; 2]> = nodes.map(|n| self.moved(n as usize)).collect();
            let values: Vec<f64> = (0..shape.len()).map(|node| value(element, node)).collect();
            let divisions = if kind.is_quadratic() { 4 } else { 1 };
            facets.extend(picture::facets(kind, divisions, |at| {
                let point = MappedPoint::new(kind, &shape, at);
                let terms = values.iter().zip(point.value);
                (point.position, terms.map(|(value, n)| value * n).sum())
            }));
        }
        facets
    }

    /// The material points with their `values`, in the order of the nodes: whole squares, and those that
    /// the outline of the region cuts.
    pub fn squares(&self, values: impl IntoIterator<Item = f64>) -> (Vec<Square>, Vec<Piece>) {
        let values: Vec<f64> = values.into_iter().collect();
        let value = |node: usize| values[node - self.model.fe_node_count()];
        let (mut squares, mut pieces) = (Vec::new(), Vec::new());
        for points in &self.model.points {
            let side = points.side();
            for cell in lattice_cells(points, &points.outline, |_| true) {
                match cell {
                    LatticeCell::Square(node) => squares.push(Square {
                        centre: self.moved(node),
                        side,
                        value: value(node),
                    }),
                    LatticeCell::Piece(node, corners) => pieces.push(Piece {
                        corners: corners
                            .iter()
                            .map(|&at| self.moved_with(node, at))
                            .collect(),
                        value: value(node),
                    }),
                }
            }
        }
        (squares, pieces)
    }

    /// Sides of elements, each once.
    pub fn cells(&self) -> Vec<Vec<[f64; 2]>> {
        let model = self.model;
        let mut seen = BTreeSet::new();
        let mut sides = Vec::new();
        for element in 0..model.elements.len() {
            for edge in model.cell(element).edges() {
                if seen.insert(edge.key()) {
                    sides.push(chords_of(&edge, |node| self.moved_mesh_node(node)));
                }
            }
        }
        sides
    }

    pub fn interfaces(&self) -> Vec<Vec<[f64; 2]>> {
        let edges = self.model.topology.interfaces.iter().flat_map(|i| &i.edges);
        edges
            .map(|edge| chords_of(edge, |node| self.moved_mesh_node(node)))
            .collect()
    }

    fn moved_mesh_node(&self, node: usize) -> [f64; 2] {
        let node = self.model.node_of[node].expect("elements and interfaces have element nodes");
        self.moved(node as usize)
    }
}

/// Factor by which moving pictures exaggerate displacements: the pipeline's, or else a round one that makes
/// the largest displacement a twentieth of the body; `None` where nothing is displaced.
pub(crate) fn visible_exaggeration(
    plan: &Plan,
    model: &Model,
    displacements: impl Iterator<Item = [f64; 2]>,
) -> Option<f64> {
    let [low, high] = model.bounds();
    let extent = (high[0] - low[0]).max(high[1] - low[1]);
    let usual = || picture::field::deformation_scale(extent, displacements);
    plan.output.exaggeration.or_else(usual)
}
