//! Couplings: who ties the finite elements to the material points, and with which weight.

pub mod clip;
pub mod truss;
