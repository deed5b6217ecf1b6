//! Probes: the nodes that they read.

use crate::fracture::functional::Functional;
use crate::model::Model;
use crate::model::node_axes::direction;
use crate::pipeline::read::plan::{Plan, Probe};
use crate::pipeline::read::source::InputError;
use std::collections::BTreeMap;

/// A probe reads the nearest node, which tells nothing where the body is not.
pub(super) fn check(plan: &Plan, model: &Model) -> Result<(), InputError> {
    let [low, high] = model.bounds();
    let slack = PROBE_SLACK * (high[0] - low[0]).max(high[1] - low[1]);
    let is_off = |at: [f64; 2]| {
        (0..2).any(|axis| at[axis] < low[axis] - slack || at[axis] > high[axis] + slack)
    };
    for Probe { name, points, .. } in &plan.probes {
        let Some([x, y]) = points.iter().find(|&&at| is_off(at)) else {
            continue;
        };
        let message = format!("probe `{name}` at ({x}, {y}) m is off the body");
        let help = format!(
            "the body reaches from ({}, {}) to ({}, {}) m; a bare number is in metres",
            low[0], low[1], high[0], high[1]
        );
        let field = if points.len() == 1 { "at" } else { "between" };
        let key = format!("probes/{name}/{field}");
        return Err(plan.source.error(&key, message, Some(help)));
    }
    Ok(())
}

/// u at the node nearest to a point, or the difference of two, along x or y.
pub(super) fn functional(model: &Model, probe: &Probe) -> Functional {
    let mut weights = BTreeMap::new();
    let signs = if probe.points.len() == 1 {
        &[1.0][..]
    } else {
        &[-1.0, 1.0]
    };
    for (&at, sign) in probe.points.iter().zip(signs) {
        let (node, _) = model.nearest_node(at);
        for dof in [2 * node, 2 * node + 1] {
            let share = sign * direction(&model.node_axes, dof)[probe.axis];
            *weights.entry(dof).or_insert(0.0) += share;
        }
    }
    Functional::of_displacement(weights.into_iter().filter(|(_, g)| *g != 0.0).collect())
}

/// Probes may be off the body by this share of its larger side: coordinates carry rounding.
const PROBE_SLACK: f64 = 1e-6;
