//! The lattice: material points x_i with areas A_i that stand for a region, eq. (16).

use super::axes::Axes;
use super::point_index::PointIndex;
use super::visibility::Visibility;
use crate::geometry::{Outline, nearest_on_segment};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Position of the points on a grid of squares. Unless its origin is given, the grid begins at the region's
/// box where squares fill that; where they do not, it lies in the middle of the box, so that mirror images
/// have mirror images of lattices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Placement {
    /// In the middle of the squares: no point on the boundary.
    CellCentred,
    /// On the corners: first and last rows and columns on the boundary (Table 1 of the paper).
    GridNodes,
}

/// The area that a point stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum CellArea {
    /// dx², wherever the point is: the paper's.
    Full,
    /// |square around the point ∩ region|: the areas sum to the region's.
    Clipped,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticeSettings {
    /// dx [m].
    pub spacing: f64,
    pub placement: Placement,
    pub cell_area: CellArea,
    /// From the x axis to the lattice's first axis, counter-clockwise [rad].
    pub angle: f64,
    /// A corner of the grid's squares [m]; `None`: see [`Placement`].
    pub origin: Option<[f64; 2]>,
}

impl LatticeSettings {
    /// Parallel to x and y, anchored at the region's box.
    pub fn upright(spacing: f64, placement: Placement, cell_area: CellArea) -> LatticeSettings {
        LatticeSettings {
            spacing,
            placement,
            cell_area,
            angle: 0.0,
            origin: None,
        }
    }

    /// The lattice's axes.
    pub fn axes(&self) -> Axes {
        Axes::new(self.angle)
    }

    /// The same lattice seen along its own axes.
    pub fn along_axes(&self) -> LatticeSettings {
        LatticeSettings {
            angle: 0.0,
            origin: self.origin.map(|origin| self.axes().local(origin)),
            ..*self
        }
    }
}

/// Material points, row by row from the lower left.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// x_i [m].
    pub positions: Vec<[f64; 2]>,
    /// A_i [m²].
    pub areas: Vec<f64>,
    pub index: PointIndex,
}

/// What lies on the other side of an interface.
#[derive(Clone, Copy, Debug)]
pub struct Neighbourhood<'a> {
    /// The segments shared with finite elements.
    pub interface: &'a [[[f64; 2]; 2]],
    /// Points nearer to the interface than this share of dx are left out [-].
    pub clearance: f64,
    /// What cells at the interface are clipped by in place of the region, if the lattice goes on
    /// beyond it.
    pub body: Option<&'a Outline>,
}

/// Points within this fraction of dx of the boundary lie on it: mesh coordinates carry noise of
/// a relative 1e-10.
pub const ON_BOUNDARY: f64 = 1e-6;

/// Squares whose centre is farther than this from a segment do not touch it [dx].
const HALF_DIAGONAL: f64 = 0.7072;

/// Up to this distance a sliver's takers must be seen from it [dx].
const SLIVER_SEES: f64 = 3.0;

/// Areas within this fraction of dx² of the whole square are the whole square.
const WHOLE_CELL: f64 = 1e-9;

/// Fills `outline` with material points. All is seen along the lattice's axes: `settings.angle` is not
/// looked at.
///
/// `interface`: the segments shared with finite elements. Points on them are left out, since the
/// interface nodes sit there; the first column is then dx away.
pub fn lattice(
    outline: &Outline,
    interface: &[[[f64; 2]; 2]],
    settings: &LatticeSettings,
) -> Lattice {
    let neighbourhood = Neighbourhood {
        interface,
        clearance: ON_BOUNDARY,
        body: None,
    };
    lattice_beside(outline, &neighbourhood, settings)
}

/// The same where an interface may be more than a row of nodes.
pub fn lattice_beside(
    outline: &Outline,
    neighbourhood: &Neighbourhood,
    settings: &LatticeSettings,
) -> Lattice {
    let grid = Grid::new(outline, settings);
    let mut kept = grid.points_inside(outline);
    for &segment in neighbourhood.interface {
        grid.visit_points_near(segment, neighbourhood.clearance, |k| kept[k] = false);
    }
    let areas = match settings.cell_area {
        CellArea::Full => kept
            .iter()
            .map(|&k| if k { grid.dx * grid.dx } else { 0.0 })
            .collect(),
        CellArea::Clipped => grid.clipped_areas(outline, neighbourhood, &kept),
    };
    let points = (0..kept.len()).filter(|&k| kept[k]);
    let (positions, areas) = points
        .map(|k| (grid.position(k % grid.columns, k / grid.columns), areas[k]))
        .unzip();
    Lattice {
        positions,
        areas,
        index: PointIndex::new(grid.first, grid.dx, [grid.columns, grid.rows], &kept),
    }
}

/// What of `part` of a region each of its lattice's points stands for, at `positions` [m²]: the area of its
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

/// The lattice of a region continued over the whole body, finite elements and other regions included:
/// what a family would find if all of the body were points.
#[derive(Clone, Debug)]
pub struct Sites {
    grid: Grid,
    /// Area of the site over dx²; zero outside the body [-].
    pub shares: Vec<f64>,
}

impl Sites {
    /// `outline` anchors the lattice, `margin` is how many spacings it reaches past that outline's box.
    pub fn new(
        outline: &Outline,
        body: &Outline,
        settings: &LatticeSettings,
        margin: usize,
    ) -> Sites {
        let grid = Grid::new(outline, settings).widened(margin);
        let kept = grid.points_inside(body);
        let whole = grid.dx * grid.dx;
        let shares = match settings.cell_area {
            CellArea::Full => kept.iter().map(|&k| f64::from(u8::from(k))).collect(),
            CellArea::Clipped => {
                // Rounding leaves slivers outside, which a whole cell takes up.
                let share = |area: f64| {
                    let share = area / whole;
                    if (share - 1.0).abs() < WHOLE_CELL {
                        1.0
                    } else {
                        share
                    }
                };
                let free = Neighbourhood {
                    interface: &[],
                    clearance: ON_BOUNDARY,
                    body: None,
                };
                let areas = grid.clipped_areas(body, &free, &kept);
                areas.into_iter().map(share).collect()
            }
        };
        Sites { grid, shares }
    }

    /// Columns and rows.
    pub fn counts(&self) -> [usize; 2] {
        [self.grid.columns, self.grid.rows]
    }

    /// [m].
    pub fn position(&self, site: usize) -> [f64; 2] {
        let columns = self.grid.columns;
        self.grid.position(site % columns, site / columns)
    }

    /// Column and row of a position, fractions included.
    pub fn coordinates(&self, position: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (position[axis] - self.grid.first[axis]) / self.grid.dx)
    }

    /// The site nearest to a position on the grid.
    pub fn nearest(&self, position: [f64; 2]) -> usize {
        let [column, row] = [0, 1].map(|axis| {
            let index = (position[axis] - self.grid.first[axis]) / self.grid.dx;
            let last = self.counts()[axis] - 1;
            (index.round().max(0.0) as usize).min(last)
        });
        row * self.grid.columns + column
    }
}

/// The grid of candidate points over the region's bounding box.
#[derive(Clone, Debug)]
struct Grid {
    /// The candidate (0, 0) [m].
    first: [f64; 2],
    dx: f64,
    columns: usize,
    rows: usize,
}

impl Grid {
    fn new(outline: &Outline, settings: &LatticeSettings) -> Grid {
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

    /// The same grid with so many more columns and rows on every side.
    fn widened(&self, margin: usize) -> Grid {
        Grid {
            first: self.first.map(|x| x - margin as f64 * self.dx),
            dx: self.dx,
            columns: self.columns + 2 * margin,
            rows: self.rows + 2 * margin,
        }
    }

    fn position(&self, column: usize, row: usize) -> [f64; 2] {
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
    fn points_inside(&self, outline: &Outline) -> Vec<bool> {
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
    fn visit_points_near(&self, segment: [[f64; 2]; 2], share: f64, mut visit: impl FnMut(usize)) {
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

    /// |square ∩ region| of every candidate [m²]. What belongs to a candidate that is not kept goes
    /// to the nearest kept one, in equal parts to those that are equally near, but for points at the
    /// interface: the finite elements carry that area.
    fn clipped_areas(
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

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(w: f64, h: f64) -> Outline {
        Outline {
            loops: vec![vec![
                [1.0, 2.0],
                [1.0 + w, 2.0],
                [1.0 + w, 2.0 + h],
                [1.0, 2.0 + h],
            ]],
        }
    }

    fn settings(placement: Placement, cell_area: CellArea) -> LatticeSettings {
        LatticeSettings::upright(0.1, placement, cell_area)
    }

    #[test]
    fn a_fitting_rectangle_has_a_point_per_square_or_per_corner() {
        let outline = rectangle(2.0, 0.5);
        let centred = lattice(
            &outline,
            &[],
            &settings(Placement::CellCentred, CellArea::Full),
        );
        let nodes = lattice(
            &outline,
            &[],
            &settings(Placement::GridNodes, CellArea::Full),
        );
        assert_eq!(
            (centred.positions.len(), nodes.positions.len()),
            (20 * 5, 21 * 6)
        );
        assert!((centred.positions[0][0] - 1.05).abs() < 1e-15);
        assert!((nodes.positions[125][1] - 2.5).abs() < 1e-15);
    }

    #[test]
    fn clipped_areas_sum_to_the_area_of_the_region() {
        let hexagon = Outline {
            loops: vec![
                (0..6)
                    .map(|k| {
                        let (s, c) = (f64::from(k) * std::f64::consts::PI / 3.0 + 0.1).sin_cos();
                        [0.77 * c, 0.77 * s]
                    })
                    .collect(),
            ],
        };
        let mut holed = rectangle(2.03, 0.97);
        holed
            .loops
            .push(vec![[1.41, 2.33], [1.52, 2.71], [1.93, 2.65]]);
        for outline in [rectangle(2.0, 0.5), rectangle(1.96, 0.53), hexagon, holed] {
            for placement in [Placement::CellCentred, Placement::GridNodes] {
                let lattice = lattice(&outline, &[], &settings(placement, CellArea::Clipped));
                let sum: f64 = lattice.areas.iter().sum();
                // Some hundred cells, each with rounding errors of 1e-16 of the region's area; whole
                // cells are snapped within 1e-9 of themselves only where they are whole.
                assert!(
                    (sum / outline.area() - 1.0).abs() < 1e-13,
                    "{placement:?} {sum}"
                );
            }
        }
    }

    #[test]
    fn points_on_the_interface_are_left_to_the_finite_elements() {
        let interface = [[[1.0, 2.0], [1.0, 2.25]], [[1.0, 2.25], [1.0, 2.5]]];
        let lattice = lattice(
            &rectangle(2.0, 0.5),
            &interface,
            &settings(Placement::GridNodes, CellArea::Full),
        );
        assert_eq!(lattice.positions.len(), 20 * 6);
        assert!(lattice.positions.iter().all(|p| p[0] > 1.09));
    }
}
