//! What the body is loaded with: phases one after the other, each proportional to a load factor of
//! its own.
//!
//! In phase p, with the phases before it held at their ends Λ_q, the loads and the prescribed
//! displacements are
//!
//! ```text
//! R(λ) = Σ_{q<p} Λ_q R_q + λ R_p
//! ```

use super::response::Load;
use crate::boundary::Boundary;
use std::collections::BTreeSet;

/// One phase of a programme.
#[derive(Clone, Debug)]
pub struct LoadPhase {
    pub name: String,
    /// R_p: supports, and what is applied per unit of the load factor.
    pub boundary: Boundary,
    /// Δλ of a load step [-]; no matter where the control finds the load by itself.
    pub increment: f64,
    /// Λ_p, positive; `None`: the phase goes on until the run ends. Only the last one may.
    pub end: Option<f64>,
}

/// The phases in their order, at least one. All prescribe displacements on the same dofs: what a
/// phase does not move, it holds.
#[derive(Clone, Debug)]
pub struct Programme {
    pub phases: Vec<LoadPhase>,
    /// Dofs with a prescribed displacement or a load in some phase, ascending: only there does the
    /// surroundings' work enter.
    pub dofs: Vec<usize>,
}

impl Programme {
    pub fn new(phases: Vec<LoadPhase>) -> Programme {
        let prescribed = |phase: &LoadPhase| phase.boundary.prescribed.keys().copied().collect();
        let loaded = |phase: &LoadPhase| {
            let loads = phase.boundary.load.iter().enumerate();
            loads
                .filter(|(_, f)| **f != 0.0)
                .map(|(dof, _)| dof)
                .collect()
        };
        let of_phase = |phase| -> [Vec<usize>; 2] { [prescribed(phase), loaded(phase)] };
        let dofs: BTreeSet<usize> = phases.iter().flat_map(of_phase).flatten().collect();
        Programme {
            phases,
            dofs: dofs.into_iter().collect(),
        }
    }

    /// One phase without an end, in load steps of Δλ = 1.
    pub fn proportional(boundary: Boundary) -> Programme {
        Programme::new(vec![LoadPhase {
            name: String::new(),
            boundary,
            increment: 1.0,
            end: None,
        }])
    }

    /// Supports, the same in every phase.
    pub fn supports(&self) -> &Boundary {
        &self.phases[0].boundary
    }

    /// Σ_{q<p} Λ_q R_q: what is held during the phase p; `None` for the first.
    pub fn held(&self, phase: usize) -> Option<Boundary> {
        let mut sum = self.phases[..phase].first()?.boundary.clone();
        sum.load.fill(0.0);
        sum.overlap_load.fill(0.0);
        sum.prescribed
            .values_mut()
            .for_each(|(value, _)| *value = 0.0);
        for LoadPhase { boundary, end, .. } in &self.phases[..phase] {
            let end = end.expect("only the last phase has no end");
            for (total, f) in sum.load.iter_mut().zip(&boundary.load) {
                *total += end * f;
            }
            for (total, f) in sum.overlap_load.iter_mut().zip(&boundary.overlap_load) {
                *total += end * f;
            }
            for (dof, (value, _)) in &boundary.prescribed {
                let total = sum.prescribed.get_mut(dof);
                total.expect("all phases prescribe the same dofs").0 += end * value;
            }
        }
        Some(sum)
    }

    /// The load on a dof during a phase [N].
    pub fn force(&self, phase: usize, load: Load, dof: usize) -> f64 {
        let held = self.phases[..phase].iter().map(|p| {
            let end = p.end.expect("only the last phase has no end");
            end * p.boundary.load[dof]
        });
        let unit = self.phases[phase].boundary.load[dof];
        load.share * (held.sum::<f64>() + load.factor * unit)
    }

    /// Whether the phase is at its end.
    pub fn ends_at(&self, phase: usize, load: Load) -> bool {
        self.phases[phase].end.map(Load::full) == Some(load)
    }

    /// Whether the last phase is at its end.
    pub fn is_over(&self, phase: usize, load: Load) -> bool {
        phase + 1 == self.phases.len() && self.ends_at(phase, load)
    }

    /// The loads of the phases up to `phase`, each by dof [N].
    pub fn loads(&self, phase: usize) -> impl Iterator<Item = &[f64]> {
        let phases = self.phases[..=phase].iter();
        phases.map(|p| p.boundary.load.as_slice())
    }
}
