//! Storage of functionals e = Σ w_a·u_a with any w_a, which have neither ends nor a direction.

use std::ops::Range;

/// Functionals of the displacement without ends; the i-th one has the entries `start[i]..start[i + 1]` of `nodes`
/// and `weights`.
#[derive(Clone, Debug, PartialEq)]
pub struct Functionals {
    start: Vec<usize>,
    /// Nodes of each functional, ascending, each once.
    nodes: Vec<u32>,
    /// w_a of each node [-].
    weights: Vec<[f64; 2]>,
    /// The length over which each is a strain [m].
    pub lengths: Vec<f64>,
}

impl Default for Functionals {
    fn default() -> Functionals {
        Functionals {
            start: vec![0],
            nodes: Vec::new(),
            weights: Vec::new(),
            lengths: Vec::new(),
        }
    }
}

impl Functionals {
    pub fn push(&mut self, terms: &[(u32, [f64; 2])], length: f64) {
        for &(node, w) in terms {
            self.nodes.push(node);
            self.weights.push(w);
        }
        self.start.push(self.nodes.len());
        self.lengths.push(length);
    }

    pub fn append(&mut self, more: &mut Functionals) {
        let offset = self.nodes.len();
        let starts = more.start[1..].iter().map(|&start| offset + start);
        self.start.extend(starts);
        self.nodes.append(&mut more.nodes);
        self.weights.append(&mut more.weights);
        self.lengths.append(&mut more.lengths);
    }

    fn range(&self, i: usize) -> Range<usize> {
        self.start[i]..self.start[i + 1]
    }

    pub fn nodes(&self, i: usize) -> &[u32] {
        &self.nodes[self.range(i)]
    }

    /// Nodes of a functional with their w_a [-].
    pub fn terms(&self, i: usize) -> impl Iterator<Item = (u32, [f64; 2])> + '_ {
        self.range(i).map(|k| (self.nodes[k], self.weights[k]))
    }

    /// e [m].
    pub fn value(&self, i: usize, displacement: &[[f64; 2]]) -> f64 {
        let parts = self.terms(i).map(|(node, w)| {
            let u = displacement[node as usize];
            w[0] * u[0] + w[1] * u[1]
        });
        parts.sum()
    }
}
