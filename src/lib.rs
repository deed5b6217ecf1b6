//! peristitch: quasi-static fracture in two dimensions by a hybrid of peridynamics and finite elements.
#![deny(unsafe_code)]
// Units stand in brackets, as in `[m]`, which rustdoc takes for links.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod assembly;
pub mod boundary;
pub mod cli;
pub mod coupling;
pub mod cracks;
pub mod fem;
pub mod fields;
pub mod fracture;
pub mod geometry;
pub mod gmsh;
pub mod linear_solver;
pub mod material;
pub mod mesh;
pub mod model;
pub mod output;
pub mod peridynamics;
pub mod phases;
pub mod pipeline;
pub mod springs;
pub mod statics;
pub mod support;
