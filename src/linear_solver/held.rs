//! Dofs that are held: K is factorised with their rows and columns cleared and one number on their diagonal,
//! without a copy of K.

use super::node_blocks::NodeBlocks;
use super::supernodes::Supernodes;

#[derive(Clone, Copy, Debug)]
pub struct HeldDofs<'a> {
    /// Whether each dof is held; empty where none is.
    pub is_held: &'a [bool],
    /// The entry on their diagonal: a number of the size of K [N/m].
    pub diagonal: f64,
}

impl HeldDofs<'_> {
    pub const NONE: HeldDofs<'static> = HeldDofs {
        is_held: &[],
        diagonal: 1.0,
    };

    pub(super) fn holds(&self, dof: usize) -> bool {
        self.is_held.get(dof).is_some_and(|held| *held)
    }

    pub(super) fn columns<const B: usize>(
        &self,
        supernodes: &Supernodes,
        nodes: &NodeBlocks<B>,
    ) -> HeldColumns {
        let columns = 0..supernodes.dofs();
        HeldColumns {
            is_held: columns
                .map(|column| self.holds(nodes.dof(column)))
                .collect(),
            diagonal: self.diagonal,
        }
    }
}

/// The columns of L that eliminate held dofs.
pub(super) struct HeldColumns {
    is_held: Vec<bool>,
    pub(super) diagonal: f64,
}

impl HeldColumns {
    pub(super) fn holds(&self, column: usize) -> bool {
        self.is_held[column]
    }

    /// The places of held dofs in a front, own columns first.
    pub(super) fn among<'a>(
        &'a self,
        supernodes: &'a Supernodes,
        s: usize,
    ) -> impl Iterator<Item = usize> + 'a {
        let rows = supernodes.rows(s).iter().map(|&row| row as usize);
        let all = supernodes.columns(s).chain(rows).enumerate();
        all.filter(|&(_, column)| self.is_held[column])
            .map(|(place, _)| place)
    }
}
