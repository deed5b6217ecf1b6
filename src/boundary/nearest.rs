//! A traction on a layer of material points: each point takes the load on the part of the curve to which it
//! is the nearest. So the resultant is exact, that of a pressure in a hole is zero, and on a straight side
//! along the lattice all points have the same load.
//!
//! Along a chord x = a + s t, |x − p_i|² differs from point to point by c_i − 2 s m_i, linear in s; the
//! nearest point is found from the lower envelope of these lines.

use super::Boundary;
use super::layer::{LAYER_REACH, Segment, right_of, short_segments};
use crate::fem::edge::EdgeLoad;
use crate::geometry::nearest_on_segment;
use crate::mesh::Edge;
use crate::model::{Model, PointRegion};
use crate::peridynamics::axes::Axes;
use crate::peridynamics::bonds::Bins;
use std::collections::BTreeMap;

/// Two points are equally near where c differs by a smaller share of dx².
const TIE: f64 = 1e-9;

/// The line c − 2 s m of a point.
#[derive(Clone, Copy, Debug)]
struct Line {
    point: u32,
    c: f64,
    m: f64,
}

impl Line {
    fn at(&self, s: f64) -> f64 {
        self.c - 2.0 * s * self.m
    }
}

impl Boundary {
    /// Adds a load on the points beside the edges of a peridynamic region. Returns whether there are any.
    pub(super) fn add_nearest_traction(
        &mut self,
        model: &Model,
        points: &PointRegion,
        edges: &[Edge],
        load: EdgeLoad,
    ) -> bool {
        let spacing = points.micromodulus.spacing;
        let positions = &model.positions[points.nodes.clone()];
        let bins = Bins::new(positions, 2.0 * spacing);
        let visibility = model.visibility(&Axes::new(0.0), &points.micromodulus);
        let (mut taken, mut lost) = (BTreeMap::new(), [0.0; 2]);
        for segment in edges.iter().flat_map(|e| short_segments(model, e, points)) {
            let middle = [0, 1].map(|axis| 0.5 * (segment[0][axis] + segment[1][axis]));
            let mut lines = Vec::new();
            bins.visit_around(middle, |i| {
                let x = positions[i as usize];
                let (foot, distance) = nearest_on_segment(x, segment);
                if distance <= LAYER_REACH * spacing && visibility.sees(foot, x) {
                    lines.push(line(segment, i, x));
                }
            });
            lines.sort_unstable_by_key(|line| line.point);
            let traction = load.traction(right_of(segment));
            let force = |length: f64| traction.map(|t| t * length * model.settings.thickness);
            let length = length(segment);
            if lines.is_empty() {
                let [x, y] = force(length);
                lost = [lost[0] + x, lost[1] + y];
            }
            for (point, part) in shares(&lines, length, TIE * spacing * spacing) {
                *taken.entry(point).or_insert(0.0) += part;
                self.add_nodal_force(points.nodes.start + point as usize, force(part));
            }
        }
        // What acts on a spike without a point near it goes to all the others.
        let total: f64 = taken.values().sum();
        for (&point, part) in &taken {
            let node = points.nodes.start + point as usize;
            self.add_nodal_force(node, lost.map(|f| f * part / total));
        }
        !taken.is_empty()
    }
}

fn length([a, b]: Segment) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

fn line([a, b]: Segment, point: u32, x: [f64; 2]) -> Line {
    let length = length([a, b]);
    let from = [x[0] - a[0], x[1] - a[1]];
    Line {
        point,
        c: from[0] * from[0] + from[1] * from[1],
        m: (from[0] * (b[0] - a[0]) + from[1] * (b[1] - a[1])) / length,
    }
}

/// The length of 0 ≤ s ≤ `length` to which each point is the nearest [m]; points that are equally near
/// share it.
fn shares(lines: &[Line], length: f64, tie: f64) -> Vec<(u32, f64)> {
    let mut parts = Vec::new();
    let mut from = 0.0;
    while from < length && !lines.is_empty() {
        let least = lines
            .iter()
            .map(|l| l.at(from))
            .fold(f64::INFINITY, f64::min);
        let near = || lines.iter().filter(|l| l.at(from) <= least + tie);
        // Of those that are equally near here, the nearest from here on.
        let slope = near().map(|l| l.m).fold(f64::NEG_INFINITY, f64::max);
        let is_nearest = |l: &&Line| (l.m - slope).abs() * length <= tie;
        let nearest: Vec<Line> = near().filter(is_nearest).copied().collect();
        let first = nearest[0];
        let crossing = |l: &Line| {
            let s = (l.c - first.c) / (2.0 * (l.m - first.m));
            ((l.m - first.m) * length > tie && s > from).then_some(s)
        };
        let to = lines.iter().filter_map(crossing).fold(length, f64::min);
        let part = (to - from) / nearest.len() as f64;
        parts.extend(nearest.iter().map(|l| (l.point, part)));
        from = to;
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_segment_belongs_to_the_points_that_are_nearest() {
        let segment = [[0.0, 0.0], [3.0, 0.0]];
        let points = [[0.5, 0.5], [1.5, 0.5], [2.5, 0.5], [1.0, 1.5]];
        let lines: Vec<Line> = (0..)
            .zip(points)
            .map(|(i, x)| line(segment, i, x))
            .collect();
        assert_eq!(shares(&lines, 3.0, 1e-9), [(0, 1.0), (1, 1.0), (2, 1.0)]);
        // One above the other: the lower one; mirror images share alike.
        let above = [[1.0, 0.5], [1.0, 0.7], [1.0, -0.5]];
        let lines: Vec<Line> = (0..).zip(above).map(|(i, x)| line(segment, i, x)).collect();
        assert_eq!(shares(&lines, 3.0, 1e-9), [(0, 1.5), (2, 1.5)]);
        assert!(shares(&[], 3.0, 1e-9).is_empty());
    }
}
