//! The events that one zone predicts.

use super::event::Load;
use super::functional::Values;
use super::low_rank::Loss;
use super::policy::AGREEMENT;
use super::solutions::{Solutions, nan_max};
use super::zone::Zone;
use super::zone_start::EarlierLosses;
use crate::statics::Solution;

/// An event to come.
pub struct PredictedEvent {
    /// Functionals of the response before it.
    pub values: Values,
    /// How many losses come before it on this factor.
    pub losses_before: usize,
    pub load: Load,
    /// The bonds that change and the cells that go with them, ascending, and their integrity φ after it [-].
    pub interactions: Vec<usize>,
    pub integrity: Vec<f64>,
    /// Their stretches before and after it, under what is held and per unit of λ [-].
    pub before: Vec<[f64; 2]>,
    pub after: Vec<[f64; 2]>,
}

/// A zone, and the events there.
pub struct ZoneRun {
    pub zone: Zone,
    pub earlier: EarlierLosses,
    /// How many events come before it on this factor.
    pub first: usize,
    pub events: Vec<PredictedEvent>,
    /// u_held and u_unit on the zone after each event.
    pub ends: Vec<[Vec<f64>; 2]>,
    pub losses: Vec<Loss>,
}

impl ZoneRun {
    /// How many events there are on this factor up to its end.
    pub fn end(&self) -> usize {
        self.first + self.events.len()
    }

    /// Loads of some of its events.
    pub fn loads(&self, events: std::ops::Range<usize>) -> Vec<Load> {
        self.events[events].iter().map(|event| event.load).collect()
    }

    /// The losses of its first `count` events.
    pub fn losses_of(&self, count: usize) -> &[Loss] {
        let events = self.events[..count].iter();
        let changes = events.map(|event| event.interactions.len());
        &self.losses[..changes.sum()]
    }

    /// The forces of all losses after `count` events here, at all dofs [N]; of each case, none where nothing is
    /// held. `touched`: dofs of the losses before the zone.
    pub fn forces(&self, touched: &[usize], count: usize, base: &Solutions) -> [Vec<f64>; 2] {
        let losses = self.losses_of(count);
        let of_case = |case: usize, u: Option<&Solution>| -> Vec<f64> {
            let Some(u) = u else { return Vec::new() };
            let own = self.zone.forces(losses, &self.ends[count - 1][case]);
            let mut all = vec![0.0; 2 * u.displacement.len()];
            (self.earlier).add_forces(touched, &self.zone, case, &own, &mut all);
            all
        };
        [of_case(0, base.held.as_ref()), of_case(1, Some(&base.unit))]
    }

    /// Drops all but its first `count` events.
    pub fn truncate(&mut self, count: usize) {
        self.losses.truncate(self.losses_of(count).len());
        self.events.truncate(count);
        self.ends.truncate(count);
    }

    /// Whether u on the zone after `count` events is that of a solution.
    pub fn leads_to(&self, end: &Solutions, count: usize) -> bool {
        let cases = [end.held.as_ref(), Some(&end.unit)];
        let mut pairs = self.ends[count - 1].iter().zip(cases);
        pairs.all(|(u, solution)| {
            let Some(solution) = solution else {
                return true;
            };
            let (mut largest, mut differ) = (0.0, 0.0);
            for (u, &dof) in u.iter().zip(&self.zone.dofs) {
                let exact = solution.displacement[dof / 2][dof % 2];
                largest = nan_max(largest, exact.abs());
                differ = nan_max(differ, (u - exact).abs());
            }
            differ <= AGREEMENT * largest
        })
    }
}
