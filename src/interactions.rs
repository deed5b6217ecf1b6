//! Interactions: what bonds, trusses, clipped bonds and cells have in common, K = k w wᵀ, Qian et al. (2021),
//! eqs. (19) and (20) for bonds.
//!
//! An interaction is one scalar functional of the displacement, the elongation e, with an energy. Its
//! integrity φ is 1 while it is whole and 0 when it is broken; it is state, and not stored here.
//!
//! ```text
//! e = w·u,   W = ½ φ k e²,   K = Σ φ k w wᵀ,   0 ≤ φ ≤ 1
//! ```
//!
//! Bonds and trusses join two nodes. A clipped bond has ends anywhere, whose displacements are
//! u_A = Σ α_a u_a and u_B = Σ β_a u_a. With n = (x_B − x_A)/ξ all three are *axial*,
//!
//! ```text
//! e = n·(u_B − u_A) = Σ_a w_a·u_a,   w_a = (β_a − α_a) n
//! ```
//!
//! A cell has any w_a: e is a component of its mean strain times its length, the lattice's spacing. It has no
//! ends and no direction.

mod clipped;
mod functionals;

use clipped::ClippedBonds;
use functionals::Functionals;
use std::ops::Range;

/// The kinds of interactions, in the order of their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InteractionKind {
    /// A bond between two material points.
    Bond,
    /// A truss between a node of the finite elements and a material point, eq. (20).
    Truss,
    /// A part of a bond that ends at an interface, where it moves with the finite elements.
    ClippedBond,
    /// A component of the mean strain of some nodes.
    Cell,
}

/// Interactions in one numbering: the bonds, then the trusses, then the clipped bonds, then the cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Interactions {
    bond_count: usize,
    /// Nodes of the bonds, then of the trusses.
    pairs: Vec<[u32; 2]>,
    clipped: ClippedBonds,
    cells: Functionals,
    /// Stiffness k of every interaction [N/m].
    pub stiffness: Vec<f64>,
}

impl Interactions {
    /// Bonds between nodes, with the stiffness of each [N/m].
    pub fn of_bonds(pairs: Vec<[u32; 2]>, stiffness: Vec<f64>) -> Interactions {
        Interactions {
            bond_count: pairs.len(),
            pairs,
            stiffness,
            ..Interactions::default()
        }
    }

    pub fn len(&self) -> usize {
        self.stiffness.len()
    }

    pub fn is_empty(&self) -> bool {
        self.stiffness.is_empty()
    }

    /// Numbers of the bonds.
    pub fn bonds(&self) -> Range<usize> {
        0..self.bond_count
    }

    /// Numbers of the trusses.
    pub fn trusses(&self) -> Range<usize> {
        self.bond_count..self.pairs.len()
    }

    /// Numbers of the clipped bonds.
    pub fn clipped_bonds(&self) -> Range<usize> {
        self.pairs.len()..self.cells().start
    }

    /// Numbers of the cells.
    pub fn cells(&self) -> Range<usize> {
        self.len() - self.cells.lengths.len()..self.len()
    }

    /// Numbers of the interactions with two ends: all but the cells.
    pub fn axial(&self) -> Range<usize> {
        0..self.cells().start
    }

    pub fn kind(&self, interaction: usize) -> InteractionKind {
        if interaction < self.bond_count {
            InteractionKind::Bond
        } else if interaction < self.pairs.len() {
            InteractionKind::Truss
        } else if interaction < self.cells().start {
            InteractionKind::ClippedBond
        } else {
            InteractionKind::Cell
        }
    }

    /// Both nodes of a bond or truss; `None` for the others.
    pub fn pair(&self, interaction: usize) -> Option<[u32; 2]> {
        self.pairs.get(interaction).copied()
    }

    /// Both nodes of every bond and truss, by number.
    pub fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs
    }

    /// Both nodes of every bond and truss, and the stiffness of each [N/m].
    pub fn pairs_mut(&mut self) -> (&[[u32; 2]], &mut [f64]) {
        let count = self.pairs.len();
        (&self.pairs, &mut self.stiffness[..count])
    }

    /// Adds a truss after the trusses so far.
    pub fn push_truss(&mut self, pair: [u32; 2], stiffness: f64) {
        self.stiffness.insert(self.pairs.len(), stiffness);
        self.pairs.push(pair);
    }

    /// Adds a cell, e = Σ w_a·u_a, with w_a [-] of its nodes, ascending, each once, and its stiffness [N/m]; e is a
    /// strain times `length` [m].
    pub fn push_cell(&mut self, terms: &[(u32, [f64; 2])], length: f64, stiffness: f64) {
        self.cells.push(terms, length);
        self.stiffness.push(stiffness);
    }

    /// Adds a clipped bond from `segment[0]` to `segment[1]` [m]. `ends`: the nodes from which the
    /// displacement of either end is interpolated, with their shares α, β; a node may come more than once.
    pub fn push_clipped_bond(
        &mut self,
        segment: [[f64; 2]; 2],
        ends: [&[(u32, f64)]; 2],
        stiffness: f64,
    ) {
        self.clipped.push(segment, ends);
        self.stiffness.insert(self.cells().start, stiffness);
    }

    /// Adds all of `other`, each kind after its own.
    pub fn append(&mut self, mut other: Interactions) {
        if self.is_empty() {
            *self = other;
            return;
        }
        let cells = other.stiffness.split_off(other.cells().start);
        let clipped = other.stiffness.split_off(other.pairs.len());
        let trusses = other.stiffness.split_off(other.bond_count);
        let end = self.cells().start;
        self.stiffness.extend(cells);
        self.stiffness.splice(end..end, clipped);
        let end = self.pairs.len();
        self.stiffness.splice(end..end, trusses);
        let end = self.bond_count;
        self.stiffness.splice(end..end, other.stiffness);
        self.pairs.extend(other.pairs.split_off(other.bond_count));
        self.pairs.splice(end..end, other.pairs);
        self.bond_count += other.bond_count;
        self.clipped.append(&mut other.clipped);
        self.cells.append(&mut other.cells);
    }

    /// Keeps those of the bonds for which `keep` is true, and all other interactions.
    pub fn retain_bonds(&mut self, mut keep: impl FnMut([u32; 2]) -> bool) {
        let bonds = &self.pairs[..self.bond_count];
        let kept: Vec<bool> = bonds.iter().map(|&pair| keep(pair)).collect();
        let mut of_pair = kept.iter();
        self.pairs.retain(|_| of_pair.next() != Some(&false));
        let mut of_stiffness = kept.iter();
        self.stiffness
            .retain(|_| of_stiffness.next() != Some(&false));
        self.bond_count = kept.iter().filter(|kept| **kept).count();
    }

    /// Nodes that an interaction acts on, each once.
    pub fn nodes(&self, interaction: usize) -> &[u32] {
        match self.place(interaction) {
            Place::Pair(pair) => pair,
            Place::Clipped(i) => self.clipped.nodes(i),
            Place::Cell(i) => self.cells.nodes(i),
        }
    }

    /// Ends A and B of an axial interaction [m].
    ///
    /// # Panics
    /// Panics for a cell.
    pub fn segment(&self, interaction: usize, positions: &[[f64; 2]]) -> [[f64; 2]; 2] {
        match self.place(interaction) {
            Place::Pair(pair) => pair.map(|node| positions[node as usize]),
            Place::Clipped(i) => self.clipped.segments[i],
            Place::Cell(_) => panic!("a cell has no ends"),
        }
    }

    /// Length ξ [m] and direction n of an axial interaction.
    ///
    /// # Panics
    /// Panics for a cell.
    pub fn axis(&self, interaction: usize, positions: &[[f64; 2]]) -> (f64, [f64; 2]) {
        axis_of(self.segment(interaction, positions))
    }

    /// Length ξ [m]; of a cell the length over which it is a strain.
    pub fn length(&self, interaction: usize, positions: &[[f64; 2]]) -> f64 {
        match self.place(interaction) {
            Place::Cell(i) => self.cells.lengths[i],
            _ => self.axis(interaction, positions).0,
        }
    }

    /// Displacements of A and B of an axial interaction [m].
    ///
    /// # Panics
    /// Panics for a cell.
    pub fn end_displacements(
        &self,
        interaction: usize,
        displacement: &[[f64; 2]],
    ) -> [[f64; 2]; 2] {
        match self.place(interaction) {
            Place::Pair(pair) => pair.map(|node| displacement[node as usize]),
            Place::Clipped(i) => self.clipped.end_displacements(i, displacement),
            Place::Cell(_) => panic!("a cell has no ends"),
        }
    }

    /// Stretch s = n·(u_B − u_A)/ξ for small displacements; of a cell its component of the mean strain [-].
    pub fn stretch(
        &self,
        interaction: usize,
        positions: &[[f64; 2]],
        displacement: &[[f64; 2]],
    ) -> f64 {
        if let Place::Cell(i) = self.place(interaction) {
            return self.cells.value(i, displacement) / self.cells.lengths[i];
        }
        let (length, n) = self.axis(interaction, positions);
        let [ua, ub] = self.end_displacements(interaction, displacement);
        (n[0] * (ub[0] - ua[0]) + n[1] * (ub[1] - ua[1])) / length
    }

    /// Calls `visit` with every node of an interaction and its w_a [-].
    pub fn for_each_term(
        &self,
        interaction: usize,
        positions: &[[f64; 2]],
        mut visit: impl FnMut(u32, [f64; 2]),
    ) {
        let axis = || self.axis(interaction, positions).1;
        match self.place(interaction) {
            Place::Pair(&[a, b]) => {
                let n = axis();
                visit(a, n.map(|n| -n));
                visit(b, n);
            }
            Place::Cell(i) => self.cells.terms(i).for_each(|(node, w)| visit(node, w)),
            Place::Clipped(i) => {
                let n = axis();
                for (node, [alpha, beta]) in self.clipped.shares(i) {
                    visit(node, n.map(|n| (beta - alpha) * n));
                }
            }
        }
    }

    fn place(&self, interaction: usize) -> Place<'_> {
        match self.pairs.get(interaction) {
            Some(pair) => Place::Pair(pair),
            None => match interaction.checked_sub(self.cells().start) {
                Some(i) => Place::Cell(i),
                None => Place::Clipped(interaction - self.pairs.len()),
            },
        }
    }
}

enum Place<'a> {
    Pair(&'a [u32; 2]),
    Clipped(usize),
    Cell(usize),
}

/// Length ξ [m] and direction n of the segment between two points.
fn axis_of([a, b]: [[f64; 2]; 2]) -> (f64, [f64; 2]) {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length = dx.hypot(dy);
    (length, [dx / length, dy / length])
}

/// Length ξ [m] and direction n of the bond between two points.
pub fn axis(pair: [u32; 2], positions: &[[f64; 2]]) -> (f64, [f64; 2]) {
    axis_of(pair.map(|node| positions[node as usize]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Node 1 is an end of the bond, and both ends of the clipped bond are interpolated from it.
    fn interactions() -> Interactions {
        let mut interactions = Interactions::of_bonds(vec![[0, 1]], vec![2.0]);
        interactions.push_clipped_bond(
            [[0.2, 0.2], [0.5, 0.4]],
            [&[(2, 0.25), (1, 0.75)], &[(1, 0.5), (0, 0.25), (1, 0.25)]],
            3.0,
        );
        interactions.push_cell(&[(0, [1.0, -2.0]), (2, [0.5, 4.0])], 0.5, 7.0);
        interactions
    }

    const POSITIONS: [[f64; 2]; 3] = [[0.1, 0.2], [0.4, 0.6], [0.9, 0.1]];

    #[test]
    fn stretch_under_uniform_strain_is_n_epsilon_n() {
        let (xx, yy, xy) = (1e-3, -2e-3, 0.5e-3);
        let u = POSITIONS.map(|[x, y]| [xx * x + xy * y, xy * x + yy * y]);
        let interactions = Interactions::of_bonds(vec![[0, 1]], vec![1.0]);
        let (length, n) = interactions.axis(0, &POSITIONS);
        let expected = xx * n[0] * n[0] + yy * n[1] * n[1] + 2.0 * xy * n[0] * n[1];
        assert!((length - 0.5).abs() < 1e-16);
        // Differences of displacements of 1e-3 over a length of 0.5.
        assert!((interactions.stretch(0, &POSITIONS, &u) - expected).abs() < 1e-17);
    }

    #[test]
    fn the_terms_are_the_elongation() {
        let interactions = interactions();
        let u = [[0.3, -0.2], [0.5, 0.7], [-0.4, 0.1]];
        for s in 0..3 {
            let mut sum = 0.0;
            let mut seen = Vec::new();
            interactions.for_each_term(s, &POSITIONS, |node, w| {
                let u = u[node as usize];
                sum += w[0] * u[0] + w[1] * u[1];
                seen.push(node);
            });
            let elongation =
                interactions.stretch(s, &POSITIONS, &u) * interactions.length(s, &POSITIONS);
            assert!((sum - elongation).abs() < 1e-15, "{s}: {sum} {elongation}");
            assert_eq!(seen, interactions.nodes(s), "each node once");
        }
        let [ua, ub] = interactions.end_displacements(1, &u);
        assert!((ua[0] - (0.75 * 0.5 - 0.25 * 0.4)).abs() < 1e-16);
        assert!((ub[1] - (0.75 * 0.7 - 0.25 * 0.2)).abs() < 1e-16);
    }

    #[test]
    fn the_kinds_have_their_ranges_in_any_order_of_adding() {
        let mut all = interactions();
        all.push_truss([1, 2], 5.0);
        all.append(interactions());
        assert_eq!(all.pairs(), [[0, 1], [0, 1], [1, 2]]);
        assert_eq!(all.stiffness, [2.0, 2.0, 5.0, 3.0, 3.0, 7.0, 7.0]);
        assert_eq!(
            [all.bonds(), all.trusses(), all.clipped_bonds(), all.cells()],
            [0..2, 2..3, 3..5, 5..7]
        );
        let kinds = [1, 2, 3, 5].map(|k| all.kind(k));
        let expected = [
            InteractionKind::Bond,
            InteractionKind::Truss,
            InteractionKind::ClippedBond,
            InteractionKind::Cell,
        ];
        assert_eq!(kinds, expected);
        for k in all.clipped_bonds() {
            assert_eq!(all.nodes(k), [0, 1, 2]);
            assert_eq!(all.segment(k, &POSITIONS), [[0.2, 0.2], [0.5, 0.4]]);
        }
        assert_eq!(all.nodes(6), [0, 2]);
        assert_eq!(all.segment(2, &POSITIONS), [POSITIONS[1], POSITIONS[2]]);
        let mut fewer = all.clone();
        let mut first = true;
        fewer.retain_bonds(|_| std::mem::take(&mut first));
        assert_eq!(fewer.pairs(), [[0, 1], [1, 2]]);
        assert_eq!(fewer.stiffness, [2.0, 5.0, 3.0, 3.0, 7.0, 7.0]);
        assert_eq!(fewer.bonds(), 0..1);
        assert_eq!(fewer.nodes(2), [0, 1, 2]);
    }
}
