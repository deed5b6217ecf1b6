//! Warnings of the program that made or read the mesh.

use super::{Observer, Run};
use crate::gmsh::Extract;

/// Warnings of one program beyond these are counted: a mesher can have thousands.
const MOST_MESH_WARNINGS: usize = 5;

impl Run<'_> {
    /// The warnings of the program that made or read the mesh.
    pub(super) fn warn_of_mesh(&mut self, extract: &Extract) {
        let program = &extract.origin.program;
        for warning in extract.warnings.iter().take(MOST_MESH_WARNINGS) {
            self.observer.warns(&format!("{program}: {warning}"));
        }
        let more = extract.warnings.len().saturating_sub(MOST_MESH_WARNINGS);
        if more > 0 {
            let plural = if more == 1 { "" } else { "s" };
            self.observer
                .warns(&format!("{program}: {more} more warning{plural}"));
        }
    }
}
