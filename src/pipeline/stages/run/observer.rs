//! The observer of a run's progress.

use crate::pipeline::record::stamp::Stage;
use serde::Serialize;
use std::fmt;
use std::time::Duration;

/// Receives the events of a run as they happen.
pub trait Observer {
    fn starts(&mut self, stage: Stage);
    fn ends(&mut self, stage: Stage, what: &str, time: Duration);
    /// The model is being made from the mesh, before the solve.
    fn discretises(&mut self);
    fn step(&mut self, step: &Step);
    fn is_fresh(&mut self, stage: Stage);
    fn warns(&mut self, text: &str);
}

/// Progress of a fracture run.
#[derive(Clone, Debug, Serialize)]
pub struct Step {
    /// Name of the phase; empty where there is only one.
    pub phase: String,
    pub step: usize,
    /// The run ends at this step, if not before; `None`: it ends by itself.
    pub most_steps: Option<usize>,
    pub load_factor: f64,
    pub bonds_broken: usize,
    pub bonds_broken_total: usize,
    pub passes: usize,
    pub steps_per_second: f64,
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if !self.phase.is_empty() {
            write!(f, "{}, ", self.phase)?;
        }
        let passes = if self.passes == 1 { "pass" } else { "passes" };
        write!(f, "step {}", self.step)?;
        if let Some(most) = self.most_steps {
            write!(f, " of at most {most}")?;
        }
        write!(
            f,
            ", λ = {:.4}, {} bonds broken ({} in all), {} {passes}, {:.1} steps/s",
            self.load_factor,
            self.bonds_broken,
            self.bonds_broken_total,
            self.passes,
            self.steps_per_second
        )?;
        match self.most_steps {
            Some(most) => {
                let left = (most - self.step) as f64 / self.steps_per_second;
                write!(f, ", at most {left:.0} s left")
            }
            None => Ok(()),
        }
    }
}
