//! What changes during a run: which bonds are intact, and what their breaking has cost.

use super::failure::CriticalStretch;
use crate::boundary::Boundary;
use crate::model::Model;
use crate::statics::Solution;
use crate::support;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// The state of damage. Bonds break and never heal.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Load steps, or events, behind us.
    pub step: usize,
    /// λ [-].
    pub load_factor: f64,
    /// u of every node [m].
    pub displacement: Vec<[f64; 2]>,
    pub intact: Vec<bool>,
    /// Nodes of the parts that nothing holds any more; they stay where they broke off.
    pub fragments: Vec<Vec<usize>>,
    /// Dofs that are held because a chunk hangs on a hinge there.
    pub mechanisms: BTreeSet<usize>,
    pub energy: Energy,
    /// The largest conjugate force so far, |Q| [J].
    pub peak_force: f64,
    /// Bonds broken since the last solution: index, and elongation n·(u_j − u_i) then [m].
    pub just_broken: Vec<(u32, f64)>,
}

/// Energies since the start [J].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Work of loads and supports, ∫ Q dλ along straight pieces of the path.
    pub external: f64,
    /// ½ uᵀ K u.
    pub elastic: f64,
    /// What the broken bonds took, Σ ½ k e e' with the elongations before and after the break.
    pub dissipated: f64,
    /// Q at the last point of the path, conjugate to λ [J].
    pub force: f64,
}

impl State {
    /// Before the first load, initial cracks open.
    pub fn new(model: &Model, boundary: &Boundary) -> State {
        State {
            step: 0,
            load_factor: 0.0,
            displacement: vec![[0.0; 2]; model.node_count()],
            intact: model.intact.clone(),
            fragments: support::fragments(model, boundary, &model.intact),
            mechanisms: BTreeSet::new(),
            energy: Energy::default(),
            peak_force: 0.0,
            just_broken: Vec::new(),
        }
    }

    /// Moves along the straight path to `load_factor`, where `unit` is the response to λ = 1.
    pub fn advance(
        &mut self,
        model: &Model,
        boundary: &Boundary,
        unit: &Solution,
        load_factor: f64,
    ) {
        let frozen: Vec<usize> = self.fragments.iter().flatten().copied().collect();
        let kept: Vec<[f64; 2]> = frozen.iter().map(|&node| self.displacement[node]).collect();
        let moved = unit.displacement.iter().map(|u| u.map(|u| load_factor * u));
        self.displacement = moved.collect();
        for (&node, u) in frozen.iter().zip(kept) {
            self.displacement[node] = u;
        }
        self.account(
            model,
            unit.conjugate_force(boundary),
            load_factor,
            &unit.displacement,
        );
        self.load_factor = load_factor;
    }

    fn account(&mut self, model: &Model, stiffness: f64, load_factor: f64, unit: &[[f64; 2]]) {
        let force = stiffness * load_factor;
        let Energy {
            external,
            elastic,
            dissipated,
            force: last,
        } = &mut self.energy;
        *external += 0.5 * (*last + force) * (load_factor - self.load_factor);
        *elastic = 0.5 * force * load_factor;
        for (spring, before) in self.just_broken.drain(..) {
            let spring = spring as usize;
            let length = model.springs.length(spring, &model.positions);
            let after =
                load_factor * length * model.springs.stretch(spring, &model.positions, unit);
            *dissipated += 0.5 * model.bond_share(spring) * model.springs.stiffness[spring] * before * after;
        }
        *last = force;
        self.peak_force = self.peak_force.max(force.abs());
    }

    /// Breaks every intact bond that is over its limit and returns how many.
    pub fn break_exceeded(&mut self, model: &Model, boundary: &Boundary, limits: &Limits) -> usize {
        let over = |&s: &usize| {
            let Model {
                springs, positions, ..
            } = model;
            let stretch = springs.stretch(s, positions, &self.displacement);
            limits.of(s).is_exceeded(stretch)
        };
        let broken: Vec<usize> = (0..model.springs.len())
            .into_par_iter()
            .filter(|&s| self.intact[s])
            .filter(over)
            .collect();
        self.break_bonds(model, boundary, &broken)
    }

    /// Breaks the given bonds, and finds what falls off.
    pub fn break_bonds(&mut self, model: &Model, boundary: &Boundary, bonds: &[usize]) -> usize {
        for &spring in bonds {
            let Model {
                springs, positions, ..
            } = model;
            let length = springs.length(spring, positions);
            let stretch = springs.stretch(spring, positions, &self.displacement);
            self.intact[spring] = false;
            self.just_broken.push((spring as u32, stretch * length));
        }
        if !bonds.is_empty() {
            self.fragments = support::fragments(model, boundary, &self.intact);
        }
        bonds.len()
    }

    /// Bonds and trusses broken since the start, initial cracks apart.
    pub fn broken(&self, model: &Model) -> usize {
        let pairs = model.intact.iter().zip(&self.intact);
        pairs.filter(|&(&before, &now)| before && !now).count()
    }
}

/// φ_i = 1 − Σ μ_ij A_j / Σ A_j over the family, Qian et al. (2021), eq. (7) [-], by material
/// point.
pub fn damage(model: &Model, intact: &[bool]) -> Vec<f64> {
    let first = model.fe_node_count();
    let mut broken = vec![0.0; model.areas.len()];
    let mut whole = vec![0.0; model.areas.len()];
    for (bond, &[i, j]) in model.springs.pairs()[..model.bond_count].iter().enumerate() {
        let ends = [i, j].map(|node| node as usize - first);
        let xi = model.springs.length(bond, &model.positions);
        let fraction = model.area_fraction(i as usize, xi);
        for (own, other) in [(ends[0], ends[1]), (ends[1], ends[0])] {
            let area = model.areas[other] * fraction;
            whole[own] += area;
            if !intact[bond] {
                broken[own] += area;
            }
        }
    }
    let ghosts = model.splice.iter().flat_map(|splice| &splice.ghosts);
    for (bond, ghost) in (model.springs.pairs().len()..).zip(ghosts) {
        let xi = model.springs.length(bond, &model.positions);
        let area = model.ghost_area(ghost) * model.area_fraction(ghost.point as usize, xi);
        let own = ghost.point as usize - first;
        whole[own] += area;
        if !intact[bond] {
            broken[own] += area;
        }
    }
    broken
        .iter()
        .zip(whole)
        .map(|(b, w)| if w > 0.0 { b / w } else { 0.0 })
        .collect()
}

/// The critical stretch of every spring.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// The different ones.
    pub table: Vec<CriticalStretch>,
    /// Which one each spring has.
    pub class: Vec<u8>,
}

impl Limits {
    pub fn of(&self, spring: usize) -> CriticalStretch {
        self.table[self.class[spring] as usize]
    }
}
