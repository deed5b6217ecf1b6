//! The area that each material point stands for in a picture: its square, cut by the outline of its region
//! as the elements on the other side are. Without the cut, the squares of a turned lattice have teeth and
//! leave holes along an interface.

use crate::geometry::Outline;
use crate::model::PointRegion;
use rayon::prelude::*;

/// The area of one material point, or a part of it.
pub(super) enum LatticeCell {
    /// The whole square of a node.
    Square(usize),
    /// A polygon in the region for which a node stands [m].
    Piece(usize, Vec<[f64; 2]>),
}

/// A cell that lacks a smaller share of its area is whole, and one that has a smaller share is none.
const WHOLE: f64 = 1e-6;

/// Sites around a site, the nearest first.
const AROUND: [[i64; 2]; 8] = [
    [1, 0],
    [-1, 0],
    [0, 1],
    [0, -1],
    [1, 1],
    [-1, 1],
    [1, -1],
    [-1, -1],
];

/// The cells of a lattice in `outline`, of the nodes for which `is_inside` holds. A sliver whose own site
/// holds no point goes to the nearest point beside it.
pub(super) fn lattice_cells(
    points: &PointRegion,
    outline: &Outline,
    is_inside: impl Fn(usize) -> bool + Sync,
) -> Vec<LatticeCell> {
    let index = &points.index;
    let outline = points.axes.outline(outline);
    let site = |x: [f64; 2]| index.coordinates(x).map(|k| k.round() as i64);
    let low = |k: i64, axis: usize| index.first[axis] + (k as f64 - 0.5) * index.spacing;
    let node = |site: [i64; 2]| {
        let node = points.nodes.start + index.point(site)? as usize;
        is_inside(node).then_some(node)
    };
    let beside = |[i, j]: [i64; 2]| AROUND.iter().find_map(|[x, y]| node([i + x, j + y]));
    let cells_of_row = |j: i64| {
        let row = outline.strip(1, low(j, 1), low(j + 1, 1));
        let [left, right] = match row.loops.is_empty() {
            true => [0, -1],
            false => row.bounds().map(|corner| site(corner)[0]),
        };
        let cell = move |i: i64| {
            let cell = row.strip(0, low(i, 0), low(i + 1, 0));
            let share = cell.area() / (index.spacing * index.spacing);
            let own = node([i, j]);
            match own {
                Some(node) if share > 1.0 - WHOLE => Some(LatticeCell::Square(node)),
                _ if share < WHOLE => None,
                _ => {
                    let corners = bridged(&cell).into_iter();
                    let corners = corners.map(|x| points.axes.global(x)).collect();
                    Some(LatticeCell::Piece(own.or_else(|| beside([i, j]))?, corners))
                }
            }
        };
        (left..=right)
            .filter_map(cell)
            .collect::<Vec<LatticeCell>>()
    };
    let [bottom, top] = outline.bounds().map(|corner| site(corner)[1]);
    let rows: Vec<Vec<LatticeCell>> = (bottom..=top).into_par_iter().map(cells_of_row).collect();
    rows.into_iter().flatten().collect()
}

/// The loops of an outline as one polygon: from each to the next and back, so that by the even-odd rule
/// the bridges cancel.
fn bridged(outline: &Outline) -> Vec<[f64; 2]> {
    let [first, rest @ ..] = outline.loops.as_slice() else {
        return Vec::new();
    };
    let mut corners = first.clone();
    for polygon in rest {
        corners.push(first[0]);
        corners.extend(polygon);
        corners.extend(polygon.first());
    }
    corners
}
