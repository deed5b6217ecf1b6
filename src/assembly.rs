//! One stiffness matrix from elements, bonds and trusses: K = Σ C_eᵀ k C_e,
//! Qian et al. (2021), eq. (12), on a pattern that is fixed once.
//!
//! Every column is gathered by one thread from what touches its node, in a fixed order: the bits do
//! not depend on the number of threads. Dof = 2 · node + axis.

pub mod full;
pub mod stiffness;

use crate::springs::Springs;
use faer::sparse::{SparseColMat, SymbolicSparseColMat, SymbolicSparseColMatRef};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Lower triangle of a symmetric matrix.
pub type LowerMatrix = SparseColMat<u32, f64>;

/// Mean of the diagonal: the scale of a stiffness matrix.
pub fn mean_diagonal(matrix: &LowerMatrix) -> f64 {
    let n = matrix.ncols();
    // The lower triangle's columns start at their diagonal.
    (0..n).map(|j| matrix.val_of_col(j)[0]).sum::<f64>() / n as f64
}

/// An element's nodes and its stiffness [N/m], two rows per node.
#[derive(Clone, Debug)]
pub struct ElementStiffness {
    pub nodes: Vec<u32>,
    pub matrix: DMatrix<f64>,
}

/// Compressed lists: what belongs to item i is `entries[start[i]..start[i + 1]]`.
#[derive(Clone, Debug, Default)]
pub struct Lists {
    start: Vec<usize>,
    entries: Vec<u32>,
}

impl Lists {
    /// Counting sort of (item, entry) pairs; entries keep their order.
    pub fn collect<I: Iterator<Item = (u32, u32)>>(items: usize, pairs: impl Fn() -> I) -> Lists {
        let mut start = vec![0; items + 1];
        pairs().for_each(|(item, _)| start[item as usize + 1] += 1);
        for i in 0..items {
            start[i + 1] += start[i];
        }
        let mut next = start.clone();
        let mut entries = vec![0; start[items]];
        for (item, entry) in pairs() {
            entries[next[item as usize]] = entry;
            next[item as usize] += 1;
        }
        Lists { start, entries }
    }

    /// Sorts each list and drops repetitions.
    fn into_sets(mut self) -> Lists {
        let mut kept = 0;
        for i in 0..self.len() {
            let range = self.start[i]..self.start[i + 1];
            self.entries[range.clone()].sort_unstable();
            let begin = kept;
            for k in range {
                let entry = self.entries[k];
                if kept == begin || self.entries[kept - 1] != entry {
                    self.entries[kept] = entry;
                    kept += 1;
                }
            }
            self.start[i] = begin;
        }
        let last = self.len();
        self.start[last] = kept;
        self.entries.truncate(kept);
        self
    }

    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub fn of(&self, item: usize) -> &[u32] {
        &self.entries[self.start[item]..self.start[item + 1]]
    }

    /// Offsets and entries, as METIS and other graph libraries want them.
    pub fn parts(&self) -> (&[usize], &[u32]) {
        (&self.start, &self.entries)
    }
}

/// Who shares stiffness with whom, and where K's entries are.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// Neighbours of each node, ascending, itself left out.
    pub graph: Lists,
    springs_at: Lists,
    elements_at: Lists,
    symbolic: SymbolicSparseColMat<u32>,
}

impl Pattern {
    /// Springs without stiffness (bonds of exactly δ under a kernel that fades to zero) take no place.
    pub fn new(nodes: usize, springs: &Springs, elements: &[ElementStiffness]) -> Pattern {
        let stiff = || {
            let all = (0..springs.len()).filter(|&s| springs.stiffness[s] != 0.0);
            all.map(|s| (s as u32, springs.nodes(s)))
        };
        let springs_at = Lists::collect(nodes, || {
            stiff().flat_map(|(s, nodes)| nodes.iter().map(move |&node| (node, s)))
        });
        let elements_at = Lists::collect(nodes, || {
            let numbered = elements.iter().enumerate();
            numbered.flat_map(|(e, element)| element.nodes.iter().map(move |&n| (n, e as u32)))
        });
        let graph = Lists::collect(nodes, || {
            let by_spring = stiff().flat_map(|(_, nodes)| pairs(nodes));
            by_spring.chain(elements.iter().flat_map(|element| pairs(&element.nodes)))
        })
        .into_sets();
        let symbolic = lower_pattern(&graph);
        Pattern {
            graph,
            springs_at,
            elements_at,
            symbolic,
        }
    }

    pub fn nodes(&self) -> usize {
        self.graph.len()
    }

    /// Where the entries of the lower triangle are.
    pub fn symbolic(&self) -> SymbolicSparseColMatRef<'_, u32> {
        self.symbolic.as_ref()
    }

    /// Stored entries of the lower triangle.
    pub fn stored_entries(&self) -> usize {
        self.symbolic.row_idx().len()
    }

    /// Indices of the springs with stiffness that act on a node.
    pub fn springs_at(&self, node: usize) -> &[u32] {
        self.springs_at.of(node)
    }

    /// The lower triangle of K [N/m].
    pub fn assemble(
        &self,
        positions: &[[f64; 2]],
        springs: &Springs,
        elements: &[ElementStiffness],
    ) -> LowerMatrix {
        let mut values = vec![0.0; self.stored_entries()];
        self.columns_mut(&mut values)
            .into_par_iter()
            .enumerate()
            .with_min_len(64)
            .for_each(|(node, values)| {
                let mut column = Column::new(node as u32, self.upper_neighbours(node), values);
                for &s in self.springs_at.of(node) {
                    column.add_spring(springs, s as usize, positions);
                }
                for &e in self.elements_at.of(node) {
                    column.add_element(&elements[e as usize]);
                }
            });
        LowerMatrix::new(self.symbolic.clone(), values)
    }

    fn upper_neighbours(&self, node: usize) -> &[u32] {
        above_diagonal(&self.graph, node)
    }

    /// The two columns of each node as one slice.
    fn columns_mut<'a>(&self, mut values: &'a mut [f64]) -> Vec<&'a mut [f64]> {
        (0..self.nodes())
            .map(|node| {
                let length = 3 + 4 * self.upper_neighbours(node).len();
                let (column, rest) = std::mem::take(&mut values).split_at_mut(length);
                values = rest;
                column
            })
            .collect()
    }
}

/// All ordered pairs of different nodes.
fn pairs(nodes: &[u32]) -> impl Iterator<Item = (u32, u32)> + '_ {
    nodes
        .iter()
        .flat_map(move |&a| nodes.iter().filter(move |&&b| b != a).map(move |&b| (a, b)))
}

fn above_diagonal(graph: &Lists, node: usize) -> &[u32] {
    let neighbours = graph.of(node);
    &neighbours[neighbours.partition_point(|&n| (n as usize) < node)..]
}

/// Columns 2j and 2j + 1: the 2 × 2 block of node j, then those of its higher neighbours.
fn lower_pattern(graph: &Lists) -> SymbolicSparseColMat<u32> {
    let n = graph.len();
    let mut start = Vec::with_capacity(2 * n + 1);
    let mut rows: Vec<u32> = Vec::new();
    start.push(0);
    for node in 0..n {
        let diagonal = 2 * node as u32;
        for first in [diagonal, diagonal + 1] {
            rows.extend(first..diagonal + 2);
            for &neighbour in above_diagonal(graph, node) {
                rows.extend([2 * neighbour, 2 * neighbour + 1]);
            }
            start.push(rows.len() as u32);
        }
    }
    SymbolicSparseColMat::new_checked(2 * n, 2 * n, start, None, rows)
}

/// The two columns of one node while they are gathered.
struct Column<'a> {
    node: u32,
    neighbours: &'a [u32],
    values: &'a mut [f64],
}

impl<'a> Column<'a> {
    fn new(node: u32, neighbours: &'a [u32], values: &'a mut [f64]) -> Column<'a> {
        Column {
            node,
            neighbours,
            values,
        }
    }

    /// Adds the 2 × 2 block (row node `other`, column this node); blocks above the diagonal are
    /// the other node's to store.
    fn add_block(&mut self, other: u32, block: [[f64; 2]; 2]) {
        let second = 2 + 2 * self.neighbours.len();
        if other == self.node {
            self.values[0] += block[0][0];
            self.values[1] += block[1][0];
            self.values[second] += block[1][1];
        } else if other > self.node {
            let place = self
                .neighbours
                .binary_search(&other)
                .expect("the pattern holds every pair");
            for (axis, [first_column, second_column]) in block.into_iter().enumerate() {
                self.values[2 + 2 * place + axis] += first_column;
                self.values[second + 1 + 2 * place + axis] += second_column;
            }
        }
    }

    /// K = k w wᵀ; k n⊗n between two nodes, eqs. (19) and (20).
    fn add_spring(&mut self, springs: &Springs, spring: usize, positions: &[[f64; 2]]) {
        let mut own = [0.0; 2];
        springs.for_each_term(spring, positions, |node, w| {
            if node == self.node {
                own = w;
            }
        });
        let stiffness = springs.stiffness[spring];
        springs.for_each_term(spring, positions, |node, w| {
            self.add_block(
                node,
                w.map(|row| own.map(|column| stiffness * row * column)),
            );
        });
    }

    fn add_element(&mut self, element: &ElementStiffness) {
        let own = element.nodes.iter().position(|&n| n == self.node);
        let own = 2 * own.expect("an element is listed at its own nodes only");
        for (b, &other) in element.nodes.iter().enumerate() {
            let block = [0, 1].map(|row| [0, 1].map(|c| element.matrix[(2 * b + row, own + c)]));
            self.add_block(other, block);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    #[test]
    fn gathered_matrix_equals_the_sum_of_dense_contributions() {
        let positions = [[0.0, 0.0], [1.0, 0.2], [0.3, 1.0], [1.2, 1.1]];
        let mut springs = Springs::of_pairs(
            vec![[0, 1], [2, 1], [3, 0], [1, 3]],
            vec![2.0, 3.0, 5.0, 0.0],
        );
        springs.push_interpolated(
            [[0.1, 0.1], [0.9, 0.4]],
            [&[(0, 0.7), (3, 0.3)], &[(2, 0.6), (3, 0.4)]],
            7.0,
        );
        let matrix = DMatrix::from_fn(6, 6, |i, j| ((i + 1) * (j + 1)) as f64);
        let elements = [ElementStiffness {
            nodes: vec![2, 0, 3],
            matrix,
        }];
        let mut dense = DMatrix::<f64>::zeros(8, 8);
        for s in 0..springs.len() {
            let mut w = DVector::<f64>::zeros(8);
            springs.for_each_term(s, &positions, |node, [x, y]| {
                w[2 * node as usize] += x;
                w[2 * node as usize + 1] += y;
            });
            dense += springs.stiffness[s] * &w * w.transpose();
        }
        for (a, &p) in elements[0].nodes.iter().enumerate() {
            for (b, &q) in elements[0].nodes.iter().enumerate() {
                for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    dense[(2 * p as usize + i, 2 * q as usize + j)] +=
                        elements[0].matrix[(2 * a + i, 2 * b + j)];
                }
            }
        }
        let pattern = Pattern::new(4, &springs, &elements);
        let sparse = pattern.assemble(&positions, &springs, &elements);
        assert_eq!(
            pattern.graph.of(1),
            [0, 2],
            "the spring without stiffness takes no place"
        );
        for j in 0..8 {
            for i in j..8 {
                let value = sparse.get(i, j).copied().unwrap_or(0.0);
                assert!((value - dense[(i, j)]).abs() < 1e-14, "({i}, {j})");
            }
        }
    }
}
