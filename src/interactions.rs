//! Interactions: what bonds, trusses and clipped bonds have in common, K = k n⊗n, Qian et al. (2021),
//! eqs. (19) and (20).
//!
//! An interaction is one scalar functional of the displacement, the elongation e, with an energy. Its
//! integrity φ is 1 while it is whole and 0 when it is broken; it is state, and not stored here.
//!
//! ```text
//! e = w·u,   W = ½ φ k e²,   K = Σ φ k w wᵀ,   0 ≤ φ ≤ 1
//! ```
//!
//! Bonds and trusses join two nodes. A clipped bond has ends anywhere, whose displacements are
//! u_A = Σ α_a u_a and u_B = Σ β_a u_a. With n = (x_B − x_A)/ξ all are
//!
//! ```text
//! e = n·(u_B − u_A) = Σ_a w_a·u_a,   w_a = (β_a − α_a) n
//! ```

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
}

/// Interactions in one numbering: the bonds, then the trusses, then the clipped bonds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Interactions {
    bond_count: usize,
    /// Nodes of the bonds, then of the trusses.
    pairs: Vec<[u32; 2]>,
    clipped: ClippedBonds,
    /// Stiffness k of every interaction [N/m].
    pub stiffness: Vec<f64>,
}

/// Clipped bonds; the i-th one has the entries `start[i]..start[i + 1]` of `nodes` and `shares`.
#[derive(Clone, Debug, PartialEq)]
struct ClippedBonds {
    start: Vec<usize>,
    /// Nodes of each clipped bond, ascending, each once.
    nodes: Vec<u32>,
    /// Shares α and β of each node [-].
    shares: Vec<[f64; 2]>,
    /// Ends x_A and x_B of each clipped bond [m].
    segments: Vec<[[f64; 2]; 2]>,
}

impl Default for ClippedBonds {
    fn default() -> ClippedBonds {
        ClippedBonds {
            start: vec![0],
            nodes: Vec::new(),
            shares: Vec::new(),
            segments: Vec::new(),
        }
    }
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
        self.pairs.len()..self.len()
    }

    pub fn kind(&self, interaction: usize) -> InteractionKind {
        if interaction < self.bond_count {
            InteractionKind::Bond
        } else if interaction < self.pairs.len() {
            InteractionKind::Truss
        } else {
            InteractionKind::ClippedBond
        }
    }

    /// Both nodes of an interaction that joins two; `None` for a clipped bond.
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

    /// Adds a clipped bond from `segment[0]` to `segment[1]` [m]. `ends`: the nodes from which the
    /// displacement of either end is interpolated, with their shares α, β; a node may come more than once.
    pub fn push_clipped_bond(
        &mut self,
        segment: [[f64; 2]; 2],
        ends: [&[(u32, f64)]; 2],
        stiffness: f64,
    ) {
        let all = &mut self.clipped;
        let first = all.nodes.len();
        let mut terms: Vec<(u32, usize, f64)> = Vec::new();
        for (end, shares) in ends.into_iter().enumerate() {
            terms.extend(shares.iter().map(|&(node, share)| (node, end, share)));
        }
        terms.sort_by_key(|&(node, end, _)| (node, end));
        for (node, end, share) in terms {
            if all.nodes[first..].last() != Some(&node) {
                all.nodes.push(node);
                all.shares.push([0.0; 2]);
            }
            all.shares.last_mut().expect("just pushed")[end] += share;
        }
        all.start.push(all.nodes.len());
        all.segments.push(segment);
        self.stiffness.push(stiffness);
    }

    /// Adds all of `other`, each kind after its own.
    pub fn append(&mut self, mut other: Interactions) {
        if self.is_empty() {
            *self = other;
            return;
        }
        let clipped = other.stiffness.split_off(other.pairs.len());
        let trusses = other.stiffness.split_off(other.bond_count);
        let end = self.pairs.len();
        self.stiffness.extend(clipped);
        self.stiffness.splice(end..end, trusses);
        let end = self.bond_count;
        self.stiffness.splice(end..end, other.stiffness);
        self.pairs.extend(other.pairs.split_off(other.bond_count));
        self.pairs.splice(end..end, other.pairs);
        self.bond_count += other.bond_count;
        let (all, more) = (&mut self.clipped, &mut other.clipped);
        let offset = all.nodes.len();
        all.start
            .extend(more.start[1..].iter().map(|&start| offset + start));
        all.nodes.append(&mut more.nodes);
        all.shares.append(&mut more.shares);
        all.segments.append(&mut more.segments);
    }

    /// Keeps those of the bonds for which `keep` is true, and all trusses and clipped bonds.
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
            Place::Clipped(i) => &self.clipped.nodes[self.clipped.range(i)],
        }
    }

    /// Ends A and B of an interaction [m].
    pub fn segment(&self, interaction: usize, positions: &[[f64; 2]]) -> [[f64; 2]; 2] {
        match self.place(interaction) {
            Place::Pair(pair) => pair.map(|node| positions[node as usize]),
            Place::Clipped(i) => self.clipped.segments[i],
        }
    }

    /// Length ξ [m] and direction n of an interaction.
    pub fn axis(&self, interaction: usize, positions: &[[f64; 2]]) -> (f64, [f64; 2]) {
        axis_of(self.segment(interaction, positions))
    }

    /// Length ξ [m].
    pub fn length(&self, interaction: usize, positions: &[[f64; 2]]) -> f64 {
        self.axis(interaction, positions).0
    }

    /// Displacements of A and B [m].
    pub fn end_displacements(
        &self,
        interaction: usize,
        displacement: &[[f64; 2]],
    ) -> [[f64; 2]; 2] {
        let i = match self.place(interaction) {
            Place::Pair(pair) => return pair.map(|node| displacement[node as usize]),
            Place::Clipped(i) => i,
        };
        let mut ends = [[0.0; 2]; 2];
        for k in self.clipped.range(i) {
            let u = displacement[self.clipped.nodes[k] as usize];
            for (end, share) in ends.iter_mut().zip(self.clipped.shares[k]) {
                end[0] += share * u[0];
                end[1] += share * u[1];
            }
        }
        ends
    }

    /// Stretch s = n·(u_B − u_A)/ξ for small displacements [-].
    pub fn stretch(
        &self,
        interaction: usize,
        positions: &[[f64; 2]],
        displacement: &[[f64; 2]],
    ) -> f64 {
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
        let (_, n) = self.axis(interaction, positions);
        match self.place(interaction) {
            Place::Pair(&[a, b]) => {
                visit(a, n.map(|n| -n));
                visit(b, n);
            }
            Place::Clipped(i) => {
                for k in self.clipped.range(i) {
                    let [alpha, beta] = self.clipped.shares[k];
                    visit(self.clipped.nodes[k], n.map(|n| (beta - alpha) * n));
                }
            }
        }
    }

    fn place(&self, interaction: usize) -> Place<'_> {
        match self.pairs.get(interaction) {
            Some(pair) => Place::Pair(pair),
            None => Place::Clipped(interaction - self.pairs.len()),
        }
    }
}

enum Place<'a> {
    Pair(&'a [u32; 2]),
    Clipped(usize),
}

impl ClippedBonds {
    fn range(&self, i: usize) -> std::ops::Range<usize> {
        self.start[i]..self.start[i + 1]
    }
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
        for s in 0..2 {
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
        assert_eq!(all.stiffness, [2.0, 2.0, 5.0, 3.0, 3.0]);
        assert_eq!(
            [all.bonds(), all.trusses(), all.clipped_bonds()],
            [0..2, 2..3, 3..5]
        );
        let kinds = [1, 2, 3].map(|k| all.kind(k));
        let expected = [
            InteractionKind::Bond,
            InteractionKind::Truss,
            InteractionKind::ClippedBond,
        ];
        assert_eq!(kinds, expected);
        for k in all.clipped_bonds() {
            assert_eq!(all.nodes(k), [0, 1, 2]);
            assert_eq!(all.segment(k, &POSITIONS), [[0.2, 0.2], [0.5, 0.4]]);
        }
        assert_eq!(all.segment(2, &POSITIONS), [POSITIONS[1], POSITIONS[2]]);
        let mut fewer = all.clone();
        let mut first = true;
        fewer.retain_bonds(|_| std::mem::take(&mut first));
        assert_eq!(fewer.pairs(), [[0, 1], [1, 2]]);
        assert_eq!(fewer.stiffness, [2.0, 5.0, 3.0, 3.0]);
        assert_eq!(fewer.bonds(), 0..1);
        assert_eq!(fewer.nodes(2), [0, 1, 2]);
    }
}
