//! From what Gmsh delivered to the mesh that the method works on, in metres.
//!
//! - Cells are ordered by their tags, and an element of several physical surfaces is one cell.
//! - Cells that run clockwise (a surface whose outline was drawn clockwise) are turned over: their
//!   first corner stays the first.
//! - Gmsh places the middle node of a straight side with an error of some 1e-12 of the side's length.
//!   Such nodes are put exactly between their ends. Nodes are never merged.

use std::collections::BTreeMap;

use thiserror::Error;

use super::extract::{Block, Extract, Group};
use crate::mesh::{Cell, CellKind, Edge, Mesh};

/// Distance within which a middle node counts as the midpoint, relative to the mesh's extent: rounding
/// errors grow with the coordinates, and a hundred times as much as seen is allowed for.
const MIDPOINT_TOLERANCE: f64 = 2e-12;
/// Distance within which a node counts as lying in the plane z = 0, relative to the mesh's extent.
const PLANE_TOLERANCE: f64 = 1e-9;
/// Area below which a cell counts as degenerate, relative to the square of its longest side.
const AREA_TOLERANCE: f64 = 1e-12;

/// Why a Gmsh model cannot be computed on, and what to change in the geometry.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ExtractError {
    #[error("the unit of length must be a positive number of metres, not {unit}")]
    Unit { unit: f64 },
    #[error(
        "the geometry has no physical surface; it has {surfaces} plain surface(s) and {groups}. \
         Name what to compute on: Physical Surface(\"plate\") = {{1}};"
    )]
    NoPhysicalSurface { surfaces: usize, groups: String },
    #[error(
        "the mesh holds no surface elements; physical surfaces: {}. Do they list existing \
         surfaces, and was a .msh saved with a two-dimensional mesh?",
        .surfaces.join(", ")
    )]
    NoElements { surfaces: Vec<String> },
    #[error("{count} element(s) of physical group '{group}' are of type '{kind}': {remedy}")]
    ElementKind {
        group: String,
        kind: String,
        count: usize,
        remedy: &'static str,
    },
    #[error(
        "{count} of {total} nodes lie off the plane z = 0 (the farthest at z = {farthest}, in the \
         geometry's unit): draw the geometry in the x-y plane"
    )]
    OffPlane {
        count: usize,
        total: usize,
        farthest: f64,
    },
    #[error("the stored mesh is damaged: {reason}")]
    Damaged { reason: String },
    #[error(
        "element {tag} of physical surface '{group}', near ({x}, {y}) in the geometry's unit, has \
         no area: are points of the geometry on top of each other?"
    )]
    Degenerate {
        tag: u64,
        group: String,
        x: f64,
        y: f64,
    },
}

impl Extract {
    /// The mesh, with lengths in metres; `unit_in_metres` is the geometry's unit (0.001 for mm).
    pub fn to_mesh(&self, unit_in_metres: f64) -> Result<Mesh, ExtractError> {
        if !(unit_in_metres > 0.0 && unit_in_metres.is_finite()) {
            return Err(ExtractError::Unit {
                unit: unit_in_metres,
            });
        }
        self.check_groups()?;
        self.check_plane()?;
        let mut mesh = Mesh {
            nodes: self
                .nodes
                .iter()
                .map(|&[x, y, _]| [x * unit_in_metres, y * unit_in_metres])
                .collect(),
            ..Mesh::default()
        };
        self.add_cells(&mut mesh)?;
        self.add_curves(&mut mesh);
        self.add_points(&mut mesh);
        snap_middle_nodes(
            &mut mesh,
            MIDPOINT_TOLERANCE * self.extent() * unit_in_metres,
        );
        Ok(mesh)
    }

    fn groups_of(&self, dimension: u8) -> impl Iterator<Item = &Group> {
        let groups = self.groups.iter();
        groups.filter(move |group| group.dimension == dimension)
    }

    /// Blocks of the physical groups of a dimension, each with its group's label.
    fn blocks_of(&self, dimension: u8) -> impl Iterator<Item = (String, &Block)> {
        self.groups_of(dimension)
            .flat_map(|group| group.blocks.iter().map(|block| (group.label(), block)))
    }

    fn check_groups(&self) -> Result<(), ExtractError> {
        if self.groups_of(2).next().is_none() {
            return Err(ExtractError::NoPhysicalSurface {
                surfaces: self.entity_counts[2],
                groups: self.describe_groups(),
            });
        }
        if self.groups_of(2).all(Group::is_empty) {
            return Err(ExtractError::NoElements {
                surfaces: self.groups_of(2).map(Group::label).collect(),
            });
        }
        for dimension in 0..=3 {
            for (group, block) in self.blocks_of(dimension) {
                check_kind(dimension, group, block)?;
            }
        }
        self.check_indices()
    }

    /// A file of an earlier run may have come from anywhere: nothing in it is trusted.
    fn check_indices(&self) -> Result<(), ExtractError> {
        let damaged = |reason: String| Err(ExtractError::Damaged { reason });
        if self.nodes.iter().flatten().any(|x| !x.is_finite()) {
            return damaged("a coordinate is no number".to_owned());
        }
        for group in &self.groups {
            for block in &group.blocks {
                let kind = &block.kind_name;
                let label = group.label();
                let each = block.nodes_per_element;
                let is_empty = block.tags.is_empty() && block.nodes.is_empty();
                let is_whole = nodes_of_kind(block.kind) == Some(each)
                    && each.checked_mul(block.tags.len()) == Some(block.nodes.len());
                // An empty one may have no nodes to count, but not none per element.
                if each == 0 || !(is_empty || is_whole) {
                    return damaged(format!(
                        "the elements '{kind}' of physical group '{label}' lack nodes"
                    ));
                }
                if let Some(node) = block.nodes.iter().find(|&&node| node >= self.nodes.len()) {
                    let total = self.nodes.len();
                    return damaged(format!(
                        "physical group '{label}' names the node {node}, of {total}"
                    ));
                }
            }
        }
        Ok(())
    }

    fn describe_groups(&self) -> String {
        let kinds = ["point", "curve", "surface", "volume"];
        let described: Vec<String> = self
            .groups
            .iter()
            .map(|group| {
                let kind = kinds.get(usize::from(group.dimension)).unwrap_or(&"group");
                format!("physical {kind} '{}'", group.label())
            })
            .collect();
        match described.as_slice() {
            [] => "no physical groups at all".to_owned(),
            groups => groups.join(", "),
        }
    }

    fn check_plane(&self) -> Result<(), ExtractError> {
        let tolerance = PLANE_TOLERANCE * self.extent();
        let off: Vec<f64> = self
            .nodes
            .iter()
            .map(|node| node[2])
            .filter(|z| z.abs() > tolerance)
            .collect();
        if off.is_empty() {
            return Ok(());
        }
        let farthest = off
            .iter()
            .copied()
            .fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
        Err(ExtractError::OffPlane {
            count: off.len(),
            total: self.nodes.len(),
            farthest,
        })
    }

    /// The longer side of the bounding box in x and y [unit of the geometry].
    fn extent(&self) -> f64 {
        let side = |axis: usize| {
            let values = self.nodes.iter().map(|node| node[axis]);
            let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
            (high - low).max(0.0)
        };
        side(0).max(side(1))
    }

    fn add_cells(&self, mesh: &mut Mesh) -> Result<(), ExtractError> {
        let mut cells: BTreeMap<u64, Cell> = BTreeMap::new();
        for (group, block) in self.blocks_of(2) {
            let kind = cell_kind(block.kind).expect("check_groups has passed every block");
            for (tag, nodes) in block.elements() {
                let cell = self.counter_clockwise(kind, nodes).ok_or_else(|| {
                    let [x, y, _] = self.nodes[nodes[0]];
                    let group = group.clone();
                    ExtractError::Degenerate { tag, group, x, y }
                })?;
                cells.insert(tag, cell);
            }
        }
        let index: BTreeMap<u64, usize> = cells.keys().copied().zip(0..).collect();
        mesh.cells = cells.into_values().collect();
        for group in self.groups_of(2) {
            let members = mesh.surfaces.entry(group.label()).or_default();
            let tags = group.blocks.iter().flat_map(|block| &block.tags);
            members.extend(tags.map(|tag| index[tag]));
            members.sort_unstable();
            members.dedup();
        }
        Ok(())
    }

    /// The cell with its corners counter-clockwise; None if it has no area.
    fn counter_clockwise(&self, kind: CellKind, nodes: &[usize]) -> Option<Cell> {
        let corners = kind.corner_count();
        let position = |side: usize| self.nodes[nodes[side % corners]];
        let (mut area, mut longest) = (0.0, 0.0_f64);
        let origin = position(0);
        for side in 0..corners {
            let ([xa, ya, _], [xb, yb, _]) = (position(side), position(side + 1));
            area +=
                0.5 * ((xa - origin[0]) * (yb - origin[1]) - (xb - origin[0]) * (ya - origin[1]));
            longest = longest.max((xb - xa).hypot(yb - ya));
        }
        let has_area = area.abs() > AREA_TOLERANCE * longest * longest;
        if !has_area {
            return None;
        }
        let mut nodes = nodes.to_vec();
        if area < 0.0 {
            nodes[1..corners].reverse();
            nodes[corners..].reverse();
        }
        Some(Cell::new(kind, &nodes))
    }

    fn add_curves(&self, mesh: &mut Mesh) {
        for group in self.groups_of(1) {
            let edges = mesh.curves.entry(group.label()).or_default();
            for (_, nodes) in group.blocks.iter().flat_map(Block::elements) {
                edges.push(Edge {
                    ends: [nodes[0], nodes[1]],
                    middle: nodes.get(2).copied(),
                });
            }
        }
    }

    fn add_points(&self, mesh: &mut Mesh) {
        for group in self.groups_of(0) {
            let points = mesh.points.entry(group.label()).or_default();
            points.extend(group.blocks.iter().flat_map(|block| &block.nodes));
            points.sort_unstable();
            points.dedup();
        }
    }
}

/// The cell that a Gmsh element type stands for.
fn cell_kind(kind: i32) -> Option<CellKind> {
    match kind {
        2 => Some(CellKind::Tri3),
        3 => Some(CellKind::Quad4),
        9 => Some(CellKind::Tri6),
        16 => Some(CellKind::Quad8),
        _ => None,
    }
}

/// Of the types that [`check_kind`] lets through.
fn nodes_of_kind(kind: i32) -> Option<usize> {
    match kind {
        15 => Some(1),
        1 => Some(2),
        8 => Some(3),
        kind => cell_kind(kind).map(CellKind::node_count),
    }
}

fn check_kind(dimension: u8, group: String, block: &Block) -> Result<(), ExtractError> {
    let fits = match dimension {
        0 => block.kind == 15,
        1 => matches!(block.kind, 1 | 8),
        2 => cell_kind(block.kind).is_some(),
        _ => false,
    };
    if fits {
        return Ok(());
    }
    let remedy = match (dimension, block.kind, block.order) {
        (3, ..) => "the computation is two-dimensional; remove the physical volume",
        (_, 10, _) => {
            "their middle node is not supported; write Mesh.SecondOrderIncomplete = 1; in the .geo"
        }
        (_, _, 3..) => {
            "the order is at most 2; write Mesh.ElementOrder = 2; and \
             Mesh.SecondOrderIncomplete = 1; in the .geo"
        }
        _ => "supported are 3- and 6-node triangles and 4- and 8-node quadrilaterals",
    };
    Err(ExtractError::ElementKind {
        group,
        kind: block.kind_name.clone(),
        count: block.tags.len(),
        remedy,
    })
}

fn snap_middle_nodes(mesh: &mut Mesh, tolerance: f64) {
    let cell_edges = mesh.cells.iter().flat_map(Cell::edges);
    let curve_edges = mesh.curves.values().flatten().copied();
    for edge in cell_edges.chain(curve_edges) {
        let Some(middle) = edge.middle else { continue };
        let [a, b] = edge.ends.map(|end| mesh.nodes[end]);
        let midpoint = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        let node = &mut mesh.nodes[middle];
        if (node[0] - midpoint[0]).hypot(node[1] - midpoint[1]) <= tolerance {
            *node = midpoint;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(kind: i32, name: &str, order: usize, elements: &[(u64, &[usize])]) -> Block {
        Block {
            kind,
            kind_name: name.to_owned(),
            order,
            nodes_per_element: elements.first().map_or(1, |(_, nodes)| nodes.len()),
            tags: elements.iter().map(|(tag, _)| *tag).collect(),
            nodes: elements
                .iter()
                .flat_map(|(_, nodes)| nodes.to_vec())
                .collect(),
        }
    }

    fn group(dimension: u8, tag: i32, name: &str, blocks: Vec<Block>) -> Group {
        Group {
            dimension,
            tag,
            name: name.to_owned(),
            blocks,
        }
    }

    /// Two unit quads side by side: nodes 0 1 2 below, 3 4 5 above.
    fn two_quads() -> Extract {
        let left = (7, &[0, 1, 4, 3][..]);
        let right = (5, &[1, 2, 5, 4][..]);
        Extract {
            nodes: (0..6)
                .map(|i| [f64::from(i % 3), f64::from(i / 3), 0.0])
                .collect(),
            groups: vec![
                group(0, 1, "origin", vec![block(15, "Point", 0, &[(1, &[0])])]),
                group(
                    1,
                    1,
                    "base",
                    vec![block(1, "Line 2", 1, &[(2, &[0, 1]), (3, &[1, 2])])],
                ),
                group(2, 1, "left", vec![block(3, "Quadrilateral 4", 1, &[left])]),
                group(
                    2,
                    9,
                    "",
                    vec![block(3, "Quadrilateral 4", 1, &[right, left])],
                ),
            ],
            entity_counts: [6, 7, 2, 0],
            ..Extract::default()
        }
    }

    /// One straight-sided 8-node quad on [0, 2]².
    fn eight_node_quad() -> Extract {
        let positions = [
            [0., 0.],
            [2., 0.],
            [2., 2.],
            [0., 2.],
            [1., 0.],
            [2., 1.],
            [1., 2.],
            [0., 1.],
        ];
        let element = (1, &[0, 1, 2, 3, 4, 5, 6, 7][..]);
        Extract {
            nodes: positions.iter().map(|&[x, y]| [x, y, 0.0]).collect(),
            groups: vec![group(
                2,
                1,
                "q",
                vec![block(16, "Quadrilateral 8", 2, &[element])],
            )],
            ..Extract::default()
        }
    }

    #[test]
    fn shared_element_is_one_cell_in_both_groups() {
        let mesh = two_quads().to_mesh(1.0).unwrap();
        assert_eq!(mesh.cells.len(), 2);
        assert_eq!(mesh.surfaces["left"], [1]);
        assert_eq!(mesh.surfaces["9"], [0, 1]);
        assert_eq!(mesh.cells[1].nodes(), [0, 1, 4, 3]);
        assert_eq!(mesh.points["origin"], [0]);
        let ends: Vec<[usize; 2]> = mesh.curves["base"].iter().map(|edge| edge.ends).collect();
        assert_eq!(ends, [[0, 1], [1, 2]]);
    }

    #[test]
    fn lengths_are_scaled_to_metres() {
        let mesh = two_quads().to_mesh(0.001).unwrap();
        assert_eq!(mesh.nodes[5], [0.002, 0.001]);
        for unit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = two_quads().to_mesh(unit).unwrap_err();
            assert!(matches!(error, ExtractError::Unit { .. }), "{unit}");
        }
    }

    #[test]
    fn clockwise_cells_are_turned_over() {
        let mut extract = eight_node_quad();
        extract.groups[0].blocks[0].nodes = vec![0, 3, 2, 1, 7, 6, 5, 4];
        let mesh = extract.to_mesh(1.0).unwrap();
        assert_eq!(mesh.cells[0].nodes(), [0, 1, 2, 3, 4, 5, 6, 7]);

        let mut extract = two_quads();
        let triangle = block(2, "Triangle 3", 1, &[(1, &[0, 3, 1])]);
        extract.groups[2].blocks = vec![triangle];
        extract.groups.truncate(3);
        assert_eq!(extract.to_mesh(1.0).unwrap().cells[0].nodes(), [0, 1, 3]);
    }

    #[test]
    fn middle_nodes_are_snapped_only_within_the_tolerance() {
        let mut extract = eight_node_quad();
        extract.nodes[4] = [1.0 + 3e-12, -2e-12, 0.0];
        extract.nodes[5] = [2.0 + 5e-12, 1.0, 0.0];
        let mesh = extract.to_mesh(0.5).unwrap();
        assert_eq!(mesh.nodes[4], [0.5, 0.0]);
        assert_eq!(mesh.nodes[5], [1.0 + 2.5e-12, 0.5]);
    }

    #[test]
    fn a_curve_outside_all_cells_keeps_its_nodes_and_is_snapped() {
        let mut extract = eight_node_quad();
        extract
            .nodes
            .extend([[0.5, 1.0, 0.0], [1.5, 1.0, 0.0], [1.0 + 1e-13, 1.0, 0.0]]);
        let line = block(8, "Line 3", 2, &[(2, &[8, 9, 10])]);
        extract.groups.insert(0, group(1, 1, "crack", vec![line]));
        let mesh = extract.to_mesh(1.0).unwrap();
        assert_eq!(mesh.curves["crack"][0].middle, Some(10));
        assert_eq!(mesh.nodes[10], [1.0, 1.0]);
    }

    #[test]
    fn missing_surface_lists_what_is_there() {
        let mut extract = two_quads();
        extract.groups.truncate(2);
        let message = extract.to_mesh(1.0).unwrap_err().to_string();
        for part in [
            "2 plain",
            "point 'origin'",
            "curve 'base'",
            "Physical Surface(",
        ] {
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn empty_mesh_is_an_error() {
        let mut extract = two_quads();
        extract.groups[2].blocks.clear();
        extract.groups[3].blocks.clear();
        let surfaces = vec!["left".to_owned(), "9".to_owned()];
        let error = extract.to_mesh(1.0).unwrap_err();
        assert_eq!(error, ExtractError::NoElements { surfaces });
    }

    #[test]
    fn wrong_elements_are_named_with_the_remedy() {
        let nine: &[usize] = &[0; 9];
        let cases = [
            (
                2,
                block(10, "Quadrilateral 9", 2, &[(1, nine)]),
                "SecondOrderIncomplete = 1",
            ),
            (
                2,
                block(21, "Triangle 10", 3, &[(1, &[0; 10])]),
                "Mesh.ElementOrder = 2",
            ),
            (
                1,
                block(26, "Line 4", 3, &[(1, &[0; 4])]),
                "Mesh.ElementOrder = 2",
            ),
            (
                3,
                block(4, "Tetrahedron 4", 1, &[(1, &[0; 4])]),
                "two-dimensional",
            ),
        ];
        for (dimension, block, remedy) in cases {
            let name = block.kind_name.clone();
            let mut extract = two_quads();
            extract
                .groups
                .push(group(dimension, 20, "odd", vec![block]));
            let message = extract.to_mesh(1.0).unwrap_err().to_string();
            for part in [name.as_str(), "'odd'", remedy] {
                assert!(message.contains(part), "{message}");
            }
        }
    }

    #[test]
    fn nodes_off_the_plane_are_an_error() {
        let mut extract = two_quads();
        extract.nodes[3][2] = -0.5;
        let expected = ExtractError::OffPlane {
            count: 1,
            total: 6,
            farthest: -0.5,
        };
        assert_eq!(extract.to_mesh(1.0).unwrap_err(), expected);
        extract.nodes[3][2] = 1e-12;
        assert!(extract.to_mesh(1.0).is_ok());
    }

    #[test]
    fn cells_without_area_are_an_error() {
        let mut extract = two_quads();
        for node in [3, 4, 5] {
            extract.nodes[node][1] = 0.0;
        }
        let error = extract.to_mesh(1.0).unwrap_err();
        assert!(
            matches!(error, ExtractError::Degenerate { tag: 7, .. }),
            "{error}"
        );
    }
}
