//! Springs that are gone, by the dofs that they touched, and I − A S with S = Σ k w wᵀ.

use crate::linear_solver::columns::{add, slice, slice_mut};
use faer::{MatMut, MatRef};
use rayon::prelude::*;

/// Rows that one thread takes at a time: pieces of columns that stay in the cache.
const ROWS: usize = 256;

/// Stiffness that an interaction has lost since a factorisation: (φ − φ') k [N/m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    pub interaction: usize,
    pub stiffness: f64,
}

/// Interactions, and the stiffness that each has lost [N/m].
pub fn pairs(losses: &[Loss]) -> impl Iterator<Item = (usize, f64)> {
    losses.iter().map(|loss| (loss.interaction, loss.stiffness))
}

/// By places among the touched dofs.
pub struct Spring {
    pub stiffness: f64,
    /// w.
    pub terms: Vec<(usize, f64)>,
}

/// Adds S z.
pub fn add_forces(springs: &[Spring], z: &[f64], forces: &mut [f64]) {
    for spring in springs {
        let elongation: f64 = spring.terms.iter().map(|&(place, w)| w * z[place]).sum();
        for &(place, w) in &spring.terms {
            forces[place] += spring.stiffness * elongation * w;
        }
    }
}

/// Takes Σ k A w wᵀ off `system`, whose rows are those of `compliance`, A.
pub fn subtract(system: MatMut<f64>, compliance: MatRef<f64>, springs: &[Spring]) {
    let chunks = system.par_row_chunks_mut(ROWS).enumerate();
    chunks.for_each(|(k, mut system)| {
        let compliance = compliance.subrows(ROWS * k, system.nrows());
        let mut column = vec![0.0; system.nrows()];
        for spring in springs {
            column.fill(0.0);
            for &(place, w) in &spring.terms {
                let own = slice(compliance.col(place));
                add(&mut column, spring.stiffness * w, own);
            }
            for &(place, w) in &spring.terms {
                add(slice_mut(system.as_mut().col_mut(place)), -w, &column);
            }
        }
    });
}
