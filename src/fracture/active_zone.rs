//! A look ahead along an event-driven path: many events from one factorisation.
//!
//! A bond that breaks is a rank-one change of K, and what it does near the tips follows from the
//! compliance A = Eᵀ K⁻¹ E of the dofs there, whatever the size of the model (Woodbury):
//!
//! ```text
//! K' = K − k w wᵀ,   a = A w,   d = 1 − k w·a
//! u' = u + a k (w·u)/d,   A' = A + (k/d) a aᵀ
//! ```
//!
//! d vanishes where the bond was the last to hold something: there the look ahead ends, and the
//! factorisation that follows finds out what.
//!
//! The next event is sought among the bonds of the zone alone. Now and then u is found everywhere, by
//! one solution with the forces k (w·u) w of the bonds that are gone: all bonds outside must have stayed
//! under [`MARGIN`] of their limits, under the loads of all events since the last such check and with
//! the response at either end. Events behind a check that fails are dropped, and the next factorisation
//! starts before them. A zone that cannot tell even the first event leaves it to the whole model.

use super::control::{Problem, TIE};
use super::event::{Bounds, Event, Load, is_at_limit};
use super::functional::Values;
use super::response::Solutions;
use super::state::State;
use super::zone::{Front, Zone};
use crate::boundary::Boundary;
use crate::statics::{Factorised, Solution};
use rayon::prelude::*;

/// Bonds outside the zone that come nearer to their limit are not outside.
const MARGIN: f64 = 0.95;

/// The largest relative residual that the updates may leave.
const DRIFT: f64 = 1e-11;

/// Events up to the first check; the distance doubles while checks succeed.
const FIRST_CHECK: usize = 8;

/// One event to come.
pub struct Moment {
    /// u_held and u_unit on the zone before it [m].
    displacement: [Vec<f64>; 2],
    pub values: Values,
    /// How many springs have gone before it.
    gone: usize,
    pub load: Load,
    /// The bonds that break, ascending.
    pub bonds: Vec<usize>,
}

/// The events to come.
pub struct Ahead {
    factorised: Factorised,
    zone: Zone,
    moments: Vec<Moment>,
    /// Springs in the order in which they go.
    gone: Vec<usize>,
    /// The largest relative residual at the checks.
    pub residual: f64,
}

impl Ahead {
    pub fn count(&self) -> usize {
        self.moments.len()
    }

    pub fn moment(&self, k: usize) -> &Moment {
        &self.moments[k]
    }

    /// Stretches of a spring of the zone, under what is held and per unit of λ.
    pub fn stretches(&self, moment: usize, spring: usize) -> Option<[f64; 2]> {
        let place = self.zone.place(spring)?;
        let u = &self.moments[moment].displacement;
        Some(self.zone.stretches(place, u))
    }

    /// u_held and u_unit everywhere.
    pub fn solutions(
        &self,
        problem: &Problem,
        phase: usize,
        base: &Solutions,
        moment: usize,
    ) -> Solutions {
        let moment = &self.moments[moment];
        let gone = &self.gone[..moment.gone];
        let u = &moment.displacement;
        recover(problem, phase, &self.factorised, &self.zone, base, u, gone)
    }
}

/// u_held and u_unit everywhere from the zone's, with the springs that have gone.
fn recover(
    problem: &Problem,
    phase: usize,
    factorised: &Factorised,
    zone: &Zone,
    base: &Solutions,
    u: &[Vec<f64>; 2],
    gone: &[usize],
) -> Solutions {
    let elongation = |case: usize| {
        let of = |spring: &usize| {
            let place = zone.place(*spring).expect("only springs of the zone go");
            (*spring, zone.elongation(place, &u[case]))
        };
        gone.iter().map(of).collect::<Vec<_>>()
    };
    let (model, programme) = (problem.model, problem.programme);
    let unit = &programme.phases[phase].boundary;
    let held = (base.held.as_ref()).zip(programme.held(phase));
    let after = |case: usize, boundary: &Boundary, before: &Solution| {
        let change = factorised.respond_to_loss(model, &elongation(case));
        let case = (boundary, factorised.scale(boundary));
        factorised.without(model, case, before, &change, gone)
    };
    Solutions {
        unit: after(1, unit, &base.unit),
        held: held.map(|(u, case)| after(0, &case, u)),
    }
}

/// What follows from `load`, the first event; `None` where the zone cannot tell.
pub fn look_ahead(
    problem: &Problem,
    state: &State,
    factorised: Factorised,
    base: &Solutions,
    values: &Values,
    load: Load,
) -> Option<Ahead> {
    let zone = Zone::new(problem, state, base, load);
    let front = Front::new(problem, state, &factorised, &zone, base, values)?;
    let mut scout = Scout {
        problem,
        state,
        outside: zone.outside(&state.intact),
        ahead: Ahead {
            factorised,
            zone,
            moments: Vec::new(),
            gone: Vec::new(),
            residual: 0.0,
        },
        ends: Vec::new(),
        base,
    };
    let sound = scout.explore(front);
    let Scout { mut ahead, .. } = scout;
    ahead.moments.truncate(sound);
    (sound > 0).then_some(ahead)
}

/// A look ahead while it goes on.
struct Scout<'a> {
    problem: &'a Problem<'a>,
    state: &'a State,
    /// Intact springs that the zone does not see.
    outside: Vec<usize>,
    ahead: Ahead,
    /// u_held and u_unit on the zone behind each event.
    ends: Vec<[Vec<f64>; 2]>,
    base: &'a Solutions,
}

impl Scout<'_> {
    /// Goes on until a check fails or there is nothing more to foresee; returns how many events are
    /// beyond doubt.
    fn explore(&mut self, mut front: Front) -> usize {
        let (mut sound, mut distance) = (0, FIRST_CHECK);
        let mut last = self.base.clone();
        loop {
            let goal = sound + distance;
            let mut goes_on = true;
            while goes_on && self.ahead.moments.len() < goal {
                goes_on = self.advance(&mut front);
            }
            let mut reached = self.ahead.moments.len();
            let first = reached;
            // Halves the distance to what is beyond doubt until a check succeeds.
            while reached > sound {
                match self.check(sound, reached, &last) {
                    Some(solutions) => {
                        last = solutions;
                        sound = reached;
                    }
                    None => reached = sound + (reached - sound) / 2,
                }
                if reached == sound {
                    break;
                }
            }
            if sound < first || !goes_on {
                return sound;
            }
            distance *= 2;
        }
    }

    /// One more event; whether others may follow.
    fn advance(&mut self, front: &mut Front) -> bool {
        let Ahead {
            zone,
            moments,
            gone,
            ..
        } = &mut self.ahead;
        let phase = &self.problem.programme.phases[self.state.phase];
        let last = moments.last().map_or(self.state.load, |m: &Moment| m.load);
        let bounds = zone.fold(
            front,
            Bounds::NONE,
            |stretches, limit| Bounds::of(stretches, limit, last.factor),
            Bounds::and,
        );
        let Event::Break(load) = bounds.event(last.factor, phase.end) else {
            return false;
        };
        let bonds = zone.filter(front, |stretches, limit| {
            is_at_limit(stretches, limit, load, TIE)
        });
        moments.push(Moment {
            displacement: front.displacement.clone(),
            values: front.values.clone(),
            gone: gone.len(),
            load,
            bonds: bonds.clone(),
        });
        let held = bonds.iter().all(|&bond| front.release(zone, bond));
        gone.extend(bonds);
        self.ends.push(front.displacement.clone());
        held
    }

    /// The solution behind `to` events, if all bonds outside stay under their limits until then; `last`
    /// is the one behind `from` of them.
    fn check(&mut self, from: usize, to: usize, last: &Solutions) -> Option<Solutions> {
        let gone = match self.ahead.moments.get(to) {
            Some(next) => next.gone,
            None => self.ahead.gone.len(),
        };
        let Ahead {
            factorised,
            zone,
            moments,
            gone: springs,
            ..
        } = &self.ahead;
        let u = &self.ends[to - 1];
        let phase = self.state.phase;
        let solutions = recover(
            self.problem,
            phase,
            factorised,
            zone,
            self.base,
            u,
            &springs[..gone],
        );
        let loads: Vec<Load> = moments[from..to].iter().map(|m| m.load).collect();
        let nearest = [last, &solutions].map(|u| self.utilisation_outside(u, &loads));
        let residual = solutions.residual();
        // False for what is not a number.
        let sound = residual <= DRIFT && nearest.iter().all(|&u| u < MARGIN);
        if sound {
            self.ahead.residual = self.ahead.residual.max(residual);
        }
        sound.then_some(solutions)
    }

    /// A bound of the largest stretch over its limit outside the zone under any of the loads: convex in
    /// (μ, μ λ), so that it lies at a corner of their box.
    fn utilisation_outside(&self, solutions: &Solutions, loads: &[Load]) -> f64 {
        let range = |of: fn(&Load) -> f64| {
            let all = || loads.iter().map(of);
            [
                all().fold(f64::INFINITY, f64::min),
                all().fold(f64::NEG_INFINITY, f64::max),
            ]
        };
        let shares = range(|load| load.share);
        let factors = range(|load| load.share * load.factor);
        let largest = |&spring: &usize| {
            let [held, unit] = solutions.rough_stretches(self.problem, spring);
            let limit = self.problem.limits.of(spring);
            let corners = shares
                .iter()
                .flat_map(|a| factors.iter().map(move |b| (a, b)));
            corners
                .map(|(a, b)| limit.utilisation(a * held + b * unit))
                .fold(0.0, f64::max)
        };
        let all = self.outside.par_iter().map(largest);
        all.reduce(|| 0.0, nan_max)
    }
}

/// The larger one; not a number if either is not.
fn nan_max(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}
