//! Trusses between interface nodes and the material points within their horizon.

use super::{Method, Model, PointRegion};
use crate::coupling::truss::{InterfaceNode, NodeArea, length_shares, trusses};
use crate::fem::element;
use std::collections::BTreeMap;

impl Model {
    pub(super) fn add_trusses(&mut self, node_area: NodeArea) {
        let lumped = self.lumped_areas();
        for points in &self.points {
            let ends = self.interface_nodes(points, &lumped, node_area);
            let fe_nodes = self.positions.len() - self.areas.len();
            let range = points.nodes.start - fe_nodes..points.nodes.end - fe_nodes;
            let Method::Peridynamics(settings) = self.regions[points.region].method else {
                continue;
            };
            let axes = settings.lattice.axes();
            let visibility = self.visibility(&axes, &points.micromodulus);
            let positions = self.positions[points.nodes.clone()].iter();
            let positions: Vec<[f64; 2]> = positions.map(|&x| axes.local(x)).collect();
            let local = |end: InterfaceNode| InterfaceNode {
                position: axes.local(end.position),
                ..end
            };
            let ends: Vec<InterfaceNode> = ends.into_iter().map(local).collect();
            self.interactions.append(trusses(
                &ends,
                &positions,
                &self.areas[range],
                &points.micromodulus,
                self.settings.thickness,
                points.nodes.start as u32,
                &visibility,
            ));
        }
    }

    /// The interface nodes of one peridynamic region with their areas A_FE, in ascending order.
    fn interface_nodes(
        &self,
        points: &PointRegion,
        lumped: &[f64],
        node_area: NodeArea,
    ) -> Vec<InterfaceNode> {
        let mut lengths: BTreeMap<u32, f64> = BTreeMap::new();
        let touching = self.interfaces_of(points.region);
        for edge in touching.flat_map(|i| &i.edges) {
            for (node, share) in edge.nodes().zip(length_shares(edge)) {
                let node = self.node_of[node].expect("an interface edge has finite-element nodes");
                *lengths.entry(node).or_insert(0.0) += share * self.edge_length(edge);
            }
        }
        let area = |node: u32, length: f64| match node_area {
            NodeArea::Lumped => lumped[node as usize],
            NodeArea::HalfEdge => length * points.micromodulus.spacing,
            NodeArea::Given(area) => area,
        };
        lengths
            .into_iter()
            .map(|(node, length)| InterfaceNode {
                node,
                position: self.positions[node as usize],
                area: area(node, length),
            })
            .collect()
    }

    /// Lumped "mass" area of every finite-element node [m²].
    fn lumped_areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.fe_node_count()];
        for element in 0..self.elements.len() {
            let coordinates = self.element_coordinates(element);
            let shares = element::lumped_areas(self.cell(element).kind, &coordinates);
            for (node, share) in self.element_nodes(element).into_iter().zip(shares) {
                areas[node as usize] += share;
            }
        }
        areas
    }
}
