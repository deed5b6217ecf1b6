//! A pipeline file to a checked [`plan`]: [`spec`] is the file as written, [`reader`] its check.

mod familiar;
pub mod files;
pub mod mistakes;
pub mod nesting;
pub mod plan;
pub mod quantity;
pub mod reader;
pub mod reference;
mod removed;
pub mod schema;
pub mod source;
pub mod sources;
pub mod spec;
pub mod yaml;
