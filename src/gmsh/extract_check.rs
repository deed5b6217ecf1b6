//! Checks of what Gmsh or meshio delivered, before a mesh is made of it.

use std::collections::BTreeSet;

use thiserror::Error;

use super::extract::{Block, Extract, Group};
use crate::mesh::CellKind;

/// Distance within which a node counts as lying in the plane z = 0, relative to the mesh's extent.
const PLANE_TOLERANCE: f64 = 1e-9;

/// Why a Gmsh model cannot be computed on, and what to change in the geometry.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ExtractError {
    #[error("the unit of length must be a positive number of metres, not {unit}")]
    Unit { unit: f64 },
    #[error(
        "the geometry has no physical surface; it has {surfaces} plain surface(s) and {groups}. \
         Name what to compute on: Physical Surface(\"plate\") = {{1}}; or compute on all of it: `group: all`"
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

impl ExtractError {
    /// The error for a model with this number of surfaces and these groups: dimension and label.
    pub fn no_physical_surface(surfaces: usize, groups: &[(u8, String)]) -> ExtractError {
        let kinds = ["point", "curve", "surface", "volume"];
        let described = groups.iter().map(|(dimension, label)| {
            let kind = kinds.get(usize::from(*dimension)).unwrap_or(&"group");
            format!("physical {kind} '{label}'")
        });
        let described: Vec<String> = described.collect();
        let groups = match described.as_slice() {
            [] => "no physical groups at all".to_owned(),
            groups => groups.join(", "),
        };
        ExtractError::NoPhysicalSurface { surfaces, groups }
    }
}

impl Extract {
    /// Checks that the groups can be a plane mesh.
    ///
    /// # Errors
    /// See [`ExtractError`].
    pub(super) fn check(&self) -> Result<(), ExtractError> {
        self.check_groups()?;
        self.check_plane()
    }

    /// Without the groups that cannot be part of a plane mesh and that nobody names: the faces of a solid in
    /// the same file do no harm.
    pub(super) fn without_unusable(&self, is_named: &dyn Fn(&str) -> bool) -> Extract {
        let tolerance = PLANE_TOLERANCE * self.extent(&self.nodes_of_groups(is_named));
        let is_in_plane = |&node: &usize| {
            let node = self.nodes.get(node);
            node.is_none_or(|node| node[2].abs() <= tolerance)
        };
        let is_usable = |group: &&Group| {
            let label = group.label();
            let fits = |block: &Block| {
                check_kind(group.dimension, &label, block).is_ok()
                    && block.nodes.iter().all(is_in_plane)
            };
            is_named(&label) || group.blocks.iter().all(fits) && group.dimension < 3
        };
        Extract {
            groups: self.groups.iter().filter(is_usable).cloned().collect(),
            ..self.clone()
        }
    }

    fn nodes_of_groups(&self, is_meant: &dyn Fn(&str) -> bool) -> BTreeSet<usize> {
        let groups = self.groups.iter().filter(|group| is_meant(&group.label()));
        let blocks = groups.flat_map(|group| &group.blocks);
        blocks
            .flat_map(|block| block.nodes.iter().copied())
            .collect()
    }

    pub(super) fn groups_of(&self, dimension: u8) -> impl Iterator<Item = &Group> {
        let groups = self.groups.iter();
        groups.filter(move |group| group.dimension == dimension)
    }

    /// Blocks of the physical groups of a dimension, each with its group's label.
    pub(super) fn blocks_of(&self, dimension: u8) -> impl Iterator<Item = (String, &Block)> {
        self.groups_of(dimension)
            .flat_map(|group| group.blocks.iter().map(|block| (group.label(), block)))
    }

    fn check_groups(&self) -> Result<(), ExtractError> {
        if self.groups_of(2).next().is_none() {
            let groups = self.groups.iter();
            let labels: Vec<(u8, String)> = groups
                .map(|group| (group.dimension, group.label()))
                .collect();
            let surfaces = self.entity_counts[2];
            return Err(ExtractError::no_physical_surface(surfaces, &labels));
        }
        if self.groups_of(2).all(Group::is_empty) {
            return Err(ExtractError::NoElements {
                surfaces: self.groups_of(2).map(Group::label).collect(),
            });
        }
        for dimension in 0..=3 {
            for (group, block) in self.blocks_of(dimension) {
                check_kind(dimension, &group, block)?;
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

    fn check_plane(&self) -> Result<(), ExtractError> {
        let used = self.nodes_of_groups(&|_| true);
        let tolerance = PLANE_TOLERANCE * self.extent(&used);
        let heights = used.iter().map(|&node| self.nodes[node][2]);
        let off: Vec<f64> = heights.filter(|z| z.abs() > tolerance).collect();
        if off.is_empty() {
            return Ok(());
        }
        let farthest = off
            .iter()
            .copied()
            .fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
        Err(ExtractError::OffPlane {
            count: off.len(),
            total: used.len(),
            farthest,
        })
    }

    /// The longer side of the box around some nodes in x and y [unit of the geometry].
    pub(super) fn extent(&self, nodes: &BTreeSet<usize>) -> f64 {
        let side = |axis: usize| {
            let nodes = nodes.iter().filter_map(|&node| self.nodes.get(node));
            let values = nodes.map(|node| node[axis]);
            let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
            (high - low).max(0.0)
        };
        side(0).max(side(1))
    }
}

/// The cell that a Gmsh element type stands for.
pub(super) fn cell_kind(kind: i32) -> Option<CellKind> {
    match kind {
        2 => Some(CellKind::Tri3),
        3 => Some(CellKind::Quad4),
        9 => Some(CellKind::Tri6),
        16 => Some(CellKind::Quad8),
        _ => None,
    }
}

/// The number of nodes of an element type that [`check_kind`] lets through.
fn nodes_of_kind(kind: i32) -> Option<usize> {
    match kind {
        15 => Some(1),
        1 => Some(2),
        8 => Some(3),
        kind => cell_kind(kind).map(CellKind::node_count),
    }
}

fn check_kind(dimension: u8, group: &str, block: &Block) -> Result<(), ExtractError> {
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
        group: group.to_owned(),
        kind: block.kind_name.clone(),
        count: block.tags.len(),
        remedy,
    })
}
