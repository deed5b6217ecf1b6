//! The lattice of a region continued over the whole body.

use super::areas::WHOLE_CELL;
use super::grid::Grid;
use super::{CellArea, LatticeSettings, Neighbourhood, ON_BOUNDARY};
use crate::geometry::Outline;

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
