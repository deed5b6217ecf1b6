//! One stiffness matrix from elements, bonds and trusses: K = Σ C_eᵀ k C_e,
//! Qian et al. (2021), eq. (12), on a pattern that is fixed once.
//!
//! The columns are shared out in a fixed number of parts. In each, columns are gathered from what touches
//! their node, in a fixed order: the bits do not depend on the number of threads. Dof = 2 · node + axis.

pub mod full;
pub mod stiffness;

use crate::springs::Springs;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef};
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Lower triangle of a symmetric matrix, columns sorted; all matrices of one pattern share it.
#[derive(Clone, Debug)]
pub struct LowerMatrix {
    symbolic: Arc<SymbolicSparseColMat<u32>>,
    values: Arc<Vec<f64>>,
}

impl LowerMatrix {
    /// `values`: in the order of the pattern's rows.
    pub fn new(symbolic: Arc<SymbolicSparseColMat<u32>>, values: Vec<f64>) -> LowerMatrix {
        assert_eq!(symbolic.row_idx().len(), values.len());
        LowerMatrix {
            symbolic,
            values: Arc::new(values),
        }
    }

    pub fn ncols(&self) -> usize {
        self.symbolic.ncols()
    }

    pub fn as_ref(&self) -> SparseColMatRef<'_, u32, f64> {
        SparseColMatRef::new(SymbolicSparseColMat::as_ref(&self.symbolic), &self.values)
    }

    pub fn row_idx_of_col_raw(&self, column: usize) -> &[u32] {
        self.symbolic.row_idx_of_col_raw(column)
    }

    /// All stored values.
    pub fn val(&self) -> &[f64] {
        &self.values
    }

    pub fn val_of_col(&self, column: usize) -> &[f64] {
        &self.values[self.symbolic.col_range(column)]
    }

    /// The pattern, and the values to change.
    pub fn parts_mut(&mut self) -> (SymbolicSparseColMatRef<'_, u32>, &mut [f64]) {
        (
            SymbolicSparseColMat::as_ref(&self.symbolic),
            Arc::<Vec<f64>>::make_mut(&mut self.values),
        )
    }

    /// The matrix, the part above the diagonal included, times u. What a part of the columns adds is
    /// summed apart: the bits do not depend on the number of threads.
    pub fn multiply(&self, u: &[f64]) -> Vec<f64> {
        let of_part = |columns: Range<usize>| {
            let first = columns.start;
            let mut product = vec![0.0; self.last_row(&columns) - first];
            for column in columns {
                let rows = self.row_idx_of_col_raw(column).iter();
                let mut entries = rows.zip(self.val_of_col(column));
                // The lower triangle's columns start at their diagonal.
                let diagonal = entries.next().map_or(0.0, |(_, &value)| value);
                let mut sum = diagonal * u[column];
                for (&row, &value) in entries {
                    let row = row as usize;
                    sum += value * u[row];
                    product[row - first] += value * u[column];
                }
                product[column - first] += sum;
            }
            (first, product)
        };
        let parts: Vec<(usize, Vec<f64>)> = column_parts(self.ncols()).map(of_part).collect();
        let mut product = vec![0.0; u.len()];
        for (first, part) in parts {
            let rows = product[first..].iter_mut().zip(part);
            rows.for_each(|(sum, share)| *sum += share);
        }
        product
    }

    /// One past the last row in some columns; no less than one past the last of them.
    fn last_row(&self, columns: &Range<usize>) -> usize {
        // The rows of a column are sorted.
        let last = |column| self.row_idx_of_col_raw(column).last();
        let last = columns.clone().filter_map(last).max();
        last.map_or(0, |&row| row as usize + 1).max(columns.end)
    }

    /// The entry at (i, j) with i ≥ j, if it is stored.
    pub fn get(&self, i: usize, j: usize) -> Option<&f64> {
        let place = self.row_idx_of_col_raw(j).binary_search(&(i as u32));
        place.ok().map(|place| &self.val_of_col(j)[place])
    }
}

/// Columns are shared out in this many parts, whatever the number of threads.
const PARTS: usize = 8;

/// Parts of `count` columns.
fn column_parts(count: usize) -> impl IndexedParallelIterator<Item = Range<usize>> {
    (0..PARTS)
        .into_par_iter()
        .map(move |part| part_bound(part, count)..part_bound(part + 1, count))
}

fn part_bound(part: usize, count: usize) -> usize {
    part * count / PARTS
}

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

    /// The list of each item in turn, from `list`, which fills an empty one; on all threads.
    fn gather(items: usize, list: impl Fn(usize, &mut Vec<u32>) + Sync) -> Lists {
        const BLOCK: usize = 1 << 12;
        let of_block = |block: usize| {
            let (mut lengths, mut entries, mut own) = (Vec::new(), Vec::new(), Vec::new());
            for item in block * BLOCK..items.min((block + 1) * BLOCK) {
                own.clear();
                list(item, &mut own);
                lengths.push(own.len());
                entries.extend_from_slice(&own);
            }
            (lengths, entries)
        };
        let blocks = (0..items.div_ceil(BLOCK)).into_par_iter();
        let blocks: Vec<(Vec<usize>, Vec<u32>)> = blocks.map(of_block).collect();
        let total = blocks.iter().map(|(_, entries)| entries.len()).sum();
        let mut all = Lists {
            start: Vec::with_capacity(items + 1),
            entries: Vec::with_capacity(total),
        };
        all.start.push(0);
        let mut next = 0;
        for (lengths, entries) in blocks {
            all.start.extend(lengths.into_iter().map(|length| {
                next += length;
                next
            }));
            all.entries.extend(entries);
        }
        all
    }

    /// Sorts each list and drops repetitions.
    pub fn into_sets(mut self) -> Lists {
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
    /// Springs between two nodes, at the lower one.
    pairs_at: Lists,
    /// All other springs, at each of their nodes.
    others_at: Lists,
    elements_at: Lists,
    symbolic: Arc<SymbolicSparseColMat<u32>>,
}

impl Pattern {
    /// Springs without stiffness (bonds of exactly δ under a kernel that fades to zero) take no place.
    pub fn new(nodes: usize, springs: &Springs, elements: &[ElementStiffness]) -> Pattern {
        let pairs = || {
            let all = (0u32..).zip(springs.pairs());
            let stiff = all.filter(|&(s, _)| springs.stiffness[s as usize] != 0.0);
            stiff.map(|(s, &[a, b])| (s, a.min(b), a.max(b)))
        };
        let pairs_at = Lists::collect(nodes, || pairs().map(|(s, lower, _)| (lower, s)));
        let lower_ends = Lists::collect(nodes, || pairs().map(|(_, lower, upper)| (upper, lower)));
        let others = || {
            let others = springs.pairs().len()..springs.len();
            others.filter(|&s| springs.stiffness[s] != 0.0)
        };
        let others_at = Lists::collect(nodes, || {
            others().flat_map(|s| springs.nodes(s).iter().map(move |&node| (node, s as u32)))
        });
        let elements_at = Lists::collect(nodes, || {
            let numbered = elements.iter().enumerate();
            numbered.flat_map(|(e, element)| element.nodes.iter().map(move |&n| (n, e as u32)))
        });
        let graph = Lists::gather(nodes, |node, neighbours| {
            neighbours.extend(lower_ends.of(node));
            let upper_ends = pairs_at.of(node).iter().map(|&s| {
                let [a, b] = springs.pairs()[s as usize];
                a.max(b)
            });
            neighbours.extend(upper_ends);
            for &s in others_at.of(node) {
                neighbours.extend(springs.nodes(s as usize));
            }
            for &e in elements_at.of(node) {
                neighbours.extend(&elements[e as usize].nodes);
            }
            // The other ends of bonds are sorted already, the node itself left out.
            neighbours.retain(|&other| other as usize != node);
            neighbours.sort_unstable();
            neighbours.dedup();
        });
        let symbolic = Arc::new(lower_pattern(&graph));
        Pattern {
            graph,
            pairs_at,
            others_at,
            elements_at,
            symbolic,
        }
    }

    pub fn nodes(&self) -> usize {
        self.graph.len()
    }

    /// Where the entries of the lower triangle are.
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
        springs: &Springs,
        elements: &[ElementStiffness],
    ) -> LowerMatrix {
        self.assemble_intact(positions, springs, |_| true, elements)
    }

    /// The same with those springs alone that are intact.
    pub fn assemble_intact(
        &self,
        positions: &[[f64; 2]],
        springs: &Springs,
        is_intact: impl Fn(usize) -> bool + Sync,
        elements: &[ElementStiffness],
    ) -> LowerMatrix {
        let mut values = vec![0.0; self.stored_entries()];
        let all = (springs, positions, elements);
        let parts = self.parts_mut(&mut values).into_par_iter();
        let beyond: Vec<(usize, Vec<[f64; 3]>)> = parts
            .map(|(nodes, values)| {
                let end = nodes.end;
                (end, self.assemble_part(nodes, values, all, &is_intact))
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

    /// Brings the columns of some nodes up to the springs that are intact: the same bits as
    /// [`Pattern::assemble_intact`], if no other spring has changed than those that end at these nodes alone.
    pub fn reassemble(
        &self,
        matrix: &mut LowerMatrix,
        nodes: &[u32],
        positions: &[[f64; 2]],
        springs: &Springs,
        is_intact: impl Fn(usize) -> bool + Sync,
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
                        let pair = springs.pairs()[s as usize];
                        if is_intact(s as usize) && pair.contains(&(node as u32)) {
                            let block = pair_block(pair, springs.stiffness[s as usize], positions);
                            add_to(sum, block);
                        }
                    }
                }
            };
            from_part(part, &mut diagonal);
            let all = (springs, positions, elements);
            self.gather(&mut column, all, &is_intact, |_, block| {
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

    /// What is gathered at one node; `diagonal` gets what each spring between two nodes adds to those of
    /// both, with the higher one.
    fn gather(
        &self,
        column: &mut Column,
        (springs, positions, elements): (&Springs, &[[f64; 2]], &[ElementStiffness]),
        is_intact: &impl Fn(usize) -> bool,
        mut diagonal: impl FnMut(u32, [f64; 3]),
    ) {
        let node = column.node as usize;
        let intact = |list: &&u32| is_intact(**list as usize);
        for &s in self.pairs_at.of(node).iter().filter(intact) {
            let pair = springs.pairs()[s as usize];
            let (other, block) = column.add_pair(pair, springs.stiffness[s as usize], positions);
            diagonal(other, block);
        }
        for &s in self.others_at.of(node).iter().filter(intact) {
            column.add_spring(springs, s as usize, positions);
        }
        for &e in self.elements_at.of(node) {
            column.add_element(&elements[e as usize]);
        }
    }

    /// The columns of some nodes, springs between two nodes being read once, at the lower one. Returns
    /// what they add to the diagonals of the nodes behind: xx, xy, yy.
    fn assemble_part(
        &self,
        nodes: Range<usize>,
        mut values: &mut [f64],
        all: (&Springs, &[[f64; 2]], &[ElementStiffness]),
        is_intact: &(impl Fn(usize) -> bool + Sync),
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
            self.gather(&mut column, all, is_intact, |other, block| {
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

fn above_diagonal(graph: &Lists, node: usize) -> &[u32] {
    let neighbours = graph.of(node);
    &neighbours[neighbours.partition_point(|&n| (n as usize) < node)..]
}

/// Columns 2j and 2j + 1: the 2 × 2 block of node j, then those of its higher neighbours.
fn lower_pattern(graph: &Lists) -> SymbolicSparseColMat<u32> {
    let n = graph.len();
    let mut start = Vec::with_capacity(2 * n + 1);
    start.push(0);
    let mut next = 0;
    for node in 0..n {
        let below = 2 * above_diagonal(graph, node).len() as u32;
        for own in [2, 1] {
            next += own + below;
            start.push(next);
        }
    }
    let mut rows = vec![0; next as usize];
    let mut rest = rows.as_mut_slice();
    let columns = (0..n).map(|node| {
        let length = (start[2 * node + 2] - start[2 * node]) as usize;
        let (columns, after) = std::mem::take(&mut rest).split_at_mut(length);
        rest = after;
        columns
    });
    let columns: Vec<&mut [u32]> = columns.collect();
    let fill = |(node, rows): (usize, &mut [u32])| {
        let mut rows = rows.iter_mut();
        let mut push = |row| *rows.next().expect("rows are counted") = row;
        let diagonal = 2 * node as u32;
        for first in [diagonal, diagonal + 1] {
            (first..diagonal + 2).for_each(&mut push);
            for &neighbour in above_diagonal(graph, node) {
                push(2 * neighbour);
                push(2 * neighbour + 1);
            }
        }
    };
    let columns = columns.into_par_iter().enumerate();
    columns.with_min_len(64).for_each(fill);
    SymbolicSparseColMat::new_checked(2 * n, 2 * n, start, None, rows)
}

/// xx, xy and yy of k n⊗n.
fn pair_block([a, b]: [u32; 2], stiffness: f64, positions: &[[f64; 2]]) -> [f64; 3] {
    let [p, q] = [a, b].map(|node| positions[node as usize]);
    let [x, y] = [q[0] - p[0], q[1] - p[1]];
    let k = stiffness / (x * x + y * y);
    [k * x * x, k * x * y, k * y * y]
}

fn add_to(sum: &mut [f64; 3], block: [f64; 3]) {
    sum.iter_mut()
        .zip(block)
        .for_each(|(sum, share)| *sum += share);
}

/// The two columns of one node while they are gathered.
struct Column<'a> {
    node: u32,
    neighbours: &'a [u32],
    /// The neighbour behind the last one: bonds come in the neighbours' order.
    next: usize,
    values: &'a mut [f64],
}

impl<'a> Column<'a> {
    fn new(node: u32, neighbours: &'a [u32], values: &'a mut [f64]) -> Column<'a> {
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
    fn add_block(&mut self, other: u32, block: [[f64; 2]; 2]) {
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

    /// k n⊗n, eqs. (19) and (20), of a spring to a higher node, off the diagonal; returns that node, and
    /// what the diagonals of both get.
    fn add_pair(
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

    fn add_diagonal(&mut self, [xx, xy, yy]: [f64; 3]) {
        self.values[0] += xx;
        self.values[1] += xy;
        self.values[2 + 2 * self.neighbours.len()] += yy;
    }

    /// K = k w wᵀ.
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
