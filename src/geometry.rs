//! Plane polygons: the outline of a region, what lies inside it, and how much of a strip it covers.

use crate::mesh::{Edge, Mesh};
use std::collections::HashMap;

/// Chords per quadratic edge: a circle meshed with 16 of them is a 128-gon, 4e-4 short in area.
const CHORDS: usize = 8;

/// The closed polygons around a region; outer boundaries counter-clockwise, holes clockwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    pub loops: Vec<Vec<[f64; 2]>>,
}

impl Outline {
    /// Chains edges that have the region on their left; curved edges become chords.
    pub fn from_edges(edges: &[Edge], nodes: &[[f64; 2]]) -> Outline {
        let mut leaving: HashMap<usize, Vec<&Edge>> = HashMap::new();
        for edge in edges.iter().rev() {
            leaving.entry(edge.ends[0]).or_default().push(edge);
        }
        let mut loops = Vec::new();
        for edge in edges {
            let mut polygon = Vec::new();
            let mut at = edge.ends[0];
            while let Some(next) = leaving.get_mut(&at).and_then(Vec::pop) {
                polygon.extend(&chords(next, nodes)[..chord_count(next)]);
                at = next.ends[1];
            }
            if !polygon.is_empty() {
                loops.push(polygon);
            }
        }
        Outline { loops }
    }

    pub fn of_cells(mesh: &Mesh, cells: &[usize]) -> Outline {
        Outline::from_edges(&mesh.outline(cells), &mesh.nodes)
    }

    /// Signed area [m²]: holes count negative.
    pub fn area(&self) -> f64 {
        self.loops.iter().map(|polygon| area(polygon)).sum()
    }

    /// Centroid [m]; not finite where there is no area.
    pub fn centroid(&self) -> [f64; 2] {
        let Some(&o) = self.loops.iter().flatten().next() else {
            return [f64::NAN; 2];
        };
        let (mut twice, mut moment) = (0.0, [0.0; 2]);
        for [a, b] in self.segments() {
            let [p, q] = [a, b].map(|x| [x[0] - o[0], x[1] - o[1]]);
            let cross = p[0] * q[1] - q[0] * p[1];
            twice += cross;
            (0..2).for_each(|axis| moment[axis] += cross * (p[axis] + q[axis]));
        }
        [0, 1].map(|axis| o[axis] + moment[axis] / (3.0 * twice))
    }

    /// Lower left and upper right corner of the bounding box [m].
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        let points = || self.loops.iter().flatten();
        let extreme = |pick: fn(f64, f64) -> f64, from: f64| {
            [0, 1].map(|axis| points().map(|p| p[axis]).fold(from, pick))
        };
        [
            extreme(f64::min, f64::INFINITY),
            extreme(f64::max, f64::NEG_INFINITY),
        ]
    }

    /// The intervals [x_in, x_out] of the horizontal line at `y` that lie inside, ascending.
    pub fn inside_at(&self, y: f64) -> Vec<[f64; 2]> {
        let mut crossings: Vec<f64> = self
            .segments()
            .filter(|[a, b]| (a[1] <= y) != (b[1] <= y))
            .map(|[a, b]| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
            .collect();
        crossings.sort_unstable_by(f64::total_cmp);
        crossings
            .chunks_exact(2)
            .map(|pair| [pair[0], pair[1]])
            .collect()
    }

    /// Whether a point lies inside.
    pub fn contains(&self, [x, y]: [f64; 2]) -> bool {
        self.inside_at(y)
            .iter()
            .any(|&[from, to]| from <= x && x <= to)
    }

    /// The part with `low` ≤ coordinate ≤ `high` along `axis`. Its area is exact; its polygons may
    /// touch themselves (Sutherland & Hodgman 1974).
    pub fn strip(&self, axis: usize, low: f64, high: f64) -> Outline {
        let clipped = |polygon: &Vec<[f64; 2]>| {
            let above = clip(polygon, axis, low, 1.0);
            clip(&above, axis, high, -1.0)
        };
        let mut loops: Vec<_> = self.loops.iter().map(clipped).collect();
        loops.retain(|polygon| polygon.len() > 2);
        Outline { loops }
    }

    /// The sides of all loops, with the inside on their left.
    pub fn segments(&self) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
        self.loops.iter().flat_map(|polygon| {
            (0..polygon.len()).map(|i| [polygon[i], polygon[(i + 1) % polygon.len()]])
        })
    }
}

fn chord_count(edge: &Edge) -> usize {
    if edge.middle.is_some() { CHORDS } else { 1 }
}

/// The points that cut an edge into chords, both ends included [m].
pub fn chords(edge: &Edge, nodes: &[[f64; 2]]) -> Vec<[f64; 2]> {
    chords_of(edge, |node| nodes[node])
}

/// Length of an edge's chords [m].
pub fn edge_length(edge: &Edge, nodes: &[[f64; 2]]) -> f64 {
    let points = chords(edge, nodes);
    let chords = points.windows(2);
    chords
        .map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]))
        .sum()
}

/// The points that cut an edge into chords, from the nodes at `position` [m], displaced for instance.
pub fn chords_of(edge: &Edge, position: impl Fn(usize) -> [f64; 2]) -> Vec<[f64; 2]> {
    let [a, b] = edge.ends.map(&position);
    let Some(middle) = edge.middle.map(&position) else {
        return vec![a, b];
    };
    (0..=CHORDS)
        .map(|k| {
            let t = k as f64 / CHORDS as f64;
            let n = [
                (1.0 - t) * (1.0 - 2.0 * t),
                t * (2.0 * t - 1.0),
                4.0 * t * (1.0 - t),
            ];
            [0, 1].map(|axis| n[0] * a[axis] + n[1] * b[axis] + n[2] * middle[axis])
        })
        .collect()
}

/// The point of the segment ab that is nearest to p, and its distance [m].
pub fn nearest_on_segment(p: [f64; 2], [a, b]: [[f64; 2]; 2]) -> ([f64; 2], f64) {
    let along = [b[0] - a[0], b[1] - a[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let t = ((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1]) / squared;
    let t = if squared > 0.0 {
        t.clamp(0.0, 1.0)
    } else {
        0.0
    };
    let q = [a[0] + t * along[0], a[1] + t * along[1]];
    (q, (p[0] - q[0]).hypot(p[1] - q[1]))
}

/// Shoelace formula about the first vertex, which keeps small polygons far from the origin exact.
fn area(polygon: &[[f64; 2]]) -> f64 {
    let Some(&o) = polygon.first() else {
        return 0.0;
    };
    let twice: f64 = polygon
        .windows(2)
        .map(|w| (w[0][0] - o[0]) * (w[1][1] - o[1]) - (w[1][0] - o[0]) * (w[0][1] - o[1]))
        .sum();
    0.5 * twice
}

/// Keeps what has `side` · (coordinate − bound) ≥ 0.
fn clip(polygon: &[[f64; 2]], axis: usize, bound: f64, side: f64) -> Vec<[f64; 2]> {
    let height = |p: [f64; 2]| side * (p[axis] - bound);
    let mut kept = Vec::with_capacity(polygon.len() + 2);
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (ha, hb) = (height(a), height(b));
        if ha >= 0.0 {
            kept.push(a);
        }
        if (ha > 0.0 && hb < 0.0) || (ha < 0.0 && hb > 0.0) {
            let t = ha / (ha - hb);
            let mut crossing = [0, 1].map(|k| a[k] + t * (b[k] - a[k]));
            crossing[axis] = bound;
            kept.push(crossing);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square_with_hole() -> Outline {
        Outline {
            loops: vec![
                vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]],
                vec![[1.0, 1.0], [1.0, 3.0], [3.0, 3.0], [3.0, 1.0]],
            ],
        }
    }

    #[test]
    fn a_line_through_a_hole_is_inside_twice() {
        assert_eq!(square_with_hole().inside_at(2.0), [[0.0, 1.0], [3.0, 4.0]]);
        assert_eq!(square_with_hole().inside_at(0.5), [[0.0, 4.0]]);
    }

    #[test]
    fn strips_tile_the_area_of_a_concave_polygon() {
        let arrow = Outline {
            loops: vec![vec![[0.0, 0.0], [2.0, 1.0], [4.0, 0.0], [2.0, 3.0]]],
        };
        for outline in [arrow, square_with_hole()] {
            let sum: f64 = (0..40)
                .map(|k| {
                    outline
                        .strip(0, 0.1 * f64::from(k), 0.1 * f64::from(k + 1))
                        .area()
                })
                .sum();
            // Forty sums of numbers of order ten.
            assert!(
                (sum - outline.area()).abs() < 1e-13,
                "{sum} {}",
                outline.area()
            );
        }
    }

    #[test]
    fn edges_chain_into_loops_with_the_hole_clockwise() {
        let nodes = [
            [0.0, 0.0],
            [4.0, 0.0],
            [0.0, 4.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [2.0, 1.0],
        ];
        let edge = |a, b| Edge {
            ends: [a, b],
            middle: None,
        };
        let edges = [
            edge(0, 1),
            edge(3, 4),
            edge(1, 2),
            edge(2, 0),
            edge(4, 5),
            edge(5, 3),
        ];
        let outline = Outline::from_edges(&edges, &nodes);
        assert_eq!(
            outline.loops.iter().map(Vec::len).collect::<Vec<_>>(),
            [3, 3]
        );
        assert!((outline.area() - (8.0 - 0.5)).abs() < 1e-15);
        // 8 · 4/3 less ½ · 4/3, over 7.5.
        let centroid = outline.centroid();
        assert!(centroid.iter().all(|x| (x - 4.0 / 3.0).abs() < 1e-15));
    }

    #[test]
    fn nearest_point_is_an_end_or_the_foot_of_the_perpendicular() {
        let segment = [[0.0, 0.0], [2.0, 0.0]];
        assert_eq!(nearest_on_segment([1.0, 3.0], segment), ([1.0, 0.0], 3.0));
        assert_eq!(nearest_on_segment([5.0, 4.0], segment), ([2.0, 0.0], 5.0));
    }
}
