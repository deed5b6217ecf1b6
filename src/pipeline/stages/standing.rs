//! Freshness of the stages.

use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::Plan;
use crate::pipeline::record::stamp::{self, Reasons, Stage};
use crate::pipeline::stages::recipe::recipe;

/// State of a stage's result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Standing {
    Fresh,
    Stale(Reasons),
    /// Stale if this earlier stage, which must run, delivers something new.
    After(Stage),
}

/// State of every stage; nothing is run or written.
///
/// # Errors
/// An unreadable geometry.
pub fn standings(plan: &Plan) -> Result<Vec<(Stage, Standing)>, RunError> {
    let on_disk = |name: &str| {
        let hash = stamp::hash_file(&plan.folder.join(name));
        hash.unwrap_or_else(|| "missing".to_owned())
    };
    let mut list: Vec<(Stage, Standing)> = Vec::new();
    for stage in Stage::ALL {
        let upstream = list
            .iter()
            .find(|(_, standing)| *standing != Standing::Fresh);
        let upstream = upstream.map(|(earlier, _)| *earlier);
        let mut recipe = recipe(plan, stage, &on_disk)?;
        if upstream.is_some() {
            // What it will deliver is not known; all else is.
            recipe.assume_inputs_of(stamp::read(&plan.folder, stage));
        }
        let reasons = stamp::stale(&plan.folder, stage, &recipe);
        let standing = match (reasons.is_empty(), upstream) {
            (false, _) => Standing::Stale(reasons),
            (true, None) => Standing::Fresh,
            (true, Some(earlier)) => Standing::After(earlier),
        };
        list.push((stage, standing));
    }
    Ok(list)
}
