//! Families and bonds: all pairs of a lattice's points within the horizon of each other that see each
//! other ([`super::visibility`]).

use super::kernel::{Micromodulus, axial_stiffness};
use super::lattice::Lattice;
use super::visibility::Visibility;
use crate::interactions::Interactions;
use rayon::prelude::*;

/// The family of an inner lattice point, in spacings from it, row by row.
pub fn family_offsets(micromodulus: &Micromodulus) -> Vec<[i32; 2]> {
    let reach = micromodulus.reach() / micromodulus.spacing;
    let steps = reach as i32;
    let rows = (-steps..=steps).flat_map(|q| (-steps..=steps).map(move |p| [p, q]));
    let is_near = |&[p, q]: &[i32; 2]| f64::from(p).hypot(f64::from(q)) <= reach;
    rows.filter(|&offset| offset != [0, 0])
        .filter(is_near)
        .collect()
}

/// The bonds of one peridynamic region with their stiffness ([`axial_stiffness`]),
/// sorted by their ends, which count from `first_node`.
///
/// On a lattice a bond is a site and one of few offsets ξ, so that nothing is searched and c(ξ) is found
/// once per offset.
pub fn bonds(
    lattice: &Lattice,
    micromodulus: &Micromodulus,
    thickness: f64,
    first_node: u32,
    visibility: &Visibility,
) -> Interactions {
    let families = Families::new(lattice, micromodulus, thickness);
    let rows = (0..lattice.index.counts[1] as usize).into_par_iter();
    let rows: Vec<Row> = rows
        .map(|row| families.row(row as i64, visibility))
        .collect();
    let total = rows.iter().map(|row| row.bonds).sum();
    let mut pairs = vec![[0; 2]; total];
    let mut stiffness = vec![0.0; total];
    let (mut rest, mut rest_k) = (pairs.as_mut_slice(), stiffness.as_mut_slice());
    let mut slices = Vec::with_capacity(rows.len());
    for row in &rows {
        let (of_row, after) = rest.split_at_mut(row.bonds);
        let (k_of_row, k_after) = rest_k.split_at_mut(row.bonds);
        slices.push((of_row, k_of_row));
        (rest, rest_k) = (after, k_after);
    }
    slices
        .into_par_iter()
        .enumerate()
        .for_each(|(row, (pairs, stiffness))| {
            let hidden = &rows[row].hidden;
            families.fill(row as i64, first_node, hidden, pairs, stiffness);
        });
    Interactions::of_bonds(pairs, stiffness)
}

/// The families from which the bonds of a lattice are made.
struct Families<'a> {
    lattice: &'a Lattice,
    thickness: f64,
    /// Half of a family, the neighbours behind a point in the numbering, row by row: offset in spacings,
    /// c(ξ) [N/m⁵], ξ [m].
    half: Vec<([i64; 2], f64, f64)>,
}

/// The bonds from a row of sites.
struct Row {
    bonds: usize,
    /// Points and places in half a family: neighbours that the point does not see, ascending.
    hidden: Vec<(u32, u32)>,
}

impl Families<'_> {
    fn new<'a>(lattice: &'a Lattice, micromodulus: &Micromodulus, thickness: f64) -> Families<'a> {
        let offsets = family_offsets(micromodulus).into_iter();
        let half = offsets.filter(|&[p, q]| q > 0 || (q == 0 && p > 0));
        let half = half.map(|offset| {
            let bond = offset.map(|steps| f64::from(steps) * micromodulus.spacing);
            let xi = bond[0].hypot(bond[1]);
            (offset.map(i64::from), micromodulus.density(bond), xi)
        });
        Families {
            lattice,
            thickness,
            half: half.collect(),
        }
    }

    /// The points of a row of sites, with their columns.
    fn points(&self, row: i64) -> impl Iterator<Item = (i64, u32)> + '_ {
        let index = &self.lattice.index;
        (0..index.counts[0]).filter_map(move |column| Some((column, index.point([column, row])?)))
    }

    fn row(&self, row: i64, visibility: &Visibility) -> Row {
        let Lattice {
            index, positions, ..
        } = self.lattice;
        let (mut bonds, mut hidden) = (0, Vec::new());
        for (column, i) in self.points(row) {
            let view = visibility.from(positions[i as usize]);
            if !view.is_near() {
                let half = self.half.iter();
                let is_there = |([p, q], ..): &&([i64; 2], f64, f64)| {
                    index.point([column + p, row + q]).is_some()
                };
                bonds += half.filter(is_there).count();
                continue;
            }
            for (place, ([p, q], ..)) in self.half.iter().enumerate() {
                let Some(j) = index.point([column + p, row + q]) else {
                    continue;
                };
                if view.sees(positions[j as usize]) {
                    bonds += 1;
                } else {
                    hidden.push((i, place as u32));
                }
            }
        }
        Row { bonds, hidden }
    }

    fn fill(
        &self,
        row: i64,
        first_node: u32,
        hidden: &[(u32, u32)],
        pairs: &mut [[u32; 2]],
        stiffness: &mut [f64],
    ) {
        let Lattice { areas, index, .. } = self.lattice;
        let mut places = pairs.iter_mut().zip(stiffness);
        let mut hidden = hidden.iter().peekable();
        for (column, i) in self.points(row) {
            for (place, &([p, q], c, xi)) in self.half.iter().enumerate() {
                if let Some(j) = index.point([column + p, row + q])
                    && hidden.next_if(|&&h| h == (i, place as u32)).is_none()
                {
                    let (pair, k) = places.next().expect("the row was counted");
                    *pair = [first_node + i, first_node + j];
                    let areas = [i, j].map(|point| areas[point as usize]);
                    *k = axial_stiffness(c, xi, areas, self.thickness);
                }
            }
        }
    }
}

/// Points sorted into square bins of the side `reach`, so that neighbours lie in nine bins.
pub struct Bins {
    origin: [f64; 2],
    side: f64,
    counts: [usize; 2],
    start: Vec<u32>,
    points: Vec<u32>,
}

impl Bins {
    pub fn new(positions: &[[f64; 2]], reach: f64) -> Bins {
        let bound = |axis: usize, pick: fn(f64, f64) -> f64, from: f64| {
            positions.iter().map(|p| p[axis]).fold(from, pick)
        };
        let low = [0, 1].map(|axis| bound(axis, f64::min, f64::INFINITY));
        let high = [0, 1].map(|axis| bound(axis, f64::max, f64::NEG_INFINITY));
        let side = Bins::affordable_side(low, high, reach, positions.len());
        let counts = [0, 1].map(|axis| {
            let extent = high[axis] - low[axis];
            if extent > 0.0 {
                (extent / side) as usize + 1
            } else {
                1
            }
        });
        let mut bins = Bins {
            origin: if positions.is_empty() { [0.0; 2] } else { low },
            side,
            counts,
            start: vec![0; counts[0] * counts[1] + 1],
            points: vec![0; positions.len()],
        };
        bins.fill(positions);
        bins
    }

    /// `reach`, or more where the points are so scattered that most bins would be empty.
    fn affordable_side(low: [f64; 2], high: [f64; 2], reach: f64, points: usize) -> f64 {
        let area = (high[0] - low[0]).max(reach) * (high[1] - low[1]).max(reach);
        reach.max((area / (4.0 * points.max(1) as f64)).sqrt())
    }

    /// Counting sort: points of one bin stay in ascending order.
    fn fill(&mut self, positions: &[[f64; 2]]) {
        let bin_of: Vec<usize> = positions
            .iter()
            .map(|&p| self.index(self.cell(p)))
            .collect();
        bin_of.iter().for_each(|&bin| self.start[bin + 1] += 1);
        for bin in 1..self.start.len() {
            self.start[bin] += self.start[bin - 1];
        }
        let mut next = self.start.clone();
        for (point, &bin) in bin_of.iter().enumerate() {
            self.points[next[bin] as usize] = point as u32;
            next[bin] += 1;
        }
    }

    fn cell(&self, p: [f64; 2]) -> [usize; 2] {
        [0, 1].map(|axis| {
            let cell = ((p[axis] - self.origin[axis]) / self.side).max(0.0) as usize;
            cell.min(self.counts[axis] - 1)
        })
    }

    fn index(&self, cell: [usize; 2]) -> usize {
        cell[1] * self.counts[0] + cell[0]
    }

    /// Calls `visit` with every point in the nine bins around `p`: all that lie within `reach`, and more.
    pub fn visit_around(&self, p: [f64; 2], mut visit: impl FnMut(u32)) {
        let [x, y] = self.cell(p);
        for row in y.saturating_sub(1)..=(y + 1).min(self.counts[1] - 1) {
            for column in x.saturating_sub(1)..=(x + 1).min(self.counts[0] - 1) {
                let bin = self.index([column, row]);
                let range = self.start[bin] as usize..self.start[bin + 1] as usize;
                self.points[range].iter().for_each(|&point| visit(point));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Outline;
    use crate::material::{Material, PlaneState};
    use crate::peridynamics::kernel::{Kernel, PartialArea};
    use crate::peridynamics::lattice::{CellArea, LatticeSettings, Placement, lattice};
    use proptest::prelude::*;

    fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
        (b[0] - a[0]).hypot(b[1] - a[1])
    }

    fn brute_force(positions: &[[f64; 2]], reach: f64) -> Vec<[u32; 2]> {
        let n = positions.len();
        (0..n)
            .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
            .filter(|&(i, j)| distance(positions[i], positions[j]) <= reach)
            .map(|(i, j)| [i as u32, j as u32])
            .collect()
    }

    fn micromodulus(partial_area: PartialArea, m: f64, spacing: f64) -> Micromodulus {
        let material = Material {
            young: 3.0,
            poisson: 1.0 / 3.0,
        };
        let plane = PlaneState::Stress;
        Micromodulus::new(
            Kernel::Linear,
            partial_area,
            &material,
            plane,
            m * spacing,
            spacing,
        )
        .isotropised()
    }

    proptest! {
        /// Polygons with a hole, so that many sites hold no point.
        #[test]
        fn the_bonds_are_the_pairs_that_brute_force_finds(
            radii in prop::collection::vec(0.3..1.0f64, 5..9),
            hole in 0.05..0.25f64,
            spacing in 0.07..0.15f64,
            m in 1.5..4.2f64,
            hhb in any::<bool>(),
        ) {
            let polygon = |radius: &dyn Fn(usize) -> f64, count: usize, turn: f64| {
                let angle = |k: usize| turn * std::f64::consts::TAU * k as f64 / count as f64;
                (0..count).map(|k| [radius(k) * angle(k).cos(), radius(k) * angle(k).sin()]).collect()
            };
            let outline = Outline {
                loops: vec![polygon(&|k| radii[k], radii.len(), 1.0), polygon(&|_| hole, 6, -1.0)],
            };
            let settings = LatticeSettings::upright(spacing, Placement::CellCentred, CellArea::Clipped);
            let points = lattice(&outline, &[], &settings);
            let partial_area = if hhb { PartialArea::Hhb } else { PartialArea::Full };
            let c = micromodulus(partial_area, m, spacing);
            let view = Visibility::new(&outline, spacing, c.reach());
            let interactions = bonds(&points, &c, 0.3, 0, &view);
            let mut seen = brute_force(&points.positions, c.reach());
            seen.retain(|pair| {
                let [a, b] = pair.map(|i| points.positions[i as usize]);
                view.sees(a, b)
            });
            prop_assert_eq!(interactions.pairs(), seen);
            let largest = interactions.stiffness.iter().fold(0.0f64, |a, &k| a.max(k));
            for (&[i, j], &k) in interactions.pairs().iter().zip(&interactions.stiffness) {
                let [a, b] = [i, j].map(|i| points.positions[i as usize]);
                let areas = [i, j].map(|i| points.areas[i as usize]);
                let expected = c.axial_stiffness([b[0] - a[0], b[1] - a[1]], areas, 0.3);
                // Differences of coordinates of order one over some 0.1; the kernel fades to zero.
                prop_assert!((k - expected).abs() <= 1e-13 * largest, "{} {}", k, expected);
            }
        }

        #[test]
        fn nine_bins_hold_all_that_is_within_reach(
            positions in prop::collection::vec([-1.0..3.0f64, 0.0..0.5f64], 0..120),
            reach in 0.01..2.0f64,
        ) {
            let bins = Bins::new(&positions, reach);
            let mut pairs = Vec::new();
            for (i, &x) in positions.iter().enumerate() {
                bins.visit_around(x, |j| {
                    if j as usize > i && distance(x, positions[j as usize]) <= reach {
                        pairs.push([i as u32, j]);
                    }
                });
            }
            pairs.sort_unstable();
            prop_assert_eq!(pairs, brute_force(&positions, reach));
        }
    }

    #[test]
    fn points_far_apart_do_not_make_a_grid_of_empty_bins() {
        let positions = [[0.0, 0.0], [1e9, 1e9], [1e9 + 0.5, 1e9]];
        assert!(Bins::new(&positions, 1.0).start.len() < 100);
    }

    #[test]
    fn an_inner_point_of_a_lattice_with_m_4_has_48_neighbours() {
        let offsets = family_offsets(&micromodulus(PartialArea::Full, 4.0, 0.1));
        assert_eq!(offsets.len(), 48);
    }
}
