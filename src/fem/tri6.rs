//! Six-node quadratic triangle: corners L_i(2L_i − 1), mid-sides 4 L_i L_j.

use super::tri3;

pub const NODES: [[f64; 2]; 6] = [
    [0.0, 0.0],
    [1.0, 0.0],
    [0.0, 1.0],
    [0.5, 0.0],
    [0.5, 0.5],
    [0.0, 0.5],
];

/// N_i(ξ, η) [-].
pub fn value(point: [f64; 2]) -> [f64; 6] {
    let l = tri3::value(point);
    std::array::from_fn(|i| match i {
        0..3 => l[i] * (2.0 * l[i] - 1.0),
        _ => 4.0 * l[i - 3] * l[(i - 2) % 3],
    })
}

/// (∂N_i/∂ξ, ∂N_i/∂η) [-].
pub fn gradient(point: [f64; 2]) -> [[f64; 2]; 6] {
    let (l, dl) = (tri3::value(point), tri3::gradient(point));
    std::array::from_fn(|i| {
        std::array::from_fn(|axis| match i {
            0..3 => (4.0 * l[i] - 1.0) * dl[i][axis],
            _ => {
                let (a, b) = (i - 3, (i - 2) % 3);
                4.0 * (dl[a][axis] * l[b] + l[a] * dl[b][axis])
            }
        })
    })
}
