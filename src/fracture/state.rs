//! The state of a run: the integrity of the interactions, and the energy that its changes have taken.

use super::bond_laws::BondLaws;
use super::ending::Ending;
use super::event::Load;
use super::load_course::LoadCourse;
use super::policy::SEPARATED;
use super::programme::Programme;
use crate::model::Model;
use crate::statics::{StaticsError, SystemSize};
use crate::support;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::sync::Arc;

/// The state of a run.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct State {
    /// Number of load steps, or events, so far.
    pub step: usize,
    /// Number of the current phase of the programme, and the step after which it began.
    pub phase: usize,
    pub phase_start: usize,
    pub load: Load,
    /// The largest λ of this phase so far: where a load that only grows would be.
    pub envelope: f64,
    /// Displacement [m] and reaction [N] of every node when the state was last settled
    /// ([`State::settled`]).
    pub displacement: Vec<[f64; 2]>,
    pub reaction: Vec<[f64; 2]>,
    /// Backward error of both [-], and the size of the system.
    pub residual: f64,
    pub size: Option<SystemSize>,
    /// Integrity φ of every interaction [-]. Copies of the state share it until it changes. It is not kept on the
    /// disk, since it follows from the changes ([`State::restore_integrity`]).
    #[serde(skip)]
    pub integrity: Arc<Vec<f64>>,
    /// How many interactions come before the cells.
    #[serde(skip)]
    pub(super) axial: usize,
    /// Nodes of the parts that no support touches any more; they stay where they broke off.
    pub fragments: Vec<Vec<usize>>,
    /// Whether a load pushes a part that the supports do not hold.
    pub load_lost: bool,
    /// Dofs that are held because a chunk hangs on a hinge there.
    pub mechanisms: BTreeSet<usize>,
    /// Ending and reason, if there is no solution any more.
    pub stopped: Option<(Ending, String)>,
    pub energy: Energy,
    pub force: LoadForce,
    pub course: LoadCourse,
    /// Q and W of each phase [J].
    pub work: Vec<[f64; 2]>,
    /// Every change of integrity since the start, in their order; initial cracks are none.
    pub changes: Vec<Change>,
    /// Number of the last of these that no response takes into account yet.
    pub fresh: usize,
}

/// A change of integrity, at the state of equilibrium before it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct Change {
    pub interaction: u32,
    /// Integrity φ before and after [-].
    pub integrity: [f64; 2],
    /// Elongation e = w·u before [m].
    pub elongation: f64,
}

impl Change {
    pub fn is_break(&self) -> bool {
        self.integrity[1] == 0.0
    }
}

/// Energies since the start [J].
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Energy {
    /// Work of loads and supports, ∫ r·du along straight pieces of the path.
    pub external: f64,
    /// ½ uᵀ K u.
    pub elastic: f64,
    /// Energy that changes of integrity took, Σ ½ (φ − φ') k e e' with the elongations before and after.
    pub dissipated: f64,
}

/// How the supports that the current phase moves resist it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
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
    /// zero while the body is whole, so that the stiffness must be lost too.
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
            integrity: Arc::new(model.integrity.clone()),
            axial: model.interactions.axial().len(),
            fragments: Vec::new(),
            load_lost: false,
            mechanisms: BTreeSet::new(),
            stopped: None,
            energy: Energy::default(),
            force: LoadForce::default(),
            course: LoadCourse::default(),
            work: vec![[0.0; 2]; programme.phases.len()],
            changes: Vec::new(),
            fresh: 0,
        };
        state.find_loose_parts(model, programme);
        state
    }

    /// Sets the integrity that the changes have left of the model's.
    pub fn restore_integrity(&mut self, model: &Model) {
        self.integrity = Arc::new(model.integrity.clone());
        self.axial = model.interactions.axial().len();
        for change in &self.changes {
            let all = Arc::make_mut(&mut self.integrity);
            all[change.interaction as usize] = change.integrity[1];
        }
    }

    /// Finds the parts that the supports do not hold any more.
    pub(super) fn find_loose_parts(&mut self, model: &Model, programme: &Programme) {
        let loose = support::loose_parts(model, programme.supports(), &self.integrity);
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

    /// Ends the run, because there is no solution any more.
    pub fn stop(&mut self, error: &StaticsError) -> Ending {
        let ending = match error {
            StaticsError::Swings { .. } => Ending::Collapsed,
            _ => Ending::Singular,
        };
        self.stopped = Some((ending, error.to_string()));
        ending
    }

    /// Changes that no response takes into account yet.
    pub fn fresh_changes(&self) -> &[Change] {
        &self.changes[self.changes.len() - self.fresh..]
    }

    /// Bonds, trusses and clipped bonds broken since the start, in their order; initial cracks and cells are none.
    pub fn broken(&self) -> Vec<u32> {
        let changes = self.changes.iter().filter(|change| change.is_break());
        let broken = changes.filter(|change| (change.interaction as usize) < self.axial);
        broken.map(|change| change.interaction).collect()
    }

    /// Stretch of an interaction [-].
    pub fn stretch(&self, model: &Model, interaction: usize) -> f64 {
        model.stretch(interaction, &self.displacement)
    }

    /// The interaction nearest to a limit, and its stretch over that [-].
    pub fn most_strained(&self, model: &Model, laws: &BondLaws) -> Option<(usize, f64)> {
        let intact = model
            .interactions
            .axial()
            .filter(|&s| self.integrity[s] > 0.0);
        let utilised = intact.map(|s| {
            let limits = laws.limits(s, self.integrity[s]);
            (s, limits.utilisation(self.stretch(model, s)))
        });
        utilised.max_by(|a, b| a.1.total_cmp(&b.1))
    }
}
