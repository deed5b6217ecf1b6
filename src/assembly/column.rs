//! The two columns of K that belong to a node, gathered from its interactions and elements.

use super::ElementStiffness;
use crate::interactions::Interactions;

/// xx, xy and yy of k n⊗n.
pub fn pair_block([a, b]: [u32; 2], stiffness: f64, positions: &[[f64; 2]]) -> [f64; 3] {
    let [p, q] = [a, b].map(|node| positions[node as usize]);
    let [x, y] = [q[0] - p[0], q[1] - p[1]];
    let k = stiffness / (x * x + y * y);
    [k * x * x, k * x * y, k * y * y]
}

pub fn add_to(sum: &mut [f64; 3], block: [f64; 3]) {
    sum.iter_mut()
        .zip(block)
        .for_each(|(sum, share)| *sum += share);
}

/// The two columns of one node while they are gathered.
pub struct Column<'a> {
    pub node: u32,
    neighbours: &'a [u32],
    /// The neighbour behind the last one: bonds come in the neighbours' order.
    next: usize,
    values: &'a mut [f64],
}

impl<'a> Column<'a> {
    pub fn new(node: u32, neighbours: &'a [u32], values: &'a mut [f64]) -> Column<'a> {
        Column {
            node,
            neighbours,
            next: 0,
            values,
        }
    }

    fn place(&mut self, other: u32) -> usize {
        let place = if self.neighbours.get(self.next) == Some(&other) {
            self.next
        } else {
            let place = self.neighbours.binary_search(&other);
            place.expect("the pattern holds every pair")
        };
        self.next = place + 1;
        place
    }

    /// Adds the 2 × 2 block (row node `other`, column this node); blocks above the diagonal are
    /// the other node's to store.
    pub fn add_block(&mut self, other: u32, block: [[f64; 2]; 2]) {
        let second = 2 + 2 * self.neighbours.len();
        if other == self.node {
            self.values[0] += block[0][0];
            self.values[1] += block[1][0];
            self.values[second] += block[1][1];
        } else if other > self.node {
            let place = self.place(other);
            for (axis, [first_column, second_column]) in block.into_iter().enumerate() {
                self.values[2 + 2 * place + axis] += first_column;
                self.values[second + 1 + 2 * place + axis] += second_column;
            }
        }
    }

    /// k n⊗n, eqs. (19) and (20), of an interaction to a higher node, off the diagonal; returns that node, and
    /// what the diagonals of both get.
    pub fn add_pair(
        &mut self,
        [a, b]: [u32; 2],
        stiffness: f64,
        positions: &[[f64; 2]],
    ) -> (u32, [f64; 3]) {
        let other = a.max(b);
        let block @ [xx, xy, yy] = pair_block([a, b], stiffness, positions);
        let second = 2 + 2 * self.neighbours.len();
        let place = self.place(other);
        let (first, second) = self.values.split_at_mut(second);
        first[2 + 2 * place] -= xx;
        first[3 + 2 * place] -= xy;
        second[1 + 2 * place] -= xy;
        second[2 + 2 * place] -= yy;
        (other, block)
    }

    pub fn add_diagonal(&mut self, [xx, xy, yy]: [f64; 3]) {
        self.values[0] += xx;
        self.values[1] += xy;
        self.values[2 + 2 * self.neighbours.len()] += yy;
    }

    /// K = φ k w wᵀ.
    pub fn add_interaction(
        &mut self,
        interactions: &Interactions,
        interaction: usize,
        integrity: f64,
        positions: &[[f64; 2]],
    ) {
        let mut own = [0.0; 2];
        interactions.for_each_term(interaction, positions, |node, w| {
            if node == self.node {
                own = w;
            }
        });
        let stiffness = integrity * interactions.stiffness[interaction];
        interactions.for_each_term(interaction, positions, |node, w| {
            self.add_block(
                node,
                w.map(|row| own.map(|column| stiffness * row * column)),
            );
        });
    }

    pub fn add_element(&mut self, element: &ElementStiffness) {
        let own = element.nodes.iter().position(|&n| n == self.node);
        let own = 2 * own.expect("an element is listed at its own nodes only");
        for (b, &other) in element.nodes.iter().enumerate() {
            let block = [0, 1].map(|row| [0, 1].map(|c| element.matrix[(2 * b + row, own + c)]));
            self.add_block(other, block);
        }
    }
}
