//! From what meshio read to an [`Extract`]: order of nodes, direction, groups.
//!
//! Programs number the nodes of a quadratic element in two ways: corners first and then the middles, as VTK,
//! Abaqus, Nastran, MED and this program do, or corner, middle, corner around the element. The first is taken
//! unless the Jacobian of an element is not positive in it at a node or quadrature point; the other then has to
//! be right for every element of the kind, or the mesh is refused.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use thiserror::Error;

use super::container::{self, Container, Kind};
use super::curves::{Edges, Traced};
use crate::fem::element::smallest_jacobian;
use crate::gmsh::{Block, Extract, Group, Origin};
use crate::mesh::{Cell, CellKind, Edge};

/// Distance within which a node counts as lying in the plane z = 0, relative to the mesh's extent.
const PLANE_TOLERANCE: f64 = 1e-9;

/// Why a foreign mesh cannot be computed on.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ConvertError {
    #[error("it holds no plane elements to compute on; it has {what}")]
    NoElements { what: String },
    #[error(
        "{count} elements are of the kind {kind}: supported are 3- and 6-node triangles and 4- and 8-node \
         quadrilaterals"
    )]
    ElementKind { kind: String, count: u64 },
    #[error(
        "no set holds plane elements, and a region is such a set: name them where the mesh comes from (Abaqus: \
         *ELSET; Nastran: a property number; MED: a group; VTU: an integer per cell). It has {what}"
    )]
    NoSets { what: String },
    #[error(
        "node {node} lies at z = {z}, and {count} of {total} nodes off the plane z = 0: the mesh must lie in the \
         x-y plane"
    )]
    OffPlane {
        node: i64,
        z: f64,
        count: usize,
        total: usize,
    },
    #[error(
        "element {id} ({kind}), near ({x}, {y}), is folded or without area: its Jacobian is not positive in any \
         order of its nodes"
    )]
    Folded {
        id: i64,
        kind: &'static str,
        x: f64,
        y: f64,
    },
    #[error(
        "the nodes of the {kind} elements are in two orders: element {first} has its corners first, element \
         {other} corner and middle in turn"
    )]
    MixedOrder {
        kind: &'static str,
        first: i64,
        other: i64,
    },
}

/// The mesh with its sets as groups.
///
/// # Errors
/// See [`ConvertError`].
pub fn extract(container: &Container) -> Result<Extract, ConvertError> {
    let plane = |cell: &&container::Cell| cell.kind.dimension() == 2;
    check_kinds(container)?;
    if !container.cells.iter().any(|cell| plane(&cell)) {
        let what = describe(container);
        return Err(ConvertError::NoElements { what });
    }
    check_plane(container)?;
    let mut notes = left_out(container);
    let orders = orders(container, &mut notes)?;
    let mut cells: Vec<Option<Cell>> = Vec::with_capacity(container.cells.len());
    let mut turned = 0;
    for cell in &container.cells {
        cells.push(match cell_kind(cell.kind) {
            None => None,
            Some(kind) => {
                let (nodes, is_turned) = counter_clockwise(container, cell, orders[&cell.kind]);
                turned += usize::from(is_turned);
                Some(Cell::new(kind, &nodes))
            }
        });
    }
    if turned > 0 {
        notes.push(format!(
            "{turned} elements ran clockwise and were turned over"
        ));
    }
    notes.extend(coincidence(container));
    let mut builder = Builder {
        container,
        orders,
        groups: BTreeMap::new(),
        next_tag: cells.len() as u64 + 1,
        cells,
        notes,
    };
    builder.add_cell_sets();
    let named = builder.groups.keys().any(|(dimension, _)| *dimension == 2);
    if !named {
        let what = describe(container);
        return Err(ConvertError::NoSets { what });
    }
    builder.add_curves();
    Ok(builder.finish())
}

/// Where a node stands in the file: corners first, or corner and middle in turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    CornersFirst,
    AroundTheElement,
}

/// The nodes with the corners first.
fn in_order(nodes: &[usize], order: Order) -> Vec<usize> {
    match order {
        Order::CornersFirst => nodes.to_vec(),
        Order::AroundTheElement => {
            let corners = nodes.iter().step_by(2);
            corners
                .chain(nodes.iter().skip(1).step_by(2))
                .copied()
                .collect()
        }
    }
}

fn positions(container: &Container, nodes: &[usize]) -> Vec<[f64; 2]> {
    let position = |&node: &usize| [container.points[node][0], container.points[node][1]];
    nodes.iter().map(position).collect()
}

/// The nodes, corners first and counter-clockwise, and whether they had to be turned over.
fn counter_clockwise(
    container: &Container,
    cell: &container::Cell,
    order: Order,
) -> (Vec<usize>, bool) {
    let mut nodes = in_order(&cell.nodes, order);
    let corners = if nodes.len().is_multiple_of(4) { 4 } else { 3 };
    let at = positions(container, &nodes[..corners]);
    let [x0, y0] = at[0];
    let twice_area: f64 = (0..corners)
        .map(|i| (at[i], at[(i + 1) % corners]))
        .map(|([xa, ya], [xb, yb])| (xa - x0) * (yb - y0) - (xb - x0) * (ya - y0))
        .sum();
    let is_clockwise = twice_area < 0.0;
    if is_clockwise {
        nodes[1..corners].reverse();
        nodes[corners..].reverse();
    }
    (nodes, is_clockwise)
}

/// The order of each kind's nodes.
fn orders(
    container: &Container,
    notes: &mut Vec<String>,
) -> Result<BTreeMap<Kind, Order>, ConvertError> {
    let mut orders = BTreeMap::new();
    for kind in [Kind::Triangle, Kind::Triangle6, Kind::Quad, Kind::Quad8] {
        let cells = || container.cells.iter().filter(|cell| cell.kind == kind);
        let cell_kind = cell_kind(kind).expect("these lie in the plane");
        let fits = |cell: &container::Cell, order| {
            let (nodes, _) = counter_clockwise(container, cell, order);
            smallest_jacobian(cell_kind, &positions(container, &nodes)).0 > 0.0
        };
        let misfit = cells().find(|cell| !fits(cell, Order::CornersFirst));
        let Some(misfit) = misfit else {
            orders.insert(kind, Order::CornersFirst);
            continue;
        };
        let around = |cell: &container::Cell| {
            cell_kind.is_quadratic() && fits(cell, Order::AroundTheElement)
        };
        if !around(misfit) {
            return Err(folded(container, misfit));
        }
        if let Some(other) = cells().find(|cell| !around(cell)) {
            return Err(match fits(other, Order::CornersFirst) {
                true => ConvertError::MixedOrder {
                    kind: kind.name(),
                    first: other.id,
                    other: misfit.id,
                },
                false => folded(container, other),
            });
        }
        notes.push(format!(
            "the nodes of the {} elements run around the element, and were put in order: corners first",
            kind.name()
        ));
        orders.insert(kind, Order::AroundTheElement);
    }
    Ok(orders)
}

fn folded(container: &Container, cell: &container::Cell) -> ConvertError {
    let [x, y, _] = container.points[cell.nodes[0]];
    ConvertError::Folded {
        id: cell.id,
        kind: cell.kind.name(),
        x,
        y,
    }
}

fn check_kinds(container: &Container) -> Result<(), ConvertError> {
    let is_plane = |kind: &str| {
        let kind = kind.to_ascii_lowercase();
        let plane = [
            "tri",
            "quad",
            "polygon",
            "vtk_lagrange_tri",
            "vtk_lagrange_qua",
        ];
        plane.iter().any(|start| kind.starts_with(start))
    };
    match container.ignored.iter().find(|(kind, _)| is_plane(kind)) {
        Some((kind, count)) => Err(ConvertError::ElementKind {
            kind: kind.clone(),
            count: *count,
        }),
        None => Ok(()),
    }
}

fn check_plane(container: &Container) -> Result<(), ConvertError> {
    let cells = container
        .cells
        .iter()
        .filter(|cell| cell.kind.dimension() == 2);
    let used: BTreeSet<usize> = cells.flat_map(|cell| cell.nodes.iter().copied()).collect();
    let tolerance = PLANE_TOLERANCE * extent(container, &used);
    let is_off = |node: &&usize| container.points[**node][2].abs() > tolerance;
    let off: Vec<usize> = used.iter().filter(is_off).copied().collect();
    match off.first() {
        Some(&node) => Err(ConvertError::OffPlane {
            node: container.node_ids[node],
            z: container.points[node][2],
            count: off.len(),
            total: used.len(),
        }),
        None => Ok(()),
    }
}

fn left_out(container: &Container) -> Vec<String> {
    let mut notes = container.notes.clone();
    let ignored = container.ignored.iter();
    let note = |(kind, count): &(String, u64)| {
        format!("{count} of {kind} left out: no element of a plane computation")
    };
    notes.extend(ignored.map(note));
    notes
}

/// Nodes of plane elements in the same place: elements do not hang together there.
fn coincidence(container: &Container) -> Option<String> {
    let cells = container
        .cells
        .iter()
        .filter(|cell| cell.kind.dimension() == 2);
    let used: BTreeSet<usize> = cells.flat_map(|cell| cell.nodes.iter().copied()).collect();
    let grain = PLANE_TOLERANCE * extent(container, &used);
    let mut first: HashMap<[i64; 2], usize> = HashMap::new();
    let mut twins = Vec::new();
    for node in used {
        let [x, y, _] = container.points[node];
        let key = [x, y].map(|coordinate| (coordinate / grain).round() as i64);
        match first.get(&key) {
            Some(&other) => twins.push([other, node].map(|node| container.node_ids[node])),
            None => {
                first.insert(key, node);
            }
        }
    }
    let &[a, b] = twins.first()?;
    Some(format!(
        "{} nodes lie where another one does, such as {b} at {a}: the elements there are not joined",
        twins.len()
    ))
}

/// The longer side of the box around some nodes.
fn extent(container: &Container, nodes: &BTreeSet<usize>) -> f64 {
    let side = |axis: usize| {
        let values = nodes.iter().map(|&node| container.points[node][axis]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        (high - low).max(0.0)
    };
    side(0).max(side(1))
}

/// What there is, for a message.
fn describe(container: &Container) -> String {
    let mut counts: BTreeMap<&str, u64> = BTreeMap::new();
    for cell in &container.cells {
        *counts.entry(cell.kind.name()).or_insert(0) += 1;
    }
    for (kind, count) in &container.ignored {
        *counts.entry(kind.as_str()).or_insert(0) += count;
    }
    let counted: Vec<String> = counts
        .iter()
        .map(|(kind, count)| format!("{count} {kind}"))
        .collect();
    let mut parts = vec![match counted.as_slice() {
        [] => "no elements".to_owned(),
        counted => format!("the elements {}", counted.join(", ")),
    }];
    let named = |what: &str, names: Vec<&str>| match names.as_slice() {
        [] => None,
        names => Some(format!("the {what} {}", names.join(", "))),
    };
    parts.extend(named("element sets", names(&container.cell_sets)));
    parts.extend(named("node sets", names(&container.node_sets)));
    parts.extend(named("surfaces", names(&container.side_sets)));
    parts.join("; ")
}

fn names<T>(sets: &[(String, T)]) -> Vec<&str> {
    sets.iter().map(|(name, _)| name.as_str()).collect()
}

fn cell_kind(kind: Kind) -> Option<CellKind> {
    match kind {
        Kind::Triangle => Some(CellKind::Tri3),
        Kind::Triangle6 => Some(CellKind::Tri6),
        Kind::Quad => Some(CellKind::Quad4),
        Kind::Quad8 => Some(CellKind::Quad8),
        Kind::Vertex | Kind::Line | Kind::Line3 => None,
    }
}

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

struct Builder<'a> {
    container: &'a Container,
    orders: BTreeMap<Kind, Order>,
    /// Those of the plane, in order.
    cells: Vec<Option<Cell>>,
    groups: Groups,
    /// Tags 1, 2, … are the cells'; edges and points come behind.
    next_tag: u64,
    notes: Vec<String>,
}

impl Builder<'_> {
    fn insert(&mut self, name: &str, kind: Kind, tag: u64, nodes: &[usize]) {
        let key = (kind.dimension(), name.to_owned());
        let blocks = self.groups.entry(key).or_default();
        let members = blocks.entry(kind).or_default();
        members.insert(tag, nodes.to_vec());
    }

    /// Plane elements make surfaces; lines and points follow with the curves.
    fn add_cell_sets(&mut self) {
        for (name, members) in &self.container.cell_sets {
            for &index in members {
                if let Some(cell) = self.cells[index] {
                    let kind = self.container.cells[index].kind;
                    self.insert(name, kind, index as u64 + 1, cell.nodes());
                }
            }
        }
    }

    fn add_curves(&mut self) {
        let container = self.container;
        let plane: Vec<Cell> = self.cells.iter().flatten().copied().collect();
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

    fn finish(mut self) -> Extract {
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
