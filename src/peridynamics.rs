//! The peridynamic region: a lattice of material points joined by bonds,
//! Qian et al. (2021), eqs. (1)–(10) and (16)–(19).

pub mod axes;
pub mod bonds;
pub mod cells;
pub mod isotropy;
pub mod kernel;
pub mod lattice;
pub mod least_squares;
pub mod point_index;
pub mod surface;
pub mod visibility;
