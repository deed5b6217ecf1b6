//! Linear functionals of the displacement that a run needs of every state besides the stretches.
//!
//! With r = K u − f at the prescribed dofs,
//!
//! ```text
//! Q = g·r   (a resultant of reactions),   W = g·u   (the displacement that a load works along)
//! ```
//!
//! When an interaction with the elongation e = w·u loses the stiffness k, K' = K − k w wᵀ, both change by
//! k (w·u') (w·v): for W, v is the response to the forces g; for Q, the response to the prescribed
//! displacements −g (Betti).

use super::event::Load;
use crate::boundary::Boundary;
use crate::model::node_axes::direction;
use crate::statics::{Factorised, Solution};
use std::collections::BTreeMap;

/// One of them.
#[derive(Clone, Debug)]
pub struct Functional {
    /// Whether it is a functional of the reactions; else it is one of the displacements.
    of_reactions: bool,
    /// g, dof by dof, ascending.
    weights: Vec<(usize, f64)>,
}

impl Functional {
    /// The displacement g·u; `weights`: g, dof by dof, ascending.
    pub fn of_displacement(weights: Vec<(usize, f64)>) -> Functional {
        Functional {
            of_reactions: false,
            weights,
        }
    }

    pub fn value(&self, solution: &Solution) -> f64 {
        let field = match self.of_reactions {
            true => &solution.reaction,
            false => &solution.displacement,
        };
        let terms = self.weights.iter();
        terms
            .map(|&(dof, g)| g * field[dof / 2][dof % 2])
            .sum::<f64>()
    }

    /// Adds what becomes v by [`Factorised::respond`] and [`Functional::complete`].
    fn prepare(&self, factorised: &Factorised, forces: &mut [f64]) {
        for &(dof, g) in &self.weights {
            forces[dof] = g;
        }
        if self.of_reactions {
            let moved = factorised.force(forces);
            forces.copy_from_slice(&moved);
        }
    }

    fn complete(&self, v: &mut [f64]) {
        if self.of_reactions {
            self.weights.iter().for_each(|&(dof, g)| v[dof] -= g);
        }
    }
}

/// v of every functional, dof by dof.
pub fn fields(list: &[Functional], factorised: &Factorised, dofs: usize) -> Vec<Vec<f64>> {
    let mut all = vec![0.0; dofs * list.len()];
    let each = || list.iter();
    for (functional, forces) in each().zip(all.chunks_exact_mut(dofs)) {
        functional.prepare(factorised, forces);
    }
    factorised.respond(&mut all);
    for (functional, v) in each().zip(all.chunks_exact_mut(dofs)) {
        functional.complete(v);
    }
    all.chunks_exact(dofs).map(<[f64]>::to_vec).collect()
}

/// The functionals of the phases with these boundaries: for every phase Q and W with its prescribed
/// displacements and its loads as g, then the two resultants on every group that prescribes displacements.
pub(super) fn of_phases(boundaries: &[&Boundary]) -> Vec<Functional> {
    let supports = boundaries[0];
    let mut list = Vec::new();
    for boundary in boundaries {
        let prescribed = boundary.prescribed.iter();
        let loads = boundary.own_load().into_iter().enumerate();
        list.push(Functional {
            of_reactions: true,
            weights: nonzero(prescribed.map(|(&dof, (value, _))| (dof, *value))),
        });
        list.push(Functional {
            of_reactions: false,
            weights: nonzero(loads),
        });
    }
    let mut groups: BTreeMap<&str, [Vec<(usize, f64)>; 2]> = BTreeMap::new();
    for (&dof, (_, group)) in &supports.prescribed {
        let direction = direction(&supports.node_axes, dof);
        let lists = groups.entry(group).or_default();
        for (list, g) in lists.iter_mut().zip(direction) {
            if g != 0.0 {
                list.push((dof, g));
            }
        }
    }
    let resultants = groups.into_values().flatten();
    list.extend(resultants.map(|weights| Functional {
        of_reactions: true,
        weights,
    }));
    list
}

fn nonzero(weights: impl Iterator<Item = (usize, f64)>) -> Vec<(usize, f64)> {
    weights.filter(|&(_, g)| g != 0.0).collect()
}

/// The functionals of a programme at one moment, under what is held and per unit of λ.
#[derive(Clone, Debug, Default)]
pub struct Values(pub Vec<[f64; 2]>);

impl Values {
    pub fn of(list: &[Functional], [held, unit]: [Option<&Solution>; 2]) -> Values {
        let value = |f: &Functional| [held, unit].map(|u| u.map_or(0.0, |u| f.value(u)));
        Values(list.iter().map(value).collect())
    }

    /// Q [J] and W [J] of a phase.
    pub fn work(&self, phase: usize, load: Load) -> [f64; 2] {
        [0, 1].map(|k| load.combine(self.0[2 * phase + k]))
    }

    /// Q of a phase per unit of λ [J].
    pub fn stiffness(&self, phase: usize) -> f64 {
        self.0[2 * phase][1]
    }

    /// The resultant on each group that prescribes displacements, in alphabetical order [N]. `phases` and `probes`:
    /// the numbers of both.
    pub fn resultants(&self, [phases, probes]: [usize; 2], load: Load) -> Vec<[f64; 2]> {
        let groups = self.0[2 * phases..self.0.len() - probes].chunks_exact(2);
        groups
            .map(|axes| [0, 1].map(|k| load.combine(axes[k])))
            .collect()
    }

    /// The displacement that a probe reads per unit of λ [m]; `count`: number of the probes.
    pub fn per_load_factor(&self, count: usize, probe: usize) -> f64 {
        self.0[self.0.len() - count + probe][1]
    }

    /// The displacement that each of the probes reads [m]; `count`: their number.
    pub fn probes(&self, count: usize, load: Load) -> Vec<f64> {
        let probes = &self.0[self.0.len() - count..];
        probes.iter().map(|&value| load.combine(value)).collect()
    }
}
