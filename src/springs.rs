//! Axial springs: what bonds, trusses and the members of other couplings have in common,
//! K = k n⊗n, Qian et al. (2021), eqs. (19) and (20).
//!
//! A spring joins two points. Those of a *pair* (bonds and trusses) are nodes. An *interpolated*
//! spring has ends anywhere, whose displacements are u_A = Σ α_a u_a and u_B = Σ β_a u_a. With
//! n = (x_B − x_A)/ξ both are one functional of the nodes, and K is its square:
//!
//! ```text
//! e = n·(u_B − u_A) = Σ_a w_a·u_a,   w_a = (β_a − α_a) n,   K = k w wᵀ
//! ```

/// Axial springs in one numbering: the pairs, then the interpolated ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Springs {
    pairs: Vec<[u32; 2]>,
    interpolated: Interpolated,
    /// k of every spring [N/m].
    pub stiffness: Vec<f64>,
}

/// Springs whose ends are interpolated; what belongs to the i-th is at `start[i]..start[i + 1]`.
#[derive(Clone, Debug, PartialEq)]
struct Interpolated {
    start: Vec<usize>,
    /// Each node once per spring, ascending.
    nodes: Vec<u32>,
    /// α and β of each node [-].
    shares: Vec<[f64; 2]>,
    /// x_A and x_B [m].
    segments: Vec<[[f64; 2]; 2]>,
}

impl Default for Interpolated {
    fn default() -> Interpolated {
        Interpolated {
            start: vec![0],
            nodes: Vec::new(),
            shares: Vec::new(),
            segments: Vec::new(),
        }
    }
}

impl Springs {
    /// Springs between nodes, with the stiffness of each [N/m].
    pub fn of_pairs(pairs: Vec<[u32; 2]>, stiffness: Vec<f64>) -> Springs {
        Springs {
            pairs,
            stiffness,
            ..Springs::default()
        }
    }

    pub fn len(&self) -> usize {
        self.stiffness.len()
    }

    pub fn is_empty(&self) -> bool {
        self.stiffness.is_empty()
    }

    /// The springs between two nodes, which come first: their nodes.
    pub fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs
    }

    /// The springs between two nodes, and the stiffness of each [N/m].
    pub fn pairs_mut(&mut self) -> (&[[u32; 2]], &mut [f64]) {
        let count = self.pairs.len();
        (&self.pairs, &mut self.stiffness[..count])
    }

    /// Adds a spring between two nodes, behind the pairs that there are.
    pub fn push(&mut self, pair: [u32; 2], stiffness: f64) {
        self.stiffness.insert(self.pairs.len(), stiffness);
        self.pairs.push(pair);
    }

    /// Adds a spring from `segment[0]` to `segment[1]` [m]. `ends`: the nodes that the displacement
    /// of either end is interpolated from, with their shares α, β; a node may come more than once.
    pub fn push_interpolated(
        &mut self,
        segment: [[f64; 2]; 2],
        ends: [&[(u32, f64)]; 2],
        stiffness: f64,
    ) {
        let all = &mut self.interpolated;
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

    /// Adds all of `other`, its pairs behind the pairs and the rest at the end.
    pub fn append(&mut self, mut other: Springs) {
        if self.is_empty() {
            *self = other;
            return;
        }
        let rest = other.stiffness.split_off(other.pairs.len());
        let place = self.pairs.len();
        self.stiffness.splice(place..place, other.stiffness);
        self.stiffness.extend(rest);
        self.pairs.append(&mut other.pairs);
        let (all, more) = (&mut self.interpolated, &mut other.interpolated);
        let offset = all.nodes.len();
        all.start
            .extend(more.start[1..].iter().map(|&start| offset + start));
        all.nodes.append(&mut more.nodes);
        all.shares.append(&mut more.shares);
        all.segments.append(&mut more.segments);
    }

    /// Keeps the pairs that `keep` says yes to, and all that is interpolated.
    pub fn retain_pairs(&mut self, mut keep: impl FnMut([u32; 2]) -> bool) {
        let kept: Vec<bool> = self.pairs.iter().map(|&pair| keep(pair)).collect();
        let mut of_pair = kept.iter();
        self.pairs.retain(|_| of_pair.next() == Some(&true));
        let mut of_spring = kept.iter();
        self.stiffness.retain(|_| of_spring.next() != Some(&false));
    }

    /// The nodes that a spring acts on, each once.
    pub fn nodes(&self, spring: usize) -> &[u32] {
        match self.place(spring) {
            Place::Pair(pair) => pair,
            Place::Interpolated(i) => &self.interpolated.nodes[self.interpolated.range(i)],
        }
    }

    /// Where a spring is, from A to B [m].
    pub fn segment(&self, spring: usize, positions: &[[f64; 2]]) -> [[f64; 2]; 2] {
        match self.place(spring) {
            Place::Pair(pair) => pair.map(|node| positions[node as usize]),
            Place::Interpolated(i) => self.interpolated.segments[i],
        }
    }

    /// Length ξ [m] and direction n of a spring.
    pub fn axis(&self, spring: usize, positions: &[[f64; 2]]) -> (f64, [f64; 2]) {
        axis_of(self.segment(spring, positions))
    }

    /// Length ξ [m].
    pub fn length(&self, spring: usize, positions: &[[f64; 2]]) -> f64 {
        self.axis(spring, positions).0
    }

    /// Displacements of A and B [m].
    pub fn end_displacements(&self, spring: usize, displacement: &[[f64; 2]]) -> [[f64; 2]; 2] {
        let i = match self.place(spring) {
            Place::Pair(pair) => return pair.map(|node| displacement[node as usize]),
            Place::Interpolated(i) => i,
        };
        let mut ends = [[0.0; 2]; 2];
        for k in self.interpolated.range(i) {
            let u = displacement[self.interpolated.nodes[k] as usize];
            for (end, share) in ends.iter_mut().zip(self.interpolated.shares[k]) {
                end[0] += share * u[0];
                end[1] += share * u[1];
            }
        }
        ends
    }

    /// Stretch s = n·(u_B − u_A)/ξ for small displacements [-].
    pub fn stretch(&self, spring: usize, positions: &[[f64; 2]], displacement: &[[f64; 2]]) -> f64 {
        let (length, n) = self.axis(spring, positions);
        let [ua, ub] = self.end_displacements(spring, displacement);
        (n[0] * (ub[0] - ua[0]) + n[1] * (ub[1] - ua[1])) / length
    }

    /// Calls `visit` with every node of a spring and its w_a [-].
    pub fn for_each_term(
        &self,
        spring: usize,
        positions: &[[f64; 2]],
        mut visit: impl FnMut(u32, [f64; 2]),
    ) {
        let (_, n) = self.axis(spring, positions);
        match self.place(spring) {
            Place::Pair(&[a, b]) => {
                visit(a, n.map(|n| -n));
                visit(b, n);
            }
            Place::Interpolated(i) => {
                for k in self.interpolated.range(i) {
                    let [alpha, beta] = self.interpolated.shares[k];
                    visit(self.interpolated.nodes[k], n.map(|n| (beta - alpha) * n));
                }
            }
        }
    }

    fn place(&self, spring: usize) -> Place<'_> {
        match self.pairs.get(spring) {
            Some(pair) => Place::Pair(pair),
            None => Place::Interpolated(spring - self.pairs.len()),
        }
    }
}

enum Place<'a> {
    Pair(&'a [u32; 2]),
    Interpolated(usize),
}

impl Interpolated {
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

    /// Node 1 is the end of a pair, and what both ends of an interpolated spring depend on.
    fn springs() -> Springs {
        let mut springs = Springs::of_pairs(vec![[0, 1]], vec![2.0]);
        springs.push_interpolated(
            [[0.2, 0.2], [0.5, 0.4]],
            [&[(2, 0.25), (1, 0.75)], &[(1, 0.5), (0, 0.25), (1, 0.25)]],
            3.0,
        );
        springs
    }

    const POSITIONS: [[f64; 2]; 3] = [[0.1, 0.2], [0.4, 0.6], [0.9, 0.1]];

    #[test]
    fn stretch_under_uniform_strain_is_n_epsilon_n() {
        let (xx, yy, xy) = (1e-3, -2e-3, 0.5e-3);
        let u = POSITIONS.map(|[x, y]| [xx * x + xy * y, xy * x + yy * y]);
        let springs = Springs::of_pairs(vec![[0, 1]], vec![1.0]);
        let (length, n) = springs.axis(0, &POSITIONS);
        let expected = xx * n[0] * n[0] + yy * n[1] * n[1] + 2.0 * xy * n[0] * n[1];
        assert!((length - 0.5).abs() < 1e-16);
        // Differences of displacements of 1e-3 over a length of 0.5.
        assert!((springs.stretch(0, &POSITIONS, &u) - expected).abs() < 1e-17);
    }

    #[test]
    fn the_terms_are_the_elongation() {
        let springs = springs();
        let u = [[0.3, -0.2], [0.5, 0.7], [-0.4, 0.1]];
        for s in 0..2 {
            let mut sum = 0.0;
            let mut seen = Vec::new();
            springs.for_each_term(s, &POSITIONS, |node, w| {
                let u = u[node as usize];
                sum += w[0] * u[0] + w[1] * u[1];
                seen.push(node);
            });
            let elongation = springs.stretch(s, &POSITIONS, &u) * springs.length(s, &POSITIONS);
            assert!((sum - elongation).abs() < 1e-15, "{s}: {sum} {elongation}");
            assert_eq!(seen, springs.nodes(s), "each node once");
        }
        let [ua, ub] = springs.end_displacements(1, &u);
        assert!((ua[0] - (0.75 * 0.5 - 0.25 * 0.4)).abs() < 1e-16);
        assert!((ub[1] - (0.75 * 0.7 - 0.25 * 0.2)).abs() < 1e-16);
    }

    #[test]
    fn pairs_come_first_whatever_the_order_of_adding() {
        let mut all = springs();
        all.push([1, 2], 5.0);
        all.append(springs());
        assert_eq!(all.pairs(), [[0, 1], [1, 2], [0, 1]]);
        assert_eq!(all.stiffness, [2.0, 5.0, 2.0, 3.0, 3.0]);
        for s in [3, 4] {
            assert_eq!(all.nodes(s), [0, 1, 2]);
            assert_eq!(all.segment(s, &POSITIONS), [[0.2, 0.2], [0.5, 0.4]]);
        }
        assert_eq!(all.segment(1, &POSITIONS), [POSITIONS[1], POSITIONS[2]]);
        let mut fewer = all.clone();
        fewer.retain_pairs(|pair| pair != [1, 2]);
        assert_eq!(fewer.pairs(), [[0, 1], [0, 1]]);
        assert_eq!(fewer.stiffness, [2.0, 2.0, 3.0, 3.0]);
        assert_eq!(fewer.nodes(2), [0, 1, 2]);
    }
}
