//! What a run costs: [`costs`] in time, memory and bytes, for [`summary`] and [`profile`].

pub mod costs;
pub mod made;
pub mod profile;
pub mod summary;
