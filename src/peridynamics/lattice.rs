//! The lattice: material points x_i with areas A_i that stand for a region, eq. (16).

mod areas;
mod grid;
mod sites;

use super::axes::Axes;
use super::point_index::PointIndex;
use crate::geometry::Outline;
use grid::Grid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use areas::areas_within;
pub use sites::Sites;

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
    /// Angle from the x axis to the lattice's first axis, counter-clockwise [rad].
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

    /// The settings of the lattice seen along its own axes.
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

/// The other side of a lattice's interface.
#[derive(Clone, Copy, Debug)]
pub struct Neighbourhood<'a> {
    /// The segments shared with finite elements.
    pub interface: &'a [[[f64; 2]; 2]],
    /// Points nearer to the interface than this share of dx are left out [-].
    pub clearance: f64,
    /// Outline that clips the squares at the interface in place of the region, if the lattice goes on
    /// beyond it.
    pub body: Option<&'a Outline>,
}

/// Points within this fraction of dx of the boundary lie on it: mesh coordinates carry noise of
/// a relative 1e-10.
pub const ON_BOUNDARY: f64 = 1e-6;

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

/// Fills `outline` with material points beside an interface that may be more than a row of nodes.
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
