//! Storage of clipped bonds, whose ends are interpolated from nodes.

use std::ops::Range;

/// Clipped bonds; the i-th one has the entries `start[i]..start[i + 1]` of `nodes` and `shares`.
#[derive(Clone, Debug, PartialEq)]
pub struct ClippedBonds {
    start: Vec<usize>,
    /// Nodes of each clipped bond, ascending, each once.
    nodes: Vec<u32>,
    /// Shares α and β of each node [-].
    shares: Vec<[f64; 2]>,
    /// Ends x_A and x_B of each clipped bond [m].
    pub segments: Vec<[[f64; 2]; 2]>,
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

impl ClippedBonds {
    /// Adds a clipped bond; `ends`: nodes and shares of either end, a node may come more than once.
    pub fn push(&mut self, segment: [[f64; 2]; 2], ends: [&[(u32, f64)]; 2]) {
        let first = self.nodes.len();
        let mut terms: Vec<(u32, usize, f64)> = Vec::new();
        for (end, shares) in ends.into_iter().enumerate() {
            terms.extend(shares.iter().map(|&(node, share)| (node, end, share)));
        }
        terms.sort_by_key(|&(node, end, _)| (node, end));
        for (node, end, share) in terms {
            if self.nodes[first..].last() != Some(&node) {
                self.nodes.push(node);
                self.shares.push([0.0; 2]);
            }
            self.shares.last_mut().expect("just pushed")[end] += share;
        }
        self.start.push(self.nodes.len());
        self.segments.push(segment);
    }

    pub fn append(&mut self, more: &mut ClippedBonds) {
        let offset = self.nodes.len();
        let starts = more.start[1..].iter().map(|&start| offset + start);
        self.start.extend(starts);
        self.nodes.append(&mut more.nodes);
        self.shares.append(&mut more.shares);
        self.segments.append(&mut more.segments);
    }

    fn range(&self, i: usize) -> Range<usize> {
        self.start[i]..self.start[i + 1]
    }

    pub fn nodes(&self, i: usize) -> &[u32] {
        &self.nodes[self.range(i)]
    }

    /// Nodes of a clipped bond with their shares α and β [-].
    pub fn shares(&self, i: usize) -> impl Iterator<Item = (u32, [f64; 2])> + '_ {
        self.range(i).map(|k| (self.nodes[k], self.shares[k]))
    }

    /// Displacements of A and B [m].
    pub fn end_displacements(&self, i: usize, displacement: &[[f64; 2]]) -> [[f64; 2]; 2] {
        let mut ends = [[0.0; 2]; 2];
        for (node, shares) in self.shares(i) {
            let u = displacement[node as usize];
            for (end, share) in ends.iter_mut().zip(shares) {
                end[0] += share * u[0];
                end[1] += share * u[1];
            }
        }
        ends
    }
}
