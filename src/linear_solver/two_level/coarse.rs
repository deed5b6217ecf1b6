//! The coarse level Pᵀ K P, and its factors.

use super::aggregates::{Aggregates, MODES};
use crate::assembly::{Lists, LowerMatrix};
use crate::linear_solver::SolverError;
use crate::linear_solver::cholesky::{self, Symbolic};
use crate::linear_solver::ordering::{Ordering, elimination_order};
use faer::sparse::SymbolicSparseColMat;
use rayon::prelude::*;

/// The 2 × 2 blocks of K.
pub struct NodeBlocks<'a> {
    pub matrix: &'a LowerMatrix,
    /// Neighbours of each node.
    pub graph: &'a Lists,
}

impl NodeBlocks<'_> {
    /// The entries xx, xy and yy of a node's own block.
    pub fn diagonal(&self, node: usize) -> [f64; 3] {
        let [first, second] = [0, 1].map(|axis| self.matrix.val_of_col(2 * node + axis));
        [first[0], first[1], second[0]]
    }

    /// The higher neighbours of a node, each with the block of its rows and the node's columns.
    pub fn below(&self, node: usize) -> impl Iterator<Item = (usize, [[f64; 2]; 2])> + '_ {
        let neighbours = self.graph.of(node);
        let neighbours = &neighbours[neighbours.partition_point(|&n| n as usize <= node)..];
        let first = &self.matrix.val_of_col(2 * node)[2..];
        let second = &self.matrix.val_of_col(2 * node + 1)[1..];
        let blocks = first.chunks_exact(2).zip(second.chunks_exact(2));
        let blocks = blocks.map(|(c, d)| [[c[0], d[0]], [c[1], d[1]]]);
        neighbours.iter().map(|&n| n as usize).zip(blocks)
    }
}

type Block = [[f64; MODES]; MODES];

/// L of Pᵀ K P.
pub fn factorise_coarse(
    blocks: &NodeBlocks,
    aggregates: &Aggregates,
) -> Result<cholesky::Factor<MODES>, SolverError> {
    let count = aggregates.members.len();
    let shares = (0..count).into_par_iter();
    let shares: Vec<Vec<(u32, Block)>> = shares
        .map(|aggregate| coarse_columns(blocks, aggregates, aggregate))
        .collect();
    let links = || {
        let of = |(a, shares): (usize, &Vec<(u32, Block)>)| {
            let others: Vec<u32> = shares.iter().map(|&(b, _)| b).collect();
            let a = a as u32;
            others
                .into_iter()
                .filter(move |&b| b != a)
                .flat_map(move |b| [(a, b), (b, a)])
        };
        shares.iter().enumerate().flat_map(of)
    };
    let graph = Lists::collect(count, links).into_sets();
    let matrix = coarse_matrix(&graph, &shares);
    let order = elimination_order(Ordering::Metis, &graph);
    let order = order.map_err(|status| SolverError::Ordering {
        nodes: count,
        status,
    })?;
    let symbolic = Symbolic::<MODES>::with_order(matrix.as_ref().symbolic(), &order);
    symbolic.factorise(&matrix).map_err(|error| match error {
        SolverError::NotPositiveDefinite { dof } => SolverError::NotPositiveDefinite {
            dof: aggregates.most_moved(dof),
        },
        error => error,
    })
}

/// The blocks that an aggregate's nodes add to Pᵀ K P in its columns; those with
/// lower rows are above the diagonal.
fn coarse_columns(
    blocks: &NodeBlocks,
    aggregates: &Aggregates,
    aggregate: usize,
) -> Vec<(u32, Block)> {
    let Aggregates {
        of,
        members,
        motion,
    } = aggregates;
    let mut columns: Vec<(u32, Block)> = vec![(aggregate as u32, Block::default())];
    for &node in members.of(aggregate) {
        let node = node as usize;
        let [xx, xy, yy] = blocks.diagonal(node);
        add_product(
            &mut columns[0].1,
            &motion[node],
            [[xx, xy], [xy, yy]],
            &motion[node],
        );
        for (other, block) in blocks.below(node) {
            let row = of[other];
            let place = columns.iter().position(|&(known, _)| known == row);
            let place = place.unwrap_or_else(|| {
                columns.push((row, Block::default()));
                columns.len() - 1
            });
            let sum = &mut columns[place].1;
            add_product(sum, &motion[other], block, &motion[node]);
            if place == 0 {
                let [[a, b], [c, d]] = block;
                add_product(sum, &motion[node], [[a, c], [b, d]], &motion[other]);
            }
        }
    }
    columns
}

/// Adds Pᵀ K Q.
fn add_product(sum: &mut Block, p: &[[f64; MODES]; 2], k: [[f64; 2]; 2], q: &[[f64; MODES]; 2]) {
    for j in 0..MODES {
        let force = k.map(|row| row[0] * q[0][j] + row[1] * q[1][j]);
        for (i, row) in sum.iter_mut().enumerate() {
            row[j] += p[0][i] * force[0] + p[1][i] * force[1];
        }
    }
}

/// Pᵀ K P. Modes that are none get a diagonal of their own.
fn coarse_matrix(graph: &Lists, shares: &[Vec<(u32, Block)>]) -> LowerMatrix {
    let find = |column: usize, row: usize| {
        let share = shares[column].iter().find(|&&(r, _)| r as usize == row);
        share.map(|&(_, block)| block)
    };
    let (mut start, mut rows, mut values) = (vec![0u32], Vec::new(), Vec::new());
    for (column, share) in shares.iter().enumerate() {
        let below = graph.of(column).iter().map(|&row| row as usize);
        let below = below.filter(|&row| row > column).map(|row| {
            let (own, other) = (find(column, row), find(row, column));
            let (own, other) = (own.unwrap_or_default(), other.unwrap_or_default());
            let block = [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| own[i][j] + other[j][i]));
            (row, block)
        });
        let below: Vec<(usize, Block)> = below.collect();
        let diagonal = share[0].1;
        for mode in 0..MODES {
            for (i, row) in diagonal.iter().enumerate().skip(mode) {
                let value = row[mode];
                rows.push((MODES * column + i) as u32);
                values.push(if i == mode && value == 0.0 {
                    1.0
                } else {
                    value
                });
            }
            for (row, block) in &below {
                for (i, of_row) in block.iter().enumerate() {
                    rows.push((MODES * row + i) as u32);
                    values.push(of_row[mode]);
                }
            }
            start.push(rows.len() as u32);
        }
    }
    let n = MODES * graph.len();
    let symbolic = SymbolicSparseColMat::new_checked(n, n, start, None, rows);
    LowerMatrix::new(symbolic.into(), values)
}
