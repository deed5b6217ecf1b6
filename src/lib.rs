//! peristitch: quasi-static fracture in two dimensions by a hybrid of peridynamics and finite elements.
#![deny(unsafe_code)]

pub mod gmsh;
pub mod mesh;
pub mod output;
