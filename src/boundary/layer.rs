//! The layer of material points beside a curve: those within dx/2, and the nearest to any piece of the curve
//! that has none so near, as when dx does not divide the region. Points that the curve does not see, behind
//! a notch or a hole, do not belong to it.

use crate::geometry::{chords, nearest_on_segment};
use crate::mesh::Edge;
use crate::model::{Model, PointRegion};
use crate::peridynamics::axes::Axes;
use crate::peridynamics::bonds::Bins;
use crate::peridynamics::visibility::Visibility;
use std::collections::BTreeMap;

/// A material point beside a curve.
pub(super) struct LayerPoint {
    pub node: usize,
    /// Outward normal of the curve at its nearest point.
    pub normal: [f64; 2],
}

/// An edge of a region's outline, cut into chords: [from, to].
pub(super) type Segment = [[f64; 2]; 2];

/// Points as far as this from a curve, in spacings, belong to its layer; the excess over 1/2 covers
/// rounding errors.
const LAYER_DEPTH: f64 = 0.5 + 1e-6;

/// The nearest points belong to the layer where none is within the depth, up to this distance, in spacings:
/// a square's diagonal.
pub(super) const LAYER_REACH: f64 = 1.42;

/// Sides whose distances differ by less, in spacings, are equally near.
const EQUALLY_NEAR: f64 = 1e-9;

/// The layer of material points beside the edges, ascending.
///
/// The normal is the mean of two sides where a corner of the curve is nearest, or both are equally near:
/// the choice of one would turn the loads on a hole all the same way round.
pub(super) fn layer(model: &Model, points: &PointRegion, edges: &[Edge]) -> Vec<LayerPoint> {
    let same = EQUALLY_NEAR * points.micromodulus.spacing;
    let positions = &model.positions[points.nodes.clone()];
    let bins = Bins::new(positions, 2.0 * points.micromodulus.spacing);
    let visibility = model.visibility(&Axes::new(0.0), &points.micromodulus);
    let points_beside = |segment: Segment| {
        let spacing = points.micromodulus.spacing;
        beside(segment, positions, &bins, spacing, &visibility)
    };
    let mut nearest: BTreeMap<u32, (f64, [f64; 2])> = BTreeMap::new();
    for segment in edges
        .iter()
        .flat_map(|edge| short_segments(model, edge, points))
    {
        let normal = right_of(segment);
        for (i, distance) in points_beside(segment) {
            let (other, sum) = nearest.entry(i).or_insert((distance, [0.0; 2]));
            if distance < *other - same {
                (*other, *sum) = (distance, normal);
            } else if distance < *other + same {
                *sum = [sum[0] + normal[0], sum[1] + normal[1]];
            }
        }
    }
    let point = |(i, (_, sum)): (u32, (f64, [f64; 2]))| LayerPoint {
        node: points.nodes.start + i as usize,
        normal: mean_direction(sum),
    };
    nearest.into_iter().map(point).collect()
}

/// The points within dx/2 of a short segment, or else the nearest, each with its distance [m].
fn beside(
    segment: Segment,
    positions: &[[f64; 2]],
    bins: &Bins,
    spacing: f64,
    visibility: &Visibility,
) -> Vec<(u32, f64)> {
    let middle = [0, 1].map(|axis| 0.5 * (segment[0][axis] + segment[1][axis]));
    let mut around = Vec::new();
    bins.visit_around(middle, |i| {
        let x = positions[i as usize];
        let (foot, distance) = nearest_on_segment(x, segment);
        if distance <= LAYER_REACH * spacing && visibility.sees(foot, x) {
            around.push((i, distance));
        }
    });
    let least = around.iter().map(|&(_, d)| d).fold(f64::INFINITY, f64::min);
    let depth = if least <= LAYER_DEPTH * spacing {
        LAYER_DEPTH * spacing
    } else {
        (least + EQUALLY_NEAR * spacing).min(LAYER_REACH * spacing)
    };
    around.retain(|&(_, distance)| distance <= depth);
    around
}

/// Unit normal to the right of a segment's direction.
pub(super) fn right_of([a, b]: Segment) -> [f64; 2] {
    let along = [b[0] - a[0], b[1] - a[1]];
    let length = along[0].hypot(along[1]);
    [along[1] / length, -along[0] / length]
}

/// The direction of a sum of unit normals; none where opposite sides are equally near, whose pressures
/// cancel.
fn mean_direction(sum: [f64; 2]) -> [f64; 2] {
    let length = sum[0].hypot(sum[1]);
    if length > 1e-6 {
        sum.map(|n| n / length)
    } else {
        [0.0; 2]
    }
}

/// An edge in pieces no longer than dx, so that the bins of 2 dx around a piece's middle hold its layer.
pub(super) fn short_segments(model: &Model, edge: &Edge, points: &PointRegion) -> Vec<Segment> {
    let mut pieces = Vec::new();
    for chord in chords(edge, &model.mesh.nodes).windows(2) {
        let [a, b] = [chord[0], chord[1]];
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let count = (length / points.micromodulus.spacing).ceil().max(1.0) as usize;
        let at = |k: usize| [0, 1].map(|x| a[x] + (b[x] - a[x]) * k as f64 / count as f64);
        pieces.extend((0..count).map(|k| [at(k), at(k + 1)]));
    }
    pieces
}
