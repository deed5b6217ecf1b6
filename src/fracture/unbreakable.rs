//! The end of a run whose cracks have reached what cannot break: finite elements, `no_fail` surfaces, trusses.
//!
//! From there on the load grows again, up to values that have nothing to do with the body's strength, while bonds
//! tear off along the unbreakable part. So the run ends when both are seen: the load had fallen and has recovered,
//! and nearly all of the last bonds to break end at what cannot break. A tooth of the path is no recovery, and a
//! crack that passes along a support while the load falls is not stopped.

use super::laws::StretchLimits;
use super::policy::{LAST_BREAKS, STOPPED};
use super::problem::Problem;
use super::state::State;

/// Nodes of finite elements, and those with an interaction that never breaks.
pub(super) struct UnbreakableNodes(Vec<bool>);

impl UnbreakableNodes {
    pub fn new(problem: &Problem) -> UnbreakableNodes {
        let Problem { model, laws, .. } = problem;
        let mut nodes = vec![false; model.node_count()];
        nodes[..model.fe_node_count()].fill(true);
        for interaction in 0..model.interactions.len() {
            if laws.first_limits(interaction) == StretchLimits::NONE {
                for &node in model.interactions.nodes(interaction) {
                    nodes[node as usize] = true;
                }
            }
        }
        UnbreakableNodes(nodes)
    }

    /// Whether they have stopped the cracks.
    pub fn have_stopped(&self, problem: &Problem, state: &State) -> bool {
        if state.phase > 0 || !state.course.has_recovered() {
            return false;
        }
        let ends_there = |&&interaction: &&u32| {
            let mut nodes = problem
                .model
                .interactions
                .nodes(interaction as usize)
                .iter();
            nodes.any(|&node| self.0[node as usize])
        };
        let broken = state.broken();
        let Some(last) = broken.last_chunk::<LAST_BREAKS>() else {
            return false;
        };
        last.iter().filter(ends_there).count() as f64 >= STOPPED * LAST_BREAKS as f64
    }
}
