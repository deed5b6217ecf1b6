//! The stages mesh, solve and output: [`recipe`] says what each is made from, [`run`] runs those that are stale.

pub mod fracture;
mod joints;
pub mod meshing;
pub mod parameters;
mod positions;
pub mod recipe;
pub mod run;
pub mod standing;
pub mod validate;
