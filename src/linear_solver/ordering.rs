//! Fill-reducing elimination orders of the nodes' graph; a node's unknowns stay together.

use super::node_blocks::{below, inverse};
use super::{elimination_tree, metis};
use crate::assembly::Lists;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::Perm;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

/// How to find the elimination order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ordering {
    /// Nested dissection by METIS.
    Metis,
    /// faer's approximate minimum degree.
    Amd,
}

/// The nodes in the order of their elimination.
///
/// # Errors
/// METIS's status.
pub fn elimination_order(ordering: Ordering, graph: &Lists) -> Result<Vec<u32>, i32> {
    match ordering {
        Ordering::Amd => Ok(minimum_degree(graph)),
        Ordering::Metis => metis::nested_dissection(graph),
    }
}

fn minimum_degree(graph: &Lists) -> Vec<u32> {
    let n = graph.len();
    let (start, neighbours) = graph.parts();
    let start: Vec<u32> = start.iter().map(|&s| s as u32).collect();
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, &start, None, neighbours);
    let mut memory = MemBuffer::new(amd::order_scratch::<u32>(n, neighbours.len()));
    let (mut order, mut inverse) = (vec![0; n], vec![0; n]);
    amd::order(
        &mut order,
        &mut inverse,
        pattern,
        Default::default(),
        MemStack::new(&mut memory),
    )
    .expect("indices of the graph fit, and so do those of its elimination");
    order
}

/// The nodes of an elimination order such that every subtree of the elimination tree is in one piece: the same
/// fill, and supernodes as large as can be.
pub fn postordered<const B: usize>(
    pattern: SymbolicSparseColMatRef<'_, u32>,
    order: &[u32],
) -> Vec<u32> {
    let parent = elimination_tree::parents(&below::<B>(pattern, &inverse(order)));
    let post = elimination_tree::postorder(&parent);
    post.iter().map(|&k| order[k as usize]).collect()
}

/// The permutation of the unknowns, B to a node, that goes with an order of the nodes.
pub fn dof_permutation<const B: usize>(order: &[u32]) -> Perm<u32> {
    let unknowns = |&node: &u32| B as u32 * node..B as u32 * (node + 1);
    let forward: Vec<u32> = order.iter().flat_map(unknowns).collect();
    let inverse = inverse(&forward);
    Perm::new_checked(forward.into(), inverse.into(), B * order.len())
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let mut order = elimination_order(Ordering::Metis, &graph).unwrap();
        order.sort_unstable();
        assert!(order.into_iter().eq(0..900));
    }
}
