//! Files that the stages keep between and during runs, and their readers.

pub mod checkpoint;
pub mod events;
pub mod folder;
pub mod format;
pub mod frames;
pub mod history;
pub mod solved;
pub mod sparse_integrity;
pub mod stamp;
pub mod stored;
pub mod writer;
