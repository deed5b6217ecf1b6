//! Sets become groups: of elements, of sides of elements, of nodes.

use std::collections::{BTreeMap, BTreeSet};

use super::container::{self, Container, Kind};
use super::curves::{Edges, Traced};
use super::node_order::{Order, in_order};
use crate::gmsh::{Block, Extract, Group, Origin, WHOLE};
use crate::mesh::{Cell, Edge};

/// Gmsh's number, name and order of a kind.
fn gmsh_kind(kind: Kind) -> (i32, &'static str, usize) {
    match kind {
        Kind::Vertex => (15, "Point", 0),
        Kind::Line => (1, "Line 2", 1),
        Kind::Line3 => (8, "Line 3", 2),
        Kind::Triangle => (2, "Triangle 3", 1),
        Kind::Triangle6 => (9, "Triangle 6", 2),
        Kind::Quad => (3, "Quadrilateral 4", 1),
        Kind::Quad8 => (16, "Quadrilateral 8", 2),
    }
}

/// Tag → nodes.
type Members = BTreeMap<u64, Vec<usize>>;
/// Dimension and name, and what is in each group.
type GroupKey = (u8, String);
type Groups = BTreeMap<GroupKey, BTreeMap<Kind, Members>>;

/// Collects the groups of a mesh.
pub(super) struct Builder<'a> {
    container: &'a Container,
    orders: BTreeMap<Kind, Order>,
    /// The elements of the plane, their nodes in order; None for others and for repeated ones.
    cells: Vec<Option<Cell>>,
    /// The first element with the same nodes.
    first_of: Vec<usize>,
    /// Whether all nodes of a cell lie in the plane z = 0.
    is_flat: Vec<bool>,
    groups: Groups,
    /// Tags 1, 2, … are the cells'; edges and points come behind.
    next_tag: u64,
    notes: Vec<String>,
}

impl<'a> Builder<'a> {
    pub fn new(
        container: &'a Container,
        orders: BTreeMap<Kind, Order>,
        cells: Vec<Option<Cell>>,
        first_of: Vec<usize>,
        is_flat: Vec<bool>,
        notes: Vec<String>,
    ) -> Builder<'a> {
        Builder {
            container,
            orders,
            next_tag: cells.len() as u64 + 1,
            cells,
            first_of,
            is_flat,
            groups: BTreeMap::new(),
            notes,
        }
    }

    pub fn has_surface(&self) -> bool {
        self.groups.keys().any(|(dimension, _)| *dimension == 2)
    }

    fn insert(&mut self, name: &str, kind: Kind, tag: u64, nodes: &[usize]) {
        let key = (kind.dimension(), name.to_owned());
        let blocks = self.groups.entry(key).or_default();
        let members = blocks.entry(kind).or_default();
        members.insert(tag, nodes.to_vec());
    }

    /// Plane elements make surfaces; lines and points follow with the curves.
    pub fn add_cell_sets(&mut self) {
        for (name, members) in &self.container.cell_sets {
            for &index in members {
                let index = self.first_of[index];
                if let Some(cell) = self.cells[index] {
                    let kind = self.container.cells[index].kind;
                    self.insert(name, kind, index as u64 + 1, cell.nodes());
                }
            }
        }
    }

    /// All elements in the plane z = 0 as one group.
    pub fn add_whole(&mut self) {
        for index in 0..self.cells.len() {
            if let (Some(cell), true) = (self.cells[index], self.is_flat[index]) {
                let kind = self.container.cells[index].kind;
                self.insert(WHOLE, kind, index as u64 + 1, cell.nodes());
            }
        }
    }

    pub fn add_curves(&mut self) {
        let container = self.container;
        let flat = self.cells.iter().zip(&self.is_flat);
        let plane: Vec<Cell> = flat
            .filter_map(|(cell, is_flat)| cell.filter(|_| *is_flat))
            .collect();
        let edges = Edges::new(&plane);
        let mut curves: BTreeMap<&str, Vec<Edge>> = BTreeMap::new();
        let mut points: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (name, members) in &container.cell_sets {
            for cell in members.iter().map(|&index| &container.cells[index]) {
                match cell.kind {
                    Kind::Vertex => points.entry(name).or_default().push(cell.nodes[0]),
                    Kind::Line | Kind::Line3 => {
                        curves
                            .entry(name)
                            .or_default()
                            .push(line(container, cell, &edges));
                    }
                    _ => {}
                }
            }
        }
        for (name, sides) in &container.side_sets {
            let side = |&[cell, side]: &[usize; 2]| self.side(cell, side);
            curves
                .entry(name)
                .or_default()
                .extend(sides.iter().map(side));
        }
        for (name, nodes) in &container.node_sets {
            let traced: Traced = edges.trace(nodes, container.points.len());
            if traced.filled > 0 && !self.groups.contains_key(&(2, name.clone())) {
                self.notes.push(format!(
                    "the node set `{name}` fills {} elements, and is no curve",
                    traced.filled
                ));
            }
            if !traced.edges.is_empty() {
                curves.entry(name).or_default().extend(traced.edges);
            }
            if !traced.points.is_empty() {
                points.entry(name).or_default().extend(traced.points);
            }
        }
        for (name, edges) in curves {
            let mut seen = BTreeSet::new();
            for edge in edges.iter().filter(|edge| seen.insert(edge.key())) {
                let nodes: Vec<usize> = edge.nodes().collect();
                let kind = if nodes.len() == 3 {
                    Kind::Line3
                } else {
                    Kind::Line
                };
                self.insert(name, kind, self.next_tag, &nodes);
                self.next_tag += 1;
            }
        }
        for (name, nodes) in points {
            for node in BTreeSet::from_iter(nodes) {
                self.insert(name, Kind::Vertex, self.next_tag, &[node]);
                self.next_tag += 1;
            }
        }
    }

    /// Side k of an element as the file counts them: from its corner k on.
    fn side(&self, index: usize, side: usize) -> Edge {
        let cell = &self.container.cells[index];
        let nodes = in_order(&cell.nodes, self.orders[&cell.kind]);
        let corners = if nodes.len().is_multiple_of(4) { 4 } else { 3 };
        Edge {
            ends: [nodes[side], nodes[(side + 1) % corners]],
            middle: nodes.get(corners + side).copied(),
        }
    }

    pub fn finish(mut self) -> Extract {
        let used: BTreeSet<usize> = self
            .groups
            .values()
            .flat_map(|blocks| blocks.values())
            .flat_map(|members| members.values().flatten().copied())
            .collect();
        let mut place = vec![usize::MAX; self.container.points.len()];
        let used = used.iter().enumerate();
        let nodes = used.map(|(new, &old)| {
            place[old] = new;
            self.container.points[old]
        });
        let nodes = nodes.collect();
        let groups = std::mem::take(&mut self.groups).into_iter().zip(1..);
        let group = |((key, blocks), tag): ((GroupKey, BTreeMap<Kind, Members>), i32)| {
            let (dimension, name) = key;
            let block = |(kind, members): (Kind, Members)| {
                let (number, kind_name, order) = gmsh_kind(kind);
                Block {
                    kind: number,
                    kind_name: kind_name.to_owned(),
                    order,
                    nodes_per_element: kind.node_count(),
                    tags: members.keys().copied().collect(),
                    nodes: members
                        .into_values()
                        .flatten()
                        .map(|node| place[node])
                        .collect(),
                }
            };
            Group {
                dimension,
                tag,
                name,
                blocks: blocks.into_iter().map(block).collect(),
            }
        };
        Extract {
            origin: Origin {
                program: "meshio".to_owned(),
                version: self.container.version.clone(),
            },
            warnings: self.notes,
            nodes,
            groups: groups.map(group).collect(),
            element_numbers: self.container.cells.iter().map(|cell| cell.id).collect(),
            ..Extract::default()
        }
    }
}

/// A line of the file as an edge. Of a line with three nodes, the middle one lies opposite the longest distance: the
/// file may have it second (beams) or last. A line without a middle takes that of the element's edge.
fn line(container: &Container, cell: &container::Cell, edges: &Edges) -> Edge {
    let [a, b] = [cell.nodes[0], cell.nodes[1]];
    let Some(&c) = cell.nodes.get(2) else {
        let ends = [a, b];
        return edges.between(ends).unwrap_or(Edge { ends, middle: None });
    };
    let distance = |[p, q]: [usize; 2]| {
        let ([xp, yp, _], [xq, yq, _]) = (container.points[p], container.points[q]);
        (xp - xq).hypot(yp - yq)
    };
    let splits = [([a, b], c), ([a, c], b), ([b, c], a)];
    let longest =
        splits
            .into_iter()
            .reduce(|best, other| match distance(other.0) > distance(best.0) {
                true => other,
                false => best,
            });
    let (ends, middle) = longest.expect("there are three");
    Edge {
        ends,
        middle: Some(middle),
    }
}
