//! Fill-reducing elimination orders of the nodes' graph; a node's two dofs stay together.

use super::metis;
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
