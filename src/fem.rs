//! The finite-element region: isoparametric elements, Qian et al. (2021), eqs. (11)–(15).

pub mod edge;
pub mod element;
pub mod quad4;
pub mod quad8;
pub mod quadrature;
pub mod recovery;
pub mod tri3;
pub mod tri6;

use crate::mesh::CellKind;

/// The most nodes that an element has.
pub const MAX_NODES: usize = 8;

/// Shape functions of one element kind at one point; entries past the element's nodes are zero.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// N_i [-].
    pub value: [f64; MAX_NODES],
    /// (∂N_i/∂ξ, ∂N_i/∂η) [-].
    pub gradient: [[f64; 2]; MAX_NODES],
}

/// N_i and their derivatives at the reference point (ξ, η).
pub fn shape(kind: CellKind, at: [f64; 2]) -> Shape {
    match kind {
        CellKind::Quad8 => padded(quad8::value(at), quad8::gradient(at)),
        CellKind::Quad4 => padded(quad4::value(at), quad4::gradient(at)),
        CellKind::Tri6 => padded(tri6::value(at), tri6::gradient(at)),
        CellKind::Tri3 => padded(tri3::value(at), tri3::gradient(at)),
    }
}

/// Reference coordinates of the nodes.
pub fn reference_nodes(kind: CellKind) -> &'static [[f64; 2]] {
    match kind {
        CellKind::Quad8 => &quad8::NODES,
        CellKind::Quad4 => &quad4::NODES,
        CellKind::Tri6 => &tri6::NODES,
        CellKind::Tri3 => &tri3::NODES,
    }
}

fn padded<const N: usize>(value: [f64; N], gradient: [[f64; 2]; N]) -> Shape {
    let mut shape = Shape {
        value: [0.0; MAX_NODES],
        gradient: [[0.0; 2]; MAX_NODES],
    };
    shape.value[..N].copy_from_slice(&value);
    shape.gradient[..N].copy_from_slice(&gradient);
    shape
}

#[cfg(test)]
mod tests {
    use super::*;

    const INSIDE: [[f64; 2]; 3] = [[0.21, 0.13], [0.4, 0.35], [0.05, 0.7]];

    #[test]
    fn shape_functions_are_one_at_their_node_and_zero_at_the_others() {
        for kind in CellKind::ALL {
            for (i, &node) in reference_nodes(kind).iter().enumerate() {
                for (j, value) in shape(kind, node).value.iter().enumerate() {
                    assert_eq!(
                        *value,
                        if i == j { 1.0 } else { 0.0 },
                        "{kind:?} N_{j} at {i}"
                    );
                }
            }
        }
    }

    #[test]
    fn gradients_agree_with_central_differences() {
        let step = 1e-5;
        for kind in CellKind::ALL {
            for at in INSIDE {
                for axis in 0..2 {
                    let moved = |h: f64| {
                        let mut p = at;
                        p[axis] += h;
                        shape(kind, p).value
                    };
                    let (ahead, behind) = (moved(step), moved(-step));
                    for i in 0..MAX_NODES {
                        let difference = (ahead[i] - behind[i]) / (2.0 * step);
                        // Cubic terms leave h² · N'''/6 ≤ 1e-10, rounding 1e-16/h = 1e-11.
                        let error = difference - shape(kind, at).gradient[i][axis];
                        assert!(error.abs() < 2e-10, "{kind:?} N_{i}: {error:e}");
                    }
                }
            }
        }
    }

    #[test]
    fn shape_functions_sum_to_one_everywhere() {
        for kind in CellKind::ALL {
            for at in INSIDE {
                let sum: f64 = shape(kind, at).value.iter().sum();
                assert!((sum - 1.0).abs() < 4e-16);
            }
        }
    }
}
