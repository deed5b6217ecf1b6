//! Manufactured solution (Roache 1998): u(x) is chosen, its body force b = −div σ applied, and the
//! error in L² must fall as h³ for the quadratic elements, as h² for the linear ones.
//!
//! Rectangles 1.2 × 0.8 m under a smooth map, so that no element is a parallelogram but each
//! refinement makes them more nearly so: on such meshes Q8 keeps its order. The relative error of
//! the finest mesh is asserted within half a percent.
//!
//! | | Q8 | T6 | Q4 | T3 |
//! |---|---|---|---|---|
//! | slope over 8², 16², 32² elements | 3.003 | 2.997 | 2.001 | 1.983 |
//! | error of the finest | 1.130e-5 | 1.736e-5 | 1.654e-3 | 2.695e-3 |

mod common;

use common::*;
use peristitch::boundary::Boundary;
use peristitch::fem::element::MappedPoint;
use peristitch::fem::quadrature;
use peristitch::material::{Material, PlaneState};
use peristitch::mesh::{CellKind, Mesh};
use peristitch::model::Model;
use std::f64::consts::PI;

const MATERIAL: Material = Material {
    young: 2.0,
    poisson: 0.3,
};
const PLANE: PlaneState = PlaneState::Strain;

/// Wave numbers [1/m]: half a wave over the body.
const A: f64 = 2.9;
const B: f64 = 3.7;

fn exact([x, y]: [f64; 2]) -> [f64; 2] {
    [
        (A * x + 0.4).sin() * (B * y).cos(),
        (B * x).cos() * (A * y - 0.3).sin(),
    ]
}

/// −div σ with σ = D ε [N/m³].
fn body_force([x, y]: [f64; 2]) -> [f64; 2] {
    let d = MATERIAL.elasticity(PLANE);
    let (c11, c12, c66) = (d[(0, 0)], d[(0, 1)], d[(2, 2)]);
    let [u, v] = exact([x, y]);
    let u_xy = -A * B * (A * x + 0.4).cos() * (B * y).sin();
    let v_xy = -A * B * (B * x).sin() * (A * y - 0.3).cos();
    let (u_xx, u_yy, v_xx, v_yy) = (-A * A * u, -B * B * u, -B * B * v, -A * A * v);
    [
        -(c11 * u_xx + c66 * u_yy + (c12 + c66) * v_xy),
        -(c11 * v_yy + c66 * v_xx + (c12 + c66) * u_xy),
    ]
}

fn mesh(kind: CellKind, n: usize) -> Mesh {
    let size = [1.2, 0.8];
    let grid = Grid {
        size,
        count: [n, n],
        kind,
    };
    grid.mesh(|[x, y]| {
        let bulge = 0.05 * (PI * x / size[0]).sin() * (PI * y / size[1]).sin();
        [bulge, -0.8 * bulge]
    })
}

/// f_i = ∫ N_i b h_t dA.
fn add_body_force(model: &Model, boundary: &mut Boundary) {
    for element in 0..model.elements.len() {
        let (kind, coordinates) = (model.cell(element).kind, model.element_coordinates(element));
        let nodes = model.element_nodes(element);
        for gauss in quadrature::full(kind) {
            let point = MappedPoint::new(kind, &coordinates, gauss.at);
            let volume = gauss.weight * point.determinant * model.settings.thickness;
            let force = body_force(point.position);
            for (&node, value) in nodes.iter().zip(point.value) {
                for (axis, force) in force.into_iter().enumerate() {
                    boundary.load[2 * node as usize + axis] += volume * value * force;
                }
            }
        }
    }
}

/// ‖u_h − u‖ / ‖u‖ in L², by the rule of the quadratic element of the same shape.
fn error(kind: CellKind, n: usize) -> f64 {
    let model = finite_elements(mesh(kind, n), MATERIAL, PLANE);
    let mut boundary = hold_outline(&model, exact);
    add_body_force(&model, &mut boundary);
    let displacement = displacements(&model, &boundary);
    let rule = quadrature::full(match kind.corner_count() {
        3 => CellKind::Tri6,
        _ => CellKind::Quad8,
    });
    let (mut error, mut scale) = (0.0, 0.0);
    for element in 0..model.elements.len() {
        let nodes = model.element_nodes(element);
        for gauss in &rule {
            let point = MappedPoint::new(kind, &model.element_coordinates(element), gauss.at);
            let area = gauss.weight * point.determinant;
            for (axis, exact) in exact(point.position).into_iter().enumerate() {
                let values = nodes.iter().zip(point.value);
                let u: f64 = values
                    .map(|(&n, value)| value * displacement[n as usize][axis])
                    .sum();
                error += area * (u - exact).powi(2);
                scale += area * exact * exact;
            }
        }
    }
    f64::sqrt(error / scale)
}

/// Least-squares slope of log error over log h.
fn slope(samples: &[(f64, f64)]) -> f64 {
    let n = samples.len() as f64;
    let logs = || samples.iter().map(|(h, e)| (h.ln(), e.ln()));
    let mean = logs().fold((0.0, 0.0), |(x, y), (h, e)| (x + h / n, y + e / n));
    let (xy, xx) = logs().fold((0.0, 0.0), |(xy, xx), (h, e)| {
        let (h, e) = (h - mean.0, e - mean.1);
        (xy + h * e, xx + h * h)
    });
    xy / xx
}

fn assert_convergence(kind: CellKind, order: f64, finest: f64) {
    let samples = [8, 16, 32].map(|n| (1.0 / n as f64, error(kind, n)));
    let slope = slope(&samples);
    assert!(
        (slope - order).abs() < 0.1,
        "{kind:?}: slope {slope}, {samples:?}"
    );
    assert_between(samples[2].1, 0.995 * finest, 1.005 * finest, "finest error");
}

#[test]
fn eight_node_quadrilaterals_converge_with_the_cube() {
    assert_convergence(CellKind::Quad8, 3.0, 1.130e-5);
}

#[test]
fn four_node_quadrilaterals_converge_with_the_square() {
    assert_convergence(CellKind::Quad4, 2.0, 1.654e-3);
}

#[test]
fn six_node_triangles_converge_with_the_cube() {
    assert_convergence(CellKind::Tri6, 3.0, 1.736e-5);
}

#[test]
fn three_node_triangles_converge_with_the_square() {
    assert_convergence(CellKind::Tri3, 2.0, 2.695e-3);
}
