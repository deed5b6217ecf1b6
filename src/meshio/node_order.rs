//! In which order a file lists the nodes of its elements.
//!
//! Programs number the nodes of a quadratic element in two ways: corners first and then the middles, as VTK,
//! Abaqus, Nastran, MED and this program do, or corner, middle, corner around the element. The first is taken
//! unless the Jacobian of an element is not positive in it at a node or quadrature point; the other then has to
//! be right for every element of the kind, or the mesh is refused.

use std::collections::BTreeMap;

use super::container::{self, Container, Kind};
use super::convert::{ConvertError, cell_kind};
use crate::fem::element::smallest_jacobian;

/// The order of an element's nodes in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    CornersFirst,
    /// Corner and middle in turn.
    AroundTheElement,
}

/// The nodes with the corners first.
pub(super) fn in_order(nodes: &[usize], order: Order) -> Vec<usize> {
    match order {
        Order::CornersFirst => nodes.to_vec(),
        Order::AroundTheElement => {
            let corners = nodes.iter().step_by(2);
            corners
                .chain(nodes.iter().skip(1).step_by(2))
                .copied()
                .collect()
        }
    }
}

fn positions(container: &Container, nodes: &[usize]) -> Vec<[f64; 2]> {
    let position = |&node: &usize| [container.points[node][0], container.points[node][1]];
    nodes.iter().map(position).collect()
}

/// The nodes, corners first and counter-clockwise, and whether they had to be turned over.
pub(super) fn counter_clockwise(
    container: &Container,
    cell: &container::Cell,
    order: Order,
) -> (Vec<usize>, bool) {
    let mut nodes = in_order(&cell.nodes, order);
    let corners = if nodes.len().is_multiple_of(4) { 4 } else { 3 };
    let at = positions(container, &nodes[..corners]);
    let [x0, y0] = at[0];
    let twice_area: f64 = (0..corners)
        .map(|i| (at[i], at[(i + 1) % corners]))
        .map(|([xa, ya], [xb, yb])| (xa - x0) * (yb - y0) - (xb - x0) * (ya - y0))
        .sum();
    let is_clockwise = twice_area < 0.0;
    if is_clockwise {
        nodes[1..corners].reverse();
        nodes[corners..].reverse();
    }
    (nodes, is_clockwise)
}

/// The order of each kind's nodes, as far as the elements lie in the plane.
pub(super) fn orders(
    container: &Container,
    is_in_plane: &dyn Fn(&container::Cell) -> bool,
    notes: &mut Vec<String>,
) -> Result<BTreeMap<Kind, Order>, ConvertError> {
    let mut orders = BTreeMap::new();
    for kind in [Kind::Triangle, Kind::Triangle6, Kind::Quad, Kind::Quad8] {
        let cells = || {
            let cells = container.cells.iter();
            cells.filter(|cell| cell.kind == kind && is_in_plane(cell))
        };
        let cell_kind = cell_kind(kind).expect("these lie in the plane");
        let fits = |cell: &container::Cell, order| {
            let (nodes, _) = counter_clockwise(container, cell, order);
            smallest_jacobian(cell_kind, &positions(container, &nodes)).0 > 0.0
        };
        let misfit = cells().find(|cell| !fits(cell, Order::CornersFirst));
        let Some(misfit) = misfit else {
            orders.insert(kind, Order::CornersFirst);
            continue;
        };
        let around = |cell: &container::Cell| {
            cell_kind.is_quadratic() && fits(cell, Order::AroundTheElement)
        };
        if !around(misfit) {
            return Err(ConvertError::folded(container, misfit));
        }
        if let Some(other) = cells().find(|cell| !around(cell)) {
            return Err(match fits(other, Order::CornersFirst) {
                true => ConvertError::MixedOrder {
                    kind: kind.name(),
                    first: other.id,
                    other: misfit.id,
                },
                false => ConvertError::folded(container, other),
            });
        }
        notes.push(format!(
            "the nodes of the {} elements run around the element, and were put in order: corners first",
            kind.name()
        ));
        orders.insert(kind, Order::AroundTheElement);
    }
    Ok(orders)
}
