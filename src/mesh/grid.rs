//! Structured meshes made in code: bodies for which no mesher is needed.

use super::{Cell, CellKind, Edge, Mesh};
use std::collections::HashMap;

/// A rectangle [0, w] × [0, h] of nx × ny quadrilaterals, each cut in two for triangles; corner
/// nodes are moved by `shift`, mid-side nodes stay in the middle of straight sides.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// w, h [m].
    pub size: [f64; 2],
    /// nx, ny.
    pub count: [usize; 2],
    pub kind: CellKind,
}

impl Grid {
    /// Corner nodes at x + `shift`(x) [m].
    pub fn mesh(&self, shift: impl Fn([f64; 2]) -> [f64; 2]) -> Mesh {
        let [nx, ny] = self.count;
        let corner = |i: usize, j: usize| j * (nx + 1) + i;
        let mut mesh = Mesh::default();
        for j in 0..=ny {
            for i in 0..=nx {
                let x = [
                    self.size[0] * i as f64 / nx as f64,
                    self.size[1] * j as f64 / ny as f64,
                ];
                let d = shift(x);
                mesh.nodes.push([x[0] + d[0], x[1] + d[1]]);
            }
        }
        let mut middles = HashMap::new();
        for j in 0..ny {
            for i in 0..nx {
                let q = [
                    corner(i, j),
                    corner(i + 1, j),
                    corner(i + 1, j + 1),
                    corner(i, j + 1),
                ];
                match self.kind {
                    CellKind::Quad4 | CellKind::Quad8 => self.push(&mut mesh, &mut middles, &q),
                    CellKind::Tri3 | CellKind::Tri6 => {
                        self.push(&mut mesh, &mut middles, &[q[0], q[1], q[2]]);
                        self.push(&mut mesh, &mut middles, &[q[0], q[2], q[3]]);
                    }
                }
            }
        }
        mesh
    }

    fn push(&self, mesh: &mut Mesh, middles: &mut HashMap<[usize; 2], usize>, corners: &[usize]) {
        let mut nodes = corners.to_vec();
        if self.kind.is_quadratic() {
            for k in 0..corners.len() {
                let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
                let next = mesh.nodes.len();
                let middle = *middles.entry([a.min(b), a.max(b)]).or_insert(next);
                if middle == next {
                    let [p, q] = [mesh.nodes[a], mesh.nodes[b]];
                    mesh.nodes.push([0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])]);
                }
                nodes.push(middle);
            }
        }
        mesh.cells.push(Cell::new(self.kind, &nodes));
    }

    /// Equal rectangles.
    pub fn plain(&self) -> Mesh {
        self.mesh(|_| [0.0, 0.0])
    }

    /// Inner corner nodes moved by up to a fifth of an element, the same for every run.
    pub fn distorted(&self) -> Mesh {
        let [w, h] = self.size;
        let step = [w / self.count[0] as f64, h / self.count[1] as f64];
        self.mesh(|[x, y]| {
            let inside =
                x > 1e-9 * w && x < w * (1.0 - 1e-9) && y > 1e-9 * h && y < h * (1.0 - 1e-9);
            if !inside {
                return [0.0, 0.0];
            }
            let wave = |a: f64, b: f64| (a * x / step[0] + b * y / step[1] + 0.3).sin();
            [
                0.2 * step[0] * wave(12.9, 7.2),
                0.2 * step[1] * wave(5.1, 3.7),
            ]
        })
    }
}

/// Names the cells whose centre satisfies `inside`.
pub fn name_cells(mesh: &mut Mesh, name: &str, inside: impl Fn([f64; 2]) -> bool) {
    let cells = (0..mesh.cells.len())
        .filter(|&c| inside(centre(mesh, c)))
        .collect();
    mesh.surfaces.insert(name.to_owned(), cells);
}

/// Mean of a cell's corners [m].
pub fn centre(mesh: &Mesh, cell: usize) -> [f64; 2] {
    let corners = mesh.cells[cell].corners();
    [0, 1].map(|axis| {
        corners.iter().map(|&n| mesh.nodes[n][axis]).sum::<f64>() / corners.len() as f64
    })
}

/// Names the outline's edges both of whose ends satisfy `on`.
pub fn name_curve(mesh: &mut Mesh, name: &str, on: impl Fn([f64; 2]) -> bool) {
    let all: Vec<usize> = (0..mesh.cells.len()).collect();
    let mut edges: Vec<Edge> = mesh.outline(&all);
    edges.retain(|edge| edge.ends.iter().all(|&n| on(mesh.nodes[n])));
    mesh.curves.insert(name.to_owned(), edges);
}
