//! From what meshio read to an [`Extract`]: which elements count, their direction, their groups.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use thiserror::Error;

use super::container::{self, Container, Kind};
use super::groups::Builder;
use super::node_order::{counter_clockwise, orders};
use crate::gmsh::Extract;
use crate::mesh::{Cell, CellKind};

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
         *ELSET; Nastran: a property number; MED: a group; VTU: an integer per cell), or compute on all of it: `group: all`. It has {what}"
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

/// The mesh with its sets as groups. `whole`: all plane elements are a group if no set holds any.
///
/// # Errors
/// See [`ConvertError`].
pub fn extract(container: &Container, whole: bool) -> Result<Extract, ConvertError> {
    let plane = |cell: &&container::Cell| cell.kind.dimension() == 2;
    check_kinds(container)?;
    if !container.cells.iter().any(|cell| plane(&cell)) {
        let what = describe(container);
        return Err(ConvertError::NoElements { what });
    }
    let off_plane = nodes_off_the_plane(container);
    let is_in_plane = |cell: &container::Cell| !cell.nodes.iter().any(|&node| off_plane[node]);
    if !container
        .cells
        .iter()
        .any(|cell| plane(&cell) && is_in_plane(cell))
    {
        return Err(all_off_the_plane(container, &off_plane));
    }
    let mut notes = left_out(container);
    let orders = orders(container, &is_in_plane, &mut notes)?;
    let mut cells: Vec<Option<Cell>> = Vec::with_capacity(container.cells.len());
    let (mut turned, mut repeated) = (0, 0);
    let mut first_of: Vec<usize> = (0..container.cells.len()).collect();
    let mut seen: HashMap<Vec<usize>, usize> = HashMap::new();
    for (index, cell) in container.cells.iter().enumerate() {
        let Some(kind) = cell_kind(cell.kind) else {
            cells.push(None);
            continue;
        };
        let mut key = cell.nodes.clone();
        key.sort_unstable();
        first_of[index] = *seen.entry(key).or_insert(index);
        if first_of[index] != index {
            repeated += 1;
            cells.push(None);
            continue;
        }
        let (nodes, is_turned) = counter_clockwise(container, cell, orders[&cell.kind]);
        turned += usize::from(is_turned);
        cells.push(Some(Cell::new(kind, &nodes)));
    }
    if turned > 0 {
        notes.push(format!(
            "{turned} elements ran clockwise and were turned over"
        ));
    }
    if repeated > 0 {
        notes.push(format!(
            "{repeated} elements have the nodes of another one and were left out; their sets hold that one"
        ));
    }
    let is_flat = container.cells.iter().map(is_in_plane).collect();
    let mut builder = Builder::new(container, orders, cells, first_of, is_flat, notes);
    builder.add_cell_sets();
    if whole && !builder.has_surface() {
        builder.add_whole();
    }
    if !builder.has_surface() {
        let what = describe(container);
        return Err(ConvertError::NoSets { what });
    }
    builder.add_curves();
    Ok(builder.finish())
}

impl ConvertError {
    pub(super) fn folded(container: &Container, cell: &container::Cell) -> ConvertError {
        let [x, y, _] = container.points[cell.nodes[0]];
        ConvertError::Folded {
            id: cell.id,
            kind: cell.kind.name(),
            x,
            y,
        }
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

fn plane_nodes(container: &Container) -> BTreeSet<usize> {
    let cells = container.cells.iter();
    let plane = cells.filter(|cell| cell.kind.dimension() == 2);
    plane.flat_map(|cell| cell.nodes.iter().copied()).collect()
}

fn nodes_off_the_plane(container: &Container) -> Vec<bool> {
    let tolerance = PLANE_TOLERANCE * extent(container, &plane_nodes(container));
    let points = container.points.iter();
    points.map(|point| point[2].abs() > tolerance).collect()
}

fn all_off_the_plane(container: &Container, off_plane: &[bool]) -> ConvertError {
    let used = plane_nodes(container);
    let off: Vec<usize> = used
        .iter()
        .copied()
        .filter(|&node| off_plane[node])
        .collect();
    ConvertError::OffPlane {
        node: container.node_ids[off[0]],
        z: container.points[off[0]][2],
        count: off.len(),
        total: used.len(),
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

/// The contents of the file, for a message.
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

pub(super) fn cell_kind(kind: Kind) -> Option<CellKind> {
    match kind {
        Kind::Triangle => Some(CellKind::Tri3),
        Kind::Triangle6 => Some(CellKind::Tri6),
        Kind::Quad => Some(CellKind::Quad4),
        Kind::Quad8 => Some(CellKind::Quad8),
        Kind::Vertex | Kind::Line | Kind::Line3 => None,
    }
}
