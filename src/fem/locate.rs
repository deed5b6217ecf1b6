//! Which element holds a point, and where in it: the inverse of the isoparametric map
//! x(ξ) = Σ N_i(ξ) x_i, by Newton's method, for elements with straight and with curved sides.

use super::element::MappedPoint;
use super::{MAX_NODES, shape};
use crate::mesh::CellKind;
use std::collections::BTreeMap;

/// Where a point lies.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    /// Index of the element.
    pub element: usize,
    /// N_i there [-]; entries past the element's nodes are zero.
    pub value: [f64; MAX_NODES],
    /// How far outside the reference cell the point is; zero within it [-].
    pub excess: f64,
}

/// Elements sorted into square bins.
#[derive(Clone, Debug)]
pub struct Locator {
    elements: Vec<(CellKind, Vec<[f64; 2]>)>,
    side: f64,
    bins: BTreeMap<[i64; 2], Vec<u32>>,
}

/// How far outside a reference cell, two units wide, a point may be and still belong to it: chords
/// that stand for a curved side leave slivers of h²/(512 R), and the shape functions are polynomials there
/// as well as inside.
const SLACK: f64 = 0.05;

/// Points this near a side of the reference cell are on it.
const ON_SIDE: f64 = 1e-9;

const MOST_ITERATIONS: usize = 30;

impl Locator {
    /// Kinds and nodes' coordinates [m] of the elements to search.
    pub fn new(elements: Vec<(CellKind, Vec<[f64; 2]>)>) -> Locator {
        let boxes: Vec<_> = elements.iter().map(|(_, x)| bounds(x)).collect();
        let widths = boxes
            .iter()
            .map(|[low, high]| (high[0] - low[0]).max(high[1] - low[1]));
        let side = widths.sum::<f64>() / boxes.len().max(1) as f64;
        let mut locator = Locator {
            elements,
            side,
            bins: BTreeMap::new(),
        };
        for (element, [low, high]) in boxes.into_iter().enumerate() {
            let ([left, bottom], [right, top]) = (locator.bin(low), locator.bin(high));
            for row in bottom..=top {
                for column in left..=right {
                    let bin = locator.bins.entry([column, row]).or_default();
                    bin.push(element as u32);
                }
            }
        }
        locator
    }

    /// The element that holds `x` [m]; where several do, on their common sides, the one with the lowest
    /// index. `None` outside all of them.
    pub fn locate(&self, x: [f64; 2]) -> Option<Held> {
        let bin = self.bins.get(&self.bin(x))?;
        let mut best: Option<Held> = None;
        for &element in bin {
            let element = element as usize;
            let Some((value, excess)) = self.invert(element, x) else {
                continue;
            };
            if excess <= SLACK && best.is_none_or(|held| excess < held.excess) {
                best = Some(Held {
                    element,
                    value,
                    excess,
                });
            }
        }
        best
    }

    fn bin(&self, x: [f64; 2]) -> [i64; 2] {
        x.map(|x| (x / self.side).floor() as i64)
    }

    /// N_i at `x`, and how far outside the reference cell it is.
    fn invert(&self, element: usize, x: [f64; 2]) -> Option<([f64; MAX_NODES], f64)> {
        let (kind, nodes) = &self.elements[element];
        let [low, high] = bounds(nodes);
        if (0..2).any(|axis| x[axis] < low[axis] || x[axis] > high[axis]) {
            return None;
        }
        let mut at = centre(*kind);
        for _ in 0..MOST_ITERATIONS {
            let step = newton_step(*kind, nodes, at, x);
            // A large step means that the map is far from linear: half of a cell at a time.
            let length = step[0].hypot(step[1]);
            let damping = (1.0 / length).min(1.0);
            at = [0, 1].map(|axis| at[axis] + damping * step[axis]);
            // Newton's method doubles the digits: the next step is below rounding.
            if length < 1e-9 {
                let step = newton_step(*kind, nodes, at, x);
                at = [0, 1].map(|axis| at[axis] + step[axis]);
                let excess = excess(*kind, at);
                let on_side = excess < ON_SIDE;
                return Some((shape(*kind, at).value, if on_side { 0.0 } else { excess }));
            }
        }
        None
    }
}

/// (∂x/∂ξ)⁻¹ (x − x(ξ)).
fn newton_step(kind: CellKind, nodes: &[[f64; 2]], at: [f64; 2], x: [f64; 2]) -> [f64; 2] {
    let mapped = MappedPoint::new(kind, nodes, at);
    let missing = [x[0] - mapped.position[0], x[1] - mapped.position[1]];
    let gradient = shape(kind, at).gradient;
    let mut jacobian = [[0.0; 2]; 2];
    for (node, gradient) in nodes.iter().zip(gradient) {
        for axis in 0..2 {
            jacobian[axis][0] += gradient[0] * node[axis];
            jacobian[axis][1] += gradient[1] * node[axis];
        }
    }
    let [[a, b], [c, d]] = jacobian;
    let determinant = a * d - b * c;
    [
        (d * missing[0] - b * missing[1]) / determinant,
        (a * missing[1] - c * missing[0]) / determinant,
    ]
}

fn is_triangle(kind: CellKind) -> bool {
    matches!(kind, CellKind::Tri3 | CellKind::Tri6)
}

fn centre(kind: CellKind) -> [f64; 2] {
    if is_triangle(kind) {
        [1.0 / 3.0; 2]
    } else {
        [0.0; 2]
    }
}

fn excess(kind: CellKind, [xi, eta]: [f64; 2]) -> f64 {
    if is_triangle(kind) {
        // Doubled, since this cell is one unit wide.
        2.0 * (-xi).max(-eta).max(xi + eta - 1.0).max(0.0)
    } else {
        (xi.abs().max(eta.abs()) - 1.0).max(0.0)
    }
}

/// Lower left and upper right corner of a box that holds the element and its slack [m]; a curved side
/// may bulge past its nodes by less.
fn bounds(nodes: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let extreme = |pick: fn(f64, f64) -> f64, from: f64| {
        [0, 1].map(|axis| nodes.iter().map(|x| x[axis]).fold(from, pick))
    };
    let low = extreme(f64::min, f64::INFINITY);
    let high = extreme(f64::max, f64::NEG_INFINITY);
    let margin = 0.25 * (high[0] - low[0]).max(high[1] - low[1]);
    [low.map(|x| x - margin), high.map(|x| x + margin)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::reference_nodes;

    /// The reference cell turned, stretched and bent.
    fn bent(kind: CellKind) -> Vec<[f64; 2]> {
        let bend = |[x, y]: [f64; 2]| {
            let (x, y) = (2.0 * x - 0.7 * y, 0.9 * x + 1.5 * y);
            [0.1 * (x + 0.06 * y * y), 0.1 * (y - 0.05 * x * x)]
        };
        reference_nodes(kind).iter().map(|&at| bend(at)).collect()
    }

    #[test]
    fn every_kind_finds_the_point_that_it_was_mapped_from() {
        for kind in CellKind::ALL {
            let nodes = bent(kind);
            let locator = Locator::new(vec![(kind, nodes.clone())]);
            for at in [[0.3, 0.2], [0.0, 0.6], [0.9, 0.05], [0.5, 0.5], [0.0, 0.0]] {
                let mapped = MappedPoint::new(kind, &nodes, at);
                let held = locator.locate(mapped.position).expect("a point inside");
                assert_eq!(held.excess, 0.0, "{kind:?} {at:?}");
                for (found, expected) in held.value.iter().zip(mapped.value) {
                    // Newton's last step is below rounding; coordinates of 0.3 carry 5e-17.
                    assert!((found - expected).abs() < 5e-15, "{kind:?} {at:?}");
                }
            }
        }
    }

    #[test]
    fn the_interpolated_position_is_the_point_in_a_mesh_of_two() {
        let left = vec![[0.0, 0.0], [1.0, 0.1], [1.1, 0.9], [-0.1, 1.0]];
        let right = vec![[1.0, 0.1], [2.0, 0.0], [2.0, 1.2], [1.1, 0.9]];
        let elements = [left, right];
        let quad4 = |nodes: &Vec<[f64; 2]>| (CellKind::Quad4, nodes.clone());
        let locator = Locator::new(elements.iter().map(quad4).collect());
        for (x, element) in [([0.4, 0.5], 0), ([1.6, 0.3], 1), ([1.05, 0.5], 0)] {
            let held = locator.locate(x).expect("inside");
            assert_eq!(held.element, element, "{x:?}");
            for axis in 0..2 {
                let nodes = elements[element].iter().zip(held.value);
                let sum: f64 = nodes.map(|(node, n)| node[axis] * n).sum();
                assert!((sum - x[axis]).abs() < 5e-16, "{x:?}");
            }
        }
        assert!(locator.locate([0.5, 1.3]).is_none());
        assert!(locator.locate([9.0, 0.3]).is_none());
    }
}
