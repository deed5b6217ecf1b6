//! Gmsh `.geo` and `.msh` files to [`crate::mesh::Mesh`].
