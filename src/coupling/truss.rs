//! The paper's coupling: a truss from every interface node to every material point within its
//! horizon that it sees ([`crate::peridynamics::visibility`]), Qian et al. (2021), eq. (20) and fig. 5.
//!
//! Eq. (20) is a force density. A truss has the stiffness k = c(ξ') A_FE A_j h_t / ξ', and the paper
//! does not say what the node's area A_FE is: [`NodeArea`] are the readings. None passes a patch test:
//! the trusses of a node fill half a disc only.

use crate::interactions::Interactions;
use crate::mesh::Edge;
use crate::peridynamics::bonds::Bins;
use crate::peridynamics::kernel::Micromodulus;
use crate::peridynamics::visibility::Visibility;

/// The area A_FE of an interface node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NodeArea {
    /// The node's lumped "mass" area over the finite elements that touch it: reproduces Table 1.
    Lumped,
    /// The node's share of the element edges along the interface times dx, see [`length_shares`]: the areas of
    /// an interface sum to its length times dx.
    HalfEdge,
    /// One area for all nodes [m²].
    Given(f64),
}

/// Shares of an edge's length that its two ends and its middle stand for, ∫ N ds / L on a straight edge [-].
pub fn length_shares(edge: &Edge) -> [f64; 3] {
    match edge.middle {
        Some(_) => [1.0 / 6.0, 1.0 / 6.0, 4.0 / 6.0],
        None => [0.5, 0.5, 0.0],
    }
}

/// A finite-element node on the interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfaceNode {
    pub node: u32,
    /// Along the lattice's axes for [`trusses`] [m].
    pub position: [f64; 2],
    /// A_FE [m²].
    pub area: f64,
}

/// The trusses between `interface` and the material points, sorted by node, then by point.
///
/// `points`, `areas`: of the material points [m, m²], whose nodes count from `first_node`. All positions
/// are along the lattice's axes.
pub fn trusses(
    interface: &[InterfaceNode],
    points: &[[f64; 2]],
    areas: &[f64],
    micromodulus: &Micromodulus,
    thickness: f64,
    first_node: u32,
    visibility: &Visibility,
) -> Interactions {
    let reach = micromodulus.reach();
    let bins = Bins::new(points, reach);
    let mut trusses = Interactions::default();
    for end in interface {
        let mut family = Vec::new();
        let view = visibility.from(end.position);
        bins.visit_around(end.position, |j| {
            let x = points[j as usize];
            let along = [x[0] - end.position[0], x[1] - end.position[1]];
            if along[0].hypot(along[1]) <= reach && view.sees(x) {
                family.push((j, along));
            }
        });
        family.sort_unstable_by_key(|&(j, _)| j);
        for (j, along) in family {
            let areas = [end.area, areas[j as usize]];
            trusses.push_truss(
                [end.node, first_node + j],
                micromodulus.axial_stiffness(along, areas, thickness),
            );
        }
    }
    trusses
}
