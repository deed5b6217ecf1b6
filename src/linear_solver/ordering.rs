//! Fill-reducing elimination orders of the nodes' graph; a node's two dofs stay together.

use super::metis;
use crate::assembly::Lists;
use faer::perm::Perm;

/// How to find the elimination order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ordering {
    /// Nested dissection by METIS.
    Metis,
    /// faer's approximate minimum degree, on the dofs.
    Amd,
}

/// The nodes in the order of their elimination, postordered along the elimination tree, or `None`
/// where the factorisation is to order the dofs itself ([`Ordering::Amd`]).
///
/// # Errors
/// METIS's status.
pub fn elimination_order(ordering: Ordering, graph: &Lists) -> Result<Option<Vec<u32>>, i32> {
    let order = match ordering {
        Ordering::Amd => return Ok(None),
        Ordering::Metis => metis::nested_dissection(graph)?,
    };
    Ok(Some(postordered(graph, &order)))
}

/// The permutation of the dofs that goes with an order of the nodes, so many `per_node`.
pub fn dof_permutation(order: &[u32], per_node: usize) -> Perm<u32> {
    let count = per_node as u32;
    let forward: Vec<u32> = order
        .iter()
        .flat_map(|&node| count * node..count * (node + 1))
        .collect();
    let mut inverse = vec![0; forward.len()];
    for (new, &old) in forward.iter().enumerate() {
        inverse[old as usize] = new as u32;
    }
    Perm::new_checked(forward.into(), inverse.into(), per_node * order.len())
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The path 0 – 1 – 2 – 3 – 4, eliminated 0, 4, 2, 1, 3: the tree is 0 → 1, 2 → 1, 4 → 3, 1 → 3.
    #[test]
    fn the_elimination_tree_of_a_path_is_postordered() {
        let links = [
            (0, 1),
            (1, 0),
            (1, 2),
            (2, 1),
            (2, 3),
            (3, 2),
            (3, 4),
            (4, 3),
        ];
        let graph = Lists::collect(5, || links.into_iter());
        let order = [0, 4, 2, 1, 3];
        let none = usize::MAX;
        assert_eq!(elimination_tree(&graph, &order), [3, 4, 3, 4, none]);
        assert_eq!(postordered(&graph, &order), [4, 0, 2, 1, 3]);
    }

    #[test]
    fn metis_orders_every_node_once() {
        let side = 30;
        let links = || {
            (0..side * side).flat_map(|k| {
                let right = (k % side + 1 < side).then_some((k, k + 1));
                let up = (k + side < side * side).then_some((k, k + side));
                right
                    .into_iter()
                    .chain(up)
                    .flat_map(|(a, b)| [(a, b), (b, a)])
            })
        };
        let graph = Lists::collect(900, links);
        let mut order = elimination_order(Ordering::Metis, &graph).unwrap().unwrap();
        order.sort_unstable();
        assert!(order.into_iter().eq(0..900));
    }
}
