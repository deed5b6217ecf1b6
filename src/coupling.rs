//! Couplings: who ties the finite elements to the material points, and with which weight.

pub mod clip;
pub mod truss;

use truss::NodeArea;

/// How finite elements and material points are tied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coupling {
    /// The paper's, with this area A_FE of the interface nodes.
    Truss(NodeArea),
    /// Bonds end where they cross the interface.
    Clip,
}
