//! A zone: nodes around the tips, and the interactions between them.

use super::laws::StretchLimits;
use super::low_rank::Loss;
use super::policy::RIM_SHARE;
use super::problem::Problem;
use crate::model::Model;
use rayon::prelude::*;

/// Some nodes, and the interactions between them that may change: bonds with all of the cells that go with them, and
/// these cells.
pub struct Zone {
    /// Dofs of the nodes, ascending.
    pub dofs: Vec<usize>,
    /// Numbers of the interactions, ascending, and where the terms of each begin.
    pub interactions: Vec<usize>,
    start: Vec<usize>,
    /// w of the interactions, by place in `dofs` [-].
    terms: Vec<(u32, f64)>,
    /// One over the lengths of the interactions [1/m].
    over_length: Vec<f64>,
    /// Places of the interactions at the rim: a node of theirs has many interactions with nodes outside.
    pub at_rim: Vec<usize>,
    /// Interactions outside with a node in the zone, or in a neighbour of one, ascending.
    pub ring: Vec<usize>,
    /// Nodes of the ring, ascending.
    pub ring_nodes: Vec<u32>,
}

/// How a node stands to the zone.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Inside(u32),
    Rim(u32),
    /// An interaction joins it to a node of the zone.
    Next,
    Outside,
}

/// Whether a node is at the rim: the more of its interactions leave the zone, the closer are those that the
/// zone does not follow.
fn is_rim(inside: usize, across: usize) -> bool {
    across as f64 > RIM_SHARE * (inside + across) as f64
}

/// The nodes of an interaction and of the cells that go with it.
fn reach(model: &Model, interaction: usize) -> impl Iterator<Item = &u32> {
    let cells = model.companions.of(interaction).iter();
    let of_cells = cells.flat_map(|&cell| model.interactions.nodes(cell as usize));
    model.interactions.nodes(interaction).iter().chain(of_cells)
}

impl Zone {
    pub fn new(problem: &Problem, integrity: &[f64], nodes: &[usize]) -> Zone {
        let model = problem.model;
        let mut places = vec![Place::Outside; model.node_count()];
        for (k, &node) in nodes.iter().enumerate() {
            places[node] = Place::Inside(2 * k as u32);
        }
        let mut zone = Zone {
            dofs: nodes.iter().flat_map(|&n| [2 * n, 2 * n + 1]).collect(),
            interactions: Vec::new(),
            start: vec![0],
            terms: Vec::new(),
            over_length: Vec::new(),
            at_rim: Vec::new(),
            ring: Vec::new(),
            ring_nodes: Vec::new(),
        };
        // Those that never change need no watching.
        let breaks = |s: usize| problem.laws.limits(s, integrity[s]) != StretchLimits::NONE;
        let touching = |test: &(dyn Fn(&u32) -> bool + Sync)| -> Vec<usize> {
            let all = model.interactions.axial().into_par_iter();
            all.filter(|&s| integrity[s] > 0.0 && breaks(s) && reach(model, s).any(test))
                .collect()
        };
        let is_in = |&node: &u32| places[node as usize] != Place::Outside;
        let (inside, across): (Vec<usize>, Vec<usize>) =
            (touching(&is_in).into_iter()).partition(|&s| reach(model, s).all(is_in));
        // How many interactions of a node stay in the zone, and how many do not.
        let mut counts = vec![[0usize; 2]; model.node_count()];
        for (list, which) in [(&inside, 0), (&across, 1)] {
            for &node in list.iter().flat_map(|&s| reach(model, s)) {
                counts[node as usize][which] += 1;
            }
        }
        for (place, [own, others]) in places.iter_mut().zip(counts) {
            *place = match *place {
                Place::Outside if others > 0 => Place::Next,
                Place::Inside(k) if is_rim(own, others) => Place::Rim(k),
                place => place,
            };
        }
        let cells = model.cells_with(&inside, |cell| integrity[cell] > 0.0);
        let inside = inside.iter().chain(&cells);
        inside.for_each(|&s| zone.add(problem, &places, s));
        zone.ring = touching(&|&node| places[node as usize] == Place::Next);
        let nodes = zone.ring.iter().flat_map(|&s| model.interactions.nodes(s));
        zone.ring_nodes = nodes.copied().collect();
        zone.ring_nodes.sort_unstable();
        zone.ring_nodes.dedup();
        zone
    }

    fn add(&mut self, problem: &Problem, places: &[Place], interaction: usize) {
        let Model {
            interactions,
            positions,
            ..
        } = problem.model;
        let mut is_at_rim = false;
        problem.model.for_each_term(interaction, |node, [x, y]| {
            if let Place::Inside(dof) | Place::Rim(dof) = places[node as usize] {
                self.terms.extend([(dof, x), (dof + 1, y)]);
            }
            is_at_rim |= matches!(places[node as usize], Place::Rim(_));
        });
        if is_at_rim {
            self.at_rim.push(self.interactions.len());
        }
        self.interactions.push(interaction);
        self.start.push(self.terms.len());
        (self.over_length).push(interactions.length(interaction, positions).recip());
    }

    /// Place of an interaction in the zone.
    pub fn place(&self, interaction: usize) -> Option<usize> {
        self.interactions.binary_search(&interaction).ok()
    }

    /// w of an interaction, by place in `dofs` [-].
    pub fn terms(&self, place: usize) -> &[(u32, f64)] {
        &self.terms[self.start[place]..self.start[place + 1]]
    }

    /// Elongation w·u [m].
    pub fn elongation(&self, place: usize, u: &[f64]) -> f64 {
        let terms = self.terms(place).iter();
        terms.map(|&(dof, w)| w * u[dof as usize]).sum()
    }

    /// Stretches under what is held and per unit of λ.
    pub fn stretches(&self, place: usize, u: &[Vec<f64>; 2]) -> [f64; 2] {
        [&u[0], &u[1]].map(|u| match u.is_empty() {
            true => 0.0,
            false => self.elongation(place, u) * self.over_length[place],
        })
    }

    /// Forces that lost stiffness had, Σ (φ − φ') k (w·u) w, dof by dof of the zone [N].
    pub fn forces(&self, losses: &[Loss], u: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0; self.dofs.len()];
        for loss in losses {
            let place = self
                .place(loss.interaction)
                .expect("an interaction of the zone");
            let force = loss.stiffness * self.elongation(place, u);
            for &(dof, w) in self.terms(place) {
                forces[dof as usize] += force * w;
            }
        }
        forces
    }
}
