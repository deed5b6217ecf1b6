//! peristitch: quasi-static fracture in two dimensions by a hybrid of peridynamics and finite elements.
#![deny(unsafe_code)]
// Units stand in brackets, as in `[m]`, which rustdoc takes for links.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod gmsh;
pub mod mesh;
pub mod output;
