//! Couplings: who ties the finite elements to the material points, and with which weight.

pub mod splice;
pub mod truss;

use truss::NodeArea;

/// How finite elements and material points are tied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coupling {
    /// The paper's trusses.
    Truss(NodeArea),
    /// Each side reads the other's displacements; K is not symmetric.
    Splice,
}
