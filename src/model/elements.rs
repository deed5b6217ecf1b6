//! The finite elements of a body, and the numbers of their nodes.

use super::check::check_jacobian;
use super::{Method, ModelError, Region};
use crate::mesh::Mesh;

/// Finite elements in the order of their regions, and their nodes in the order of the mesh.
pub(super) struct Elements {
    /// (region, cell) of every element.
    pub elements: Vec<(usize, usize)>,
    /// The node at each of the mesh's nodes, where elements use it.
    pub node_of: Vec<Option<u32>>,
    /// Positions of the nodes [m].
    pub positions: Vec<[f64; 2]>,
}

impl Elements {
    /// # Errors
    /// [`ModelError::Jacobian`].
    pub fn new(mesh: &Mesh, regions: &[Region]) -> Result<Elements, ModelError> {
        let mut elements = Vec::new();
        let mut is_used = vec![false; mesh.nodes.len()];
        for (index, region) in regions.iter().enumerate() {
            if region.method != Method::FiniteElements {
                continue;
            }
            for &cell in &region.cells {
                check_jacobian(mesh, region, cell)?;
                elements.push((index, cell));
                for &node in mesh.cells[cell].nodes() {
                    is_used[node] = true;
                }
            }
        }
        let mut positions = Vec::new();
        let number = |(is_used, &position): (bool, &[f64; 2])| {
            is_used.then(|| {
                positions.push(position);
                positions.len() as u32 - 1
            })
        };
        let node_of = is_used.into_iter().zip(&mesh.nodes).map(number).collect();
        Ok(Elements {
            elements,
            node_of,
            positions,
        })
    }
}
