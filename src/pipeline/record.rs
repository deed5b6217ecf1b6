//! What the stages keep on the disk between and during runs, and how it is read back.

pub mod checkpoint;
pub mod folder;
pub mod format;
pub mod frames;
pub mod history;
pub mod solved;
pub mod sparse_integrity;
pub mod stamp;
pub mod stored;
pub mod writer;
