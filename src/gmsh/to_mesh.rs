//! From what Gmsh delivered to the mesh that the method works on, in metres.
//!
//! - Cells are ordered by their tags, and an element of several physical surfaces is one cell.
//! - Cells that run clockwise (a surface whose outline was drawn clockwise) are turned over: their
//!   first corner stays the first.
//! - Gmsh places the middle node of a straight side with an error of some 1e-12 of the side's length.
//!   Such nodes are put exactly between their ends. Nodes are never merged.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::extract::{Block, Extract};
use super::extract_check::{ExtractError, cell_kind};
use crate::mesh::{Cell, CellKind, Edge, Mesh};

/// Distance within which a middle node counts as the midpoint, relative to the mesh's extent: rounding
/// errors grow with the coordinates, and a hundred times as much as seen is allowed for.
const MIDPOINT_TOLERANCE: f64 = 2e-12;
/// Area below which a cell counts as degenerate, relative to the square of its longest side.
const AREA_TOLERANCE: f64 = 1e-12;

impl Extract {
    /// The mesh with all groups, and lengths in metres; `unit_in_metres` is the geometry's unit (0.001
    /// for mm).
    ///
    /// # Errors
    /// A group that cannot be part of a plane mesh.
    pub fn to_mesh(&self, unit_in_metres: f64) -> Result<Mesh, ExtractError> {
        self.to_mesh_of(unit_in_metres, &|_| true)
    }

    /// The mesh with the groups that are named and with those others that can be part of a plane mesh.
    ///
    /// # Errors
    /// A named group that cannot be part of a plane mesh.
    pub fn to_mesh_of(
        &self,
        unit_in_metres: f64,
        is_named: &dyn Fn(&str) -> bool,
    ) -> Result<Mesh, ExtractError> {
        self.without_unusable(is_named).whole_mesh(unit_in_metres)
    }

    fn whole_mesh(&self, unit_in_metres: f64) -> Result<Mesh, ExtractError> {
        if !(unit_in_metres > 0.0 && unit_in_metres.is_finite()) {
            return Err(ExtractError::Unit {
                unit: unit_in_metres,
            });
        }
        self.check()?;
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
        take_middles_of_cells(&mut mesh);
        self.add_points(&mut mesh);
        snap_middle_nodes(
            &mut mesh,
            MIDPOINT_TOLERANCE * self.extent(&(0..self.nodes.len()).collect()) * unit_in_metres,
        );
        Ok(mesh)
    }

    /// Cells in the order of their tags. Elements with the same nodes are one cell, which all their groups
    /// hold: the format MSH 2.2 writes an element once for each of its groups, under a new tag each time.
    fn add_cells(&self, mesh: &mut Mesh) -> Result<(), ExtractError> {
        let mut cells: BTreeMap<u64, Cell> = BTreeMap::new();
        for (group, block) in self.blocks_of(2) {
            let kind = cell_kind(block.kind).expect("check has passed every block");
            for (tag, nodes) in block.elements() {
                let cell = self.counter_clockwise(kind, nodes).ok_or_else(|| {
                    let [x, y, _] = self.nodes[nodes[0]];
                    let group = group.clone();
                    ExtractError::Degenerate { tag, group, x, y }
                })?;
                cells.insert(tag, cell);
            }
        }
        let mut index: BTreeMap<u64, usize> = BTreeMap::new();
        let mut first: HashMap<Vec<usize>, usize> = HashMap::new();
        for (tag, cell) in cells {
            let mut nodes = cell.nodes().to_vec();
            nodes.sort_unstable();
            let at = *first.entry(nodes).or_insert_with(|| {
                mesh.cells.push(cell);
                mesh.cell_numbers.push(self.element_number(tag));
                mesh.cells.len() - 1
            });
            index.insert(tag, at);
        }
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
            let mut seen: HashSet<[usize; 2]> = edges.iter().map(Edge::key).collect();
            for (_, nodes) in group.blocks.iter().flat_map(Block::elements) {
                let edge = Edge {
                    ends: [nodes[0], nodes[1]],
                    middle: nodes.get(2).copied(),
                };
                if seen.insert(edge.key()) {
                    edges.push(edge);
                }
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

/// Edges along cells have the cells' middle nodes: a file may list the corners alone.
fn take_middles_of_cells(mesh: &mut Mesh) {
    let edges = mesh.cells.iter().flat_map(Cell::edges);
    let middles: HashMap<[usize; 2], Option<usize>> =
        edges.map(|edge| (edge.key(), edge.middle)).collect();
    for edge in mesh.curves.values_mut().flatten() {
        if let Some(&middle) = middles.get(&edge.key()) {
            edge.middle = middle;
        }
    }
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
mod tests;
