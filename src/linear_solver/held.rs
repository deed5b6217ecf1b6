//! Dofs that do not move: the factors of K with their rows and columns cleared, and one number on their
//! diagonal, without a copy of K.

use super::supernodes::Supernodes;

#[derive(Clone, Copy, Debug)]
pub struct Held<'a> {
    /// By dof; of none: no dof is held.
    pub dofs: &'a [bool],
    /// What stands on their diagonal: something of the size of K [N/m].
    pub diagonal: f64,
}

impl Held<'_> {
    pub const NONE: Held<'static> = Held {
        dofs: &[],
        diagonal: 1.0,
    };

    pub(super) fn holds(&self, dof: usize) -> bool {
        self.dofs.get(dof).is_some_and(|held| *held)
    }

    pub(super) fn columns(&self, structure: &Supernodes) -> HeldColumns {
        let columns = 0..structure.dofs();
        let is_held = columns.map(|column| self.holds(structure.dof(column)));
        HeldColumns {
            is_held: is_held.collect(),
            diagonal: self.diagonal,
        }
    }
}

/// The same by columns of the factor.
pub(super) struct HeldColumns {
    is_held: Vec<bool>,
    pub(super) diagonal: f64,
}

impl HeldColumns {
    pub(super) fn holds(&self, column: usize) -> bool {
        self.is_held[column]
    }

    /// Where held dofs are in a front, own columns first.
    pub(super) fn among<'a>(
        &'a self,
        structure: &'a Supernodes,
        s: usize,
    ) -> impl Iterator<Item = usize> + 'a {
        let rows = structure.rows(s).iter().map(|&row| row as usize);
        let all = structure.columns(s).chain(rows).enumerate();
        all.filter(|&(_, column)| self.is_held[column])
            .map(|(place, _)| place)
    }
}
