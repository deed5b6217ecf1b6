//! Fill-reducing elimination orders of the nodes' graph; a node's two dofs stay together.

use super::metis;
use crate::assembly::Lists;
use faer::perm::Perm;

/// How to find the elimination order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ordering {
    /// Nested dissection by METIS.
    Metis,
    /// Nested dissection along the coordinate axes: each cut leaves equal halves.
    Geometric,
    /// faer's approximate minimum degree, on the dofs.
    Amd,
}

/// Parts of at most this many nodes are not cut further.
const LEAF: usize = 64;

/// The nodes in the order of their elimination, postordered along the elimination tree, or `None`
/// where the factorisation is to order the dofs itself ([`Ordering::Amd`]).
///
/// # Errors
/// METIS's status.
pub fn elimination_order(
    ordering: Ordering,
    graph: &Lists,
    positions: &[[f64; 2]],
) -> Result<Option<Vec<u32>>, i32> {
    let order = match ordering {
        Ordering::Amd => return Ok(None),
        Ordering::Metis => metis::nested_dissection(graph)?,
        Ordering::Geometric => geometric_dissection(graph, positions),
    };
    Ok(Some(postordered(graph, &order)))
}

/// The permutation of the dofs that goes with an order of the nodes.
pub fn dof_permutation(order: &[u32]) -> Perm<u32> {
    let forward: Vec<u32> = order
        .iter()
        .flat_map(|&node| [2 * node, 2 * node + 1])
        .collect();
    let mut inverse = vec![0; forward.len()];
    for (new, &old) in forward.iter().enumerate() {
        inverse[old as usize] = new as u32;
    }
    Perm::new_checked(forward.into(), inverse.into(), 2 * order.len())
}

/// Cuts the nodes at the median of their wider extent; what the first half sees of the second is
/// the separator, eliminated last (George 1973).
fn geometric_dissection(graph: &Lists, positions: &[[f64; 2]]) -> Vec<u32> {
    let mut order = Vec::with_capacity(graph.len());
    let mut side = vec![0u32; graph.len()];
    let mut nodes: Vec<u32> = (0..graph.len() as u32).collect();
    let mut cuts = 0;
    dissect(
        graph, positions, &mut nodes, &mut side, &mut cuts, &mut order,
    );
    order
}

fn dissect(
    graph: &Lists,
    positions: &[[f64; 2]],
    nodes: &mut [u32],
    side: &mut [u32],
    cuts: &mut u32,
    order: &mut Vec<u32>,
) {
    if nodes.len() <= LEAF {
        order.extend_from_slice(nodes);
        return;
    }
    let axis = wider_axis(nodes, positions);
    let coordinate = |&n: &u32| positions[n as usize][axis];
    let half = nodes.len() / 2;
    nodes.select_nth_unstable_by(half, |a, b| {
        coordinate(a).total_cmp(&coordinate(b)).then(a.cmp(b))
    });
    let (near, far) = nodes.split_at_mut(half);
    *cuts += 1;
    let mark = *cuts;
    far.iter().for_each(|&n| side[n as usize] = mark);
    let inner = partition(near, |n| {
        graph
            .of(n as usize)
            .iter()
            .all(|&m| side[m as usize] != mark)
    });
    let mut separator = near[inner..].to_vec();
    far.iter().for_each(|&n| side[n as usize] = 0);
    dissect(graph, positions, &mut near[..inner], side, cuts, order);
    dissect(graph, positions, far, side, cuts, order);
    separator.sort_unstable();
    order.extend(separator);
}

/// Moves what `keep`s to the front, and counts it.
fn partition(nodes: &mut [u32], keep: impl Fn(u32) -> bool) -> usize {
    let mut kept = 0;
    for k in 0..nodes.len() {
        if keep(nodes[k]) {
            nodes.swap(k, kept);
            kept += 1;
        }
    }
    kept
}

fn wider_axis(nodes: &[u32], positions: &[[f64; 2]]) -> usize {
    let extent = |axis: usize| {
        let along = nodes.iter().map(|&n| positions[n as usize][axis]);
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        high - low
    };
    usize::from(extent(1) > extent(0))
}

/// Reorders along the elimination tree, children before parents and each subtree in one piece:
/// the fill is the same, and supernodes become as large as they can be.
fn postordered(graph: &Lists, order: &[u32]) -> Vec<u32> {
    let parent = elimination_tree(graph, order);
    let n = order.len();
    let mut first_child = vec![usize::MAX; n + 1];
    let mut next_sibling = vec![usize::MAX; n];
    for k in (0..n).rev() {
        let up = parent[k].min(n);
        next_sibling[k] = first_child[up];
        first_child[up] = k;
    }
    let mut result = Vec::with_capacity(n);
    let mut path = vec![n];
    while let Some(&k) = path.last() {
        let child = first_child[k];
        if child == usize::MAX {
            path.pop();
            if k < n {
                result.push(order[k]);
            }
        } else {
            first_child[k] = next_sibling[child];
            path.push(child);
        }
    }
    result
}

/// Parent of each position in the elimination tree, `usize::MAX` for roots (Liu 1990).
fn elimination_tree(graph: &Lists, order: &[u32]) -> Vec<usize> {
    let n = order.len();
    let mut position = vec![0; n];
    for (k, &node) in order.iter().enumerate() {
        position[node as usize] = k;
    }
    let mut parent = vec![usize::MAX; n];
    let mut ancestor = vec![usize::MAX; n];
    for (k, &node) in order.iter().enumerate() {
        for &neighbour in graph.of(node as usize) {
            let mut below = position[neighbour as usize];
            while below < k {
                let above = std::mem::replace(&mut ancestor[below], k);
                if above == usize::MAX {
                    parent[below] = k;
                    break;
                }
                below = above;
            }
        }
    }
    parent
}
