//! A pipeline file to results: [`spec`] (YAML as written) → [`plan`] (checked) → [`stamp`] (what is
//! stale) → [`run`].

mod bits;
mod charts;
mod checkpoint;
pub mod costs;
pub mod damage_picture;
mod deformed;
mod drafter;
mod files;
pub mod folder;
pub mod fracture;
pub mod history;
mod made;
mod maps;
mod mesh_picture;
mod meshing;
mod parts;
mod pictures;
pub mod plan;
pub mod profile;
pub mod quantity;
mod reader;
mod recipe;
mod reel;
pub mod report;
pub mod results;
pub mod run;
pub mod scribe;
pub mod solved;
pub mod source;
pub mod sources;
pub mod spec;
pub mod stamp;
pub mod validate;
pub mod view;
mod workshop;
pub mod yaml;
