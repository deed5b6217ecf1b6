//! Conjugate gradients with a preconditioner of two levels, where the factor of K would be too large.
//!
//! ```text
//! M⁻¹ = D⁻¹ + P (Pᵀ K P)⁻¹ Pᵀ
//! ```
//!
//! D is the 2 × 2 diagonal of K, one block per node. P moves *aggregates* of nodes: two shifts, a turn and
//! a growth in all directions each; Pᵀ K P is factorised by Cholesky. Bonds reach as far as the aggregates are
//! wide, so that neither level leaves an error to the other that grows with the system: on a lattice the
//! number of iterations does not depend on its size (docs/performance.md). An additive method of Schwarz
//! (Toselli & Widlund 2005, section 3) with the coarse space of smoothed aggregation (Vaněk, Mandel &
//! Brezina 1996), unsmoothed.
//!
//! Aggregates are what K still ties together within a cell of the caller's: a crack through a cell makes
//! two of it. Where a chunk has come loose of all supports, Pᵀ K P has a pivot that vanishes, which is
//! told as Cholesky tells it.

use super::cholesky::{self, Symbolic};
use super::held::Held;
use super::ordering::{Ordering, elimination_order};
use super::{
    Backend, FactorSize, Factorisation, SolverError, SymmetricSolver, expected_factor_entries,
};
use crate::assembly::{Lists, LowerMatrix};
use faer::sparse::SymbolicSparseColMat;
use rayon::prelude::*;
use std::sync::Arc;

/// Motions of an aggregate: two shifts, a turn, a growth.
const MODES: usize = 4;

/// Modes are dropped of which supports and the other modes leave a smaller share.
const INDEPENDENT: f64 = 1e-6;

/// The residual over the load at which iterations end [-].
const RESIDUAL_GOAL: f64 = 1e-10;

/// An end for systems that are too close to singular.
const MOST_ITERATIONS: usize = 2000;

/// Sums are cut into pieces of this many terms, whatever the number of threads.
const PIECE: usize = 1 << 14;

/// Which nodes the coarse level may move as one.
#[derive(Clone, Debug)]
pub struct Coarsening {
    /// Neighbours of each node in the pattern of K.
    pub graph: Arc<Lists>,
    /// A number per node, the same for nodes that may share an aggregate.
    pub cells: Vec<u32>,
    /// x of every node [m].
    pub positions: Vec<[f64; 2]>,
}

impl SymmetricSolver for Coarsening {
    fn backend(&self) -> Backend {
        Backend::TwoLevel
    }

    /// An estimate: aggregates are taken to be connected to the eight around them, with four dofs where
    /// [`expected_factor_entries`] has two.
    fn size(&self) -> FactorSize {
        let is_first = |&(node, cell): &(usize, &u32)| node == *cell as usize;
        let aggregates = self.cells.iter().enumerate().filter(is_first).count();
        FactorSize {
            entries: (4.0 * expected_factor_entries(aggregates, 8 * aggregates)) as usize,
            ..FactorSize::default()
        }
    }

    fn factorise(
        &self,
        stiffness: &LowerMatrix,
        held: Held,
        _: &[u32],
    ) -> Result<Box<dyn Factorisation>, SolverError> {
        Ok(Box::new(TwoLevel::new(self, stiffness, held.dofs)?))
    }
}

/// K, ready to be solved with.
#[derive(Clone, Debug)]
struct TwoLevel {
    matrix: LowerMatrix,
    is_held: Vec<bool>,
    /// D⁻¹ of each node, xx, xy, yy; zero where it is held.
    smoother: Vec<[f64; 3]>,
    aggregates: Aggregates,
    coarse: cholesky::Factor,
}

/// P.
#[derive(Clone, Debug)]
struct Aggregates {
    /// The aggregate of each node.
    of: Vec<u32>,
    members: Lists,
    /// The rows of P of each node.
    motion: Vec<[[f64; MODES]; 2]>,
}

impl TwoLevel {
    /// # Errors
    /// [`SolverError::NotPositiveDefinite`], with the dof that a motion without force moves the most.
    fn new(
        coarsening: &Coarsening,
        matrix: &LowerMatrix,
        is_held: &[bool],
    ) -> Result<TwoLevel, SolverError> {
        let Coarsening {
            graph,
            cells,
            positions,
        } = coarsening;
        let blocks = Blocks { matrix, graph };
        let aggregates = Aggregates::new(&blocks, cells, positions, is_held);
        let coarse = factorise_coarse(&blocks, &aggregates)?;
        let smoother = (0..graph.len()).into_par_iter();
        let smoother = smoother.map(|node| {
            inverse(
                blocks.diagonal(node),
                [0, 1].map(|axis| is_held[2 * node + axis]),
            )
        });
        Ok(TwoLevel {
            smoother: smoother.collect(),
            matrix: matrix.clone(),
            is_held: is_held.to_vec(),
            aggregates,
            coarse,
        })
    }

    /// Overwrites `rhs` by an x with ‖K x − rhs‖₂ ≤ `goal` and no motion at held dofs. Where rounding or a
    /// singular K does not let the residual fall so far, x is the last iterate.
    fn iterate(&self, rhs: &mut [f64], goal: f64) {
        let mut residual = rhs.to_vec();
        self.clear_held(&mut residual);
        let x = rhs;
        x.fill(0.0);
        let mut z = self.precondition(&residual);
        let mut direction = z.clone();
        let mut product = dot(&residual, &z);
        for _ in 0..MOST_ITERATIONS {
            if dot(&residual, &residual).sqrt() <= goal {
                return;
            }
            let mut force = self.matrix.multiply(&direction);
            self.clear_held(&mut force);
            let energy = dot(&direction, &force);
            // Also for what is not a number.
            if !(energy > 0.0 && product > 0.0) {
                return;
            }
            let step = product / energy;
            add(x, step, &direction);
            add(&mut residual, -step, &force);
            z = self.precondition(&residual);
            let next = dot(&residual, &z);
            let share = next / product;
            product = next;
            let pieces = direction.par_chunks_mut(PIECE).zip(z.par_chunks(PIECE));
            pieces.for_each(|(direction, z)| {
                let dofs = direction.iter_mut().zip(z);
                dofs.for_each(|(d, z)| *d = z + share * *d);
            });
        }
    }

    fn clear_held(&self, force: &mut [f64]) {
        let dofs = force.iter_mut().zip(&self.is_held);
        dofs.filter(|(_, held)| **held).for_each(|(f, _)| *f = 0.0);
    }

    /// M⁻¹ r.
    fn precondition(&self, residual: &[f64]) -> Vec<f64> {
        let Aggregates {
            of,
            members,
            motion,
        } = &self.aggregates;
        let sum = |aggregate: usize| {
            let mut sum = [0.0; MODES];
            for &node in members.of(aggregate) {
                let node = node as usize;
                for (axis, row) in motion[node].iter().enumerate() {
                    let r = residual[2 * node + axis];
                    (0..MODES).for_each(|mode| sum[mode] += row[mode] * r);
                }
            }
            sum
        };
        let sums: Vec<[f64; MODES]> = (0..members.len()).into_par_iter().map(sum).collect();
        let mut coarse = sums.into_flattened();
        self.coarse.solve_in_place(&mut coarse);
        let mut z = vec![0.0; residual.len()];
        let nodes = z.par_chunks_mut(2).enumerate().with_min_len(PIECE / 2);
        nodes.for_each(|(node, z)| {
            let [xx, xy, yy] = self.smoother[node];
            let [x, y] = [residual[2 * node], residual[2 * node + 1]];
            let rigid = &coarse[MODES * of[node] as usize..][..MODES];
            let moved =
                motion[node].map(|row| row.iter().zip(rigid).map(|(p, u)| p * u).sum::<f64>());
            z[0] = xx * x + xy * y + moved[0];
            z[1] = xy * x + yy * y + moved[1];
        });
        z
    }
}

impl Factorisation for TwoLevel {
    fn solve_in_place(&self, rhs: &mut [f64], goals: &[f64]) {
        let cases = rhs.chunks_exact_mut(self.is_held.len()).zip(goals);
        cases.for_each(|(rhs, &goal)| self.iterate(rhs, goal));
    }

    fn residual_goal(&self) -> f64 {
        RESIDUAL_GOAL
    }

    fn entries(&self) -> usize {
        self.coarse.values().len()
    }

    fn gains_by_guess(&self) -> bool {
        true
    }
}

/// The 2 × 2 blocks of K.
struct Blocks<'a> {
    matrix: &'a LowerMatrix,
    graph: &'a Lists,
}

impl Blocks<'_> {
    /// xx, xy, yy of a node's own block.
    fn diagonal(&self, node: usize) -> [f64; 3] {
        let [first, second] = [0, 1].map(|axis| self.matrix.val_of_col(2 * node + axis));
        [first[0], first[1], second[0]]
    }

    /// Its higher neighbours, each with the block of its rows and the node's columns.
    fn below(&self, node: usize) -> impl Iterator<Item = (usize, [[f64; 2]; 2])> + '_ {
        let neighbours = self.graph.of(node);
        let neighbours = &neighbours[neighbours.partition_point(|&n| n as usize <= node)..];
        let first = &self.matrix.val_of_col(2 * node)[2..];
        let second = &self.matrix.val_of_col(2 * node + 1)[1..];
        let blocks = first.chunks_exact(2).zip(second.chunks_exact(2));
        let blocks = blocks.map(|(c, d)| [[c[0], d[0]], [c[1], d[1]]]);
        neighbours.iter().map(|&n| n as usize).zip(blocks)
    }
}

impl Aggregates {
    fn new(blocks: &Blocks, cells: &[u32], positions: &[[f64; 2]], is_held: &[bool]) -> Aggregates {
        let (of, count) = connected(blocks, cells);
        let numbered = || {
            (0u32..)
                .zip(&of)
                .map(|(node, &aggregate)| (aggregate, node))
        };
        let members = Lists::collect(count, numbered);
        let all = (0..count).into_par_iter();
        let all: Vec<Vec<[[f64; MODES]; 2]>> = all
            .map(|aggregate| motions(members.of(aggregate), positions, is_held))
            .collect();
        let mut motion = vec![[[0.0; MODES]; 2]; of.len()];
        for (aggregate, rows) in all.into_iter().enumerate() {
            for (&node, rows) in members.of(aggregate).iter().zip(rows) {
                motion[node as usize] = rows;
            }
        }
        Aggregates {
            of,
            members,
            motion,
        }
    }

    /// The dof that a mode of the coarse level moves the most.
    fn most_moved(&self, coarse: usize) -> usize {
        let (aggregate, mode) = (coarse / MODES, coarse % MODES);
        let nodes = self.members.of(aggregate).iter();
        let dofs = nodes.flat_map(|&node| [2 * node as usize, 2 * node as usize + 1]);
        let size = |dof: usize| self.motion[dof / 2][dof % 2][mode].abs();
        // The first of those that move alike.
        let most = dofs.reduce(|a, b| if size(b) > size(a) { b } else { a });
        most.unwrap_or(0)
    }
}

/// Numbers what K ties together within each cell, by the lowest nodes.
fn connected(blocks: &Blocks, cells: &[u32]) -> (Vec<u32>, usize) {
    let mut parent: Vec<u32> = (0..cells.len() as u32).collect();
    for node in 0..cells.len() {
        for (other, block) in blocks.below(node) {
            if cells[node] == cells[other] && block != [[0.0; 2]; 2] {
                let (a, b) = (
                    root(&mut parent, node as u32),
                    root(&mut parent, other as u32),
                );
                parent[a.max(b) as usize] = a.min(b);
            }
        }
    }
    let mut number = vec![0; cells.len()];
    let mut count = 0;
    let of = (0..cells.len()).map(|node| {
        let root = root(&mut parent, node as u32) as usize;
        if root == node {
            number[root] = count;
            count += 1;
        }
        number[root]
    });
    (of.collect(), count as usize)
}

fn root(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        parent[node as usize] = parent[parent[node as usize] as usize];
        node = parent[node as usize];
    }
    node
}

/// Two shifts, a turn and a growth of some nodes, without what is held, orthonormal; zero where they are
/// not independent.
fn motions(nodes: &[u32], positions: &[[f64; 2]], is_held: &[bool]) -> Vec<[[f64; MODES]; 2]> {
    let at = |node: u32| positions[node as usize];
    let count = nodes.len() as f64;
    let centre = [0, 1].map(|axis| nodes.iter().map(|&n| at(n)[axis]).sum::<f64>() / count);
    let arm = |node: u32| [0, 1].map(|axis| at(node)[axis] - centre[axis]);
    let size = nodes.iter().map(|&n| arm(n)[0].hypot(arm(n)[1]));
    let size = size.fold(f64::MIN_POSITIVE, f64::max);
    let free =
        |node: u32| [0, 1].map(|axis| f64::from(u8::from(!is_held[2 * node as usize + axis])));
    let rows = nodes.iter().map(|&node| {
        let ([x, y], [fx, fy]) = (arm(node).map(|a| a / size), free(node));
        [[fx, 0.0, -y * fx, x * fx], [0.0, fy, x * fy, y * fy]]
    });
    let mut rows: Vec<[[f64; MODES]; 2]> = rows.collect();
    let product = |rows: &[[[f64; MODES]; 2]], a: usize, b: usize| -> f64 {
        rows.iter().flatten().map(|row| row[a] * row[b]).sum()
    };
    for mode in 0..MODES {
        let whole = count.sqrt();
        for earlier in 0..mode {
            let share = product(&rows, earlier, mode);
            let all = rows.iter_mut().flatten();
            all.for_each(|row| row[mode] -= share * row[earlier]);
        }
        let left = product(&rows, mode, mode).sqrt();
        let scale = if left > INDEPENDENT * whole {
            1.0 / left
        } else {
            0.0
        };
        rows.iter_mut().flatten().for_each(|row| row[mode] *= scale);
    }
    rows
}

type Block = [[f64; MODES]; MODES];

/// L of Pᵀ K P.
fn factorise_coarse(
    blocks: &Blocks,
    aggregates: &Aggregates,
) -> Result<cholesky::Factor, SolverError> {
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
    // Two dofs to a node: an aggregate is two of them.
    let order: Vec<u32> = order.iter().flat_map(|&a| [2 * a, 2 * a + 1]).collect();
    let symbolic = Symbolic::with_order(matrix.as_ref().symbolic(), &order);
    symbolic.factorise(&matrix).map_err(|error| match error {
        SolverError::NotPositiveDefinite { dof } => SolverError::NotPositiveDefinite {
            dof: aggregates.most_moved(dof),
        },
        error => error,
    })
}

/// What the stored blocks of an aggregate's nodes add to the blocks of Pᵀ K P in its columns; those with
/// lower rows are above the diagonal.
fn coarse_columns(blocks: &Blocks, aggregates: &Aggregates, aggregate: usize) -> Vec<(u32, Block)> {
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

/// The inverse of a node's block on what is not held.
fn inverse([xx, xy, yy]: [f64; 3], is_held: [bool; 2]) -> [f64; 3] {
    let over = |x: f64| if x > 0.0 { 1.0 / x } else { 0.0 };
    let determinant = xx * yy - xy * xy;
    match is_held {
        [true, true] => [0.0; 3],
        [false, true] => [over(xx), 0.0, 0.0],
        [true, false] => [0.0, 0.0, over(yy)],
        // A point whose bonds are parallel has a singular block.
        [false, false] if determinant > f64::EPSILON * xx * yy => {
            [yy, -xy, xx].map(|x| x / determinant)
        }
        [false, false] => [over(xx + yy), 0.0, over(xx + yy)],
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let pieces = a.par_chunks(PIECE).zip(b.par_chunks(PIECE));
    let sums = pieces.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>());
    // Collected, so that the pieces are summed in their order.
    sums.collect::<Vec<f64>>().into_iter().sum()
}

/// x + factor y, in x.
fn add(x: &mut [f64], factor: f64, y: &[f64]) {
    let pieces = x.par_chunks_mut(PIECE).zip(y.par_chunks(PIECE));
    pieces.for_each(|(x, y)| x.iter_mut().zip(y).for_each(|(x, y)| *x += factor * y));
}
