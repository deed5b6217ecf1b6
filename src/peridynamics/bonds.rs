//! Families and bonds: all pairs of material points within the horizon of each other.

use super::kernel::Micromodulus;
use crate::springs::Springs;
use rayon::prelude::*;

/// All pairs i < j with |x_j − x_i| ≤ `reach`, sorted; O(N) by a grid of square bins.
pub fn neighbour_pairs(positions: &[[f64; 2]], reach: f64) -> Vec<[u32; 2]> {
    let bins = Bins::new(positions, reach);
    let families: Vec<Vec<[u32; 2]>> = (0..positions.len())
        .into_par_iter()
        .with_min_len(256)
        .map(|i| {
            let mut pairs = Vec::new();
            bins.visit_around(positions[i], |j| {
                if j as usize > i && distance(positions[i], positions[j as usize]) <= reach {
                    pairs.push([i as u32, j]);
                }
            });
            pairs.sort_unstable();
            pairs
        })
        .collect();
    families.concat()
}

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

/// The bonds of one peridynamic region with their stiffness k = c(ξ) A_i A_j h_t / ξ
/// [N/m], eq. (19). `areas`: one per point [m²]. Ends count from `first_node`.
pub fn bonds(
    positions: &[[f64; 2]],
    areas: &[f64],
    micromodulus: &Micromodulus,
    thickness: f64,
    first_node: u32,
) -> Springs {
    let pairs = neighbour_pairs(positions, micromodulus.reach());
    let stiffness = pairs
        .par_iter()
        .map(|&[i, j]| {
            let (a, b) = (positions[i as usize], positions[j as usize]);
            let areas = [areas[i as usize], areas[j as usize]];
            micromodulus.axial_stiffness([b[0] - a[0], b[1] - a[1]], areas, thickness)
        })
        .collect();
    let pairs = pairs
        .into_iter()
        .map(|pair| pair.map(|i| i + first_node))
        .collect();
    Springs::of_pairs(pairs, stiffness)
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
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
    use proptest::prelude::*;

    fn brute_force(positions: &[[f64; 2]], reach: f64) -> Vec<[u32; 2]> {
        let n = positions.len();
        (0..n)
            .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
            .filter(|&(i, j)| distance(positions[i], positions[j]) <= reach)
            .map(|(i, j)| [i as u32, j as u32])
            .collect()
    }

    proptest! {
        #[test]
        fn the_search_finds_what_brute_force_finds(
            positions in prop::collection::vec([-1.0..3.0f64, 0.0..0.5f64], 0..120),
            reach in 0.01..2.0f64,
        ) {
            prop_assert_eq!(neighbour_pairs(&positions, reach), brute_force(&positions, reach));
        }
    }

    #[test]
    fn points_far_apart_do_not_make_a_grid_of_empty_bins() {
        let positions = [[0.0, 0.0], [1e9, 1e9], [1e9 + 0.5, 1e9]];
        assert_eq!(neighbour_pairs(&positions, 1.0), [[1, 2]]);
        assert!(Bins::new(&positions, 1.0).start.len() < 100);
    }

    #[test]
    fn an_inner_point_of_a_lattice_with_m_4_has_48_neighbours() {
        let positions: Vec<[f64; 2]> = (0..81)
            .map(|k| [(k % 9) as f64 * 0.1, (k / 9) as f64 * 0.1])
            .collect();
        let pairs = neighbour_pairs(&positions, 0.4 * (1.0 + 1e-9));
        assert_eq!(pairs.iter().filter(|pair| pair.contains(&40)).count(), 48);
    }
}
