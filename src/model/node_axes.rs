//! Axes of single nodes: where a support holds a direction that is neither x nor y, the node's two dofs
//! are the components along axes of its own.
//!
//! With T the rotations of these nodes, u' = T u, K' = T K Tᵀ and R' = T R: the solver sees ordinary
//! prescribed dofs, K stays symmetric, and an interaction's e = w·u is w'·u' with w' = T w. All of `statics` and
//! `fracture` works in these axes; what leaves them is turned back.

use super::Model;
use std::collections::BTreeMap;

/// Cosine and sine of the angle between x and a node's first axis.
pub type NodeAxes = BTreeMap<usize, [f64; 2]>;

/// Components along axes with the cosine c and the sine s.
pub fn to_own([c, s]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    [c * x + s * y, c * y - s * x]
}

/// Components along x and y.
pub fn to_space([c, s]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    [c * x - s * y, c * y + s * x]
}

/// The direction of a dof.
pub fn direction(axes: &NodeAxes, dof: usize) -> [f64; 2] {
    let unit = [[1.0, 0.0], [0.0, 1.0]][dof % 2];
    axes.get(&(dof / 2))
        .map_or(unit, |&own| to_space(own, unit))
}

impl Model {
    /// Gives the nodes the axes that supports ask for.
    pub fn with_node_axes(mut self, axes: &NodeAxes) -> Model {
        self.node_axes = axes.clone();
        self
    }

    /// A field of nodes along x and y, from one in the nodes' own axes.
    pub fn in_space(&self, field: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut field = field.to_vec();
        for (&node, &axes) in &self.node_axes {
            field[node] = to_space(axes, field[node]);
        }
        field
    }

    /// Calls `visit` with every node of an interaction and its w_a in the node's own axes [-].
    pub fn for_each_term(&self, interaction: usize, mut visit: impl FnMut(u32, [f64; 2])) {
        let axes = &self.node_axes;
        self.interactions
            .for_each_term(interaction, &self.positions, |node, w| {
                let own = axes.get(&(node as usize));
                visit(node, own.map_or(w, |&own| to_own(own, w)));
            });
    }

    /// Whether an interaction acts on a node with axes of its own.
    pub fn has_turned_end(&self, interaction: usize) -> bool {
        !self.node_axes.is_empty() && {
            let mut nodes = self.interactions.nodes(interaction).iter();
            nodes.any(|&node| self.node_axes.contains_key(&(node as usize)))
        }
    }

    /// Stretch of an interaction from displacements in the nodes' own axes [-].
    pub fn stretch(&self, interaction: usize, displacement: &[[f64; 2]]) -> f64 {
        if !self.has_turned_end(interaction) {
            return self
                .interactions
                .stretch(interaction, &self.positions, displacement);
        }
        let mut elongation = 0.0;
        self.for_each_term(interaction, |node, w| {
            let u = displacement[node as usize];
            elongation += w[0] * u[0] + w[1] * u[1];
        });
        elongation / self.interactions.length(interaction, &self.positions)
    }
}
