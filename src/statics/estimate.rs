//! The expected cost of a solve, from counts alone.

use super::StaticsError;
use super::structure::Structure;
use crate::boundary::Boundary;
use crate::linear_solver::Backend;
use crate::linear_solver::rates::{
    BOND_ENTRY_SECONDS, BOND_SECONDS, BREAKABLE_BYTES, DIRECT_VECTORS, ENTRY_BYTES, ENTRY_RATE,
    FACTOR_RATE, FEW_EVENTS, FEW_EVENTS_BYTES, FRACTURE_BYTES, ITERATION_RATE, ITERATIONS,
    ITERATIVE_VECTORS, KEPT_SHARE, MANY_EVENTS_BYTES, MANY_EVENTS_SHARE, STEPPED_SHARE,
    WAITING_SHARE,
};
use crate::model::Model;
use crate::phases::{held_memory, peak_memory};
use std::time::Duration;

/// Whether bonds break in a run, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Breaks {
    Never,
    InSteps,
    EventByEvent { most_events: usize },
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    pub dofs: usize,
    pub backend: Backend,
    /// Stored entries of L; an estimate of the coarse level's where there are two levels.
    pub factor_entries: usize,
    /// Multiplications and additions of the numeric factorisation.
    pub flops: f64,
    /// Peak memory [bytes].
    pub bytes: u64,
    /// Time of one solve.
    pub time: Duration,
    /// Time that the breaking of a bond takes.
    pub time_per_bond: Duration,
}

impl Estimate {
    /// `backend`: what K is solved by, if its size is not to decide.
    ///
    /// # Errors
    /// [`SolverError::Ordering`](crate::linear_solver::SolverError::Ordering),
    /// [`SolverError::OutOfMemory`](crate::linear_solver::SolverError::OutOfMemory).
    pub fn new(
        model: &Model,
        boundary: &Boundary,
        backend: Option<Backend>,
        breaks: Breaks,
    ) -> Result<Estimate, StaticsError> {
        let structure = Structure::new(model, backend)?;
        let interactions = model.interactions.len();
        Ok(Estimate::of(&structure, boundary, breaks, interactions))
    }

    /// `interactions`: how many may break.
    pub(super) fn of(
        structure: &Structure,
        boundary: &Boundary,
        breaks: Breaks,
        interactions: usize,
    ) -> Estimate {
        let backend = structure.solver.backend();
        let size = structure.solver.size();
        let dofs = boundary.load.len();
        let stiffness = structure.stiffness_entries() as f64;
        let (copies, vectors) = match backend {
            // K as it is, and with its supports.
            Backend::Multifrontal | Backend::Faer => (2.0, DIRECT_VECTORS),
            Backend::TwoLevel => (1.0, ITERATIVE_VECTORS),
        };
        let of_run = FRACTURE_BYTES + BREAKABLE_BYTES * interactions as f64;
        let (share, fracture) = match breaks {
            Breaks::Never => (0.0, 0.0),
            Breaks::InSteps => (KEPT_SHARE, of_run),
            Breaks::EventByEvent { most_events } if most_events <= FEW_EVENTS => {
                (KEPT_SHARE, of_run + FEW_EVENTS_BYTES)
            }
            Breaks::EventByEvent { .. } => {
                (KEPT_SHARE + MANY_EVENTS_SHARE, of_run + MANY_EVENTS_BYTES)
            }
        };
        let kept = match backend {
            Backend::Multifrontal => share,
            Backend::Faer | Backend::TwoLevel => 0.0,
        };
        let factors =
            (1.0 + kept) * size.entries as f64 + WAITING_SHARE * size.waiting_entries as f64;
        let per_bond = BOND_SECONDS + BOND_ENTRY_SECONDS * size.entries as f64;
        let per_bond = match breaks {
            Breaks::EventByEvent { .. } => per_bond,
            Breaks::Never | Breaks::InSteps => STEPPED_SHARE * per_bond,
        };
        let solving =
            ENTRY_BYTES * (copies * stiffness + factors + vectors * dofs as f64) + fracture;
        let bytes = held_memory().unwrap_or(0) + solving as u64;
        let seconds = match backend {
            Backend::Multifrontal | Backend::Faer => {
                size.flops / FACTOR_RATE + stiffness / ENTRY_RATE
            }
            Backend::TwoLevel => {
                stiffness / ENTRY_RATE / 10.0 + ITERATIONS * stiffness / ITERATION_RATE
            }
        };
        Estimate {
            dofs,
            backend,
            factor_entries: size.entries,
            flops: size.flops,
            bytes: bytes.max(peak_memory().unwrap_or(0)),
            time: Duration::from_secs_f64(seconds),
            time_per_bond: Duration::from_secs_f64(per_bond),
        }
    }

    /// Before that memory is taken; `machine`: how much there is [bytes], if that is known.
    ///
    /// # Errors
    /// [`StaticsError::Memory`].
    pub fn fits(&self, machine: Option<u64>) -> Result<(), StaticsError> {
        match machine.filter(|&machine| self.bytes > machine) {
            None => Ok(()),
            Some(machine) => Err(StaticsError::Memory {
                dofs: self.dofs,
                bytes: self.bytes,
                machine,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_with_both_numbers() {
        let estimate = Estimate {
            dofs: 7,
            backend: Backend::Multifrontal,
            factor_entries: 0,
            flops: 0.0,
            bytes: 400_000_000_000,
            time: Duration::ZERO,
            time_per_bond: Duration::ZERO,
        };
        for enough in [None, Some(400_000_000_000)] {
            assert!(estimate.fits(enough).is_ok());
        }
        let error = estimate.fits(Some(24_000_000_000)).expect_err("too little");
        let text = error.to_string();
        assert!(text.contains("7 equations needs 400.0 GB"), "{text}");
        assert!(text.contains("the machine has 24.0"), "{text}");
    }
}
