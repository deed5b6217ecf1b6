//! The part of a Gmsh model that is kept: the elements of its physical groups and their nodes.
//!
//! The worker hands it to its parent, and the pipeline keeps it as the result of the mesh stage.
//! Equal input gives equal bytes: nodes, groups and elements are sorted by Gmsh's tags. Nodes that
//! no group uses (centres of circles, surfaces without a group) are left out.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Value;

/// The group of all surfaces. It is made where it is asked for and the file has no group of surfaces.
pub const WHOLE: &str = "all";

/// The part of a Gmsh model that has a name or a number for the user.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extract {
    /// Program and version that read or made the mesh, such as "Gmsh" and "4.15.2".
    pub origin: Origin,
    /// Warnings of the program, without their level.
    pub warnings: Vec<String>,
    /// The parameters of the geometry, with the values that it was meshed with where they are known.
    pub parameters: BTreeMap<String, Value>,
    /// Geometrical entities of dimension 0 to 3, in a group or not.
    pub entity_counts: [usize; 4],
    /// Node positions [unit of the geometry].
    pub nodes: Vec<[f64; 3]>,
    /// Physical groups, by dimension and tag.
    pub groups: Vec<Group>,
    /// Numbers of the elements in the file, by tag from 1 on; empty where the tags are these numbers.
    pub element_numbers: Vec<i64>,
}

impl Extract {
    /// The number of an element in the file that it comes from.
    pub(super) fn element_number(&self, tag: u64) -> i64 {
        let place = usize::try_from(tag).ok().and_then(|tag| tag.checked_sub(1));
        let number = place.and_then(|place| self.element_numbers.get(place));
        number.copied().unwrap_or(tag as i64)
    }
}

/// The program that a mesh comes from.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    pub program: String,
    pub version: String,
}

impl std::fmt::Display for Origin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.program, self.version)
    }
}

/// A physical group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Group {
    /// 0 point, 1 curve, 2 surface, 3 volume.
    pub dimension: u8,
    pub tag: i32,
    /// Empty if the group has a number only.
    pub name: String,
    /// One block per element type.
    pub blocks: Vec<Block>,
}

/// The elements of one type in a group, ascending by tag.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Block {
    /// Gmsh's number of the element type.
    pub kind: i32,
    /// Gmsh's name of the element type, such as "Quadrilateral 8".
    pub kind_name: String,
    pub order: usize,
    pub nodes_per_element: usize,
    /// Unique in the model: an element that two groups hold has the same tag in both.
    pub tags: Vec<u64>,
    /// Indices into [`Extract::nodes`], element after element.
    pub nodes: Vec<usize>,
}

impl Group {
    /// The name, or the tag of a group without one.
    pub fn label(&self) -> String {
        label(&self.name, self.tag)
    }

    pub fn is_empty(&self) -> bool {
        self.blocks.iter().all(|block| block.tags.is_empty())
    }
}

/// The name of a group, or its tag if the name is empty.
pub(super) fn label(name: &str, tag: i32) -> String {
    match name {
        "" => tag.to_string(),
        name => name.to_owned(),
    }
}

/// A dimension of Gmsh as [`Group`] holds it.
pub(super) fn dimension(dimension: i32) -> u8 {
    u8::try_from(dimension).expect("Gmsh's dimensions are 0 to 3")
}

impl Block {
    /// Tag and node indices of each element.
    pub fn elements(&self) -> impl Iterator<Item = (u64, &[usize])> {
        let nodes = self.nodes.chunks_exact(self.nodes_per_element);
        self.tags.iter().copied().zip(nodes)
    }
}
