//! One stiffness matrix from elements, bonds and trusses: K = Σ C_eᵀ k C_e,
//! Qian et al. (2021), eq. (12), on a pattern that is fixed once.
//!
//! The columns are shared out in a fixed number of parts. In each, columns are gathered from what touches
//! their node, in a fixed order: the bits do not depend on the number of threads. Dof = 2 · node + axis.

mod column;
mod lists;
mod lower_matrix;
mod parts;
mod turn;

pub use lists::Lists;
pub use lower_matrix::{LowerMatrix, lower_pattern};

use crate::interactions::Interactions;
use column::{Column, add_to, pair_block};
use faer::sparse::{SymbolicSparseColMat, SymbolicSparseColMatRef};
use lower_matrix::above_diagonal;
use nalgebra::DMatrix;
use parts::{PARTS, column_parts, part_bound};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Unknowns of a node: its displacements along x and y.
pub const UNKNOWNS: usize = 2;

/// An element's nodes and its stiffness [N/m], two rows per node.
#[derive(Clone, Debug)]
pub struct ElementStiffness {
    pub nodes: Vec<u32>,
    pub matrix: DMatrix<f64>,
}

/// Who shares stiffness with whom, and where K's entries are.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// Neighbours of each node, ascending, itself left out.
    pub graph: Arc<Lists>,
    /// Interactions between two nodes, at the lower one.
    pairs_at: Lists,
    /// All other interactions, at each of their nodes.
    others_at: Lists,
    elements_at: Lists,
    symbolic: Arc<SymbolicSparseColMat<u32>>,
}

impl Pattern {
    /// Interactions without stiffness (bonds of exactly δ under a kernel that fades to zero) take no place.
    pub fn new(
        nodes: usize,
        interactions: &Interactions,
        elements: &[ElementStiffness],
    ) -> Pattern {
        let pairs = || {
            let all = (0u32..).zip(interactions.pairs());
            let stiff = all.filter(|&(s, _)| interactions.stiffness[s as usize] != 0.0);
            stiff.map(|(s, &[a, b])| (s, a.min(b), a.max(b)))
        };
        let pairs_at = Lists::collect(nodes, || pairs().map(|(s, lower, _)| (lower, s)));
        let lower_ends = Lists::collect(nodes, || pairs().map(|(_, lower, upper)| (upper, lower)));
        let others = || {
            let others = interactions.pairs().len()..interactions.len();
            others.filter(|&s| interactions.stiffness[s] != 0.0)
        };
        let others_at = Lists::collect(nodes, || {
            others().flat_map(|s| {
                interactions
                    .nodes(s)
                    .iter()
                    .map(move |&node| (node, s as u32))
            })
        });
        let elements_at = Lists::collect(nodes, || {
            let numbered = elements.iter().enumerate();
            numbered.flat_map(|(e, element)| element.nodes.iter().map(move |&n| (n, e as u32)))
        });
        let graph = Lists::gather(nodes, |node, neighbours| {
            neighbours.extend(lower_ends.of(node));
            let upper_ends = pairs_at.of(node).iter().map(|&s| {
                let [a, b] = interactions.pairs()[s as usize];
                a.max(b)
            });
            neighbours.extend(upper_ends);
            for &s in others_at.of(node) {
                neighbours.extend(interactions.nodes(s as usize));
            }
            for &e in elements_at.of(node) {
                neighbours.extend(&elements[e as usize].nodes);
            }
            // The other ends of bonds are sorted already, the node itself left out.
            neighbours.retain(|&other| other as usize != node);
            neighbours.sort_unstable();
            neighbours.dedup();
        });
        let symbolic = Arc::new(lower_pattern::<UNKNOWNS>(&graph));
        Pattern {
            graph: Arc::new(graph),
            pairs_at,
            others_at,
            elements_at,
            symbolic,
        }
    }

    pub fn nodes(&self) -> usize {
        self.graph.len()
    }

    /// The places of the entries of the lower triangle.
    pub fn symbolic(&self) -> SymbolicSparseColMatRef<'_, u32> {
        SymbolicSparseColMat::as_ref(&self.symbolic)
    }

    /// Stored entries of the lower triangle.
    pub fn stored_entries(&self) -> usize {
        self.symbolic.row_idx().len()
    }

    /// The lower triangle of K [N/m].
    pub fn assemble(
        &self,
        positions: &[[f64; 2]],
        interactions: &Interactions,
        elements: &[ElementStiffness],
    ) -> LowerMatrix {
        self.assemble_with(positions, interactions, |_| 1.0, elements)
    }

    /// The lower triangle of K with the `integrity` φ of every interaction [-].
    pub fn assemble_with(
        &self,
        positions: &[[f64; 2]],
        interactions: &Interactions,
        integrity: impl Fn(usize) -> f64 + Sync,
        elements: &[ElementStiffness],
    ) -> LowerMatrix {
        let mut values = vec![0.0; self.stored_entries()];
        let all = (interactions, positions, elements);
        let parts = self.parts_mut(&mut values).into_par_iter();
        let beyond: Vec<(usize, Vec<[f64; 3]>)> = parts
            .map(|(nodes, values)| {
                let end = nodes.end;
                (end, self.assemble_part(nodes, values, all, &integrity))
            })
            .collect();
        for (first, diagonals) in beyond {
            for (node, [xx, xy, yy]) in (first..).zip(diagonals) {
                let [start, second] =
                    [0, 1].map(|axis| self.symbolic.col_range(2 * node + axis).start);
                values[start] += xx;
                values[start + 1] += xy;
                values[second] += yy;
            }
        }
        LowerMatrix::new(self.symbolic.clone(), values)
    }

    /// Brings the columns of some nodes up to the `integrity` φ of now: the same bits as
    /// [`Pattern::assemble_with`], if no other interaction has changed than those that end at these nodes alone.
    pub fn reassemble(
        &self,
        matrix: &mut LowerMatrix,
        nodes: &[u32],
        positions: &[[f64; 2]],
        interactions: &Interactions,
        integrity: impl Fn(usize) -> f64 + Sync,
        elements: &[ElementStiffness],
    ) {
        let (symbolic, values) = matrix.parts_mut();
        for &node in nodes {
            let node = node as usize;
            let columns = symbolic.col_range(2 * node).start..symbolic.col_range(2 * node + 1).end;
            let own = &mut values[columns];
            own.fill(0.0);
            let mut column = Column::new(node as u32, self.upper_neighbours(node), own);
            let part = (0..PARTS).rfind(|&part| part_bound(part, self.nodes()) <= node);
            let part = part.expect("the first part begins at the first node");
            let mut diagonal = [0.0; 3];
            let from_part = |part: usize, sum: &mut [f64; 3]| {
                let lower = self.graph.of(node).iter().map(|&other| other as usize);
                let bounds = part_bound(part, self.nodes())..part_bound(part + 1, self.nodes());
                for other in lower.filter(|other| *other < node && bounds.contains(other)) {
                    for &s in self.pairs_at.of(other) {
                        let pair = interactions.pairs()[s as usize];
                        let phi = integrity(s as usize);
                        if phi > 0.0 && pair.contains(&(node as u32)) {
                            let stiffness = phi * interactions.stiffness[s as usize];
                            let block = pair_block(pair, stiffness, positions);
                            add_to(sum, block);
                        }
                    }
                }
            };
            from_part(part, &mut diagonal);
            let all = (interactions, positions, elements);
            self.gather(&mut column, all, &integrity, |_, block| {
                add_to(&mut diagonal, block);
            });
            column.add_diagonal(diagonal);
            for earlier in 0..part {
                let mut sum = [0.0; 3];
                from_part(earlier, &mut sum);
                column.add_diagonal(sum);
            }
        }
    }

    /// Gathers the interactions and elements of one node; `diagonal` gets what each interaction between two nodes adds to those of
    /// both, with the higher one.
    fn gather(
        &self,
        column: &mut Column,
        (interactions, positions, elements): (&Interactions, &[[f64; 2]], &[ElementStiffness]),
        integrity: &impl Fn(usize) -> f64,
        mut diagonal: impl FnMut(u32, [f64; 3]),
    ) {
        let node = column.node as usize;
        let carries = |&s: &u32| {
            let phi = integrity(s as usize);
            (phi > 0.0).then_some((s as usize, phi))
        };
        for (s, phi) in self.pairs_at.of(node).iter().filter_map(carries) {
            let stiffness = phi * interactions.stiffness[s];
            let (other, block) = column.add_pair(interactions.pairs()[s], stiffness, positions);
            diagonal(other, block);
        }
        for (s, phi) in self.others_at.of(node).iter().filter_map(carries) {
            column.add_interaction(interactions, s, phi, positions);
        }
        for &e in self.elements_at.of(node) {
            column.add_element(&elements[e as usize]);
        }
    }

    /// The columns of some nodes, interactions between two nodes being read once, at the lower one. Returns
    /// what they add to the diagonals of the nodes behind: xx, xy, yy.
    fn assemble_part(
        &self,
        nodes: Range<usize>,
        mut values: &mut [f64],
        all: (&Interactions, &[[f64; 2]], &[ElementStiffness]),
        integrity: &(impl Fn(usize) -> f64 + Sync),
    ) -> Vec<[f64; 3]> {
        let first = nodes.start;
        let last = nodes.clone().filter_map(|node| self.graph.of(node).last());
        let end = last
            .max()
            .map_or(0, |&last| last as usize + 1)
            .max(nodes.end);
        let mut diagonals = vec![[0.0; 3]; end - first];
        for node in nodes.clone() {
            let neighbours = self.upper_neighbours(node);
            let (own, behind) = values.split_at_mut(3 + 4 * neighbours.len());
            values = behind;
            let mut column = Column::new(node as u32, neighbours, own);
            self.gather(&mut column, all, integrity, |other, block| {
                for end in [node, other as usize] {
                    add_to(&mut diagonals[end - first], block);
                }
            });
            // All lower nodes of this part have been here.
            column.add_diagonal(diagonals[node - first]);
        }
        diagonals.split_off(nodes.len())
    }

    fn upper_neighbours(&self, node: usize) -> &[u32] {
        above_diagonal(&self.graph, node)
    }

    /// Parts of the nodes, with their columns.
    fn parts_mut<'a>(&self, mut values: &'a mut [f64]) -> Vec<(Range<usize>, &'a mut [f64])> {
        let parts: Vec<Range<usize>> = column_parts(self.nodes()).collect();
        let start = |node: usize| self.symbolic.col_ptr()[2 * node] as usize;
        let take = |nodes: Range<usize>| {
            let length = start(nodes.end) - start(nodes.start);
            let (own, rest) = std::mem::take(&mut values).split_at_mut(length);
            values = rest;
            (nodes, own)
        };
        parts.into_iter().map(take).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    #[test]
    fn gathered_matrix_equals_the_sum_of_dense_contributions() {
        let positions = [[0.0, 0.0], [1.0, 0.2], [0.3, 1.0], [1.2, 1.1]];
        let mut interactions = Interactions::of_bonds(
            vec![[0, 1], [2, 1], [3, 0], [1, 3]],
            vec![2.0, 3.0, 5.0, 0.0],
        );
        interactions.push_clipped_bond(
            [[0.1, 0.1], [0.9, 0.4]],
            [&[(0, 0.7), (3, 0.3)], &[(2, 0.6), (3, 0.4)]],
            7.0,
        );
        interactions.push_cell(&[(0, [0.5, -2.0]), (3, [1.5, 1.0])], 1.0, 11.0);
        let matrix = DMatrix::from_fn(6, 6, |i, j| ((i + 1) * (j + 1)) as f64);
        let elements = [ElementStiffness {
            nodes: vec![2, 0, 3],
            matrix,
        }];
        let mut dense = DMatrix::<f64>::zeros(8, 8);
        for s in 0..interactions.len() {
            let mut w = DVector::<f64>::zeros(8);
            interactions.for_each_term(s, &positions, |node, [x, y]| {
                w[2 * node as usize] += x;
                w[2 * node as usize + 1] += y;
            });
            dense += interactions.stiffness[s] * &w * w.transpose();
        }
        for (a, &p) in elements[0].nodes.iter().enumerate() {
            for (b, &q) in elements[0].nodes.iter().enumerate() {
                for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    dense[(2 * p as usize + i, 2 * q as usize + j)] +=
                        elements[0].matrix[(2 * a + i, 2 * b + j)];
                }
            }
        }
        let pattern = Pattern::new(4, &interactions, &elements);
        let sparse = pattern.assemble(&positions, &interactions, &elements);
        assert_eq!(
            pattern.graph.of(1),
            [0, 2],
            "the interaction without stiffness takes no place"
        );
        for j in 0..8 {
            for i in j..8 {
                let value = sparse.get(i, j).copied().unwrap_or(0.0);
                assert!((value - dense[(i, j)]).abs() < 1e-14, "({i}, {j})");
            }
        }
    }
}
