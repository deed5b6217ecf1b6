//! The dofs around the tips, the springs between them, and their compliance while springs go.

use super::control::Problem;
use super::event::Load;
use super::failure::CriticalStretch;
use super::functional::{Values, fields};
use super::response::Solutions;
use super::state::State;
use crate::model::Model;
use crate::statics::{Factorised, Solution};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::*;

/// Nodes of a zone. A wider one lasts longer and costs more: 400 were better than 250 and 600 at 10 000
/// dofs, and than 900 at 31 000 (docs/performance.md).
const NODES: usize = 400;

/// Below this d the bond was about the last to hold something: what is left is a mechanism, or too close
/// to one for the update.
const LEAST_DENOMINATOR: f64 = 1e-7;

/// Updates of A that wait to be applied together.
const PENDING: usize = 48;

/// The nodes with the most strained bonds, and the springs between them.
pub struct Zone {
    /// Dofs of the nodes.
    dofs: Vec<usize>,
    /// Ascending, and where the terms of each begin.
    springs: Vec<usize>,
    start: Vec<usize>,
    /// The springs' w by place in `dofs` [-].
    terms: Vec<(u32, f64)>,
    lengths: Vec<f64>,
    limits: Vec<CriticalStretch>,
    stiffness: Vec<f64>,
}

impl Zone {
    /// `load` breaks the next bond.
    pub fn new(problem: &Problem, state: &State, base: &Solutions, load: Load) -> Zone {
        let model = problem.model;
        let nodes = most_strained_nodes(problem, state, base, load);
        let mut local = vec![u32::MAX; model.node_count()];
        for (k, &node) in nodes.iter().enumerate() {
            local[node] = 2 * k as u32;
        }
        let mut zone = Zone {
            dofs: nodes.iter().flat_map(|&n| [2 * n, 2 * n + 1]).collect(),
            springs: Vec::new(),
            start: vec![0],
            terms: Vec::new(),
            lengths: Vec::new(),
            limits: Vec::new(),
            stiffness: Vec::new(),
        };
        for spring in (0..model.springs.len()).filter(|&s| state.intact[s]) {
            let nodes = model.springs.nodes(spring);
            if nodes.iter().all(|&node| local[node as usize] != u32::MAX) {
                zone.add(problem, &local, spring);
            }
        }
        zone
    }

    fn add(&mut self, problem: &Problem, local: &[u32], spring: usize) {
        let Model {
            springs, positions, ..
        } = problem.model;
        self.springs.push(spring);
        springs.for_each_term(spring, positions, |node, [x, y]| {
            let dof = local[node as usize];
            self.terms.extend([(dof, x), (dof + 1, y)]);
        });
        self.start.push(self.terms.len());
        self.lengths.push(springs.length(spring, positions));
        self.limits.push(problem.limits.of(spring));
        self.stiffness.push(springs.stiffness[spring]);
    }

    /// Intact springs that the zone does not see.
    pub fn outside(&self, intact: &[bool]) -> Vec<usize> {
        let mut seen = self.springs.iter().peekable();
        let is_outside = |&spring: &usize| seen.next_if_eq(&&spring).is_none();
        let all = (0..intact.len()).filter(|&s| intact[s]);
        all.filter(is_outside).collect()
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
            false => self.elongation(place, u) / self.lengths[place],
        })
    }

    /// Combines `f` of the stretches and the limit of every spring that is still there.
    pub fn fold<T>(
        &self,
        front: &Front,
        start: T,
        f: impl Fn([f64; 2], CriticalStretch) -> T,
        combine: impl Fn(T, T) -> T,
    ) -> T {
        let there = (0..self.springs.len()).filter(|&k| front.intact[k]);
        let each = there.map(|k| f(self.stretches(k, &front.displacement), self.limits[k]));
        each.fold(start, combine)
    }

    /// The springs still there of which `f` is true, ascending.
    pub fn filter(
        &self,
        front: &Front,
        f: impl Fn([f64; 2], CriticalStretch) -> bool,
    ) -> Vec<usize> {
        let there = (0..self.springs.len()).filter(|&k| front.intact[k]);
        let found = there.filter(|&k| f(self.stretches(k, &front.displacement), self.limits[k]));
        found.map(|k| self.springs[k]).collect()
    }
}

/// The nodes whose bonds are nearest to their limits, ascending.
fn most_strained_nodes(
    problem: &Problem,
    state: &State,
    base: &Solutions,
    load: Load,
) -> Vec<usize> {
    let model = problem.model;
    let utilisation: Vec<f64> = (0..model.springs.len())
        .into_par_iter()
        .map(|s| match state.intact[s] {
            true => problem
                .limits
                .of(s)
                .utilisation(load.combine(base.rough_stretches(problem, s))),
            false => 0.0,
        })
        .collect();
    let mut score = vec![0.0f64; model.node_count()];
    for (spring, &utilisation) in utilisation.iter().enumerate() {
        for &node in model.springs.nodes(spring) {
            score[node as usize] = score[node as usize].max(utilisation);
        }
    }
    let mut nodes: Vec<usize> = (0..model.node_count()).collect();
    let count = NODES.min(nodes.len());
    let by_score = |a: &usize, b: &usize| score[*b].total_cmp(&score[*a]).then(a.cmp(b));
    if count < nodes.len() {
        nodes.select_nth_unstable_by(count, by_score);
        nodes.truncate(count);
    }
    nodes.sort_unstable();
    nodes
}

/// The response on the zone while springs go.
pub struct Front {
    /// A as it was before the updates that wait [m/N].
    compliance: Mat<f64>,
    /// √(k/d) a of the updates that wait, one after the other.
    pending: Vec<f64>,
    /// u_held, empty where nothing is held, and u_unit [m].
    pub displacement: [Vec<f64>; 2],
    /// v of the functionals.
    fields: Vec<Vec<f64>>,
    pub values: Values,
    intact: Vec<bool>,
}

impl Front {
    pub fn new(
        problem: &Problem,
        state: &State,
        factorised: &Factorised,
        zone: &Zone,
        base: &Solutions,
        values: &Values,
    ) -> Option<Front> {
        let dofs = &zone.dofs;
        let on_zone = |u: &Solution| -> Vec<f64> {
            dofs.iter().map(|&d| u.displacement[d / 2][d % 2]).collect()
        };
        let functionals = &problem.programme.functionals;
        let all = fields(functionals, factorised, 2 * state.displacement.len());
        Some(Front {
            compliance: factorised.compliance(dofs)?,
            pending: Vec::new(),
            displacement: [
                base.held.as_ref().map(on_zone).unwrap_or_default(),
                on_zone(&base.unit),
            ],
            fields: (all.iter())
                .map(|v| dofs.iter().map(|&d| v[d]).collect())
                .collect(),
            values: values.clone(),
            intact: vec![true; zone.springs.len()],
        })
    }

    /// Takes a spring away; whether all is still held.
    pub fn release(&mut self, zone: &Zone, spring: usize) -> bool {
        let place = zone.place(spring).expect("a spring of the zone");
        let (w, k) = (zone.terms(place), zone.stiffness[place]);
        self.intact[place] = false;
        let mut a = self.column(w);
        let d = 1.0 - k * dot(w, &a);
        // False for what is not a number.
        let is_held = d > LEAST_DENOMINATOR;
        if !is_held {
            return false;
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
        a.iter_mut().for_each(|a| *a *= scale);
        self.pending.extend(a);
        if self.pending.len() == PENDING * zone.dofs.len() {
            self.flush();
        }
        true
    }

    /// A w.
    fn column(&self, w: &[(u32, f64)]) -> Vec<f64> {
        let n = self.compliance.nrows();
        let mut a = vec![0.0; n];
        for &(dof, w) in w {
            let column = self.compliance.col(dof as usize);
            let column = column
                .try_as_col_major()
                .expect("stored by columns")
                .as_slice();
            add(&mut a, w, column);
        }
        for p in self.pending.chunks_exact(n) {
            add(&mut a, dot(w, p), p);
        }
        a
    }

    /// Applies the updates that wait, block by block of A's columns.
    fn flush(&mut self) {
        let n = self.compliance.nrows();
        let count = self.pending.len() / n;
        let p = MatRef::from_column_major_slice(&self.pending, n, count);
        self.compliance
            .par_col_chunks_mut(128)
            .enumerate()
            .for_each(|(k, block)| {
                let rows = p.subrows(128 * k, block.ncols());
                matmul(block, Accum::Add, p, rows.transpose(), 1.0, Par::Seq);
            });
        self.pending.clear();
    }
}

/// w·u.
fn dot(w: &[(u32, f64)], u: &[f64]) -> f64 {
    w.iter().map(|&(dof, w)| w * u[dof as usize]).sum()
}

/// u += scale · a.
fn add(u: &mut [f64], scale: f64, a: &[f64]) {
    u.iter_mut().zip(a).for_each(|(u, a)| *u += scale * a);
}
