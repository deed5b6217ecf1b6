//! Areas of the points of a lattice: their squares clipped by the region.

use super::grid::Grid;
use super::{LatticeSettings, Neighbourhood, ON_BOUNDARY};
use crate::geometry::Outline;
use crate::peridynamics::visibility::Visibility;
use rayon::prelude::*;

/// Squares whose centre is farther than this from a segment do not touch it [dx].
const HALF_DIAGONAL: f64 = 0.7072;

/// Up to this distance a sliver's takers must be seen from it [dx].
const SLIVER_SEES: f64 = 3.0;

/// Areas within this fraction of dx² of the whole square are the whole square.
pub(super) const WHOLE_CELL: f64 = 1e-9;

/// The area of `part` of a region that each of its lattice's points stands for, at `positions` [m²]: that of its
/// square in the part, slivers included, so that the sum is the part's. `outline`: of the region, which
/// anchors the lattice.
pub fn areas_within(
    part: &Outline,
    outline: &Outline,
    settings: &LatticeSettings,
    positions: &[[f64; 2]],
) -> Vec<f64> {
    let grid = Grid::new(outline, settings);
    let place = |&[x, y]: &[f64; 2]| {
        let index = |x: f64, axis: usize| ((x - grid.first[axis]) / grid.dx).round() as usize;
        index(y, 1) * grid.columns + index(x, 0)
    };
    let places: Vec<usize> = positions.iter().map(place).collect();
    let mut kept = vec![false; grid.columns * grid.rows];
    places.iter().for_each(|&k| kept[k] = true);
    let neighbourhood = Neighbourhood {
        interface: &[],
        clearance: ON_BOUNDARY,
        body: None,
    };
    let areas = grid.clipped_areas(part, &neighbourhood, &kept);
    places.into_iter().map(|k| areas[k]).collect()
}

impl Grid {
    /// |square ∩ region| of every candidate [m²]. What belongs to a candidate that is not kept goes
    /// to the nearest kept one, in equal parts to those that are equally near, but for points at the
    /// interface: the finite elements carry that area.
    pub(super) fn clipped_areas(
        &self,
        outline: &Outline,
        neighbourhood: &Neighbourhood,
        kept: &[bool],
    ) -> Vec<f64> {
        let areas_in = |outline: &Outline| -> Vec<f64> {
            let rows: Vec<Vec<f64>> = (0..self.rows)
                .into_par_iter()
                .map(|row| self.row_areas(outline, row))
                .collect();
            rows.concat()
        };
        let mut areas = areas_in(outline);
        if let Some(body) = neighbourhood.body {
            let beyond = areas_in(body);
            for &segment in neighbourhood.interface {
                self.visit_points_near(segment, HALF_DIAGONAL, |k| {
                    areas[k] = if kept[k] { beyond[k] } else { 0.0 };
                });
            }
        }
        for &segment in neighbourhood.interface {
            self.visit_points_near(segment, neighbourhood.clearance, |k| areas[k] = 0.0);
        }
        self.share_slivers(outline, kept, &mut areas);
        areas
    }

    /// Gives the areas of candidates that are not kept to others. Those that the sliver's centroid sees
    /// come first, lest a notch's other side gets it.
    fn share_slivers(&self, outline: &Outline, kept: &[bool], areas: &mut [f64]) {
        let is_sliver = |k: &usize| !kept[*k] && areas[*k] > 0.0;
        let slivers: Vec<usize> = (0..areas.len()).filter(is_sliver).collect();
        let visibility = Visibility::new(outline, self.dx, 2.0 * SLIVER_SEES * self.dx);
        let takers = |&k: &usize| {
            let [x, y] = self.position(k % self.columns, k / self.columns);
            let half = 0.5 * self.dx;
            let row = outline.strip(1, y - half, y + half);
            let centroid = row.strip(0, x - half, x + half).centroid();
            let view = visibility.from(centroid);
            let sees = |other: usize| {
                kept[other] && view.sees(self.position(other % self.columns, other / self.columns))
            };
            let seen = self.nearest(k, SLIVER_SEES, sees);
            let mut reach = SLIVER_SEES;
            let mut found = seen;
            while found.is_empty() && reach < 2.0 * (self.columns + self.rows) as f64 {
                found = self.nearest(k, reach, |other| kept[other]);
                reach *= 2.0;
            }
            found
        };
        let takers: Vec<Vec<usize>> = slivers.par_iter().map(takers).collect();
        for (sliver, takers) in slivers.into_iter().zip(takers) {
            let share = std::mem::take(&mut areas[sliver]) / takers.len() as f64;
            takers.into_iter().for_each(|taker| areas[taker] += share);
        }
    }

    fn row_areas(&self, outline: &Outline, row: usize) -> Vec<f64> {
        let half = 0.5 * self.dx;
        let y = self.position(0, row)[1];
        let band = outline.strip(1, y - half, y + half);
        let whole = self.dx * self.dx;
        (0..self.columns)
            .map(|column| {
                let x = self.position(column, row)[0];
                let area = band.strip(0, x - half, x + half).area();
                if (area - whole).abs() < WHOLE_CELL * whole {
                    whole
                } else {
                    area
                }
            })
            .collect()
    }

    /// The candidates nearest to the k-th, up to `reach` dx away, that `is_wanted` says yes to; several
    /// that are equally near.
    fn nearest(&self, k: usize, reach: f64, is_wanted: impl Fn(usize) -> bool) -> Vec<usize> {
        let (column, row) = ((k % self.columns) as i64, (k / self.columns) as i64);
        let steps = reach as i64;
        let mut offsets: Vec<(i64, i64, i64)> = (-steps..=steps)
            .flat_map(|q| (-steps..=steps).map(move |p| (p * p + q * q, p, q)))
            .filter(|&(squared, p, q)| {
                let inside = (0..self.columns as i64).contains(&(column + p))
                    && (0..self.rows as i64).contains(&(row + q));
                inside && squared > 0 && squared as f64 <= reach * reach
            })
            .collect();
        offsets.sort_unstable();
        let mut found = Vec::new();
        let mut distance = None;
        for (squared, p, q) in offsets {
            if distance.is_some_and(|d| squared > d) {
                break;
            }
            let other = (row + q) as usize * self.columns + (column + p) as usize;
            if is_wanted(other) {
                distance = Some(squared);
                found.push(other);
            }
        }
        found
    }
}
