//! Four-node bilinear quadrilateral.

pub const NODES: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// N_i(ξ, η) = (1 + ξ_i ξ)(1 + η_i η) / 4 [-].
pub fn value([xi, eta]: [f64; 2]) -> [f64; 4] {
    NODES.map(|[a, b]| 0.25 * (1.0 + a * xi) * (1.0 + b * eta))
}

/// (∂N_i/∂ξ, ∂N_i/∂η) [-].
pub fn gradient([xi, eta]: [f64; 2]) -> [[f64; 2]; 4] {
    NODES.map(|[a, b]| [0.25 * a * (1.0 + b * eta), 0.25 * b * (1.0 + a * xi)])
}
