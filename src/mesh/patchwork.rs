//! Structured meshes of several mapped squares: bodies with curved sides for which no mesher is needed.

use super::{Cell, CellKind, Mesh};
use std::collections::HashMap;

/// The unit square in a × b cells, mapped to the plane; a, b ≥ 1. The map must keep the orientation.
pub struct Patch<'a> {
    pub count: [usize; 2],
    /// (s, t) ∈ [0, 1]² → x [m].
    pub map: &'a dyn Fn([f64; 2]) -> [f64; 2],
}

/// Nodes closer together than this share of `size` are one.
const SAME: f64 = 1e-9;

/// Quadrilaterals (`kind`) of all patches, joined where their nodes coincide; mid-side nodes lie on the
/// maps' curves. `size`: of the body [m].
pub fn patchwork(kind: CellKind, size: f64, patches: &[Patch]) -> Mesh {
    let mut mesh = Mesh::default();
    let mut known: HashMap<[i64; 2], usize> = HashMap::new();
    // Corners, then mid-sides, in half steps.
    const PLACES: [[usize; 2]; 8] = [
        [0, 0],
        [2, 0],
        [2, 2],
        [0, 2],
        [1, 0],
        [2, 1],
        [1, 2],
        [0, 1],
    ];
    for Patch { count, map } in patches {
        for cell in 0..count[0] * count[1] {
            let from = [cell % count[0], cell / count[0]];
            let mut node = |place: &[usize; 2]| {
                let parameter =
                    [0, 1].map(|k| (2 * from[k] + place[k]) as f64 / (2 * count[k]) as f64);
                let x = map(parameter);
                let key = x.map(|x| (x / (SAME * size)).round() as i64);
                // A position may be rounded to either side.
                let around = [-1, 0, 1]
                    .into_iter()
                    .flat_map(|i| [-1, 0, 1].map(|j| [i, j]));
                let mut near = around.map(|[i, j]| [key[0] + i, key[1] + j]);
                near.find_map(|key| known.get(&key).copied())
                    .unwrap_or_else(|| {
                        known.insert(key, mesh.nodes.len());
                        mesh.nodes.push(x);
                        mesh.nodes.len() - 1
                    })
            };
            let nodes: Vec<usize> = PLACES[..kind.node_count()].iter().map(&mut node).collect();
            mesh.cells.push(Cell::new(kind, &nodes));
        }
    }
    mesh
}

/// The point of the circle of radius r about the origin that is seen in the direction of the point
/// (h, h t), −1 ≤ t ≤ 1, of a square's right side, turned by `quarter` right angles.
pub fn on_circle(r: f64, t: f64, quarter: usize) -> [f64; 2] {
    let (sin, cos) = (0.25 * std::f64::consts::PI * t).sin_cos();
    turned([r * cos, r * sin], quarter)
}

/// The point (h, h t), −1 ≤ t ≤ 1, of the right side of a square with half-side h about the origin,
/// turned by `quarter` right angles.
pub fn on_square(h: f64, t: f64, quarter: usize) -> [f64; 2] {
    turned([h, h * t], quarter)
}

fn turned([x, y]: [f64; 2], quarter: usize) -> [f64; 2] {
    match quarter % 4 {
        0 => [x, y],
        1 => [-y, x],
        2 => [-x, -y],
        _ => [y, -x],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Outline;
    use std::f64::consts::PI;

    #[test]
    fn a_ring_of_four_patches_closes() {
        let ring = |quarter: usize| {
            move |[s, t]: [f64; 2]| {
                let (a, b) = (
                    on_circle(1.0, 2.0 * t - 1.0, quarter),
                    on_square(3.0, 2.0 * t - 1.0, quarter),
                );
                [0, 1].map(|k| (1.0 - s) * a[k] + s * b[k])
            }
        };
        let maps = [ring(0), ring(1), ring(2), ring(3)];
        let patches = maps.each_ref().map(|map| Patch { count: [3, 8], map });
        let mesh = patchwork(CellKind::Quad8, 3.0, &patches);
        // Rings of 32 cells: corners and mid-sides around, and one node on each of the sides across.
        assert_eq!(mesh.cells.len(), 96);
        assert_eq!(mesh.nodes.len(), 4 * 64 + 3 * 32);
        let all: Vec<usize> = (0..96).collect();
        let outline = Outline::of_cells(&mesh, &all);
        assert_eq!(outline.loops.len(), 2);
        // Chords of parabolas through three points of the circle, eight to each of 32 arcs.
        assert!((outline.area() / (36.0 - PI) - 1.0).abs() < 1e-4);
    }
}
