//! The body on its deformed shape, for pictures: displacements exaggerated by a round factor.

use crate::fem::element::MappedPoint;
use crate::geometry::chords_of;
use crate::model::Model;
use crate::output::picture::{self, Facet, Square};
use std::collections::BTreeSet;

pub(crate) struct Deformed<'a> {
    pub model: &'a Model,
    /// [m].
    displacement: &'a [[f64; 2]],
    /// `None` where nothing is displaced.
    pub exaggeration: Option<f64>,
}

impl<'a> Deformed<'a> {
    /// With a factor that makes the largest displacement a twentieth of the body.
    pub fn new(model: &'a Model, displacement: &'a [[f64; 2]]) -> Deformed<'a> {
        let exaggeration =
            picture::field::deformation_scale(extent(model), displacement.iter().copied());
        Deformed {
            model,
            displacement,
            exaggeration,
        }
    }

    /// With a factor that several pictures share.
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
        let scale = self.exaggeration.unwrap_or(0.0);
        let [x, u] = [self.model.positions[node], self.displacement[node]];
        [0, 1].map(|k| x[k] + scale * u[k])
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

    /// The material points with their `values`.
    pub fn squares(&self, values: impl IntoIterator<Item = f64>) -> Vec<Square> {
        let points = self.model.points.iter();
        let sides = points.flat_map(|points| {
            let side = points.side();
            points.nodes.clone().map(move |node| (node, side))
        });
        let square = |((node, side), value): ((usize, [f64; 2]), f64)| Square {
            centre: self.moved(node),
            side,
            value,
        };
        sides.zip(values).map(square).collect()
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

/// The body's larger side [m].
pub(crate) fn extent(model: &Model) -> f64 {
    let [low, high] = model.bounds();
    (high[0] - low[0]).max(high[1] - low[1])
}
