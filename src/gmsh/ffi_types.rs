//! Data that the calls of Gmsh deliver, and their error.

use std::ffi::NulError;
use std::path::PathBuf;

use thiserror::Error;

/// Why Gmsh could not be started or a call failed.
#[derive(Debug, Error)]
pub enum FfiError {
    #[error("{library}: {reason}", library = library.display())]
    Load { library: PathBuf, reason: String },
    #[error("a Gmsh session is open in this process already")]
    SessionOpen,
    #[error("Gmsh's {function} returned {code}: {message}")]
    Call {
        function: &'static str,
        code: i32,
        message: String,
    },
    #[error("an element uses node {node}, which Gmsh does not list")]
    NodeMissing { node: usize },
    #[error("a text for Gmsh holds a NUL character")]
    Nul(#[from] NulError),
}

/// The elements of one Gmsh type within one geometrical entity.
#[derive(Debug)]
pub struct ElementBlock {
    /// Gmsh's number of the element type.
    pub kind: i32,
    pub tags: Vec<usize>,
    /// Node tags, element after element.
    pub nodes: Vec<usize>,
}

/// The properties of an element type.
#[derive(Debug)]
pub struct ElementProperties {
    /// Such as "Quadrilateral 8".
    pub name: String,
    pub order: usize,
    pub node_count: usize,
}
