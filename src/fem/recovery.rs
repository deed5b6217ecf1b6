//! Strain and stress at the nodes of an element: sampled where they are most accurate
//! (Barlow 1976) and carried to the nodes by the polynomial through those samples.

use super::element::MappedPoint;
use super::{quadrature, reference_nodes};
use crate::mesh::CellKind;
use nalgebra::Vector3;

/// Strain ε_xx, ε_yy, γ_xy at each node of the element [-].
///
/// `displacement`: one vector per node [m].
pub fn nodal_strain(
    kind: CellKind,
    coordinates: &[[f64; 2]],
    displacement: &[[f64; 2]],
) -> Vec<Vector3<f64>> {
    let samples: Vec<Vector3<f64>> = quadrature::barlow(kind)
        .iter()
        .map(|g| strain_at(kind, coordinates, displacement, g.at))
        .collect();
    let weighted = |at: &[f64; 2]| {
        let weights = extrapolation(kind, *at);
        weights
            .iter()
            .zip(&samples)
            .map(|(w, sample)| sample * *w)
            .sum()
    };
    reference_nodes(kind).iter().map(weighted).collect()
}

/// ε = B u_e at a reference point [-].
pub fn strain_at(
    kind: CellKind,
    coordinates: &[[f64; 2]],
    displacement: &[[f64; 2]],
    at: [f64; 2],
) -> Vector3<f64> {
    let gradient = MappedPoint::new(kind, coordinates, at).gradient;
    displacement
        .iter()
        .zip(gradient)
        .map(|(u, [dx, dy])| Vector3::new(u[0] * dx, u[1] * dy, u[0] * dy + u[1] * dx))
        .sum()
}

/// Weights of the Barlow samples at a reference point: bilinear through 2 × 2, linear through
/// three, constant from one.
fn extrapolation(kind: CellKind, at: [f64; 2]) -> Vec<f64> {
    match kind {
        CellKind::Quad8 | CellKind::Quad4 => {
            let inward = at.map(|x| x * 3f64.sqrt());
            [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]]
                .map(|[a, b]| 0.25 * (1.0 + a * inward[0]) * (1.0 + b * inward[1]))
                .to_vec()
        }
        CellKind::Tri6 => {
            // The samples sit at L = (2/3, 1/6, 1/6) and its permutations.
            let l = [1.0 - at[0] - at[1], at[0], at[1]];
            l.map(|l| 2.0 * l - 1.0 / 3.0).to_vec()
        }
        CellKind::Tri3 => vec![1.0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_field_gives_its_linear_strain_at_every_node_of_an_affine_element() {
        let affine = |[x, y]: [f64; 2]| [2.0 * x + 0.5 * y, 0.3 * x + 1.5 * y];
        let field = |[x, y]: [f64; 2]| [x * x + x * y, y * y - 2.0 * x * y];
        for kind in [CellKind::Quad8, CellKind::Tri6] {
            let x: Vec<_> = reference_nodes(kind).iter().map(|p| affine(*p)).collect();
            let u: Vec<_> = x.iter().map(|p| field(*p)).collect();
            for (strain, [x, y]) in nodal_strain(kind, &x, &u).iter().zip(x.iter().copied()) {
                let exact = Vector3::new(2.0 * x + y, 2.0 * y - 2.0 * x, x - 2.0 * y);
                // Extrapolation weights up to 1.9 on samples up to 10.
                assert!((strain - exact).amax() < 1e-13, "{kind:?} {strain} {exact}");
            }
        }
    }
}
