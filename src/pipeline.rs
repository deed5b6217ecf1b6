//! A pipeline file to results: [`spec`] (YAML as written) → [`plan`] (checked) → [`stamp`] (what is
//! stale) → [`run`].

mod checkpoint;
mod damage_picture;
mod files;
pub mod folder;
pub mod fracture;
pub mod history;
mod meshing;
mod pictures;
pub mod plan;
pub mod quantity;
mod reader;
mod recipe;
pub mod results;
pub mod run;
pub mod solved;
pub mod source;
pub mod spec;
pub mod stamp;
pub mod validate;
pub mod yaml;
