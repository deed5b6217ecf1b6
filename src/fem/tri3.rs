//! Three-node linear triangle in area coordinates (L1, L2, L3) = (1 − ξ − η, ξ, η).

pub const NODES: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];

/// N_i = L_i [-].
pub fn value([xi, eta]: [f64; 2]) -> [f64; 3] {
    [1.0 - xi - eta, xi, eta]
}

/// (∂N_i/∂ξ, ∂N_i/∂η) [-].
pub fn gradient(_: [f64; 2]) -> [[f64; 2]; 3] {
    [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]]
}
