//! Supports and loads on physical groups of the mesh.
//!
//! `constraints` prescribe displacements, along `axes` of the nodes; `loads` and `body_force` add
//! forces. A curve acts on the finite-element nodes on it and, where it bounds a peridynamic region, on the
//! `layer` of material points beside it.

mod axes;
mod body_force;
mod constraints;
mod groups;
mod layer;
mod loads;
mod nearest;

use crate::model::Model;
use crate::model::node_axes::NodeAxes;
use std::collections::BTreeMap;
use thiserror::Error;

pub use axes::Directions;
pub use groups::{nodes_of, outline_edges};

#[derive(Debug, Error)]
pub enum BoundaryError {
    #[error("group `{group}` touches no node and no material point of any region")]
    NothingThere { group: String },
    #[error("group `{group}` cannot carry a load: it bounds no region")]
    NoOutline { group: String },
    #[error("group `{group}` is a point: a traction or pressure needs a curve")]
    LoadOnPoint { group: String },
    #[error("group `{group}` has no normal everywhere")]
    NoNormal { group: String },
    #[error(
        "`{group}` and `{other}` prescribe displacements at ({x:.6e}, {y:.6e}) m that contradict \
         each other"
    )]
    Contradiction {
        group: String,
        other: String,
        x: f64,
        y: f64,
    },
    #[error(
        "`{group}` prescribes {value} m for the displacement {axis} at ({x:.6e}, {y:.6e}) m, \
         where `{other}` prescribes {other_value} m"
    )]
    Conflict {
        group: String,
        other: String,
        axis: char,
        x: f64,
        y: f64,
        value: f64,
        other_value: f64,
    },
}

/// Prescribed displacements and nodal forces of a model, by dof.
#[derive(Clone, Debug, Default)]
pub struct Boundary {
    /// Axes of nodes that are held along neither x nor y; the model must have them too
    /// ([`Model::with_node_axes`]).
    pub node_axes: NodeAxes,
    /// Displacement [m] and the group that prescribes it, by dof in the axes of the nodes.
    pub prescribed: BTreeMap<usize, (f64, String)>,
    /// Force on every node along x and y, dof by dof [N].
    pub load: Vec<f64>,
}

impl Boundary {
    /// A boundary without supports and loads.
    pub fn new(model: &Model) -> Boundary {
        Boundary {
            node_axes: NodeAxes::new(),
            prescribed: BTreeMap::new(),
            load: vec![0.0; 2 * model.node_count()],
        }
    }
}
