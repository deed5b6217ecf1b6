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
//! The next event is sought among the bonds of a zone alone, until one of those at its rim comes near to its
//! limit. Then u is found everywhere, by one solution with the forces k (w·u) w of the bonds that are gone,
//! and the next zone begins on the same factor (`gone.rs`), as long as that is cheaper than to factorise
//! again ([`Costs`]).
//!
//! What is not seen is looked at afterwards. u on the zone must have come to the solution at its end;
//! any state on the way is found from it by one solution. Bonds next to the zone must have stayed under [`MARGIN`] of
//! their limits with the responses at [`LOOKS`] moments and under the loads of all events around each; those
//! farther away with the responses at both ends and under all loads between. Between two looks a bond
//! outside is not followed. Events behind a look that fails are dropped. A zone that cannot tell even its
//! first event leaves it to the whole model.

use super::corridor;
use super::event::{Bounds, Event, Load, TIE, is_at_limit};
use super::functional::{Values, fields};
use super::gone::{self, Earlier, Gone};
use super::laws::StretchLimits;
use super::lost::Loss;
use super::problem::Problem;
use super::solutions::{Solutions, nan_max};
use super::state::State;
use super::zone::{Front, Zone};
use crate::statics::{Factorised, Solution};
use rayon::prelude::*;

/// Bonds outside the zone that come nearer to their limit are not outside.
const MARGIN: f64 = 0.95;

/// A zone is used up when a bond at its rim comes nearer than this to its limit, or than halfway to
/// [`MARGIN`] from where it was.
const RIM: f64 = 0.93;

/// Looks at the bonds next to a zone while it lasts.
const LOOKS: usize = 4;

/// The largest backward error that the updates may leave: a factorisation leaves some 1e-17.
const DRIFT: f64 = 1e-14;

/// By how much u on a zone may differ at its end from the solution there, over the largest: load factors are to be
/// right to 1e-9. Updates leave some 1e-14.
const AGREEMENT: f64 = 1e-10;

/// One event to come.
pub struct Moment {
    pub values: Values,
    /// How many springs have gone before it.
    gone: usize,
    pub load: Load,
    /// The bonds that change, ascending, and their integrity φ after it [-].
    pub bonds: Vec<usize>,
    integrity: Vec<f64>,
    /// Their stretches before and after, under what is held and per unit of λ.
    before: Vec<[f64; 2]>,
    after: Vec<[f64; 2]>,
}

/// The events to come.
pub struct Ahead {
    factorised: Factorised,
    /// The springs that go, in that order.
    order: Vec<Loss>,
    /// The dofs that those touch which were gone when the last zone began, in that order.
    touched: Vec<usize>,
    zones: Vec<Crossing>,
    /// Largest backward error between zones [-].
    pub residual: f64,
}

impl Ahead {
    pub fn count(&self) -> usize {
        self.zones.last().map_or(0, Crossing::end)
    }

    pub fn moment(&self, k: usize) -> &Moment {
        let zone = self.zone(k);
        &zone.moments[k - zone.first]
    }

    /// The zone of a moment.
    fn zone(&self, moment: usize) -> &Crossing {
        let next = self.zones.partition_point(|zone| zone.first <= moment);
        &self.zones[next - 1]
    }

    /// Stretches of a spring that breaks in an event or broke in the one before, under what is held and per
    /// unit of λ.
    pub fn stretches(&self, moment: usize, spring: usize) -> Option<[f64; 2]> {
        let find = |m: &Moment, of: fn(&Moment) -> &Vec<[f64; 2]>| {
            let place = m.bonds.binary_search(&spring).ok()?;
            Some(of(m)[place])
        };
        let before = moment.checked_sub(1).map(|k| self.moment(k));
        find(self.moment(moment), |m| &m.before)
            .or_else(|| before.and_then(|m| find(m, |m| &m.after)))
    }

    /// u_held and u_unit everywhere, at a moment that is not the first.
    pub fn solutions(
        &self,
        problem: &Problem,
        phase: usize,
        base: &Solutions,
        moment: usize,
    ) -> Solutions {
        let zone = self.zone(moment - 1);
        let forces = zone.forces(&self.touched, moment - zone.first, base);
        let gone = &self.order[..self.moment(moment).gone];
        gone::respond(problem, phase, &self.factorised, base, forces, gone)
    }
}

/// What follows from `load`, the first event; `None` where not even that can be told.
pub fn look_ahead(
    problem: &Problem,
    state: &State,
    factorised: Factorised,
    base: &Solutions,
    values: &Values,
    load: Load,
) -> Option<Ahead> {
    let functionals = &problem.programme.functionals;
    let mut costs = Costs::new(&factorised);
    let mut scout = Scout {
        problem,
        phase: state.phase,
        load: state.load,
        left: problem.until.steps - state.step,
        integrity: state.integrity.clone(),
        fields: fields(functionals, &factorised, factorised.dofs()),
        base,
        gone: Gone::default(),
        ahead: Ahead {
            factorised,
            order: Vec::new(),
            touched: Vec::new(),
            zones: Vec::new(),
            residual: 0.0,
        },
    };
    let mut here = Here {
        solutions: base.clone(),
        values: values.clone(),
        load,
    };
    while let Some((next, cost)) = scout.cross(here, &costs) {
        costs.add(cost, scout.ahead.order.len());
        match next {
            Some(next) if !costs.is_due(scout.gone.dofs().len()) => here = next,
            _ => break,
        }
    }
    scout.ahead.touched = scout.gone.dofs().to_vec();
    (scout.ahead.count() > 0).then_some(scout.ahead)
}

/// When the next factorisation is due: as soon as the next zone would cost more per bond than all since the
/// last one have on average, that one included. From counts alone, in multiplications and additions of a dense
/// product.
struct Costs {
    /// Dofs of a zone.
    dofs: usize,
    /// More touched dofs than these would take more memory than the factor.
    most_touched: f64,
    /// Of L.
    entries: f64,
    spent: f64,
    bonds: usize,
    /// Of the last zone: its cost apart from what is gone, and bonds.
    last: [f64; 2],
}

/// What others cost beside a dense product, measured (docs/performance.md): a sparse factorisation, each of its
/// flops; assembly and a first solution, the end of a zone, each entry of L; a bond, each entry of A'.
const FACTORISATION: f64 = 2.5;
const ASSEMBLY: f64 = 200.0;
const END: f64 = 300.0;
const BOND: f64 = 6.0;

/// The dofs of a zone: per bond they cost n², and the solutions at its end 1/n. The third root is the
/// optimum, its factor measured.
const DOFS: f64 = 30.0;
const FEWEST_DOFS: f64 = 1200.0;

impl Costs {
    fn new(factorised: &Factorised) -> Costs {
        let (entries, flops) = (factorised.entries as f64, factorised.flops);
        Costs {
            dofs: (DOFS * entries).cbrt().max(FEWEST_DOFS) as usize,
            most_touched: entries.sqrt(),
            entries,
            spent: FACTORISATION * flops + ASSEMBLY * entries,
            bonds: 0,
            last: [0.0; 2],
        }
    }

    /// Of what comes after the compliance of a zone of `n` dofs.
    fn end(&self, n: usize, bonds: usize) -> f64 {
        END * self.entries + BOND * (bonds * n * n) as f64
    }

    fn add(&mut self, cost: f64, bonds: usize) {
        self.spent += cost;
        self.last = [cost, (bonds - self.bonds) as f64];
        self.bonds = bonds;
    }

    fn is_due(&self, touched: usize) -> bool {
        let touched = touched as f64;
        let [cost, bonds] = self.last;
        let next = cost + touched * touched * touched;
        next * self.bonds as f64 > self.spent * bonds || touched > self.most_touched
    }
}

/// Where a zone begins.
struct Here {
    solutions: Solutions,
    values: Values,
    /// Breaks the next bond.
    load: Load,
}

/// A look ahead while it goes on.
struct Scout<'a> {
    problem: &'a Problem<'a>,
    phase: usize,
    /// Of the last event.
    load: Load,
    /// Events that the run may still take.
    left: usize,
    integrity: Vec<f64>,
    /// v of the functionals when K was factorised.
    fields: Vec<Vec<f64>>,
    base: &'a Solutions,
    gone: Gone,
    ahead: Ahead,
}

/// A zone, and what happens there.
struct Crossing {
    zone: Zone,
    earlier: Earlier,
    /// How many events come before it.
    first: usize,
    moments: Vec<Moment>,
    /// u_held and u_unit on the zone behind each event.
    ends: Vec<[Vec<f64>; 2]>,
    order: Vec<Loss>,
}

impl Scout<'_> {
    /// One zone: where the next one begins, if there is an event, and what it has cost; `None` if it could
    /// not tell its first event.
    fn cross(&mut self, here: Here, costs: &Costs) -> Option<(Option<Here>, f64)> {
        let Here {
            solutions,
            values,
            load,
        } = here;
        let problem = self.problem;
        let nodes = corridor::nodes(problem, &self.integrity, &solutions, load, costs.dofs / 2);
        let zone = Zone::new(problem, &self.integrity, &nodes);
        let (start, earlier) = (self.gone).start(&self.ahead.factorised, &zone, self.base)?;
        let on_zone = self.fields.iter();
        let on_zone = on_zone
            .map(|v| earlier.field(self.gone.dofs(), &zone, v))
            .collect();
        let mut front = Front::new(
            problem,
            &self.integrity,
            &zone,
            start.compliance(&earlier),
            &solutions,
            on_zone,
            values,
        );
        let mut crossing = Crossing {
            zone,
            earlier,
            first: self.ahead.count(),
            moments: Vec::new(),
            ends: Vec::new(),
            order: Vec::new(),
        };
        let goes_on = self.explore(&mut crossing, &mut front, load);
        let mut count = crossing.moments.len();
        while count > 0 {
            if let Err(fewer) = self.look(&crossing, &solutions, count) {
                count = fewer;
                continue;
            }
            let end = self.behind(&crossing, count);
            if !self.is_sound(&crossing, [&solutions, &end], count) {
                count /= 2;
                continue;
            }
            let is_whole = count == crossing.moments.len();
            crossing.truncate(count);
            let cost = start.flops + costs.end(crossing.zone.dofs.len(), crossing.order.len());
            self.accept(&crossing, end.residual());
            let next = match is_whole && !goes_on {
                true => None,
                false => self.next(end),
            };
            if next.is_some() {
                (self.gone).lose(problem, &crossing.zone, start, &crossing.order);
            }
            self.ahead.zones.push(crossing);
            return Some((next, cost));
        }
        None
    }

    /// Takes events until the zone is used up; whether others may follow from the same factor.
    fn explore(&self, crossing: &mut Crossing, front: &mut Front, first: Load) -> bool {
        let zone = &crossing.zone;
        let end = self.problem.programme.phases[self.phase].end;
        let mut last = self.load;
        let mut rim = RIM;
        let mut stretches = Vec::new();
        while crossing.moments.len() < self.left {
            let bounds = zone.survey(front, last.factor, &mut stretches);
            let Event::Break(load) = bounds.event(last.factor, end) else {
                return false;
            };
            let at_rim = zone.at_rim.iter();
            let nearest = at_rim
                .map(|&k| front.limits[k].utilisation(load.combine(stretches[k])))
                .fold(0.0, nan_max);
            if crossing.moments.is_empty() {
                rim = f64::max(RIM, 0.5 * (nearest + MARGIN));
                // The zone must see what the whole model does.
                let differs = |a: f64, b: f64| (a - b).abs() > 1e-6 * b.abs();
                if differs(load.factor, first.factor) || differs(load.share, first.share) {
                    return false;
                }
            }
            // False for what is not a number.
            let is_far = nearest < rim;
            if !is_far {
                return true;
            }
            let is_due = |&k: &usize| is_at_limit(stretches[k], front.limits[k], load, TIE);
            let due: Vec<usize> = (0..stretches.len()).filter(is_due).collect();
            let values = front.values.clone();
            let bonds: Vec<usize> = due.iter().map(|&k| zone.springs[k]).collect();
            let next = |&k: &usize| {
                let stretch = load.combine(stretches[k]);
                let laws = &self.problem.laws;
                laws.next(zone.springs[k], front.integrity[k], stretch)
            };
            let integrity: Vec<f64> = due.iter().map(next).collect();
            let mut losses = Vec::new();
            for (&k, &phi) in due.iter().zip(&integrity) {
                let Some(loss) = front.change(self.problem, zone, k, phi) else {
                    return false;
                };
                losses.push(loss);
            }
            crossing.moments.push(Moment {
                values,
                gone: self.ahead.order.len() + crossing.order.len(),
                load,
                before: due.iter().map(|&k| stretches[k]).collect(),
                after: due
                    .iter()
                    .map(|&k| zone.stretches(k, &front.displacement))
                    .collect(),
                bonds,
                integrity,
            });
            crossing.order.extend(losses);
            crossing.ends.push(front.displacement.clone());
            last = load;
        }
        false
    }

    /// Looks at the bonds next to the zone while `count` events pass; or else how many are beyond doubt.
    fn look(&self, crossing: &Crossing, start: &Solutions, count: usize) -> Result<(), usize> {
        let moments: Vec<usize> = (1..LOOKS).map(|k| k * count / LOOKS).collect();
        let mut moments: Vec<usize> = moments.into_iter().filter(|&k| k > 0).collect();
        moments.dedup();
        let looks = self.displacements(crossing, &moments);
        let mut last = start;
        let mut from = 0;
        for (k, solutions) in looks.iter().enumerate() {
            let to = moments[k];
            let loads: Vec<Load> = crossing.moments[from..to].iter().map(|m| m.load).collect();
            let ring = crossing.zone.ring.par_iter().copied();
            let is_under = self.utilisation(ring, &[last, solutions], &loads) < MARGIN;
            if !is_under {
                return Err(from.min(to - 1));
            }
            (last, from) = (solutions, to);
        }
        let loads: Vec<Load> = crossing.moments[from..count]
            .iter()
            .map(|m| m.load)
            .collect();
        let ring = crossing.zone.ring.par_iter().copied();
        match self.utilisation(ring, &[last], &loads) < MARGIN {
            true => Ok(()),
            false => Err(from.min(count - 1)),
        }
    }

    /// u_held and u_unit next to the zone behind some numbers of events.
    fn displacements(&self, crossing: &Crossing, counts: &[usize]) -> Vec<Solutions> {
        let dofs = self.ahead.factorised.dofs();
        let of_count = |&count: &usize| crossing.forces(self.gone.dofs(), count, self.base);
        let mut forces: Vec<f64> = counts.iter().flat_map(of_count).flatten().collect();
        if !forces.is_empty() {
            let nodes = &crossing.zone.ring_nodes;
            (self.ahead.factorised).respond_at(nodes, &mut forces);
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

    /// u_held and u_unit everywhere behind `count` events.
    fn behind(&self, crossing: &Crossing, count: usize) -> Solutions {
        let Ahead {
            factorised, order, ..
        } = &self.ahead;
        let forces = crossing.forces(self.gone.dofs(), count, self.base);
        let gone = [order, &crossing.order[..crossing.gone(count)]].concat();
        gone::respond(
            self.problem,
            self.phase,
            factorised,
            self.base,
            forces,
            &gone,
        )
    }

    /// Whether all bonds outside stay under their limits with the responses at both ends, of which the second
    /// must be a solution.
    fn is_sound(&self, crossing: &Crossing, ends: [&Solutions; 2], count: usize) -> bool {
        let loads: Vec<Load> = crossing.moments[..count].iter().map(|m| m.load).collect();
        let mut is_outside: Vec<bool> = self.integrity.iter().map(|&phi| phi > 0.0).collect();
        for &spring in &crossing.zone.springs {
            is_outside[spring] = false;
        }
        let all = (0..is_outside.len()).into_par_iter();
        let outside = all.filter(|&spring| is_outside[spring]);
        // False for what is not a number.
        let is_exact = ends[1].residual() <= DRIFT;
        is_exact
            && crossing.leads_to(ends[1], count)
            && self.utilisation(outside, &ends, &loads) < MARGIN
    }

    /// A bound of the largest stretch over its limit of some springs with any of the responses and under any of
    /// the loads: convex in (μ, μ λ), so that it lies at a corner of their box.
    fn utilisation(
        &self,
        springs: impl ParallelIterator<Item = usize>,
        responses: &[&Solutions],
        loads: &[Load],
    ) -> f64 {
        let range = |of: fn(&Load) -> f64| {
            let all = || loads.iter().map(of);
            [
                all().fold(f64::INFINITY, f64::min),
                all().fold(f64::NEG_INFINITY, f64::max),
            ]
        };
        let shares = range(|load| load.share);
        let factors = range(|load| load.share * load.factor);
        let of_stretches = |limit: StretchLimits, [held, unit]: [f64; 2]| {
            let corners = shares
                .iter()
                .flat_map(|a| factors.iter().map(move |b| (a, b)));
            corners
                .map(|(a, b)| limit.utilisation(a * held + b * unit))
                .fold(0.0, nan_max)
        };
        let largest = |spring: usize| {
            let limit = self.problem.laws.limits(spring, self.integrity[spring]);
            let stretches = responses.iter();
            stretches
                .map(|u| of_stretches(limit, u.rough_stretches(self.problem, spring)))
                .fold(0.0, nan_max)
        };
        springs.map(largest).reduce(|| 0.0, nan_max)
    }

    fn accept(&mut self, crossing: &Crossing, residual: f64) {
        for moment in &crossing.moments {
            for (&bond, &phi) in moment.bonds.iter().zip(&moment.integrity) {
                self.integrity[bond] = phi;
            }
        }
        self.left -= crossing.moments.len();
        self.load = crossing.moments.last().expect("an event").load;
        self.ahead.order.extend(&crossing.order);
        self.ahead.residual = nan_max(self.ahead.residual, residual);
    }

    /// Where the next zone begins, if a bond breaks next.
    fn next(&self, solutions: Solutions) -> Option<Here> {
        if self.left == 0 {
            return None;
        }
        let last = self.load.factor;
        let bounds = (0..self.integrity.len())
            .into_par_iter()
            .filter(|&s| self.integrity[s] > 0.0)
            .map(|s| {
                let stretches = solutions.rough_stretches(self.problem, s);
                Bounds::of(
                    stretches,
                    self.problem.laws.limits(s, self.integrity[s]),
                    last,
                )
            })
            .reduce(|| Bounds::NONE, Bounds::and);
        let end = self.problem.programme.phases[self.phase].end;
        let Event::Break(load) = bounds.event(last, end) else {
            return None;
        };
        let functionals = &self.problem.programme.functionals;
        let both = [solutions.held.as_ref(), Some(&solutions.unit)];
        Some(Here {
            values: Values::of(functionals, both),
            solutions,
            load,
        })
    }
}

impl Crossing {
    /// How many events there are up to its end.
    fn end(&self) -> usize {
        self.first + self.moments.len()
    }

    /// Of each case, none of what is not held: the forces of all springs that are gone behind `count` events here,
    /// at all dofs [N]. `touched`: by those that were gone before.
    fn forces(&self, touched: &[usize], count: usize, base: &Solutions) -> [Vec<f64>; 2] {
        let order = &self.order[..self.gone(count)];
        let of_case = |case: usize, u: Option<&Solution>| -> Vec<f64> {
            let Some(u) = u else { return Vec::new() };
            let own = self.zone.forces(order, &self.ends[count - 1][case]);
            let mut all = vec![0.0; 2 * u.displacement.len()];
            (self.earlier).add_forces(touched, &self.zone, case, &own, &mut all);
            all
        };
        [of_case(0, base.held.as_ref()), of_case(1, Some(&base.unit))]
    }

    /// Only its first `count` events count.
    fn truncate(&mut self, count: usize) {
        self.order.truncate(self.gone(count));
        self.moments.truncate(count);
        self.ends.truncate(count);
    }

    /// Whether u on the zone behind `count` events is that of a solution.
    fn leads_to(&self, end: &Solutions, count: usize) -> bool {
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

    /// How many springs of the zone have gone behind `count` events.
    fn gone(&self, count: usize) -> usize {
        self.moments[..count].iter().map(|m| m.bonds.len()).sum()
    }
}
