//! The two-dimensional mesh: nodes, surface cells and named physical groups, in metres.
//!
//! A mesh knows nothing of mechanics. Node order within a cell follows Gmsh, Abaqus and VTK alike:
//! corners counter-clockwise, then mid-sides 12, 23, 34, 41 (Qian et al. 2021, fig. 3).

mod chords;
pub mod conformity;
pub mod contact;
pub mod grid;
pub mod patchwork;
pub mod selection;

use std::collections::{BTreeMap, HashMap};

/// Shape and order of a surface cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CellKind {
    Tri3,
    Tri6,
    Quad4,
    Quad8,
}

impl CellKind {
    pub const ALL: [CellKind; 4] = [
        CellKind::Tri3,
        CellKind::Tri6,
        CellKind::Quad4,
        CellKind::Quad8,
    ];

    pub fn corner_count(self) -> usize {
        match self {
            CellKind::Tri3 | CellKind::Tri6 => 3,
            CellKind::Quad4 | CellKind::Quad8 => 4,
        }
    }

    pub fn node_count(self) -> usize {
        match self {
            CellKind::Tri3 | CellKind::Quad4 => self.corner_count(),
            CellKind::Tri6 | CellKind::Quad8 => 2 * self.corner_count(),
        }
    }

    pub fn is_quadratic(self) -> bool {
        self.node_count() > self.corner_count()
    }
}

/// A surface cell: its kind and the indices of its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    pub kind: CellKind,
    nodes: [usize; 8],
}

impl Cell {
    /// `nodes` must hold `kind.node_count()` indices.
    pub fn new(kind: CellKind, nodes: &[usize]) -> Cell {
        let mut padded = [usize::MAX; 8];
        padded[..kind.node_count()].copy_from_slice(nodes);
        Cell {
            kind,
            nodes: padded,
        }
    }

    pub fn nodes(&self) -> &[usize] {
        &self.nodes[..self.kind.node_count()]
    }

    pub fn corners(&self) -> &[usize] {
        &self.nodes[..self.kind.corner_count()]
    }

    /// The cell's sides, each running counter-clockwise, so that the cell lies on its left.
    pub fn edges(&self) -> impl Iterator<Item = Edge> + '_ {
        let n = self.kind.corner_count();
        (0..n).map(move |side| Edge {
            ends: [self.nodes[side], self.nodes[(side + 1) % n]],
            middle: self.kind.is_quadratic().then(|| self.nodes[n + side]),
        })
    }
}

/// A straight (two-node) or quadratic (three-node) edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Edge {
    pub ends: [usize; 2],
    pub middle: Option<usize>,
}

impl Edge {
    /// The end nodes in ascending order: the same for both cells that share the edge.
    pub fn key(&self) -> [usize; 2] {
        let [a, b] = self.ends;
        [a.min(b), a.max(b)]
    }

    /// End, end, and the middle node if there is one.
    pub fn nodes(&self) -> impl Iterator<Item = usize> {
        self.ends.into_iter().chain(self.middle)
    }
}

/// Nodes, cells and the physical groups that name parts of them.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Node positions \[m\].
    pub nodes: Vec<[f64; 2]>,
    pub cells: Vec<Cell>,
    /// Numbers of the cells in the file that they come from; empty for a mesh made in code.
    pub cell_numbers: Vec<i64>,
    /// Physical surfaces: indices into `cells`, ascending.
    pub surfaces: BTreeMap<String, Vec<usize>>,
    /// Physical curves: their edges, in the mesher's order.
    pub curves: BTreeMap<String, Vec<Edge>>,
    /// Physical points: node indices.
    pub points: BTreeMap<String, Vec<usize>>,
}

impl Mesh {
    /// The edges that belong to exactly one of `cells`: the outline of the region they fill,
    /// holes included, each with the region on its left.
    pub fn outline(&self, cells: &[usize]) -> Vec<Edge> {
        let edges = || cells.iter().flat_map(|&c| self.cells[c].edges());
        let mut uses: HashMap<[usize; 2], u32> = HashMap::new();
        edges().for_each(|edge| *uses.entry(edge.key()).or_insert(0) += 1);
        edges().filter(|edge| uses[&edge.key()] == 1).collect()
    }

    /// The edges that a cell of `a` and a cell of `b` share, each with `a` on its left:
    /// the interface of two regions is found, not declared.
    pub fn shared_edges(&self, a: &[usize], b: &[usize]) -> Vec<Edge> {
        let other: std::collections::HashSet<[usize; 2]> =
            self.outline(b).iter().map(Edge::key).collect();
        let mut shared = self.outline(a);
        shared.retain(|edge| other.contains(&edge.key()));
        shared
    }
}
