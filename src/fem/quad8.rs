//! Eight-node serendipity quadrilateral, Qian et al. (2021), eq. (15).

pub const NODES: [[f64; 2]; 8] = [
    [-1.0, -1.0],
    [1.0, -1.0],
    [1.0, 1.0],
    [-1.0, 1.0],
    [0.0, -1.0],
    [1.0, 0.0],
    [0.0, 1.0],
    [-1.0, 0.0],
];

/// N_i(ξ, η) [-].
pub fn value([xi, eta]: [f64; 2]) -> [f64; 8] {
    std::array::from_fn(|i| {
        let [a, b] = NODES[i];
        match (a == 0.0, b == 0.0) {
            (true, _) => 0.5 * (1.0 - xi * xi) * (1.0 + b * eta),
            (_, true) => 0.5 * (1.0 - eta * eta) * (1.0 + a * xi),
            _ => 0.25 * (1.0 + a * xi) * (1.0 + b * eta) * (a * xi + b * eta - 1.0),
        }
    })
}

/// (∂N_i/∂ξ, ∂N_i/∂η) [-].
pub fn gradient([xi, eta]: [f64; 2]) -> [[f64; 2]; 8] {
    std::array::from_fn(|i| {
        let [a, b] = NODES[i];
        match (a == 0.0, b == 0.0) {
            (true, _) => [-xi * (1.0 + b * eta), 0.5 * (1.0 - xi * xi) * b],
            (_, true) => [0.5 * (1.0 - eta * eta) * a, -eta * (1.0 + a * xi)],
            _ => [
                0.25 * a * (1.0 + b * eta) * (2.0 * a * xi + b * eta),
                0.25 * b * (1.0 + a * xi) * (a * xi + 2.0 * b * eta),
            ],
        }
    })
}
