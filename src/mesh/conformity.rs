//! Do the cells of a body fit together along their edges?
//!
//! Cells run counter-clockwise, so that two neighbours run through their common edge in opposite
//! directions. Each direction of an edge therefore belongs to one cell at most: a second one lies on the
//! same side, over the first. A third cell on an edge always repeats a direction. Neighbours must also
//! share the middle node, or displacements are not continuous across the edge.

use super::{Edge, Mesh};
use rayon::prelude::*;

/// Two cells that do not fit together at an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    pub kind: MisfitKind,
    /// Indices of the two cells.
    pub cells: [usize; 2],
    /// Place of the misfit \[m\].
    pub at: [f64; 2],
}

/// The ways in which two cells do not fit together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MisfitKind {
    /// Both cells lie on the same side of an edge.
    SameSide,
    /// The cells share the ends of an edge and not its middle node.
    MiddleNode,
    /// A node of one cell lies within an edge of the other.
    HangingNode,
    /// One cell covers a part of the other.
    Overlap,
}

/// One direction of an edge: sorted by its key, the directions of an edge are neighbours.
struct Side {
    edge: Edge,
    cell: usize,
}

/// The sides of all `cells`, those of the same edge beside each other.
fn sides(mesh: &Mesh, cells: &[usize]) -> Vec<Side> {
    let of_cell = |&cell: &usize| {
        let edges = mesh.cells[cell].edges();
        edges.map(move |edge| Side { edge, cell })
    };
    let mut sides: Vec<Side> = cells.iter().flat_map(of_cell).collect();
    sides.par_sort_unstable_by_key(|side| (side.edge.key(), side.edge.ends, side.cell));
    sides
}

/// Checks that no two of the `cells` lie on the same side of an edge.
///
/// # Errors
/// The first two that do.
pub fn check_sides(mesh: &Mesh, cells: &[usize]) -> Result<(), Misfit> {
    find(mesh, cells, MisfitKind::SameSide, |a, b| a.ends == b.ends)
}

/// Checks that neighbours among the `cells` share the middle nodes of their edges.
///
/// # Errors
/// The first two that do not.
pub fn check_middle_nodes(mesh: &Mesh, cells: &[usize]) -> Result<(), Misfit> {
    find(mesh, cells, MisfitKind::MiddleNode, |a, b| {
        a.key() == b.key() && a.middle != b.middle
    })
}

fn find(
    mesh: &Mesh,
    cells: &[usize],
    kind: MisfitKind,
    is_misfit: impl Fn(&Edge, &Edge) -> bool,
) -> Result<(), Misfit> {
    let sides = sides(mesh, cells);
    let mut pairs = sides.windows(2);
    match pairs.find(|pair| is_misfit(&pair[0].edge, &pair[1].edge)) {
        None => Ok(()),
        Some(pair) => {
            let [a, b] = pair[0].edge.ends.map(|end| mesh.nodes[end]);
            Err(Misfit {
                kind,
                cells: [pair[0].cell, pair[1].cell],
                at: [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])],
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Cell, CellKind};

    fn mesh(nodes: &[[f64; 2]], cells: &[(CellKind, &[usize])]) -> Mesh {
        let cell = |(kind, nodes): &(CellKind, &[usize])| Cell::new(*kind, nodes);
        Mesh {
            nodes: nodes.to_vec(),
            cells: cells.iter().map(cell).collect(),
            ..Mesh::default()
        }
    }

    const SQUARES: [[f64; 2]; 6] = [[0., 0.], [1., 0.], [2., 0.], [0., 1.], [1., 1.], [2., 1.]];

    #[test]
    fn neighbours_fit_and_a_cell_over_another_does_not() {
        let left = (CellKind::Quad4, &[0, 1, 4, 3][..]);
        let right = (CellKind::Quad4, &[1, 2, 5, 4][..]);
        let over = (CellKind::Tri3, &[1, 2, 5][..]);
        let sound = mesh(&SQUARES, &[left, right]);
        assert_eq!(check_sides(&sound, &[0, 1]), Ok(()));
        let doubled = mesh(&SQUARES, &[left, right, over]);
        let misfit = check_sides(&doubled, &[0, 1, 2]).unwrap_err();
        assert_eq!(
            (misfit.kind, misfit.cells, misfit.at),
            (MisfitKind::SameSide, [1, 2], [1.5, 0.0])
        );
        assert_eq!(check_sides(&doubled, &[0, 2]), Ok(()), "one is left out");
    }

    #[test]
    fn a_quadratic_cell_beside_a_linear_one_is_found() {
        let mut nodes = SQUARES.to_vec();
        nodes.extend([[0.5, 0.0], [1.0, 0.5], [0.5, 1.0], [0.0, 0.5]]);
        let left = (CellKind::Quad8, &[0, 1, 4, 3, 6, 7, 8, 9][..]);
        let right = (CellKind::Quad4, &[1, 2, 5, 4][..]);
        let mixed = mesh(&nodes, &[left, right]);
        let misfit = check_middle_nodes(&mixed, &[0, 1]).unwrap_err();
        assert_eq!(
            (misfit.kind, misfit.cells, misfit.at),
            (MisfitKind::MiddleNode, [0, 1], [1.0, 0.5])
        );
        assert_eq!(check_middle_nodes(&mixed, &[1]), Ok(()));
    }
}
