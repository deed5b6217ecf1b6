//! The edges of the mesh that a set of nodes traces.
//!
//! A set lists nodes, a curve consists of edges. An edge belongs to the curve if all its nodes, the middle one
//! included, are in the set; edges of the mesh's outline come first, and inner ones only where a node of the set
//! is on none of those. A set that fills whole elements and is not their outline alone is no curve.

use crate::mesh::{Cell, Edge};
use std::collections::HashMap;

/// The edges of a mesh.
pub struct Edges<'a> {
    cells: &'a [Cell],
    /// Each once, in the order of the cells, with the number of cells that have it.
    edges: Vec<(Edge, u32)>,
    index: HashMap<[usize; 2], usize>,
}

/// The edges and points of a set of nodes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Traced {
    pub edges: Vec<Edge>,
    /// Nodes on none of the edges.
    pub points: Vec<usize>,
    /// Elements that the set fills; then it is no curve.
    pub filled: usize,
}

impl<'a> Edges<'a> {
    pub fn new(cells: &'a [Cell]) -> Edges<'a> {
        let mut edges: Vec<(Edge, u32)> = Vec::new();
        let mut index = HashMap::new();
        for edge in cells.iter().flat_map(Cell::edges) {
            let at = *index.entry(edge.key()).or_insert_with(|| {
                edges.push((edge, 0));
                edges.len() - 1
            });
            edges[at].1 += 1;
        }
        Edges {
            cells,
            edges,
            index,
        }
    }

    /// The mesh's edge between two nodes.
    pub fn between(&self, ends: [usize; 2]) -> Option<Edge> {
        let key = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        self.index.get(&key).map(|&at| self.edges[at].0)
    }

    /// `nodes` are below `node_count`.
    pub fn trace(&self, nodes: &[usize], node_count: usize) -> Traced {
        let mut is_member = vec![false; node_count];
        nodes.iter().for_each(|&node| is_member[node] = true);
        let mut is_covered = vec![false; node_count];
        let mut traced = Traced::default();
        let within = |edge: &Edge| edge.nodes().all(|node| is_member[node]);
        for (edge, _) in self
            .edges
            .iter()
            .filter(|(edge, uses)| *uses == 1 && within(edge))
        {
            traced.edges.push(*edge);
            edge.nodes().for_each(|node| is_covered[node] = true);
        }
        if nodes.iter().all(|&node| is_covered[node]) {
            return traced;
        }
        let is_filled = |cell: &&Cell| cell.nodes().iter().all(|&node| is_member[node]);
        let filled = self.cells.iter().filter(is_filled).count();
        if filled > 0 {
            return Traced {
                filled,
                ..Traced::default()
            };
        }
        let on_outline = is_covered.clone();
        let reaches = |edge: &Edge| edge.nodes().any(|node| !on_outline[node]);
        let inner = self.edges.iter().filter(|(_, uses)| *uses > 1);
        for (edge, _) in inner.filter(|(edge, _)| within(edge) && reaches(edge)) {
            traced.edges.push(*edge);
            edge.nodes().for_each(|node| is_covered[node] = true);
        }
        let mut points: Vec<usize> = nodes.to_vec();
        points.retain(|&node| !is_covered[node]);
        points.sort_unstable();
        points.dedup();
        Traced { points, ..traced }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::CellKind;

    /// 3 × 3 unit squares, nodes 4 j + i; the last is cut into triangles.
    fn cells() -> Vec<Cell> {
        let mut cells = Vec::new();
        for j in 0..3 {
            for i in 0..3 {
                let a = 4 * j + i;
                let corners = [a, a + 1, a + 5, a + 4];
                if (i, j) == (2, 2) {
                    cells.push(Cell::new(CellKind::Tri3, &[a, a + 1, a + 5]));
                    cells.push(Cell::new(CellKind::Tri3, &[a, a + 5, a + 4]));
                } else {
                    cells.push(Cell::new(CellKind::Quad4, &corners));
                }
            }
        }
        cells
    }

    fn keys(traced: &Traced) -> Vec<[usize; 2]> {
        let mut keys: Vec<[usize; 2]> = traced.edges.iter().map(Edge::key).collect();
        keys.sort_unstable();
        keys
    }

    #[test]
    fn sides_of_the_outline_are_curves_even_around_a_triangle() {
        let cells = cells();
        let edges = Edges::new(&cells);
        let bottom = edges.trace(&[0, 1, 2, 3], 16);
        assert_eq!(keys(&bottom), [[0, 1], [1, 2], [2, 3]]);
        assert!(bottom.points.is_empty());
        // The right side and the top hold no node of a whole element but the corner's.
        let two = edges.trace(&[3, 7, 11, 15, 14, 13, 12], 16);
        assert_eq!(keys(&two).len(), 6);
        assert_eq!((two.points.len(), two.filled), (0, 0));
    }

    #[test]
    fn inner_lines_points_and_areas_are_told_apart() {
        let cells = cells();
        let edges = Edges::new(&cells);
        let crack = edges.trace(&[4, 5, 6], 16);
        assert_eq!(keys(&crack), [[4, 5], [5, 6]]);
        let apart = edges.trace(&[0, 1, 10], 16);
        assert_eq!((keys(&apart), apart.points), (vec![[0, 1]], vec![10]));
        let area = edges.trace(&[0, 1, 4, 5, 10], 16);
        assert_eq!(
            (area.edges.len(), area.points.len(), area.filled),
            (0, 0, 1)
        );
        assert_eq!(edges.trace(&[6], 16).points, [6]);
    }
}
