//! Aggregates of nodes, and their motions: the columns of P.

use super::coarse::NodeBlocks;
use crate::assembly::Lists;
use crate::linear_solver::policy::INDEPENDENT_SHARE;
use rayon::prelude::*;

/// Motions of an aggregate: two shifts, a turn, a growth.
pub const MODES: usize = 4;

/// P: the motions of aggregates.
#[derive(Clone, Debug)]
pub struct Aggregates {
    /// The aggregate of each node.
    pub of: Vec<u32>,
    /// The nodes of each aggregate.
    pub members: Lists,
    /// The rows of P of each node.
    pub motion: Vec<[[f64; MODES]; 2]>,
}

impl Aggregates {
    pub fn new(
        blocks: &NodeBlocks,
        cells: &[u32],
        positions: &[[f64; 2]],
        is_held: &[bool],
    ) -> Aggregates {
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

    /// The dof that an unknown of the coarse level moves the most.
    pub fn most_moved(&self, coarse: usize) -> usize {
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
fn connected(blocks: &NodeBlocks, cells: &[u32]) -> (Vec<u32>, usize) {
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
        let scale = if left > INDEPENDENT_SHARE * whole {
            1.0 / left
        } else {
            0.0
        };
        rows.iter_mut().flatten().for_each(|row| row[mode] *= scale);
    }
    rows
}
