//! The dofs around the tips, the springs between them, and their compliance while springs go.

use super::event::Bounds;
use super::functional::Values;
use super::laws::StretchLimits;
use super::lost::Loss;
use super::problem::Problem;
use super::solutions::Solutions;
use crate::linear_solver::columns::{add, slice, slice_mut};
use crate::model::Model;
use crate::statics::Solution;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, Par};
use rayon::prelude::*;

/// A node with a larger share of its springs across the edge of the zone is at its rim.
const RIM_SHARE: f64 = 0.4;

/// Below this d the bond was about the last to hold something: what is left is a mechanism, or too close
/// to one for the update.
const LEAST_DENOMINATOR: f64 = 1e-7;

/// Springs that one thread surveys at a time.
const CHUNK: usize = 1024;

/// Updates of A that wait to be applied together.
const PENDING: usize = 48;

/// Some nodes, and the springs between them.
pub struct Zone {
    /// Dofs of the nodes, ascending.
    pub dofs: Vec<usize>,
    /// Ascending, and where the terms of each begin.
    pub springs: Vec<usize>,
    start: Vec<usize>,
    /// The springs' w by place in `dofs` [-].
    terms: Vec<(u32, f64)>,
    /// One over their lengths [1/m].
    over_length: Vec<f64>,
    /// Places of those of which one node has many intact springs to nodes outside.
    pub at_rim: Vec<usize>,
    /// Springs outside with a node in the zone, or next to one that has, ascending.
    pub ring: Vec<usize>,
    /// Their nodes, ascending.
    pub ring_nodes: Vec<u32>,
}

/// How a node stands to the zone.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Inside(u32),
    Rim(u32),
    /// A spring joins it to a node of the zone.
    Next,
    Outside,
}

/// Whether a node is at the rim: the more of its springs leave the zone, the closer are those that it does
/// not see.
fn is_rim(inside: usize, across: usize) -> bool {
    across as f64 > RIM_SHARE * (inside + across) as f64
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
            springs: Vec::new(),
            start: vec![0],
            terms: Vec::new(),
            over_length: Vec::new(),
            at_rim: Vec::new(),
            ring: Vec::new(),
            ring_nodes: Vec::new(),
        };
        // Unbreakable ones need no watching.
        let breaks = |s: usize| problem.laws.limits(s, integrity[s]) != StretchLimits::NONE;
        let touching = |test: &(dyn Fn(&u32) -> bool + Sync)| -> Vec<usize> {
            let all = (0..model.springs.len()).into_par_iter();
            all.filter(|&s| {
                integrity[s] > 0.0 && breaks(s) && model.springs.nodes(s).iter().any(test)
            })
            .collect()
        };
        let is_in = |&node: &u32| places[node as usize] != Place::Outside;
        let (inside, across): (Vec<usize>, Vec<usize>) =
            (touching(&is_in).into_iter()).partition(|&s| model.springs.nodes(s).iter().all(is_in));
        // How many springs of a node stay in the zone, and how many do not.
        let mut counts = vec![[0usize; 2]; model.node_count()];
        for (list, which) in [(&inside, 0), (&across, 1)] {
            for &node in list.iter().flat_map(|&s| model.springs.nodes(s)) {
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
        inside.iter().for_each(|&s| zone.add(problem, &places, s));
        zone.ring = touching(&|&node| places[node as usize] == Place::Next);
        let nodes = zone.ring.iter().flat_map(|&s| model.springs.nodes(s));
        zone.ring_nodes = nodes.copied().collect();
        zone.ring_nodes.sort_unstable();
        zone.ring_nodes.dedup();
        zone
    }

    fn add(&mut self, problem: &Problem, places: &[Place], spring: usize) {
        let Model {
            springs, positions, ..
        } = problem.model;
        let mut is_at_rim = false;
        problem.model.for_each_term(spring, |node, [x, y]| {
            if let Place::Inside(dof) | Place::Rim(dof) = places[node as usize] {
                self.terms.extend([(dof, x), (dof + 1, y)]);
            }
            is_at_rim |= matches!(places[node as usize], Place::Rim(_));
        });
        if is_at_rim {
            self.at_rim.push(self.springs.len());
        }
        self.springs.push(spring);
        self.start.push(self.terms.len());
        (self.over_length).push(springs.length(spring, positions).recip());
    }

    /// Where a spring stands in the zone.
    pub fn place(&self, spring: usize) -> Option<usize> {
        self.springs.binary_search(&spring).ok()
    }

    fn terms(&self, place: usize) -> &[(u32, f64)] {
        &self.terms[self.start[place]..self.start[place + 1]]
    }

    /// w·u [m].
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

    /// Stretches of every spring, nothing for those that have gone, and what they allow; λ is `last` now.
    pub fn survey(&self, front: &Front, last: f64, stretches: &mut Vec<[f64; 2]>) -> Bounds {
        stretches.resize(self.springs.len(), [0.0; 2]);
        let chunks = stretches.par_chunks_mut(CHUNK).enumerate();
        let bounds = chunks.map(|(chunk, stretches)| {
            let mut bounds = Bounds::NONE;
            for (k, stretch) in (chunk * CHUNK..).zip(stretches) {
                *stretch = match front.integrity[k] > 0.0 {
                    true => self.stretches(k, &front.displacement),
                    false => [0.0; 2],
                };
                bounds = bounds.and(Bounds::of(*stretch, front.limits[k], last));
            }
            bounds
        });
        bounds.reduce(|| Bounds::NONE, Bounds::and)
    }

    /// The forces that lost stiffness had, Σ (φ − φ') k (w·u) w, dof by dof of the zone [N].
    pub fn forces(&self, losses: &[Loss], u: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0; self.dofs.len()];
        for loss in losses {
            let place = self.place(loss.interaction).expect("a spring of the zone");
            let force = loss.stiffness * self.elongation(place, u);
            for &(dof, w) in self.terms(place) {
                forces[dof as usize] += force * w;
            }
        }
        forces
    }
}

/// The response on the zone while springs go.
pub struct Front {
    /// A as it was before the updates that wait [m/N].
    compliance: Mat<f64>,
    /// √(k/d) a of the updates that wait, and how many do.
    pending: Mat<f64>,
    waiting: usize,
    /// u_held, empty where nothing is held, and u_unit [m].
    pub displacement: [Vec<f64>; 2],
    /// v of the functionals.
    fields: Vec<Vec<f64>>,
    pub values: Values,
    /// Integrity φ of the zone's springs [-], and the limits of their branches.
    pub integrity: Vec<f64>,
    pub limits: Vec<StretchLimits>,
}

impl Front {
    pub fn new(
        problem: &Problem,
        integrity: &[f64],
        zone: &Zone,
        compliance: Mat<f64>,
        solutions: &Solutions,
        fields: Vec<Vec<f64>>,
        values: Values,
    ) -> Front {
        let on_zone = |u: &Solution| -> Vec<f64> {
            let dofs = zone.dofs.iter();
            dofs.map(|&d| u.displacement[d / 2][d % 2]).collect()
        };
        Front {
            compliance,
            pending: Mat::zeros(zone.dofs.len(), PENDING),
            waiting: 0,
            displacement: [
                solutions.held.as_ref().map(on_zone).unwrap_or_default(),
                on_zone(&solutions.unit),
            ],
            fields,
            values,
            integrity: zone.springs.iter().map(|&s| integrity[s]).collect(),
            limits: (zone.springs.iter())
                .map(|&s| problem.laws.limits(s, integrity[s]))
                .collect(),
        }
    }

    /// Gives a spring of the zone another integrity, and returns the stiffness that it loses; `None` where
    /// not all is held any more.
    pub fn change(
        &mut self,
        problem: &Problem,
        zone: &Zone,
        place: usize,
        integrity: f64,
    ) -> Option<Loss> {
        let (w, spring) = (zone.terms(place), zone.springs[place]);
        let k = (self.integrity[place] - integrity) * problem.model.springs.stiffness[spring];
        self.integrity[place] = integrity;
        self.limits[place] = problem.laws.limits(spring, integrity);
        let a = self.column(w);
        let d = 1.0 - k * dot(w, &a);
        // False for what is not a number.
        let is_held = d > LEAST_DENOMINATOR;
        if !is_held {
            return None;
        }
        let force = |u: &Vec<f64>| if u.is_empty() { 0.0 } else { k * dot(w, u) / d };
        let forces = [force(&self.displacement[0]), force(&self.displacement[1])];
        for (value, v) in self.values.0.iter_mut().zip(&mut self.fields) {
            let along = dot(w, v);
            value[0] += forces[0] * along;
            value[1] += forces[1] * along;
            add(v, k * along / d, &a);
        }
        for (u, force) in self.displacement.iter_mut().zip(forces) {
            add(u, force, &a);
        }
        let scale = (k / d).sqrt();
        let pending = slice_mut(self.pending.col_mut(self.waiting));
        pending.iter_mut().zip(&a).for_each(|(p, a)| *p = scale * a);
        self.waiting += 1;
        if self.waiting == PENDING {
            self.flush();
        }
        Some(Loss {
            interaction: spring,
            stiffness: k,
        })
    }

    /// A w.
    fn column(&self, w: &[(u32, f64)]) -> Vec<f64> {
        let mut a = vec![0.0; self.compliance.nrows()];
        for &(dof, w) in w {
            add(&mut a, w, slice(self.compliance.col(dof as usize)));
        }
        let pending = self.pending.subcols(0, self.waiting);
        let along = Mat::from_fn(self.waiting, 1, |j, _| dot(w, slice(pending.col(j))));
        let rows = a.len();
        let sum = MatMut::from_column_major_slice_mut(&mut a, rows, 1);
        matmul(sum, Accum::Add, pending, &along, 1.0, Par::Seq);
        a
    }

    /// Applies the updates that wait, block by block of A's columns.
    fn flush(&mut self) {
        let p = self.pending.as_ref();
        self.compliance
            .par_col_chunks_mut(128)
            .enumerate()
            .for_each(|(k, block)| {
                let rows = p.subrows(128 * k, block.ncols());
                matmul(block, Accum::Add, p, rows.transpose(), 1.0, Par::Seq);
            });
        self.waiting = 0;
    }
}

/// w·u.
fn dot(w: &[(u32, f64)], u: &[f64]) -> f64 {
    w.iter().map(|&(dof, w)| w * u[dof as usize]).sum()
}
