//! What changes during a run: which bonds are intact, and what their breaking has cost.

use super::control::{Ending, Problem, SEPARATED};
use super::event::Load;
use super::failure::CriticalStretch;
use super::programme::Programme;
use super::response::Response;
use crate::model::Model;
use crate::statics::{StaticsError, SystemSize};
use crate::support;
use std::collections::BTreeSet;

/// The state of damage. Bonds break and never heal.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Load steps, or events, behind us.
    pub step: usize,
    /// The current phase of the programme, and the step behind which it began.
    pub phase: usize,
    pub phase_start: usize,
    pub load: Load,
    /// The largest λ of this phase so far: where a load that only grows would be.
    pub envelope: f64,
    /// u of every node [m] and the reactions there [N], when they were last asked for
    /// ([`State::settle`]).
    pub displacement: Vec<[f64; 2]>,
    pub reaction: Vec<[f64; 2]>,
    /// Relative residual of both, and the size of the system.
    pub residual: f64,
    pub size: Option<SystemSize>,
    pub intact: Vec<bool>,
    /// Nodes of the parts that no support touches any more; they stay where they broke off.
    pub fragments: Vec<Vec<usize>>,
    /// Whether a load pushes a part that the supports do not hold.
    pub load_lost: bool,
    /// Dofs that are held because a chunk hangs on a hinge there.
    pub mechanisms: BTreeSet<usize>,
    /// Where there is no solution any more: how the run ends, and why.
    pub stopped: Option<(Ending, String)>,
    pub energy: Energy,
    pub force: LoadForce,
    /// Bonds and trusses broken since the start, in their order, initial cracks apart.
    pub broken: Vec<u32>,
    /// Q and W of each phase [J].
    pub work: Vec<[f64; 2]>,
    /// Bonds broken since the last solution: index, and elongation n·(u_j − u_i) then [m].
    pub just_broken: Vec<(u32, f64)>,
}

/// Energies since the start [J].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Work of loads and supports, ∫ r·du along straight pieces of the path.
    pub external: f64,
    /// ½ uᵀ K u.
    pub elastic: f64,
    /// What the broken bonds took, Σ ½ k e e' with the elongations before and after the break.
    pub dissipated: f64,
}

/// How the supports that the current phase moves resist it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoadForce {
    /// λ Q, the reaction that goes with λ alone [J].
    pub now: f64,
    /// Its largest amount in this phase [J].
    pub peak: f64,
    /// Q at the phase's start and now [J].
    pub stiffness: [f64; 2],
    /// Whether earlier phases have left loads in place.
    pub is_on_top: bool,
}

impl LoadForce {
    /// Whether next to nothing is left of the reaction. On top of held loads it also passes through
    /// zero while the body is whole, so that there the stiffness must be gone too.
    pub fn is_spent(&self) -> bool {
        let [first, now] = self.stiffness;
        let is_soft = now.abs() < SEPARATED * first.abs();
        self.now.abs() < SEPARATED * self.peak && (is_soft || !self.is_on_top)
    }
}

impl State {
    /// Before the first load, initial cracks open.
    pub fn new(model: &Model, programme: &Programme) -> State {
        let mut state = State {
            step: 0,
            phase: 0,
            phase_start: 0,
            load: Load::full(0.0),
            envelope: 0.0,
            displacement: vec![[0.0; 2]; model.node_count()],
            reaction: vec![[0.0; 2]; model.node_count()],
            residual: 0.0,
            size: None,
            intact: model.intact.clone(),
            fragments: Vec::new(),
            load_lost: false,
            mechanisms: BTreeSet::new(),
            stopped: None,
            energy: Energy::default(),
            force: LoadForce::default(),
            broken: Vec::new(),
            work: vec![[0.0; 2]; programme.phases.len()],
            just_broken: Vec::new(),
        };
        state.find_loose_parts(model, programme);
        state
    }

    fn find_loose_parts(&mut self, model: &Model, programme: &Programme) {
        let loose = support::loose_parts(model, programme.supports(), &self.intact);
        let pushed = |part: &support::LoosePart| {
            let mut loads = programme.loads(self.phase);
            loads.any(|load| part.is_pushed(model, load))
        };
        self.load_lost = loose.iter().any(pushed);
        let fragments = loose.into_iter().filter(|part| !part.touches_support);
        self.fragments = fragments.map(|part| part.nodes).collect();
    }

    /// Goes over to the next phase where this one is at its end and not the last.
    pub fn begin_phase_if_due(&mut self, model: &Model, programme: &Programme) -> bool {
        let is_due =
            programme.ends_at(self.phase, self.load) && !programme.is_over(self.phase, self.load);
        if is_due {
            self.phase += 1;
            self.phase_start = self.step;
            self.load = Load::full(0.0);
            self.envelope = 0.0;
            self.force = LoadForce {
                is_on_top: true,
                ..LoadForce::default()
            };
            self.find_loose_parts(model, programme);
        }
        is_due
    }

    /// Moves along the straight path to `load`.
    pub fn advance(&mut self, problem: &Problem, response: &Response, load: Load) {
        self.account(problem, response, load);
        self.resist(response.values().stiffness(self.phase), load);
        self.load = load;
        self.envelope = self.envelope.max(load.factor);
    }

    /// Finds displacements and reactions everywhere. Fragments stay where they broke off.
    pub fn settle(&mut self, problem: &Problem, response: &Response) {
        let solutions = response.solutions(problem, self.phase);
        let frozen: Vec<usize> = self.fragments.iter().flatten().copied().collect();
        let kept: Vec<[f64; 2]> = frozen.iter().map(|&node| self.displacement[node]).collect();
        let nodes = 0..self.displacement.len();
        (self.displacement, self.reaction) = nodes.map(|n| solutions.at(self.load, n)).unzip();
        for (&node, u) in frozen.iter().zip(kept) {
            self.displacement[node] = u;
        }
        self.residual = response.residual();
        self.size = Some(solutions.unit.size);
    }

    /// Energies. With r = K u, equal to loads and reactions, before and after the break of bonds,
    /// ½ (r + r')·(u' − u) = Δ(½ uᵀ K u) + Σ ½ k e e' holds for any two states. With the factors a_q
    /// of the phases, u is Σ a_q u_q at the supports and r is Σ a_q f_q at the loads: all sums over dofs
    /// are in Q and W.
    fn account(&mut self, problem: &Problem, response: &Response, load: Load) {
        let Problem {
            model, programme, ..
        } = problem;
        let before = programme.factors(self.phase, self.load);
        let now = programme.factors(self.phase, load);
        let mut elastic = 0.0;
        for (phase, (a, b)) in before.zip(now).enumerate() {
            let [q, w] = response.values().work(phase, load);
            let [q_before, w_before] = std::mem::replace(&mut self.work[phase], [q, w]);
            self.energy.external += 0.5 * ((q_before + q) * (b - a) + (a + b) * (w - w_before));
            elastic += 0.5 * b * (q + w);
        }
        self.energy.elastic = elastic;
        for (spring, before) in self.just_broken.drain(..) {
            let spring = spring as usize;
            let length = model.springs.length(spring, &model.positions);
            let after = length * response.stretch(problem, spring, load);
            let stiffness = model.springs.stiffness[spring];
            self.energy.dissipated += 0.5 * stiffness * before * after;
        }
    }

    fn resist(&mut self, stiffness: f64, load: Load) {
        let force = &mut self.force;
        force.now = load.share * load.factor * stiffness;
        force.peak = force.peak.max(force.now.abs());
        if force.stiffness[0] == 0.0 {
            force.stiffness[0] = stiffness;
        }
        force.stiffness[1] = stiffness;
    }

    /// What is left has no solution: the run ends here.
    pub fn stop(&mut self, error: &StaticsError) -> Ending {
        let ending = match error {
            StaticsError::Swings { .. } => Ending::Collapsed,
            _ => Ending::Singular,
        };
        self.stopped = Some((ending, error.to_string()));
        ending
    }

    /// Breaks the given bonds, finds what falls off, and returns how many have broken. Displacements are
    /// those of the `response`, or else the state's own.
    pub fn break_bonds(
        &mut self,
        problem: &Problem,
        response: Option<&Response>,
        bonds: &[usize],
    ) -> usize {
        let Problem {
            model, programme, ..
        } = problem;
        for &spring in bonds {
            let stretch = match response {
                Some(response) => response.stretch(problem, spring, self.load),
                None => self.stretch(model, spring),
            };
            let elongation = model.springs.length(spring, &model.positions) * stretch;
            self.intact[spring] = false;
            self.broken.push(spring as u32);
            self.just_broken.push((spring as u32, elongation));
        }
        // A response that is known already is that of a regular K: everything is held.
        let is_held = response.is_some_and(Response::foresees_next);
        if bonds.is_empty() || is_held {
            return bonds.len();
        }
        let before = self.fragments.clone();
        self.find_loose_parts(model, programme);
        if self.fragments != before
            && let Some(response) = response
        {
            // What comes off stays where it is now.
            let now = std::mem::replace(&mut self.fragments, before);
            self.settle(problem, response);
            self.fragments = now;
        }
        bonds.len()
    }

    /// Stretch of a spring [-].
    pub fn stretch(&self, model: &Model, spring: usize) -> f64 {
        model.stretch(spring, &self.displacement)
    }

    /// The intact spring nearest to its limit, and its stretch over it [-].
    pub fn most_strained(&self, model: &Model, limits: &Limits) -> Option<(usize, f64)> {
        let intact = (0..model.springs.len()).filter(|&s| self.intact[s]);
        let utilised = intact.map(|s| (s, limits.of(s).utilisation(self.stretch(model, s))));
        utilised.max_by(|a, b| a.1.total_cmp(&b.1))
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
    for share in &model.clipped {
        let own = share.point as usize - first;
        whole[own] += share.area;
        if !intact[model.springs.pairs().len() + share.spring as usize] {
            broken[own] += share.area;
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
    pub class: Vec<u32>,
}

impl Limits {
    pub fn of(&self, spring: usize) -> CriticalStretch {
        self.table[self.class[spring] as usize]
    }
}
