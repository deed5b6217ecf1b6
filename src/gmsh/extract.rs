//! What is kept of a Gmsh model: the elements of its physical groups and their nodes.
//!
//! The worker hands it to its parent, and the pipeline keeps it as the result of the mesh stage.
//! Equal input gives equal bytes: nodes, groups and elements are sorted by Gmsh's tags. Nodes that
//! no group uses (centres of circles, surfaces without a group) are left out.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Value;

/// The part of a Gmsh model that has a name or a number for the user.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extract {
    /// Program and version that read or made the mesh, such as "Gmsh" and "4.15.2".
    pub origin: Origin,
    /// What the program warns of, without a level.
    pub warnings: Vec<String>,
    /// The parameters of the geometry, with the values that it was meshed with where they are known.
    pub parameters: BTreeMap<String, Value>,
    /// Geometrical entities of dimension 0 to 3, in a group or not.
    pub entity_counts: [usize; 4],
    /// Node positions [unit of the geometry].
    pub nodes: Vec<[f64; 3]>,
    /// Physical groups, by dimension and tag.
    pub groups: Vec<Group>,
}

/// Where a mesh comes from.
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
        match self.name.as_str() {
            "" => self.tag.to_string(),
            name => name.to_owned(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.blocks.iter().all(|block| block.tags.is_empty())
    }
}

impl Block {
    /// Tag and node indices of each element.
    pub fn elements(&self) -> impl Iterator<Item = (u64, &[usize])> {
        let nodes = self.nodes.chunks_exact(self.nodes_per_element);
        self.tags.iter().copied().zip(nodes)
    }
}
