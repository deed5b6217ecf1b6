//! The grid of candidate points over a region's bounding box.

use super::{LatticeSettings, ON_BOUNDARY, Placement};
use crate::geometry::{Outline, nearest_on_segment};
use rayon::prelude::*;

/// The grid of candidate points over the region's bounding box.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// The candidate (0, 0) [m].
    pub(super) first: [f64; 2],
    pub(super) dx: f64,
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl Grid {
    pub(super) fn new(outline: &Outline, settings: &LatticeSettings) -> Grid {
        let [mut low, high] = outline.bounds();
        let dx = settings.spacing;
        for axis in 0..2 {
            let squares = (high[axis] - low[axis]) / dx;
            match settings.origin {
                Some(origin) => {
                    let steps = (low[axis] - origin[axis]) / dx;
                    low[axis] = origin[axis] + (steps + ON_BOUNDARY).floor() * dx;
                }
                None if (squares - squares.round()).abs() <= ON_BOUNDARY => {}
                None => {
                    let fitting = match settings.placement {
                        Placement::CellCentred => squares.ceil(),
                        Placement::GridNodes => squares.floor(),
                    };
                    low[axis] += 0.5 * (squares - fitting) * dx;
                }
            }
        }
        let squares = |axis: usize| (high[axis] - low[axis]) / dx;
        let (shift, [columns, rows]) = match settings.placement {
            Placement::CellCentred => (
                0.5 * dx,
                [0, 1].map(|axis| (squares(axis) - ON_BOUNDARY).ceil().max(1.0) as usize),
            ),
            Placement::GridNodes => (
                0.0,
                // One past the last corner where the region goes on for more than dx/2.
                [0, 1].map(|axis| (squares(axis) + 0.5 - ON_BOUNDARY).ceil().max(1.0) as usize),
            ),
        };
        Grid {
            first: low.map(|x| x + shift),
            dx,
            columns,
            rows,
        }
    }

    /// The grid with so many more columns and rows on every side.
    pub(super) fn widened(&self, margin: usize) -> Grid {
        Grid {
            first: self.first.map(|x| x - margin as f64 * self.dx),
            dx: self.dx,
            columns: self.columns + 2 * margin,
            rows: self.rows + 2 * margin,
        }
    }

    pub(super) fn position(&self, column: usize, row: usize) -> [f64; 2] {
        [
            self.first[0] + column as f64 * self.dx,
            self.first[1] + row as f64 * self.dx,
        ]
    }

    /// The indices k with low ≤ first + k dx ≤ high, within the grid.
    fn indices(&self, axis: usize, low: f64, high: f64) -> std::ops::Range<usize> {
        let count = [self.columns, self.rows][axis];
        let index = |x: f64| (x - self.first[axis]) / self.dx;
        let from = index(low).ceil().max(0.0) as usize;
        let to = (index(high).floor() + 1.0).max(0.0) as usize;
        from.min(count)..to.min(count).max(from.min(count))
    }

    /// Whether each candidate lies inside the outline or on it.
    pub(super) fn points_inside(&self, outline: &Outline) -> Vec<bool> {
        let tolerance = ON_BOUNDARY * self.dx;
        let row_inside = |row: usize| {
            let mut inside = vec![false; self.columns];
            let y = self.position(0, row)[1];
            for level in [y - tolerance, y, y + tolerance] {
                for [a, b] in outline.inside_at(level) {
                    inside[self.indices(0, a - tolerance, b + tolerance)].fill(true);
                }
            }
            inside
        };
        let rows: Vec<Vec<bool>> = (0..self.rows).into_par_iter().map(row_inside).collect();
        rows.concat()
    }

    /// The candidates within `share` dx of a segment.
    pub(super) fn visit_points_near(
        &self,
        segment: [[f64; 2]; 2],
        share: f64,
        mut visit: impl FnMut(usize),
    ) {
        let tolerance = share * self.dx;
        let [a, b] = segment;
        let range = |axis: usize| {
            let (low, high) = (a[axis].min(b[axis]), a[axis].max(b[axis]));
            self.indices(axis, low - tolerance, high + tolerance)
        };
        for row in range(1) {
            for column in range(0) {
                if nearest_on_segment(self.position(column, row), segment).1 <= tolerance {
                    visit(row * self.columns + column);
                }
            }
        }
    }
}
