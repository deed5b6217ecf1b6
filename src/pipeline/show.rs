//! The results that people and other programs look at: VTU parts, pictures, report, ParaView script.

pub mod animation;
pub mod charts;
pub mod damage_picture;
pub mod deformed;
mod lattice_cells;
pub mod live_picture;
pub mod maps;
pub mod mesh_picture;
pub mod output_files;
pub mod parts;
pub mod pictures;
pub mod report;
pub mod results;
pub mod summary;
pub mod view;
