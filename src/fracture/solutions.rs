//! The two solutions of which the response is made: u_held and u_unit.

use super::event::Load;
use super::functional::Values;
use super::laws::StretchLimits;
use super::problem::Problem;
use crate::model::Model;
use crate::statics::Solution;
use rayon::prelude::*;

/// u_held and u_unit of all nodes.
#[derive(Clone)]
pub struct Solutions {
    pub held: Option<Solution>,
    pub unit: Solution,
}

impl Solutions {
    /// Displacement [m] and, where one is prescribed, reaction [N] of a node.
    pub fn at(&self, load: Load, node: usize) -> ([f64; 2], [f64; 2]) {
        let combine = |field: fn(&Solution) -> &Vec<[f64; 2]>| {
            [0, 1].map(|axis| {
                let held = self.held.as_ref();
                let held = held.map_or(0.0, |held| field(held)[node][axis]);
                load.combine([held, field(&self.unit)[node][axis]])
            })
        };
        (combine(|s| &s.displacement), combine(|s| &s.reaction))
    }

    /// Stretches of an interaction under what is held, and per unit of λ.
    pub fn stretches(&self, problem: &Problem, interaction: usize) -> [f64; 2] {
        let stretch = |u: &Solution| problem.model.stretch(interaction, &u.displacement);
        [self.held.as_ref().map_or(0.0, stretch), stretch(&self.unit)]
    }

    /// The same but for rounding, in a fifth of the time.
    pub fn rough_stretches(&self, problem: &Problem, interaction: usize) -> [f64; 2] {
        let Model {
            interactions,
            positions,
            ..
        } = problem.model;
        let Some(pair) = interactions.pair(interaction) else {
            return self.stretches(problem, interaction);
        };
        if problem.model.has_turned_end(interaction) {
            return self.stretches(problem, interaction);
        }
        let [a, b] = pair.map(|node| node as usize);
        let [x, y] = [0, 1].map(|k| positions[b][k] - positions[a][k]);
        let over = 1.0 / (x * x + y * y);
        let stretch = |u: &Solution| {
            let u = &u.displacement;
            over * (x * (u[b][0] - u[a][0]) + y * (u[b][1] - u[a][1]))
        };
        [self.held.as_ref().map_or(0.0, stretch), stretch(&self.unit)]
    }

    /// Larger backward error of the two [-].
    pub fn residual(&self) -> f64 {
        let held = self.held.as_ref().map_or(0.0, |held| held.residual);
        nan_max(held, self.unit.residual)
    }

    pub fn values(&self, problem: &Problem) -> Values {
        let both = [self.held.as_ref(), Some(&self.unit)];
        Values::of(&problem.programme.functionals, both)
    }
}

/// The larger one; not a number if either is not: `f64::max` would pass over a solution that is none.
pub fn nan_max(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// A bound of the largest stretch over its limit of some interactions with any of the responses and under any
/// of the loads: convex in (μ, μ λ), so that it lies at a corner of their box.
pub fn largest_utilisation(
    problem: &Problem,
    integrity: &[f64],
    interactions: impl ParallelIterator<Item = usize>,
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
    let of_stretches = |limits: StretchLimits, [held, unit]: [f64; 2]| {
        let corners = shares
            .iter()
            .flat_map(|a| factors.iter().map(move |b| (a, b)));
        corners
            .map(|(a, b)| limits.utilisation(a * held + b * unit))
            .fold(0.0, nan_max)
    };
    let largest = |interaction: usize| {
        let limits = problem.laws.limits(interaction, integrity[interaction]);
        let stretches = responses.iter();
        stretches
            .map(|u| of_stretches(limits, u.rough_stretches(problem, interaction)))
            .fold(0.0, nan_max)
    };
    interactions.map(largest).reduce(|| 0.0, nan_max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statics::{Backend, SystemSize};

    #[test]
    fn a_solution_that_is_none_is_not_passed_over() {
        let solution = |residual| Solution {
            displacement: Vec::new(),
            reaction: Vec::new(),
            residual,
            size: SystemSize {
                dofs: 0,
                stiffness_entries: 0,
                factor_entries: 0,
                backend: Backend::Multifrontal,
            },
        };
        let of = |held: Option<f64>, unit| {
            let (held, unit) = (held.map(solution), solution(unit));
            Solutions { held, unit }.residual()
        };
        assert_eq!([of(None, 2.0), of(Some(3.0), 2.0)], [2.0, 3.0]);
        for (held, unit) in [
            (None, f64::NAN),
            (Some(f64::NAN), 1.0),
            (Some(1.0), f64::NAN),
        ] {
            assert!(of(held, unit).is_nan());
        }
    }
}
