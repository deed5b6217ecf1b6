//! Quadrature rules on the reference square [−1, 1]² , triangle and interval.

use crate::mesh::CellKind;

/// A point of the reference cell and its weight.
#[derive(Clone, Copy, Debug)]
pub struct QuadraturePoint {
    pub at: [f64; 2],
    pub weight: f64,
}

/// The Gauss–Legendre points and weights on [−1, 1]: exact to degree 3 (two points) or 5 (three).
pub fn gauss_2() -> [(f64, f64); 2] {
    let x = 1.0 / 3f64.sqrt();
    [(-x, 1.0), (x, 1.0)]
}

pub fn gauss_3() -> [(f64, f64); 3] {
    let x = 0.6f64.sqrt();
    [(-x, 5.0 / 9.0), (0.0, 8.0 / 9.0), (x, 5.0 / 9.0)]
}

fn tensor_product(rule: &[(f64, f64)]) -> Vec<QuadraturePoint> {
    rule.iter()
        .flat_map(|&(eta, we)| {
            rule.iter().map(move |&(xi, wx)| QuadraturePoint {
                at: [xi, eta],
                weight: wx * we,
            })
        })
        .collect()
}

/// The orbit of (a, a, 1 − 2a) in area coordinates; weights are fractions of the area 1/2.
fn triangle_orbit(a: f64, weight: f64) -> [QuadraturePoint; 3] {
    [[a, a], [1.0 - 2.0 * a, a], [a, 1.0 - 2.0 * a]].map(|at| QuadraturePoint {
        at,
        weight: 0.5 * weight,
    })
}

/// Full quadrature of the stiffness: exact on affine cells.
///
/// Quad8 3 × 3, Quad4 2 × 2 Gauss points; Tri6 the six-point rule of degree 4 (Dunavant 1985), one
/// more than affine cells need, for curved sides; Tri3 one point.
pub fn full(kind: CellKind) -> Vec<QuadraturePoint> {
    match kind {
        CellKind::Quad8 => tensor_product(&gauss_3()),
        CellKind::Quad4 => tensor_product(&gauss_2()),
        CellKind::Tri6 => {
            // Closed form of Dunavant's degree-4 rule (Strang & Fix 1973, rule 5).
            let s10 = 10f64.sqrt();
            let root = (38.0 - 44.0 * 0.4f64.sqrt()).sqrt();
            let a = [8.0 - s10 + root, 8.0 - s10 - root].map(|x| x / 18.0);
            let w_root = (213125.0 - 53320.0 * s10).sqrt();
            let w = [620.0 + w_root, 620.0 - w_root].map(|x| x / 3720.0);
            [triangle_orbit(a[0], w[0]), triangle_orbit(a[1], w[1])].concat()
        }
        CellKind::Tri3 => vec![QuadraturePoint {
            at: [1.0 / 3.0; 2],
            weight: 0.5,
        }],
    }
}

/// The points at which strains are most accurate (Barlow points): 2 × 2 Gauss points, the three points of degree 2
/// in Tri6, the centroid of Tri3.
pub fn barlow(kind: CellKind) -> Vec<QuadraturePoint> {
    match kind {
        CellKind::Quad8 | CellKind::Quad4 => tensor_product(&gauss_2()),
        CellKind::Tri6 => triangle_orbit(1.0 / 6.0, 1.0 / 3.0).to_vec(),
        CellKind::Tri3 => full(CellKind::Tri3),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ ξ^p η^q over the reference cell.
    fn exact(kind: CellKind, p: i32, q: i32) -> f64 {
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        let line = |p: i32| {
            if p % 2 == 0 {
                2.0 / f64::from(p + 1)
            } else {
                0.0
            }
        };
        match kind {
            CellKind::Quad4 | CellKind::Quad8 => line(p) * line(q),
            CellKind::Tri3 | CellKind::Tri6 => factorial(p) * factorial(q) / factorial(p + q + 2),
        }
    }

    #[test]
    fn rules_integrate_monomials_exactly_up_to_their_degree() {
        let degree = |kind| match kind {
            CellKind::Quad8 => 5,
            CellKind::Quad4 => 3,
            CellKind::Tri6 => 4,
            CellKind::Tri3 => 1,
        };
        for kind in CellKind::ALL {
            for p in 0..=degree(kind) {
                for q in 0..=degree(kind) {
                    let triangle = kind.corner_count() == 3;
                    if triangle && p + q > degree(kind) {
                        continue;
                    }
                    let sum: f64 = full(kind)
                        .iter()
                        .map(|g| g.weight * g.at[0].powi(p) * g.at[1].powi(q))
                        .sum();
                    // A few units in the last place of the coordinates.
                    assert!(
                        (sum - exact(kind, p, q)).abs() < 1e-15,
                        "{kind:?} {p} {q}: {sum}"
                    );
                }
            }
        }
    }

    #[test]
    fn one_degree_more_is_not_exact() {
        let at = |p| {
            full(CellKind::Tri6)
                .iter()
                .map(|g| g.weight * g.at[0].powi(p))
                .sum::<f64>()
        };
        assert!((at(5) - exact(CellKind::Tri6, 5, 0)).abs() > 1e-6);
    }
}
