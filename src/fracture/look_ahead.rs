//! The events that follow from one factorisation, as `predictor.rs` finds them.

use super::low_rank::Loss;
use super::problem::Problem;
use super::solutions::Solutions;
use super::zone_run::{PredictedEvent, ZoneRun};
use super::zone_start::respond;
use crate::statics::Factorised;

/// The events to come.
pub struct LookAhead {
    pub factorised: Factorised,
    /// The losses on this factor, in their order.
    pub losses: Vec<Loss>,
    /// Dofs of the losses before the last zone, in the order in which they came in.
    pub touched: Vec<usize>,
    pub zones: Vec<ZoneRun>,
    /// Largest backward error between zones [-].
    pub residual: f64,
    /// Number of the state's changes when K was factorised.
    pub first: usize,
}

impl LookAhead {
    pub fn count(&self) -> usize {
        self.zones.last().map_or(0, ZoneRun::end)
    }

    pub fn event(&self, k: usize) -> &PredictedEvent {
        let zone = self.zone(k);
        &zone.events[k - zone.first]
    }

    /// The zone of an event.
    fn zone(&self, event: usize) -> &ZoneRun {
        let next = self.zones.partition_point(|zone| zone.first <= event);
        &self.zones[next - 1]
    }

    /// Stretches of an interaction that changes in an event or changed in the one before, under what is held and
    /// per unit of λ [-].
    pub fn stretches(&self, event: usize, interaction: usize) -> Option<[f64; 2]> {
        let find = |e: &PredictedEvent, of: fn(&PredictedEvent) -> &Vec<[f64; 2]>| {
            let place = e.interactions.binary_search(&interaction).ok()?;
            Some(of(e)[place])
        };
        let before = event.checked_sub(1).map(|k| self.event(k));
        find(self.event(event), |e| &e.before)
            .or_else(|| before.and_then(|e| find(e, |e| &e.after)))
    }

    /// u_held and u_unit everywhere, before an event that is not the first.
    pub fn solutions(
        &self,
        problem: &Problem,
        phase: usize,
        base: &Solutions,
        event: usize,
    ) -> Solutions {
        let zone = self.zone(event - 1);
        let forces = zone.forces(&self.touched, event - zone.first, base);
        let losses = &self.losses[..self.event(event).losses_before];
        respond(problem, phase, &self.factorised, base, forces, losses)
    }
}
