//! Warnings on what a run has broken first, or that it has broken nothing. They follow from the state alone, so
//! that a resumed run has those of a whole one.

use crate::fracture::control::Problem;
use crate::fracture::state::State;
use crate::output::number::percent;
use crate::pipeline::read::source::quoted;
use std::collections::BTreeSet;

/// Breaks after which it is decided what breaks first.
const FIRST_BREAKS: usize = 10;

/// All warnings on a state.
pub(super) fn of(problem: &Problem, state: &State) -> Vec<String> {
    let warnings = [torn_off(problem, state), nothing_broke(problem, state)];
    warnings.into_iter().flatten().collect()
}

/// Whether the first breaks are known, so that no warning can follow.
pub(super) fn are_told(state: &State) -> bool {
    state.changes.len() >= FIRST_BREAKS
}

/// Whether they are known since the last `changed` changes of integrity.
pub(super) fn is_due(state: &State, changed: usize) -> bool {
    are_told(state) && state.changes.len() - changed < FIRST_BREAKS
}

/// A held row of material points that tears off before the body cracks: at least half of the bonds that broke
/// first end at a material point with a prescribed
/// displacement.
fn torn_off(problem: &Problem, state: &State) -> Option<String> {
    let model = problem.model;
    let supports = problem.programme.supports();
    let group = |node: u32| {
        let node = node as usize;
        let mut dofs = [2 * node, 2 * node + 1].into_iter();
        let held = dofs.find_map(|dof| supports.prescribed.get(&dof));
        let held = held.filter(|_| node >= model.fe_node_count());
        held.map(|(_, group)| group.as_str())
    };
    let mut broken = state.broken();
    broken.truncate(FIRST_BREAKS);
    let mut groups = BTreeSet::new();
    let mut count = 0;
    for &interaction in &broken {
        let nodes = model.interactions.nodes(interaction as usize).iter();
        let held: BTreeSet<&str> = nodes.filter_map(|&node| group(node)).collect();
        count += usize::from(!held.is_empty());
        groups.extend(held);
    }
    let groups: Vec<&str> = groups.into_iter().collect();
    (count > 0 && 2 * count >= broken.len()).then(|| {
        format!(
            "of the first {} bonds that broke, {count} end at points whose displacement is prescribed by {}: the \
             held points tear off before the body cracks. Name a surface some horizons wide along them under \
             `no_fail`, or hold the body by finite elements",
            broken.len(),
            quoted(&groups)
        )
    })
}

/// A load that could not break a bond, told with what it has reached.
fn nothing_broke(problem: &Problem, state: &State) -> Option<String> {
    let Problem { model, laws, .. } = problem;
    if state.step == 0 || !state.changes.is_empty() {
        return None;
    }
    let (interaction, utilisation) = state.most_strained(model, laws)?;
    let [a, b] = model.interactions.segment(interaction, &model.positions);
    let [x, y] = [0, 1].map(|axis| 500.0 * (a[axis] + b[axis]));
    Some(format!(
        "no bond has broken: at λ = {:.4} the largest stretch is {} of its limit, at ({x:.4}, {y:.4}) mm",
        state.load.factor,
        percent(utilisation, 0)
    ))
}
