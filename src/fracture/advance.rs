//! How a state moves along a response, and what its changes cost.

use super::event::Load;
use super::laws::released;
use super::problem::Problem;
use super::response::Response;
use super::state::{Change, LoadForce, State};
use std::borrow::Cow;
use std::sync::Arc;

impl State {
    /// Moves along the straight path to `load`.
    pub(super) fn advance(&mut self, problem: &Problem, response: &Response, load: Load) {
        self.account(problem, response, load);
        let stiffness = response.values().stiffness(self.phase);
        self.force.follow(stiffness, load);
        self.course.follow(match stiffness == 0.0 {
            true => load.share * load.factor,
            false => self.force.now.abs(),
        });
        self.load = load;
        self.envelope = self.envelope.max(load.factor);
    }

    /// Finds displacements and reactions, unless the next response is known already: nothing needs them then.
    pub(super) fn settle_if_due(&mut self, problem: &Problem, response: &Response) {
        if !response.foresees_next() {
            self.settle(problem, response);
        }
    }

    /// This state with displacements and reactions.
    pub fn settled(&self, problem: &Problem, response: &Response) -> Cow<'_, State> {
        if !response.foresees_next() {
            return Cow::Borrowed(self);
        }
        let mut settled = self.clone();
        settled.settle(problem, response);
        Cow::Owned(settled)
    }

    /// Finds displacements and reactions everywhere. Fragments stay where they broke off.
    pub(super) fn settle(&mut self, problem: &Problem, response: &Response) {
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
    /// ½ (r + r')·(u' − u) = Δ(½ uᵀ K u) + Σ ½ (φ − φ') k e e' holds for any two states. With the factors a_q
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
        for change in self.fresh_changes().to_vec() {
            let interaction = change.interaction as usize;
            let length = model.interactions.length(interaction, &model.positions);
            let after = length * response.stretch(problem, interaction, load);
            let stiffness = model.interactions.stiffness[interaction];
            self.energy.dissipated +=
                released(change.integrity, stiffness, [change.elongation, after]);
        }
        self.fresh = 0;
    }

    /// Changes the integrity of interactions that have reached a limit, takes the cells of those that break with
    /// them, finds the parts that come off, and
    /// returns the changes. Displacements are those of the `response`, or else the state's own.
    pub fn change(
        &mut self,
        problem: &Problem,
        response: Option<&Response>,
        interactions: &[usize],
    ) -> &[Change] {
        let Problem {
            model,
            programme,
            laws,
            ..
        } = problem;
        let mut count = interactions.len();
        let change = |state: &mut State, interaction: usize| {
            let stretch = match response {
                Some(response) => response.stretch(problem, interaction, state.load),
                None => state.stretch(model, interaction),
            };
            let before = state.integrity[interaction];
            let after = laws.next(interaction, before, stretch);
            Arc::make_mut(&mut state.integrity)[interaction] = after;
            state.changes.push(Change {
                interaction: interaction as u32,
                integrity: [before, after],
                elongation: model.interactions.length(interaction, &model.positions) * stretch,
            });
        };
        interactions.iter().for_each(|&s| change(self, s));
        let is_broken = |&s: &usize| self.integrity[s] == 0.0;
        let broken: Vec<usize> = interactions.iter().copied().filter(is_broken).collect();
        let cells = model.cells_with(&broken, |cell| self.integrity[cell] > 0.0);
        cells.iter().for_each(|&cell| change(self, cell));
        count += cells.len();
        self.fresh += count;
        // A response that is known already is that of a regular K: everything is held.
        let is_held = response.is_some_and(Response::foresees_next);
        if !interactions.is_empty() && !is_held {
            let before = self.fragments.clone();
            self.find_loose_parts(model, programme);
            if self.fragments != before
                && let Some(response) = response
            {
                // Parts that come off stay where they are now.
                let now = std::mem::replace(&mut self.fragments, before);
                self.settle(problem, response);
                self.fragments = now;
            }
        }
        &self.changes[self.changes.len() - count..]
    }
}

impl LoadForce {
    /// Takes in the response to `load`, of which Q per unit of λ is `stiffness` [J].
    fn follow(&mut self, stiffness: f64, load: Load) {
        self.now = load.share * load.factor * stiffness;
        self.peak = self.peak.max(self.now.abs());
        if self.stiffness[0] == 0.0 {
            self.stiffness[0] = stiffness;
        }
        self.stiffness[1] = stiffness;
    }
}
