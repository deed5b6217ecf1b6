//! Consistent loads on straight and curved element edges: f_i = ∫ N_i t h_t ds.

use super::quadrature::gauss_3;
use crate::mesh::Edge;

/// A load on an edge, per unit of its area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EdgeLoad {
    /// Force per area in fixed directions [Pa].
    Traction([f64; 2]),
    /// Pressure p [Pa]: t = −p n with the outward normal n.
    Pressure(f64),
}

impl EdgeLoad {
    /// t [Pa] on a surface with the outward unit normal `normal`.
    pub fn traction(&self, normal: [f64; 2]) -> [f64; 2] {
        match *self {
            EdgeLoad::Traction(t) => t,
            EdgeLoad::Pressure(p) => normal.map(|n| -p * n),
        }
    }
}

/// A point of an edge.
#[derive(Clone, Copy, Debug)]
pub struct EdgePoint {
    /// x(s) [m].
    pub position: [f64; 2],
    /// Unit normal to the right of the edge's direction: outward when the region lies on its left.
    pub normal: [f64; 2],
    /// Shape functions of the two ends and the middle [-].
    pub value: [f64; 3],
    /// Length that the point stands for [m].
    pub length: f64,
}

/// The three Gauss points of an edge, exact for quadratic traces on straight edges.
pub fn edge_points(edge: &Edge, nodes: &[[f64; 2]]) -> [EdgePoint; 3] {
    gauss_3().map(|(s, weight)| edge_point(edge, nodes, s, weight))
}

fn edge_point(edge: &Edge, nodes: &[[f64; 2]], s: f64, weight: f64) -> EdgePoint {
    let (value, slope) = trace(edge.middle.is_some(), s);
    let mut position = [0.0; 2];
    let mut tangent = [0.0; 2];
    for (i, node) in edge.nodes().enumerate() {
        for axis in 0..2 {
            position[axis] += value[i] * nodes[node][axis];
            tangent[axis] += slope[i] * nodes[node][axis];
        }
    }
    let stretch = tangent[0].hypot(tangent[1]);
    EdgePoint {
        position,
        normal: [tangent[1] / stretch, -tangent[0] / stretch],
        value,
        length: stretch * weight,
    }
}

/// N and dN/ds of the ends and the middle at s ∈ [−1, 1].
fn trace(quadratic: bool, s: f64) -> ([f64; 3], [f64; 3]) {
    if quadratic {
        (
            [0.5 * s * (s - 1.0), 0.5 * s * (s + 1.0), 1.0 - s * s],
            [s - 0.5, s + 0.5, -2.0 * s],
        )
    } else {
        ([0.5 * (1.0 - s), 0.5 * (1.0 + s), 0.0], [-0.5, 0.5, 0.0])
    }
}

/// Nodal forces [N], paired with the edge's nodes; the region must lie on the edge's left.
pub fn consistent_load(
    edge: &Edge,
    nodes: &[[f64; 2]],
    load: EdgeLoad,
    thickness: f64,
) -> Vec<(usize, [f64; 2])> {
    let mut forces: Vec<(usize, [f64; 2])> = edge.nodes().map(|node| (node, [0.0; 2])).collect();
    for point in edge_points(edge, nodes) {
        let traction = load.traction(point.normal);
        for ((_, force), value) in forces.iter_mut().zip(point.value) {
            for axis in 0..2 {
                force[axis] += value * traction[axis] * thickness * point.length;
            }
        }
    }
    forces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_uniform_traction_on_a_quadratic_edge_is_shared_one_four_one() {
        let nodes = [[0.0, 0.0], [3.0, 0.0], [1.5, 0.0]];
        let edge = Edge {
            ends: [0, 1],
            middle: Some(2),
        };
        let forces = consistent_load(&edge, &nodes, EdgeLoad::Traction([2.0, -1.0]), 0.5);
        let expected = [[0.5, -0.25], [0.5, -0.25], [2.0, -1.0]];
        for ((_, force), expected) in forces.iter().zip(expected) {
            // Three products summed: a few units in the last place.
            assert!(
                (force[0] - expected[0]).abs() < 1e-15 && (force[1] - expected[1]).abs() < 1e-15
            );
        }
    }

    #[test]
    fn pressure_on_an_arc_sums_to_pressure_times_chord() {
        // ∮ n ds of any curve depends on its ends only: exact for the parabola through three points.
        let nodes = [[1.0, 0.0], [0.0, 1.0], [0.5f64.sqrt(), 0.5f64.sqrt()]];
        let edge = Edge {
            ends: [0, 1],
            middle: Some(2),
        };
        let forces = consistent_load(&edge, &nodes, EdgeLoad::Pressure(3.0), 2.0);
        let total = forces
            .iter()
            .fold([0.0; 2], |t, (_, f)| [t[0] + f[0], t[1] + f[1]]);
        assert!(
            (total[0] + 6.0).abs() < 1e-14 && (total[1] + 6.0).abs() < 1e-14,
            "{total:?}"
        );
    }
}
