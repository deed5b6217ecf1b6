//! Load programme: phases one after the other, each proportional to a load factor of
//! its own.
//!
//! In phase p, with the phases before it held at their ends Λ_q, the loads and the prescribed
//! displacements are
//!
//! ```text
//! R(λ) = Σ_{q<p} Λ_q R_q + λ R_p
//! ```

use super::event::Load;
use super::functional::{self, Functional, Values};
use crate::boundary::Boundary;
use std::cmp::Ordering;

/// One phase of a programme.
#[derive(Clone, Debug)]
pub struct LoadPhase {
    pub name: String,
    /// R_p: supports, and what is applied per unit of the load factor.
    pub boundary: Boundary,
    /// Δλ of a load step [-], or the increment of the probe that controls it [m]; no matter where the control
    /// finds the load by itself.
    pub increment: f64,
    /// Λ_p, positive; `None`: the phase goes on until the run ends. Only the last one may.
    pub end: Option<f64>,
}

/// The phases in their order, at least one. All prescribe displacements on the same dofs: what a
/// phase does not move, it holds.
#[derive(Clone, Debug)]
pub struct Programme {
    pub phases: Vec<LoadPhase>,
    /// Q and W of every phase, then the resultants on every group ([`functional`]), then what the probes read.
    pub functionals: Vec<Functional>,
    /// Number of the last of these that are probes.
    pub probes: usize,
    /// Number of the probe whose displacement grows by the increment in each load step, in place of λ; then there
    /// is one phase, without an end.
    pub control_probe: Option<usize>,
}

impl Programme {
    pub fn new(phases: Vec<LoadPhase>) -> Programme {
        let boundaries: Vec<&Boundary> = phases.iter().map(|phase| &phase.boundary).collect();
        Programme {
            functionals: functional::of_phases(&boundaries),
            probes: 0,
            control_probe: None,
            phases,
        }
    }

    /// The same programme with load steps in increments of what a probe reads.
    pub fn controlled_by(self, probe: Option<usize>) -> Programme {
        Programme {
            control_probe: probe,
            ..self
        }
    }

    /// The load of a step of the phase: its increments of λ, or the λ > 0 at which the probe that controls it has
    /// moved by as many increments, either way. After breaks that λ may be smaller.
    pub fn load_of_step(&self, phase: usize, step: usize, values: &Values) -> Load {
        let LoadPhase { increment, end, .. } = self.phases[phase];
        let grown = step as f64 * increment;
        Load::full(match self.control_probe {
            Some(probe) => grown / values.per_load_factor(self.probes, probe).abs(),
            None => grown.min(end.unwrap_or(f64::INFINITY)),
        })
    }

    /// The same programme with displacements that are read at every step.
    pub fn with_probes(mut self, probes: impl IntoIterator<Item = Functional>) -> Programme {
        let before = self.functionals.len();
        self.functionals.extend(probes);
        self.probes += self.functionals.len() - before;
        self
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
        sum.prescribed
            .values_mut()
            .for_each(|(value, _)| *value = 0.0);
        for LoadPhase { boundary, end, .. } in &self.phases[..phase] {
            let end = end.expect("only the last phase has no end");
            for (total, f) in sum.load.iter_mut().zip(&boundary.load) {
                *total += end * f;
            }
            for (dof, (value, _)) in &boundary.prescribed {
                let total = sum.prescribed.get_mut(dof);
                total.expect("all phases prescribe the same dofs").0 += end * value;
            }
        }
        Some(sum)
    }

    /// μ Λ_q of the phases before this one, μ λ of this one, zero of those to come.
    pub fn factors(&self, phase: usize, load: Load) -> impl Iterator<Item = f64> {
        self.phases
            .iter()
            .enumerate()
            .map(move |(q, p)| match q.cmp(&phase) {
                Ordering::Less => load.share * p.end.expect("only the last phase has no end"),
                Ordering::Equal => load.share * load.factor,
                Ordering::Greater => 0.0,
            })
    }

    /// The largest prescribed displacement [m].
    pub fn largest_prescribed(&self, phase: usize, load: Load) -> f64 {
        let factors: Vec<f64> = self.factors(phase, load).collect();
        let dofs = self.supports().prescribed.keys();
        let value = |dof: &usize| {
            let phases = self.phases.iter().zip(&factors);
            let terms = phases.map(|(p, factor)| factor * p.boundary.prescribed[dof].0);
            terms.sum::<f64>().abs()
        };
        dofs.map(value).fold(0.0, f64::max)
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
