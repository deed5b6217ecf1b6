//! A pipeline file to results, in six rooms; each imports only from those before it.

pub mod account;
pub mod error;
pub mod read;
pub mod record;
pub mod show;
pub mod stages;
pub mod study;
