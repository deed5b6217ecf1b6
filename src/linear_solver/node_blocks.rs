//! The pattern of K in nodes of `B` unknowns each, which stay together in the order of elimination: what is
//! analysed has B² times fewer entries than K. Unknown = B · node + axis.

use super::supernodes::Supernodes;
use crate::assembly::Lists;
use faer::sparse::SymbolicSparseColMatRef;
use std::array::from_fn;

/// The columns of L that eliminate each node, and the places of K's blocks in the supernodes.
#[derive(Debug)]
pub struct NodeBlocks<const B: usize> {
    /// The nodes as they are eliminated.
    order: Vec<u32>,
    /// The inverse: where a node is in the order.
    position: Vec<u32>,
    /// The first block of each node's columns among all blocks, by position.
    start: Vec<usize>,
    blocks: Vec<NodeBlock<B>>,
}

/// The block of two nodes, in the lower triangle of K as reordered.
#[derive(Clone, Copy, Debug)]
pub struct NodeBlock<const B: usize> {
    /// Its first row in the supernode's block of L.
    pub row: u32,
    /// The first entry of each of the block's columns among those of K, B rows each; of a node with itself, the
    /// lower triangle.
    pub columns: [u32; B],
    /// K's columns are the rows of L.
    pub transposed: bool,
}

impl<const B: usize> NodeBlocks<B> {
    /// `order`: the nodes as the supernodes eliminate them.
    pub fn new(
        pattern: SymbolicSparseColMatRef<'_, u32>,
        order: Vec<u32>,
        supernodes: &Supernodes,
    ) -> NodeBlocks<B> {
        let n = order.len();
        let position = inverse(&order);
        let mut start = vec![0; n + 1];
        for_each_block::<B>(pattern, |a, b, _| {
            start[position[a].min(position[b]) as usize + 1] += 1;
        });
        for k in 0..n {
            start[k + 1] += start[k];
        }
        let mut next = start.clone();
        let nothing = NodeBlock {
            row: 0,
            columns: [0; B],
            transposed: false,
        };
        let mut blocks = vec![nothing; start[n]];
        for_each_block::<B>(pattern, |a, b, columns| {
            let (a, b) = (position[a], position[b]);
            let owner = a.min(b) as usize;
            blocks[next[owner]] = NodeBlock {
                row: B as u32 * a.max(b),
                columns,
                transposed: b < a,
            };
            next[owner] += 1;
        });
        let mut row_of = vec![0; B * n];
        for s in 0..supernodes.len() {
            let columns = supernodes.columns(s);
            let rows = supernodes.rows(s).iter().map(|&row| row as usize);
            let own = columns.clone().chain(rows);
            own.zip(0..).for_each(|(row, k)| row_of[row] = k);
            for block in &mut blocks[start[columns.start / B]..start[columns.end / B]] {
                block.row = row_of[block.row as usize];
            }
        }
        NodeBlocks {
            order,
            position,
            start,
            blocks,
        }
    }

    /// The unknown that a column of L eliminates.
    pub fn dof(&self, column: usize) -> usize {
        B * self.order[column / B] as usize + column % B
    }

    /// The column of L that eliminates an unknown.
    pub fn column(&self, dof: usize) -> usize {
        B * self.position[dof / B] as usize + dof % B
    }

    /// The first column of each of some nodes.
    pub fn first_columns(&self, nodes: &[u32]) -> impl Iterator<Item = usize> {
        nodes
            .iter()
            .map(|&node| B * self.position[node as usize] as usize)
    }

    /// K's blocks in the columns of a node, given by its first column.
    pub fn of_columns(&self, first: usize) -> &[NodeBlock<B>] {
        &self.blocks[self.start[first / B]..self.start[first / B + 1]]
    }
}

/// Every two nodes of the lower triangle of K, first the column's, and where the entries of the block's columns
/// begin.
fn for_each_block<const B: usize>(
    pattern: SymbolicSparseColMatRef<'_, u32>,
    mut block: impl FnMut(usize, usize, [u32; B]),
) {
    for node in 0..pattern.ncols() / B {
        let diagonal: [usize; B] = from_fn(|axis| pattern.col_range(B * node + axis).start);
        block(node, node, diagonal.map(|at| at as u32));
        for (k, other) in later_neighbours::<B>(pattern, node).enumerate() {
            // Below the diagonal's part of each column, which is a triangle.
            let columns = from_fn(|axis| (diagonal[axis] + B - axis + B * k) as u32);
            block(node, other as usize, columns);
        }
    }
}

/// Neighbours of a node with a larger number.
fn later_neighbours<const B: usize>(
    pattern: SymbolicSparseColMatRef<'_, u32>,
    node: usize,
) -> impl Iterator<Item = u32> {
    let rows = &pattern.row_idx()[pattern.col_range(B * node)];
    rows[B..].iter().step_by(B).map(|row| row / B as u32)
}

/// Neighbours that are eliminated later, by position in the order.
pub(super) fn below<const B: usize>(
    pattern: SymbolicSparseColMatRef<'_, u32>,
    position: &[u32],
) -> Lists {
    let n = position.len();
    Lists::collect(n, || {
        (0..n).flat_map(|node| {
            let a = position[node];
            later_neighbours::<B>(pattern, node).map(move |other| {
                let b = position[other as usize];
                (a.min(b), a.max(b))
            })
        })
    })
}

pub(super) fn inverse(order: &[u32]) -> Vec<u32> {
    let mut inverse = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        inverse[old as usize] = new as u32;
    }
    inverse
}
