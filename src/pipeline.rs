//! A pipeline file to results: [`spec`] (YAML as written) → [`plan`] (checked) → [`stamp`] (what is
//! stale) → [`run`].

mod bits;
mod checkpoint;
pub mod costs;
pub mod damage_picture;
mod drafter;
mod files;
pub mod folder;
pub mod fracture;
pub mod history;
mod made;
mod meshing;
pub mod parameters;
mod parts;
mod pictures;
pub mod plan;
pub mod profile;
pub mod quantity;
mod reader;
mod recipe;
pub mod results;
pub mod run;
pub mod schema;
pub mod scribe;
pub mod solved;
pub mod source;
pub mod sources;
pub mod spec;
pub mod stamp;
pub mod study;
pub mod study_engines;
pub mod study_table;
pub mod validate;
mod workshop;
pub mod yaml;
