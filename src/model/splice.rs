//! The splice in a model: which cells overlap, what ghosts and slaves follow, and the equations of the
//! finite-element side. [`crate::coupling::splice`] has the method.

use super::{Method, Model, ModelError, PeridynamicSettings, PointRegion};
use crate::assembly::full::Equations;
use crate::coupling::splice::{
    GhostBond, Overlap, Segment, SpliceError, SplicedLattice, ghost_bonds,
};
use crate::fem::element;
use crate::fem::locate::Locator;
use crate::geometry::{Outline, chords};
use crate::mesh::Edge;
use crate::peridynamics::lattice::Sites;
use crate::peridynamics::visibility::Visibility;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Finite elements behind the interface, in the mesh of peridynamic regions.
#[derive(Clone, Debug, Default)]
pub struct Splice {
    /// (region, cell) of every element of the overlap. Their material is not the body's a second time:
    /// they are in no output, and act on no more than the nodes of the finite-element side.
    pub overlap: Vec<(usize, usize)>,
    /// The mesh's nodes behind the interface that belong to the finite-element side, ascending.
    pub inner: Vec<usize>,
    /// The mesh's nodes that follow material points: these and their weights [-].
    pub slaves: BTreeMap<usize, Vec<(u32, f64)>>,
    /// The bonds to ghosts, in the order of the springs behind the pairs.
    pub ghosts: Vec<GhostBond>,
}

impl Model {
    /// Finds the overlap, once the nodes of finite-element regions are marked in `node_of`, and marks
    /// the inner nodes too.
    pub(super) fn add_overlap(&mut self) -> Result<(), ModelError> {
        let mut splice = Splice::default();
        for index in 0..self.regions.len() {
            let region = &self.regions[index];
            let Method::Peridynamics(settings) = region.method else {
                continue;
            };
            let interface = self.interface_segments(index);
            if self.leader[index] != index || interface.is_empty() {
                continue;
            }
            let cells = self.lattice_cells(index);
            let spacing = settings.lattice.spacing;
            let is_solved = |node: usize| self.node_of[node].is_some();
            let overlap = Overlap::new(&self.mesh, &cells, is_solved, &interface, spacing)
                .map_err(|error| self.splice_error(index, error))?;
            for &cell in &overlap.cells {
                super::check::check_jacobian(&self.mesh, region, cell)?;
            }
            let cells = overlap.cells.into_iter();
            splice
                .overlap
                .extend(cells.map(|cell| (self.owner(index, cell), cell)));
            splice.inner.extend(overlap.inner);
            let slaves = overlap.slaves.into_iter().map(|node| (node, Vec::new()));
            splice.slaves.extend(slaves);
        }
        splice.inner.sort_unstable();
        for &node in &splice.inner {
            self.node_of[node] = Some(0);
        }
        if !splice.overlap.is_empty() {
            self.splice = Some(splice);
        }
        Ok(())
    }

    /// Bonds to ghosts, and what the slaves follow.
    pub(super) fn add_splice(&mut self) -> Result<(), ModelError> {
        let Some(mut splice) = self.splice.take() else {
            return Ok(());
        };
        let elements = self.locator();
        for points in &self.points {
            let Method::Peridynamics(settings) = self.regions[points.region].method else {
                continue;
            };
            if self.interface_segments(points.region).is_empty() {
                continue;
            }
            let failed = |error| self.splice_error(points.region, error);
            let axes = settings.lattice.axes();
            let lattice = SplicedLattice::new(
                self.sites(&axes.outline(&points.outline), &settings),
                axes,
                &self.positions[points.nodes.clone()],
                points.nodes.start as u32,
            );
            let cells: BTreeSet<usize> = {
                let own = splice
                    .overlap
                    .iter()
                    .filter(|(region, _)| self.leader[*region] == points.region);
                own.flat_map(|&(_, cell)| self.mesh.cells[cell].nodes().to_vec())
                    .collect()
            };
            for (node, weights) in &mut splice.slaves {
                if cells.contains(node) {
                    *weights = lattice
                        .interpolate(self.mesh.nodes[*node])
                        .map_err(failed)?;
                }
            }
            let free = self.free_segments(points);
            let visibility = self.visibility(&axes, &points.micromodulus);
            let micromodulus = &points.micromodulus;
            let bonds = ghost_bonds(&lattice, &elements, micromodulus, &free, &visibility);
            let bonds = bonds.map_err(failed)?;
            let stiffness = self.ghost_stiffness(points, &settings, &bonds, &visibility)?;
            for (bond, stiffness) in bonds.iter().zip(stiffness) {
                let ends = [self.positions[bond.point as usize], bond.ghost];
                let shares = self.ghost_shares(bond);
                self.springs
                    .push_interpolated(ends, [&[(bond.point, 1.0)], &shares], stiffness);
            }
            splice.ghosts.extend(bonds);
        }
        self.splice = Some(splice);
        Ok(())
    }

    /// The lattice of a region continued over the body, as far as its bonds reach; `turned`: the
    /// region's outline along the lattice's axes, as the sites are.
    pub(super) fn sites(&self, turned: &Outline, settings: &PeridynamicSettings) -> Sites {
        let margin = settings.horizon_ratio.ceil() as usize + 1;
        let body = settings.lattice.axes().outline(&self.body_outline());
        Sites::new(turned, &body, &settings.lattice.along_axes(), margin)
    }

    fn splice_error(&self, region: usize, source: SpliceError) -> ModelError {
        ModelError::Splice {
            region: self.regions[region].name.clone(),
            source,
        }
    }

    fn locator(&self) -> Locator {
        let elements = (0..self.elements.len())
            .map(|element| (self.cell(element).kind, self.element_coordinates(element)));
        Locator::new(elements.collect())
    }

    fn ghost_stiffness(
        &self,
        points: &PointRegion,
        settings: &PeridynamicSettings,
        bonds: &[GhostBond],
        visibility: &Visibility,
    ) -> Result<Vec<f64>, ModelError> {
        let region = &self.regions[points.region];
        let axes = settings.lattice.axes();
        let turned = axes.outline(&points.outline);
        let micromodulus = &points.micromodulus;
        let surface = self.surface(region, &turned, settings, micromodulus, visibility)?;
        let cell = points.micromodulus.spacing.powi(2);
        let first = self.fe_node_count();
        let stiffness = |bond: &GhostBond| {
            let at = axes.local(self.positions[bond.point as usize]);
            let ghost = axes.local(bond.ghost);
            let along = [0, 1].map(|axis| ghost[axis] - at[axis]);
            let areas = [self.areas[bond.point as usize - first], bond.share * cell];
            let thickness = self.settings.thickness;
            let factor = surface.as_ref().map_or(1.0, |s| s.factor(at, ghost));
            factor * points.micromodulus.axial_stiffness(along, areas, thickness)
        };
        Ok(bonds.par_iter().map(stiffness).collect())
    }

    /// The nodes that a ghost is interpolated from.
    fn ghost_shares(&self, bond: &GhostBond) -> Vec<(u32, f64)> {
        let nodes = self.element_nodes(bond.element);
        let shares = nodes.into_iter().zip(bond.value);
        // On a side of the element, the others' shares are rounding errors.
        shares.filter(|(_, n)| n.abs() > 1e-14).collect()
    }

    /// The sides of a region that bound the body.
    fn free_segments(&self, points: &PointRegion) -> Vec<Segment> {
        let interfaces = self.interfaces_of(points.region);
        let shared: BTreeSet<[usize; 2]> = interfaces
            .flat_map(|i| i.edges.iter().map(Edge::key))
            .collect();
        let edges = self.mesh.outline(&self.lattice_cells(points.region));
        let free = edges.iter().filter(|edge| !shared.contains(&edge.key()));
        free.flat_map(|edge| {
            let points = chords(edge, &self.mesh.nodes);
            let segments = points.windows(2).map(|w| [w[0], w[1]]);
            segments.collect::<Vec<_>>()
        })
        .collect()
    }

    /// The finite-element side's equations under the splice: those of the elements, and those of the
    /// overlap in which slaves are expressed by material points.
    pub fn equations(&self, splice: &Splice) -> Vec<Equations> {
        let elements = self.elements.par_iter().chain(&splice.overlap);
        elements
            .map(|&(region, cell)| self.equations_of(splice, region, cell))
            .collect()
    }

    fn equations_of(&self, splice: &Splice, region: usize, cell: usize) -> Equations {
        let nodes = self.mesh.cells[cell].nodes();
        let coordinates: Vec<[f64; 2]> = nodes.iter().map(|&n| self.mesh.nodes[n]).collect();
        let stiffness = element::stiffness(
            self.mesh.cells[cell].kind,
            &coordinates,
            &self.regions[region]
                .material
                .elasticity(self.settings.plane),
            self.settings.thickness,
        );
        let solved = |k: usize| self.node_of[nodes[k]];
        let rows: Vec<usize> = (0..nodes.len()).filter(|&k| solved(k).is_some()).collect();
        // What each of the element's nodes follows: itself, or its points.
        let follows: Vec<Vec<(u32, f64)>> = (0..nodes.len())
            .map(|k| match solved(k) {
                Some(node) => vec![(node, 1.0)],
                None => splice.slaves[&nodes[k]].clone(),
            })
            .collect();
        let columns: BTreeSet<u32> = follows.iter().flatten().map(|&(node, _)| node).collect();
        let columns: Vec<u32> = columns.into_iter().collect();
        let mut matrix = DMatrix::zeros(2 * rows.len(), 2 * columns.len());
        for (r, &row) in rows.iter().enumerate() {
            for (k, follows) in follows.iter().enumerate() {
                for &(node, weight) in follows {
                    let c = columns.binary_search(&node).expect("collected above");
                    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                        matrix[(2 * r + i, 2 * c + j)] +=
                            weight * stiffness[(2 * row + i, 2 * k + j)];
                    }
                }
            }
        }
        Equations {
            rows: rows.into_iter().filter_map(solved).collect(),
            columns,
            matrix,
        }
    }

    /// The share of a spring's energy that is the body's: half of a bond to a ghost, whose other half
    /// the finite element holds [-].
    pub fn bond_share(&self, spring: usize) -> f64 {
        let is_ghost = self.splice.is_some() && spring >= self.springs.pairs().len();
        if is_ghost { 0.5 } else { 1.0 }
    }

    /// Area of a ghost [m²].
    pub fn ghost_area(&self, bond: &GhostBond) -> f64 {
        let points = self
            .points
            .iter()
            .find(|p| p.nodes.contains(&(bond.point as usize)));
        points.map_or(0.0, |p| bond.share * p.micromodulus.spacing.powi(2))
    }

    /// The finite-element side's nodes behind the interface, which stand for no material of their own.
    pub fn inner_nodes(&self) -> BTreeSet<usize> {
        let inner = self.splice.iter().flat_map(|splice| &splice.inner);
        let nodes = inner.filter_map(|&mesh_node| self.node_of[mesh_node]);
        nodes.map(|node| node as usize).collect()
    }

    /// The finite-element side's nodes of each element of the overlap.
    pub fn overlap_nodes(&self) -> Vec<Vec<u32>> {
        let overlap = self.splice.iter().flat_map(|splice| &splice.overlap);
        overlap
            .map(|&(_, cell)| {
                let nodes = self.mesh.cells[cell].nodes().iter();
                nodes.filter_map(|&node| self.node_of[node]).collect()
            })
            .collect()
    }
}
