//! The cost of a run: [`costs`] in time, memory and bytes, for [`summary`] and [`profile`].

pub mod costs;
pub mod profile;
pub mod summary;
pub mod written_file;
