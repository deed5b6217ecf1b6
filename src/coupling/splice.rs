//! The splice: each side reads the other's displacements, after Galvanetto, Mudrić, Shojaei &
//! Zaccariotto (2016). It passes the patch test with any interface and any elements, and K is not
//! symmetric.
//!
//! *Material points* keep their full families. The lattice is continued into the finite elements, and a
//! site there is a **ghost**, u_g = Σ N_a(x_g) u_a, of the element that holds it. A bond to a ghost
//! acts on the point alone.
//!
//! *Finite elements* reach over the interface by an **overlap**: the cells of the peridynamic region's
//! own mesh that touch a node of the finite-element side. Such nodes are those on the interface and those
//! less than 2 dx behind it. The other nodes of the overlap are **slaves** of the lattice,
//! u_s = Σ ℓ_p(x_s) u_p by cubic Lagrange polynomials over a block of 4 × 4 points; the overlap's
//! elements act on the finite-element side's nodes alone.

use crate::fem::locate::Locator;
use crate::geometry::nearest_on_segment;
use crate::mesh::Mesh;
use crate::peridynamics::axes::Axes;
use crate::peridynamics::bonds::family_offsets;
use crate::peridynamics::kernel::Micromodulus;
use crate::peridynamics::lattice::Sites;
use crate::peridynamics::visibility::Visibility;
use std::collections::BTreeSet;
use thiserror::Error;

#[derive(Clone, Debug, Error, PartialEq)]
pub enum SpliceError {
    #[error(
        "the finite elements around it are narrower than its horizon of {horizon:.4e} m at \
         ({x:.6e}, {y:.6e}) m, where a bond finds no material"
    )]
    NarrowRing { x: f64, y: f64, horizon: f64 },
    #[error(
        "its mesh is too coarse, or the region too narrow: the overlap of the finite elements reaches \
         from one interface to the opposite one at ({x:.6e}, {y:.6e}) m"
    )]
    Bridged { x: f64, y: f64 },
    #[error(
        "it holds no block of 4 × 4 material points near ({x:.6e}, {y:.6e}) m, which the overlap of \
         the finite elements needs"
    )]
    NoBlock { x: f64, y: f64 },
}

/// A side of the interface, finite elements on the left.
pub type Segment = [[f64; 2]; 2];

/// Nodes less than these spacings behind the interface belong to the finite elements: the blocks of
/// those farther in are nearly centred on them.
pub const DEPTH: f64 = 2.0;

/// Depths within this share of dx are the same: mesh coordinates carry rounding errors.
const SAME_DEPTH: f64 = 1e-6;

/// Where the overlap's nodes look at interfaces of which one's normal has less than this cosine to the
/// other's, the interfaces are opposite.
const OPPOSITE: f64 = -0.9;

/// The cells of one peridynamic region that the finite elements need.
#[derive(Clone, Debug, Default)]
pub struct Overlap {
    /// Indices of the mesh's cells, ascending.
    pub cells: Vec<usize>,
    /// Nodes of the mesh behind the interface that belong to the finite elements, ascending.
    pub inner: Vec<usize>,
    /// Nodes of the mesh that follow the material points, ascending.
    pub slaves: Vec<usize>,
}

impl Overlap {
    /// `cells`: of the peridynamic region; `is_solved`: the mesh's nodes that finite elements use.
    ///
    /// # Errors
    /// [`SpliceError::Bridged`].
    pub fn new(
        mesh: &Mesh,
        cells: &[usize],
        is_solved: impl Fn(usize) -> bool,
        interface: &[Segment],
        spacing: f64,
    ) -> Result<Overlap, SpliceError> {
        let depth = DEPTH * spacing * (1.0 - SAME_DEPTH);
        let mut inner = BTreeSet::new();
        let mut slaves = BTreeSet::new();
        let mut overlap = BTreeSet::new();
        // Inner nodes bring more cells, which may hold more of them.
        loop {
            let before = (inner.len(), overlap.len());
            for &cell in cells {
                let nodes = mesh.cells[cell].nodes();
                let belongs = |&node: &usize| is_solved(node) || inner.contains(&node);
                if overlap.contains(&cell) || !nodes.iter().any(belongs) {
                    continue;
                }
                overlap.insert(cell);
                for &node in nodes {
                    if !is_solved(node) && !slaves.contains(&node) {
                        let near = distance(mesh.nodes[node], interface) < depth;
                        if near { &mut inner } else { &mut slaves }.insert(node);
                    }
                }
            }
            if before == (inner.len(), overlap.len()) {
                break;
            }
        }
        let overlap = Overlap {
            cells: overlap.into_iter().collect(),
            inner: inner.into_iter().collect(),
            slaves: slaves.into_iter().collect(),
        };
        overlap.check(mesh, interface, spacing)?;
        Ok(overlap)
    }

    /// Elements from one interface to the opposite one would carry the load past the points.
    fn check(&self, mesh: &Mesh, interface: &[Segment], spacing: f64) -> Result<(), SpliceError> {
        let is_slave = |node: &&usize| self.slaves.binary_search(node).is_ok();
        for &cell in &self.cells {
            let solved: Vec<usize> = {
                let nodes = mesh.cells[cell].nodes().iter();
                nodes.filter(|node| !is_slave(node)).copied().collect()
            };
            let [x, y] = mesh.nodes[mesh.cells[cell].nodes()[0]];
            let normals: Vec<_> = solved
                .iter()
                .map(|&node| nearest_normals(mesh.nodes[node], interface, spacing))
                .collect();
            for (k, first) in normals.iter().enumerate() {
                if normals[..k]
                    .iter()
                    .any(|second| are_opposite(first, second))
                {
                    return Err(SpliceError::Bridged { x, y });
                }
            }
        }
        match self.cells.first() {
            Some(&cell) if self.slaves.is_empty() => {
                let [x, y] = mesh.nodes[mesh.cells[cell].nodes()[0]];
                Err(SpliceError::Bridged { x, y })
            }
            _ => Ok(()),
        }
    }
}

fn distance(x: [f64; 2], segments: &[Segment]) -> f64 {
    let distances = segments.iter().map(|&s| nearest_on_segment(x, s).1);
    distances.fold(f64::INFINITY, f64::min)
}

/// Normals of the sides of the interface that are nearest to a point.
fn nearest_normals(x: [f64; 2], interface: &[Segment], spacing: f64) -> Vec<[f64; 2]> {
    let least = distance(x, interface) + SAME_DEPTH * spacing;
    let near = interface
        .iter()
        .filter(|&&s| nearest_on_segment(x, s).1 <= least);
    near.map(|[a, b]| {
        let along = [b[0] - a[0], b[1] - a[1]];
        let length = along[0].hypot(along[1]);
        [along[1] / length, -along[0] / length]
    })
    .collect()
}

fn are_opposite(first: &[[f64; 2]], second: &[[f64; 2]]) -> bool {
    let mut cosines = first
        .iter()
        .flat_map(|a| second.iter().map(|b| a[0] * b[0] + a[1] * b[1]));
    cosines.all(|cosine| cosine < OPPOSITE)
}

/// The lattice of one region, continued over the body, with the material points on it.
pub struct SplicedLattice {
    /// Along the lattice's axes.
    sites: Sites,
    axes: Axes,
    /// The node of the material point at each site.
    node_at: Vec<Option<u32>>,
}

/// Blocks whose first column or row is farther than this from the centred one are not tried.
const BLOCK_REACH: i64 = 6;

/// Blocks of which Σ|w| is larger amplify what they extrapolate; a corner of the body that is dx/2
/// from its first points has 36.
const MOST_AMPLIFIED: f64 = 100.0;

/// Lattice coordinates this near a whole number are that number, sums of weights that differ by less
/// are equal.
const ROUNDING: f64 = 1e-9;

impl SplicedLattice {
    /// `points`: of the region, whose nodes count from `first_node` [m].
    pub fn new(sites: Sites, axes: Axes, points: &[[f64; 2]], first_node: u32) -> SplicedLattice {
        let mut node_at = vec![None; sites.shares.len()];
        for (k, &x) in points.iter().enumerate() {
            node_at[sites.nearest(axes.local(x))] = Some(first_node + k as u32);
        }
        SplicedLattice {
            sites,
            axes,
            node_at,
        }
    }

    /// [m].
    fn position(&self, site: usize) -> [f64; 2] {
        self.axes.global(self.sites.position(site))
    }

    /// The site some columns and rows away, if the grid reaches as far.
    fn neighbour(&self, site: usize, offset: [i32; 2]) -> Option<usize> {
        let [columns, rows] = self.sites.counts();
        let column = (site % columns).checked_add_signed(offset[0] as isize)?;
        let row = (site / columns).checked_add_signed(offset[1] as isize)?;
        (column < columns && row < rows).then_some(row * columns + column)
    }

    fn node(&self, column: i64, row: i64) -> Option<u32> {
        let [columns, rows] = self.sites.counts();
        let inside = (0..columns as i64).contains(&column) && (0..rows as i64).contains(&row);
        inside
            .then(|| self.node_at[row as usize * columns + column as usize])
            .flatten()
    }

    /// The material points that a slave at `x` [m] follows, with their weights: those of the block of
    /// 4 × 4 points with the least Σ|w|, which is one where `x` lies on a point. Where several blocks have it,
    /// their mean, so that mirror images give mirror images.
    ///
    /// # Errors
    /// [`SpliceError::NoBlock`].
    pub fn interpolate(&self, x: [f64; 2]) -> Result<Vec<(u32, f64)>, SpliceError> {
        let at = self.sites.coordinates(self.axes.local(x)).map(|c| {
            let whole = c.round();
            if (c - whole).abs() < ROUNDING {
                whole
            } else {
                c
            }
        });
        let first = at.map(|c| c.floor() as i64 - 1);
        let near = -BLOCK_REACH..=BLOCK_REACH;
        let mut best: Vec<([i64; 2], f64)> = Vec::new();
        for row in near.clone().map(|k| first[1] + k) {
            for column in near.clone().map(|k| first[0] + k) {
                let corner = [column, row];
                let sum = amplification(at, corner);
                let least = best.first().map_or(MOST_AMPLIFIED, |&(_, least)| least);
                if sum <= least * (1.0 + ROUNDING) && self.is_full(corner) {
                    if sum < least * (1.0 - ROUNDING) {
                        best.clear();
                    }
                    best.push((corner, sum));
                }
            }
        }
        if best.is_empty() {
            let [x, y] = x;
            return Err(SpliceError::NoBlock { x, y });
        }
        Ok(self.mean_weights(at, &best))
    }

    fn is_full(&self, [column, row]: [i64; 2]) -> bool {
        (0..4).all(|q| (0..4).all(|p| self.node(column + p, row + q).is_some()))
    }

    fn mean_weights(&self, at: [f64; 2], blocks: &[([i64; 2], f64)]) -> Vec<(u32, f64)> {
        let mut weights = std::collections::BTreeMap::new();
        for &([column, row], _) in blocks {
            let [across, up] = [lagrange(at[0], column), lagrange(at[1], row)];
            for (q, up) in up.into_iter().enumerate() {
                for (p, across) in across.into_iter().enumerate() {
                    let weight = across * up / blocks.len() as f64;
                    let node = self.node(column + p as i64, row + q as i64);
                    let node = node.expect("the block is full");
                    if weight != 0.0 {
                        *weights.entry(node).or_insert(0.0) += weight;
                    }
                }
            }
        }
        weights.into_iter().collect()
    }
}

/// Cubic Lagrange polynomials of the points first … first + 3, at `x` [-].
fn lagrange(x: f64, first: i64) -> [f64; 4] {
    let t = x - first as f64;
    std::array::from_fn(|i| {
        let others = (0..4).filter(|&j| j != i);
        others
            .map(|j| (t - j as f64) / (i as f64 - j as f64))
            .product()
    })
}

/// Σ|w| of a block.
fn amplification(at: [f64; 2], corner: [i64; 2]) -> f64 {
    let sum = |axis: usize| -> f64 {
        let weights = lagrange(at[axis], corner[axis]);
        weights.iter().map(|w| w.abs()).sum()
    };
    sum(0) * sum(1)
}

/// A bond that acts on its material point alone.
#[derive(Clone, Debug, PartialEq)]
pub struct GhostBond {
    /// The material point's node.
    pub point: u32,
    /// Where the ghost is [m].
    pub ghost: [f64; 2],
    /// Area of the ghost over dx² [-].
    pub share: f64,
    /// Element that holds the ghost.
    pub element: usize,
    /// N_a there [-].
    pub value: [f64; crate::fem::MAX_NODES],
}

/// The bonds from the region's points into the finite elements, by point and then row by row.
///
/// `free`: the sides of the region that bound the body. Families are cut there, and within two horizons of
/// them also by the finite elements' own free surface, which continues such a side.
///
/// # Errors
/// [`SpliceError::NarrowRing`].
pub fn ghost_bonds(
    lattice: &SplicedLattice,
    elements: &Locator,
    micromodulus: &Micromodulus,
    free: &[Segment],
    visibility: &Visibility,
) -> Result<Vec<GhostBond>, SpliceError> {
    let offsets = family_offsets(micromodulus);
    let mut found: Vec<Option<Option<crate::fem::locate::Held>>> =
        vec![None; lattice.sites.shares.len()];
    let mut bonds = Vec::new();
    let points = (0..lattice.node_at.len()).filter_map(|s| lattice.node_at[s].map(|n| (s, n)));
    let mut by_point: Vec<(u32, usize)> = points.map(|(site, node)| (node, site)).collect();
    by_point.sort_unstable();
    for (point, site) in by_point {
        let mut is_cut = false;
        let view = visibility.from(lattice.sites.position(site));
        for &offset in &offsets {
            let Some(other) = lattice.neighbour(site, offset) else {
                continue;
            };
            if lattice.node_at[other].is_some() {
                continue;
            }
            let share = lattice.sites.shares[other];
            // The body's surface is between.
            if share > 0.0 && !view.sees(lattice.sites.position(other)) {
                continue;
            }
            let ghost = lattice.position(other);
            let held = *found[other].get_or_insert_with(|| {
                // Off the body, whatever the slack of the elements.
                if share > 0.0 {
                    elements.locate(ghost)
                } else {
                    None
                }
            });
            match held {
                Some(held) => bonds.push(GhostBond {
                    point,
                    ghost,
                    share,
                    element: held.element,
                    value: held.value,
                }),
                None => is_cut = true,
            }
        }
        let [x, y] = lattice.position(site);
        if is_cut && distance([x, y], free) > 2.0 * micromodulus.reach() {
            let horizon = micromodulus.horizon;
            return Err(SpliceError::NarrowRing { x, y, horizon });
        }
    }
    Ok(bonds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Outline;
    use crate::peridynamics::lattice::{CellArea, LatticeSettings, Placement};

    fn lattice(columns: usize, rows: usize) -> SplicedLattice {
        let [w, h] = [0.1 * columns as f64, 0.1 * rows as f64];
        let outline = Outline {
            loops: vec![vec![[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]]],
        };
        let settings = LatticeSettings::upright(0.1, Placement::CellCentred, CellArea::Full);
        let sites = Sites::new(&outline, &outline, &settings, 3);
        let points: Vec<[f64; 2]> = (0..columns * rows)
            .map(|k| [k % columns, k / columns].map(|c| 0.05 + 0.1 * c as f64))
            .collect();
        SplicedLattice::new(sites, Axes::new(0.0), &points, 7)
    }

    #[test]
    fn slaves_follow_every_cubic() {
        let lattice = lattice(6, 5);
        let cubic =
            |[x, y]: [f64; 2]| 1.0 + x - 2.0 * y + 3.0 * x * x * y - x * y * y * x + y.powi(3);
        for x in [[0.31, 0.22], [0.0, 0.5], [0.6, 0.0], [0.25, 0.13]] {
            let weights = lattice.interpolate(x).expect("a block");
            let at = |node: u32| {
                let k = node - 7;
                [k % 6, k / 6].map(|c| 0.05 + 0.1 * f64::from(c))
            };
            let sum: f64 = weights.iter().map(|&(node, w)| w * cubic(at(node))).sum();
            // Σ|w| is at most 36.
            assert!((sum - cubic(x)).abs() < 1e-14, "{x:?}: {sum}");
        }
    }

    #[test]
    fn a_slave_on_a_point_is_that_point_and_ties_are_shared() {
        let lattice = lattice(8, 4);
        let on_point = lattice.interpolate([0.25, 0.15]).expect("a block");
        assert_eq!(on_point, [(7 + 8 + 2, 1.0)]);
        // Both mirror images have the same weights.
        let left = lattice.interpolate([0.1, 0.02]).expect("a block");
        let right = lattice.interpolate([0.7, 0.02]).expect("a block");
        for &(node, w) in &left {
            let (column, row) = ((node - 7) % 8, (node - 7) / 8);
            let mirrored = 7 + row * 8 + 7 - column;
            let other = right
                .iter()
                .find(|&&(n, _)| n == mirrored)
                .expect("its image");
            // Sums of sixteen products whose positions carry rounding of 1e-16.
            assert!((w - other.1).abs() < 5e-15);
        }
    }

    #[test]
    fn three_rows_hold_no_block() {
        let error = lattice(8, 3).interpolate([0.4, 0.1]);
        assert_eq!(error, Err(SpliceError::NoBlock { x: 0.4, y: 0.1 }));
    }
}
