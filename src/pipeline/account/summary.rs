//! `summary.json`: what a run has computed and what it has cost.

use serde_json::Value;
use std::fs;
use std::path::Path;

pub const SUMMARY_FILE: &str = "summary.json";

/// The summary of the last finished run.
pub fn read_summary(folder: &Path) -> Option<Value> {
    serde_json::from_slice(&fs::read(folder.join(SUMMARY_FILE)).ok()?).ok()
}
