//! The stages mesh, solve and output: [`recipe`] says what each is made from, [`run`] runs those that are stale.

mod course_warnings;
pub mod fracture;
mod half_models;
mod joints;
pub mod meshing;
pub mod notes;
pub mod parameters;
mod positions;
mod probes;
pub mod recipe;
pub mod run;
pub mod standing;
pub mod validate;
