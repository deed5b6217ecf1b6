//! One element: the map from the reference cell, the strain matrix B and the stiffness
//! k = ∫ Bᵀ D B h_t dA, Qian et al. (2021), eqs. (12)–(14).

use super::quadrature::{self, QuadraturePoint};
use super::{MAX_NODES, reference_nodes, shape};
use crate::mesh::CellKind;
use nalgebra::{DMatrix, Matrix3, SMatrix};

/// Strain–displacement matrix of the widest element: rows ε_xx, ε_yy, γ_xy, two columns per node.
pub type StrainMatrix = SMatrix<f64, 3, { 2 * MAX_NODES }>;

/// The isoparametric map x(ξ) = Σ N_i x_i at one point.
#[derive(Clone, Copy, Debug)]
pub struct MappedPoint {
    /// x(ξ) [m].
    pub position: [f64; 2],
    /// N_i [-].
    pub value: [f64; MAX_NODES],
    /// (∂N_i/∂x, ∂N_i/∂y) [1/m]; meaningless where the determinant is not positive.
    pub gradient: [[f64; 2]; MAX_NODES],
    /// det ∂x/∂ξ [m²].
    pub determinant: f64,
}

impl MappedPoint {
    /// `coordinates` are those of the element's nodes [m].
    pub fn new(kind: CellKind, coordinates: &[[f64; 2]], at: [f64; 2]) -> MappedPoint {
        let shape = shape(kind, at);
        let mut position = [0.0; 2];
        let mut jacobian = [[0.0; 2]; 2];
        for (i, x) in coordinates.iter().enumerate() {
            for axis in 0..2 {
                position[axis] += shape.value[i] * x[axis];
                jacobian[axis][0] += shape.gradient[i][0] * x[axis];
                jacobian[axis][1] += shape.gradient[i][1] * x[axis];
            }
        }
        let [[a, b], [c, d]] = jacobian;
        let determinant = a * d - b * c;
        let gradient = shape.gradient.map(|[xi, eta]| {
            [
                (xi * d - eta * c) / determinant,
                (eta * a - xi * b) / determinant,
            ]
        });
        MappedPoint {
            position,
            value: shape.value,
            gradient,
            determinant,
        }
    }

    /// B of ε = B u_e with the nodal displacements in the order u_1, v_1, u_2, v_2, … [1/m].
    pub fn strain_matrix(&self) -> StrainMatrix {
        let mut b = StrainMatrix::zeros();
        for (i, [dx, dy]) in self.gradient.into_iter().enumerate() {
            b[(0, 2 * i)] = dx;
            b[(1, 2 * i + 1)] = dy;
            b[(2, 2 * i)] = dy;
            b[(2, 2 * i + 1)] = dx;
        }
        b
    }
}

/// The smallest determinant of the map at the nodes and the quadrature points [m²], and where.
///
/// An element whose smallest determinant is not positive is folded over or run through clockwise.
pub fn smallest_jacobian(kind: CellKind, coordinates: &[[f64; 2]]) -> (f64, [f64; 2]) {
    let quadrature = quadrature::full(kind);
    let nodes = reference_nodes(kind).iter().copied();
    nodes
        .chain(quadrature.iter().map(|g| g.at))
        .map(|at| MappedPoint::new(kind, coordinates, at))
        .map(|point| (point.determinant, point.position))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .expect("every kind of element has nodes")
}

/// Element stiffness, 2n × 2n [N/m]; `elasticity` in Pa, `thickness` in m.
pub fn stiffness(
    kind: CellKind,
    coordinates: &[[f64; 2]],
    elasticity: &Matrix3<f64>,
    thickness: f64,
) -> DMatrix<f64> {
    let mut k = SMatrix::<f64, { 2 * MAX_NODES }, { 2 * MAX_NODES }>::zeros();
    for QuadraturePoint { at, weight } in quadrature::full(kind) {
        let point = MappedPoint::new(kind, coordinates, at);
        let b = point.strain_matrix();
        k += b.transpose() * (elasticity * b) * (weight * point.determinant * thickness);
    }
    let size = 2 * kind.node_count();
    DMatrix::from_fn(size, size, |i, j| 0.5 * (k[(i, j)] + k[(j, i)]))
}

/// The element's area [m²].
pub fn area(kind: CellKind, coordinates: &[[f64; 2]]) -> f64 {
    mass_integral(&quadrature::full(kind), kind, coordinates, |_, _| 1.0)
}

/// ∫ N_a dA of the element's nodes [m²].
pub fn shape_integrals(kind: CellKind, coordinates: &[[f64; 2]]) -> Vec<f64> {
    let rule = quadrature::full(kind);
    (0..kind.node_count())
        .map(|a| mass_integral(&rule, kind, coordinates, |n, _| n[a]))
        .collect()
}

/// Lumped "mass" areas of the nodes [m²] by Hinton, Rock & Zienkiewicz (1976): the element's area
/// shared in the ratio of the diagonal of the consistent mass matrix, ∫ N_i² dA.
///
/// The integral over a Quad8 is taken on the 2 × 2 Gauss points: a square gives 1/36 to a corner and 8/36
/// to a mid-side node (the exact integral would give 3/76 and 16/76). It is exact on a Tri6: 3/57 and
/// 16/57. Quad4 and Tri3 give equal shares.
pub fn lumped_areas(kind: CellKind, coordinates: &[[f64; 2]]) -> Vec<f64> {
    if !kind.is_quadratic() {
        let share = area(kind, coordinates) / kind.node_count() as f64;
        return vec![share; kind.node_count()];
    }
    let rule = match kind {
        CellKind::Quad8 => quadrature::barlow(kind),
        _ => quadrature::full(kind),
    };
    let squares: Vec<f64> = (0..kind.node_count())
        .map(|i| mass_integral(&rule, kind, coordinates, |n, _| n[i] * n[i]))
        .collect();
    let scale = area(kind, coordinates) / squares.iter().sum::<f64>();
    squares.into_iter().map(|square| square * scale).collect()
}

fn mass_integral(
    rule: &[QuadraturePoint],
    kind: CellKind,
    coordinates: &[[f64; 2]],
    integrand: impl Fn(&[f64; MAX_NODES], [f64; 2]) -> f64,
) -> f64 {
    rule.iter()
        .map(|g| {
            let point = MappedPoint::new(kind, coordinates, g.at);
            g.weight * point.determinant * integrand(&point.value, point.position)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(kind: CellKind) -> Vec<[f64; 2]> {
        reference_nodes(kind).to_vec()
    }

    #[test]
    fn lumped_areas_of_a_square_are_those_of_the_handbook() {
        let quad8 = lumped_areas(CellKind::Quad8, &unit(CellKind::Quad8));
        let tri6 = lumped_areas(CellKind::Tri6, &unit(CellKind::Tri6));
        // Areas 4 and 1/2; a dozen additions of numbers of order one.
        assert!((quad8[0] - 4.0 / 36.0).abs() < 1e-14 && (quad8[5] - 32.0 / 36.0).abs() < 1e-14);
        assert!((tri6[1] - 1.5 / 57.0).abs() < 1e-14 && (tri6[4] - 8.0 / 57.0).abs() < 1e-14);
    }

    #[test]
    fn a_clockwise_and_a_folded_element_have_a_negative_jacobian() {
        let mut clockwise = unit(CellKind::Quad4);
        clockwise.swap(1, 3);
        assert!(smallest_jacobian(CellKind::Quad4, &clockwise).0 < 0.0);
        let mut folded = unit(CellKind::Quad8);
        folded[4] = [0.9, -1.0];
        assert!(smallest_jacobian(CellKind::Quad8, &folded).0 < 0.0);
        assert!((smallest_jacobian(CellKind::Quad8, &unit(CellKind::Quad8)).0 - 1.0).abs() < 1e-15);
    }
}
