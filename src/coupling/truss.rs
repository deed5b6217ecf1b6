//! The paper's coupling: a truss from every interface node to every material point within its
//! horizon that it sees ([`crate::peridynamics::visibility`]), Qian et al. (2021), eq. (20) and fig. 5.
//!
//! Eq. (20) is a force density. A truss has the stiffness k = c(ξ') A_FE A_j h_t / ξ', and the paper
//! does not say what the node's area A_FE is: [`NodeArea`] are the readings. None passes a patch test:
//! the trusses of a node fill half a disc only.

use super::{Parts, Tie, Tied};
use crate::fem::element;
use crate::geometry::edge_length;
use crate::interactions::Interactions;
use crate::mesh::Edge;
use crate::peridynamics::bonds::Bins;
use crate::peridynamics::lattice::ON_BOUNDARY;
use std::collections::{BTreeMap, BTreeSet};

/// The area A_FE of an interface node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NodeArea {
    /// The node's lumped "mass" area over the finite elements that touch it: reproduces Table 1.
    Lumped,
    /// The node's share of the element edges along the interface times dx. The areas of an interface
    /// sum to its length times dx.
    HalfEdge,
    /// One area for all nodes [m²].
    Given(f64),
}

impl Tie for NodeArea {
    fn name(&self) -> &'static str {
        "trusses"
    }

    /// The interface nodes stand where points on the interface would.
    fn clearance(&self) -> f64 {
        ON_BOUNDARY
    }

    fn interface_cuts_areas(&self) -> bool {
        true
    }

    fn tie(&self, bonds: Interactions, parts: &Parts) -> Tied {
        let mut interactions = bonds;
        interactions.append(trusses(&interface_nodes(parts, *self), parts));
        Tied {
            interactions,
            ..Tied::default()
        }
    }
}

/// Shares of an edge's length that its two ends and its middle stand for, ∫ N ds / L on a straight edge [-].
fn length_shares(edge: &Edge) -> [f64; 3] {
    match edge.middle {
        Some(_) => [1.0 / 6.0, 1.0 / 6.0, 4.0 / 6.0],
        None => [0.5, 0.5, 0.0],
    }
}

/// A finite-element node on the interface.
struct InterfaceNode {
    node: u32,
    /// Position along the lattice's axes [m].
    position: [f64; 2],
    /// A_FE [m²].
    area: f64,
}

/// The interface nodes of a lattice, ascending.
fn interface_nodes(parts: &Parts, node_area: NodeArea) -> Vec<InterfaceNode> {
    // Mesh node and length of the interface that each node stands for.
    let mut lengths: BTreeMap<u32, (usize, f64)> = BTreeMap::new();
    for edge in parts.interface {
        for (mesh_node, share) in edge.nodes().zip(length_shares(edge)) {
            let node = parts.node_of[mesh_node].expect("interface edges have finite-element nodes");
            let (_, length) = lengths.entry(node).or_insert((mesh_node, 0.0));
            *length += share * edge_length(edge, &parts.mesh.nodes);
        }
    }
    let lumped = match node_area {
        NodeArea::Lumped => lumped_areas(parts, &lengths.values().map(|l| l.0).collect()),
        NodeArea::HalfEdge | NodeArea::Given(_) => BTreeMap::new(),
    };
    let interface_node = |(node, (mesh_node, length))| InterfaceNode {
        node,
        position: parts.axes.local(parts.mesh.nodes[mesh_node]),
        area: match node_area {
            NodeArea::Lumped => lumped[&mesh_node],
            NodeArea::HalfEdge => length * parts.micromodulus.spacing,
            NodeArea::Given(area) => area,
        },
    };
    lengths.into_iter().map(interface_node).collect()
}

/// Lumped "mass" areas of some of the mesh's nodes over the finite elements [m²].
fn lumped_areas(parts: &Parts, wanted: &BTreeSet<usize>) -> BTreeMap<usize, f64> {
    let mut areas = BTreeMap::new();
    for &cell in parts.elements {
        let cell = &parts.mesh.cells[cell];
        if !cell.nodes().iter().any(|node| wanted.contains(node)) {
            continue;
        }
        let coordinates = cell.nodes().iter().map(|&node| parts.mesh.nodes[node]);
        let coordinates: Vec<[f64; 2]> = coordinates.collect();
        let shares = element::lumped_areas(cell.kind, &coordinates);
        for (&node, share) in cell.nodes().iter().zip(shares) {
            *areas.entry(node).or_insert(0.0) += share;
        }
    }
    areas
}

/// The trusses between `interface` and the material points, sorted by node, then by point.
fn trusses(interface: &[InterfaceNode], parts: &Parts) -> Interactions {
    let Parts {
        lattice,
        micromodulus,
        ..
    } = *parts;
    let reach = micromodulus.reach();
    let bins = Bins::new(&lattice.positions, reach);
    let mut trusses = Interactions::default();
    for end in interface {
        let mut family = Vec::new();
        let view = parts.visibility.from(end.position);
        bins.visit_around(end.position, |j| {
            let x = lattice.positions[j as usize];
            let along = [x[0] - end.position[0], x[1] - end.position[1]];
            if along[0].hypot(along[1]) <= reach && view.sees(x) {
                family.push((j, along));
            }
        });
        family.sort_unstable_by_key(|&(j, _)| j);
        for (j, along) in family {
            let areas = [end.area, lattice.areas[j as usize]];
            trusses.push_truss(
                [end.node, parts.first_node + j],
                micromodulus.axial_stiffness(along, areas, parts.thickness),
            );
        }
    }
    trusses
}
