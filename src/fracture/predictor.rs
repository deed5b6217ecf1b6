//! A look ahead along an event-driven path: many events from one factorisation.
//!
//! An interaction that loses the stiffness t = (φ − φ') k is a rank-one change of K, and what that does near the
//! tips follows from the compliance A = Eᵀ K⁻¹ E of the dofs there, whatever the size of the model (Woodbury):
//!
//! ```text
//! K' = K − t w wᵀ,   a = A w,   d = 1 − t w·a
//! u' = u + a t (w·u)/d,   A' = A + (t/d) a aᵀ
//! ```
//!
//! d vanishes where the interaction was the last to hold something: there the look ahead ends, and the
//! factorisation that follows finds out what.
//!
//! The next event is sought among the bonds of a zone alone, until one of those at its rim comes near to its
//! limit. Then u is found everywhere, by one solution with the forces t (w·u) w of the losses, and the next zone
//! begins on the same factor (`zone_start.rs`), as long as that is cheaper than to factorise again.
//!
//! Bonds outside the zone are checked a posteriori. u on the zone must have come to the solution at its end; any
//! state on the way is found from it by one solution. Bonds next to the zone must have stayed under [`MARGIN`] of
//! their limits with the responses at [`CHECKS`] events and under the loads of all events around each; those
//! farther away with the responses at both ends and under all loads between. Between two checks a bond outside is
//! not followed. Events after a check that fails are dropped. A zone that does not find the first event of the
//! whole model predicts nothing.

use super::costs::ZoneCosts;
use super::event::{Bounds, Event, Load, is_at_limit};
use super::functional::{Values, fields};
use super::look_ahead::LookAhead;
use super::policy::{CHECKS, DRIFT, MARGIN, RIM, SAME_EVENT, TIE};
use super::problem::Problem;
use super::solutions::{Solutions, largest_utilisation, nan_max};
use super::state::State;
use super::zone::Zone;
use super::zone_nodes::zone_nodes;
use super::zone_response::ZoneResponse;
use super::zone_run::{PredictedEvent, ZoneRun};
use super::zone_start::{ZoneSequence, respond};
use crate::statics::{Factorised, Solution};
use rayon::prelude::*;

/// The events that follow, of which `load` is the first.
///
/// # Errors
/// The factorisation, where not even the first event can be predicted.
pub fn look_ahead(
    problem: &Problem,
    state: &State,
    factorised: Factorised,
    base: &Solutions,
    values: &Values,
    load: Load,
) -> Result<Box<LookAhead>, Box<Factorised>> {
    let functionals = &problem.programme.functionals;
    let mut costs = ZoneCosts::new(&factorised);
    let mut predictor = Predictor {
        problem,
        phase: state.phase,
        load: state.load,
        left: problem.until.steps - state.step,
        integrity: state.integrity.to_vec(),
        fields: fields(functionals, &factorised, factorised.dofs()),
        base,
        sequence: ZoneSequence::default(),
        found: LookAhead {
            factorised,
            losses: Vec::new(),
            touched: Vec::new(),
            zones: Vec::new(),
            residual: 0.0,
            first: state.changes.len(),
        },
    };
    let (solutions, values) = (base.clone(), values.clone());
    let mut beginning = Beginning {
        solutions,
        values,
        load,
    };
    while let Some((next, cost)) = predictor.run_zone(beginning, &costs) {
        costs.add(cost, predictor.found.losses.len());
        match next {
            Some(next) if !costs.is_due(predictor.sequence.dofs().len()) => beginning = next,
            _ => break,
        }
    }
    predictor.found.touched = predictor.sequence.dofs().to_vec();
    match predictor.found.count() {
        0 => Err(Box::new(predictor.found.factorised)),
        _ => Ok(Box::new(predictor.found)),
    }
}

/// State at which a zone begins.
struct Beginning {
    solutions: Solutions,
    values: Values,
    /// Load of the next event.
    load: Load,
}

/// A look ahead while it goes on.
struct Predictor<'a> {
    problem: &'a Problem<'a>,
    phase: usize,
    /// Load of the last event.
    load: Load,
    /// Events that the run may still take.
    left: usize,
    integrity: Vec<f64>,
    /// v of the functionals when K was factorised.
    fields: Vec<Vec<f64>>,
    base: &'a Solutions,
    sequence: ZoneSequence,
    found: LookAhead,
}

impl Predictor<'_> {
    /// One zone: where the next one begins, if there is an event, and what it has cost; `None` if it did
    /// not find its first event.
    fn run_zone(
        &mut self,
        beginning: Beginning,
        costs: &ZoneCosts,
    ) -> Option<(Option<Beginning>, f64)> {
        let Beginning {
            solutions,
            values,
            load,
        } = beginning;
        let problem = self.problem;
        let nodes = zone_nodes(problem, &self.integrity, &solutions, load, costs.dofs / 2);
        let zone = Zone::new(problem, &self.integrity, &nodes);
        let (start, earlier) = (self.sequence).start(&self.found.factorised, &zone, self.base)?;
        let on_zone = self.fields.iter();
        let on_zone = on_zone
            .map(|v| earlier.field(self.sequence.dofs(), &zone, v))
            .collect();
        let mut response = ZoneResponse::new(
            problem,
            &self.integrity,
            &zone,
            start.compliance(&earlier),
            &solutions,
            on_zone,
            values,
        );
        let mut run = ZoneRun {
            zone,
            earlier,
            first: self.found.count(),
            events: Vec::new(),
            ends: Vec::new(),
            losses: Vec::new(),
        };
        let goes_on = self.predict(&mut run, &mut response, load);
        let mut count = run.events.len();
        while count > 0 {
            if let Err(fewer) = self.check_ring(&run, &solutions, count) {
                count = fewer;
                continue;
            }
            let end = self.solutions_after(&run, count);
            if !self.is_sound(&run, [&solutions, &end], count) {
                count /= 2;
                continue;
            }
            let is_whole = count == run.events.len();
            run.truncate(count);
            let cost = start.flops + costs.end(run.zone.dofs.len(), run.losses.len());
            self.accept(&run, end.residual());
            let next = match is_whole && !goes_on {
                true => None,
                false => self.next(end),
            };
            if next.is_some() {
                (self.sequence).finish(problem, &run.zone, start, &run.losses);
            }
            self.found.zones.push(run);
            return Some((next, cost));
        }
        None
    }

    /// Predicts events until the zone is used up; returns whether others may follow from the same factor.
    fn predict(&self, run: &mut ZoneRun, response: &mut ZoneResponse, first: Load) -> bool {
        let zone = &run.zone;
        let end = self.problem.programme.phases[self.phase].end;
        let mut last = self.load;
        let mut rim = RIM;
        let mut stretches = Vec::new();
        while run.events.len() < self.left {
            let bounds = response.survey(zone, last.factor, &mut stretches);
            let Event::Break(load) = bounds.event(last.factor, end) else {
                return false;
            };
            let at_rim = zone.at_rim.iter();
            let nearest = at_rim
                .map(|&k| response.limits[k].utilisation(load.combine(stretches[k])))
                .fold(0.0, nan_max);
            if run.events.is_empty() {
                rim = f64::max(RIM, 0.5 * (nearest + MARGIN));
                // The zone must see what the whole model does.
                let differs = |a: f64, b: f64| (a - b).abs() > SAME_EVENT * b.abs();
                if differs(load.factor, first.factor) || differs(load.share, first.share) {
                    return false;
                }
            }
            // False for what is not a number.
            let is_far = nearest < rim;
            if !is_far {
                return true;
            }
            let is_due = |&k: &usize| is_at_limit(stretches[k], response.limits[k], load, TIE);
            let mut due: Vec<usize> = (0..stretches.len()).filter(is_due).collect();
            let values = response.values.clone();
            let laws = self.problem.laws;
            let next = |&k: &usize| {
                let stretch = load.combine(stretches[k]);
                laws.next(zone.interactions[k], response.integrity[k], stretch)
            };
            let mut integrity: Vec<f64> = due.iter().map(next).collect();
            due.extend(self.cells_with(zone, &response.integrity, &due, &integrity));
            integrity.resize(due.len(), 0.0);
            let losses_before = self.found.losses.len() + run.losses.len();
            for (&k, &phi) in due.iter().zip(&integrity) {
                let Some(loss) = response.change(self.problem, zone, k, phi) else {
                    run.losses.truncate(losses_before - self.found.losses.len());
                    return false;
                };
                run.losses.push(loss);
            }
            let stretches_now = |&k: &usize| zone.stretches(k, &response.displacement);
            run.events.push(PredictedEvent {
                values,
                losses_before,
                load,
                before: due.iter().map(|&k| stretches[k]).collect(),
                after: due.iter().map(stretches_now).collect(),
                interactions: due.iter().map(|&k| zone.interactions[k]).collect(),
                integrity,
            });
            run.ends.push(response.displacement.clone());
            last = load;
        }
        false
    }

    /// Places of the cells that go with the interactions at some places, ascending.
    fn cells_with(
        &self,
        zone: &Zone,
        before: &[f64],
        due: &[usize],
        integrity: &[f64],
    ) -> Vec<usize> {
        let broken = due.iter().zip(integrity).filter(|(_, phi)| **phi == 0.0);
        let broken: Vec<usize> = broken.map(|(&k, _)| zone.interactions[k]).collect();
        let place = |cell| zone.place(cell).expect("a bond is there with its cells");
        let is_intact = |cell: usize| self.integrity[cell] > 0.0 && before[place(cell)] > 0.0;
        let cells = self.problem.model.cells_with(&broken, is_intact);
        cells.into_iter().map(place).collect()
    }

    /// Checks the bonds next to the zone while `count` events pass.
    ///
    /// # Errors
    /// How many events are beyond doubt.
    fn check_ring(&self, run: &ZoneRun, start: &Solutions, count: usize) -> Result<(), usize> {
        let checks: Vec<usize> = (1..CHECKS).map(|k| k * count / CHECKS).collect();
        let mut checks: Vec<usize> = checks.into_iter().filter(|&k| k > 0).collect();
        checks.dedup();
        let solutions = self.solutions_near(run, &checks);
        let ring = || run.zone.ring.par_iter().copied();
        let mut last = start;
        let mut from = 0;
        for (&to, solutions) in checks.iter().zip(&solutions) {
            let is_under =
                self.utilisation(ring(), &[last, solutions], &run.loads(from..to)) < MARGIN;
            if !is_under {
                return Err(from.min(to - 1));
            }
            (last, from) = (solutions, to);
        }
        match self.utilisation(ring(), &[last], &run.loads(from..count)) < MARGIN {
            true => Ok(()),
            false => Err(from.min(count - 1)),
        }
    }

    /// u_held and u_unit next to the zone after some numbers of events.
    fn solutions_near(&self, run: &ZoneRun, counts: &[usize]) -> Vec<Solutions> {
        let dofs = self.found.factorised.dofs();
        let of_count = |&count: &usize| run.forces(self.sequence.dofs(), count, self.base);
        let mut forces: Vec<f64> = counts.iter().flat_map(of_count).flatten().collect();
        if !forces.is_empty() {
            let nodes = &run.zone.ring_nodes;
            (self.found.factorised).respond_at(nodes, &mut forces);
        }
        let moved = |before: &Solution, change: &[f64]| Solution {
            displacement: (before.displacement.iter().zip(change.chunks_exact(2)))
                .map(|(u, c)| [u[0] + c[0], u[1] + c[1]])
                .collect(),
            reaction: Vec::new(),
            residual: 0.0,
            size: before.size,
        };
        let mut found = Vec::new();
        let cases = 1 + usize::from(self.base.held.is_some());
        for both in forces.chunks_exact(dofs * cases) {
            let (held, unit) = both.split_at(both.len() - dofs);
            found.push(Solutions {
                held: self.base.held.as_ref().map(|u| moved(u, held)),
                unit: moved(&self.base.unit, unit),
            });
        }
        found
    }

    /// u_held and u_unit everywhere after `count` events.
    fn solutions_after(&self, run: &ZoneRun, count: usize) -> Solutions {
        let found = &self.found;
        let forces = run.forces(self.sequence.dofs(), count, self.base);
        let losses = [&found.losses, run.losses_of(count)].concat();
        let (problem, base) = (self.problem, self.base);
        respond(
            problem,
            self.phase,
            &found.factorised,
            base,
            forces,
            &losses,
        )
    }

    /// Whether all bonds outside stay under their limits with the responses at both ends, of which the second
    /// must be a solution.
    fn is_sound(&self, run: &ZoneRun, ends: [&Solutions; 2], count: usize) -> bool {
        let mut is_outside: Vec<bool> = self.integrity.iter().map(|&phi| phi > 0.0).collect();
        for &interaction in &run.zone.interactions {
            is_outside[interaction] = false;
        }
        let all = self.problem.model.interactions.axial().into_par_iter();
        let outside = all.filter(|&interaction| is_outside[interaction]);
        // False for what is not a number.
        let is_exact = ends[1].residual() <= DRIFT;
        is_exact
            && run.leads_to(ends[1], count)
            && self.utilisation(outside, &ends, &run.loads(0..count)) < MARGIN
    }

    /// A bound of the largest stretch over its limit, see [`largest_utilisation`].
    fn utilisation(
        &self,
        interactions: impl ParallelIterator<Item = usize>,
        responses: &[&Solutions],
        loads: &[Load],
    ) -> f64 {
        let (problem, integrity) = (self.problem, &self.integrity);
        largest_utilisation(problem, integrity, interactions, responses, loads)
    }

    fn accept(&mut self, run: &ZoneRun, residual: f64) {
        for event in &run.events {
            for (&s, &phi) in event.interactions.iter().zip(&event.integrity) {
                self.integrity[s] = phi;
            }
        }
        self.left -= run.events.len();
        self.load = run.events.last().expect("an event").load;
        self.found.losses.extend(&run.losses);
        self.found.residual = nan_max(self.found.residual, residual);
    }

    /// State at which the next zone begins, if a bond breaks next.
    fn next(&self, solutions: Solutions) -> Option<Beginning> {
        if self.left == 0 {
            return None;
        }
        let last = self.load.factor;
        let bounds = (self.problem.model.interactions.axial())
            .into_par_iter()
            .filter(|&s| self.integrity[s] > 0.0)
            .map(|s| {
                let stretches = solutions.rough_stretches(self.problem, s);
                let limits = self.problem.laws.limits(s, self.integrity[s]);
                Bounds::of(stretches, limits, last)
            })
            .reduce(|| Bounds::NONE, Bounds::and);
        let end = self.problem.programme.phases[self.phase].end;
        let Event::Break(load) = bounds.event(last, end) else {
            return None;
        };
        Some(Beginning {
            values: solutions.values(self.problem),
            solutions,
            load,
        })
    }
}
