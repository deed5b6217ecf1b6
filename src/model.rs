//! The discretisation: elements, material points, bonds and trusses in one numbering of nodes.
//!
//! Nodes are the finite-element nodes in the mesh's order, then the material points, region by
//! region. Immutable once built.

mod check;
mod companions;
mod elements;
mod error;
mod families;
mod joints;
mod lattice_angle;
mod lattices;
pub mod node_axes;
mod settings;
pub mod topology;

use crate::assembly::ElementStiffness;
use crate::coupling::clip::FamilyShare;
use crate::coupling::{Parts, Tied};
use crate::cracks::Cracks;
use crate::fem::element;
use crate::geometry::Outline;
use crate::interactions::Interactions;
use crate::material::Material;
use crate::mesh::{Cell, Mesh};
use crate::peridynamics::axes::Axes;
use crate::peridynamics::kernel::Micromodulus;
use crate::peridynamics::lattice::CellArea;
use crate::peridynamics::point_index::PointIndex;
use crate::peridynamics::visibility::Visibility;
use rayon::prelude::*;
use std::ops::Range;

use check::check;
use elements::Elements;
use lattices::LatticeOfPoints;

pub use companions::Companions;
pub use error::ModelError;
pub use families::FamilyMember;
pub use lattice_angle::turn_lattices;
pub use node_axes::NodeAxes;
pub use settings::{
    Method, ModelSettings, PeridynamicSettings, Region, SMALLEST_HORIZON, SettingsError,
    check_horizon,
};
pub use topology::{LatticePart, Topology};

/// The material points of one peridynamic region, or of several that touch each other.
#[derive(Clone, Debug)]
pub struct PointRegion {
    /// The first of the regions.
    pub region: usize,
    /// Their nodes.
    pub nodes: Range<usize>,
    /// Axes of the lattice.
    pub axes: Axes,
    /// Sites of the lattice that hold these points.
    pub index: PointIndex,
    /// Micromodulus of the first region's material.
    pub micromodulus: Micromodulus,
    /// The regions' outline, and its area |Ω| [m²].
    pub outline: Outline,
    pub area: f64,
}

impl PointRegion {
    fn new(part: &LatticePart, lattice: &LatticeOfPoints, first_node: usize) -> PointRegion {
        PointRegion {
            region: part.leader(),
            nodes: first_node..first_node + lattice.lattice.positions.len(),
            axes: lattice.axes,
            index: lattice.lattice.index.clone(),
            micromodulus: lattice.micromodulus,
            area: part.part.outline.area(),
            outline: part.part.outline.clone(),
        }
    }

    /// The first side of a point's square, as a vector [m].
    pub fn side(&self) -> [f64; 2] {
        self.axes.global([self.micromodulus.spacing, 0.0])
    }
}

/// The discretised body: all that the stiffness matrix is assembled from.
#[derive(Clone, Debug)]
pub struct Model {
    pub mesh: Mesh,
    pub settings: ModelSettings,
    pub regions: Vec<Region>,
    pub topology: Topology,
    /// x of every node [m].
    pub positions: Vec<[f64; 2]>,
    /// The node at each of the mesh's nodes, where finite elements use it.
    pub node_of: Vec<Option<u32>>,
    /// (region, cell) of every finite element.
    pub elements: Vec<(usize, usize)>,
    /// A_i of every material point [m²].
    pub areas: Vec<f64>,
    /// The region of every material point.
    region_of: Vec<u32>,
    pub points: Vec<PointRegion>,
    pub interactions: Interactions,
    /// Places of clipped bonds in the points' families.
    pub clipped: Vec<FamilyShare>,
    /// ξ of the bond that each clipped bond is a part of [m].
    clipped_from: Vec<f64>,
    /// The peridynamic regions in which each clipped bond begins and ends.
    clipped_regions: Vec<Option<[usize; 2]>>,
    /// The cells that break with each bond.
    pub companions: Companions,
    /// Integrity φ of every interaction before the first load: 0 where it meets an initial crack, 1
    /// elsewhere [-].
    pub integrity: Vec<f64>,
    /// Axes of nodes that are held along neither x nor y.
    pub node_axes: NodeAxes,
}

impl Model {
    /// Builds elements and lattices, and ties them by the coupling.
    ///
    /// # Errors
    /// See [`ModelError`].
    pub fn build(
        mesh: Mesh,
        regions: Vec<Region>,
        settings: ModelSettings,
    ) -> Result<Model, ModelError> {
        check(&mesh, &regions, &settings)?;
        let topology = Topology::new(&mesh, &regions)?;
        let Elements {
            elements,
            node_of,
            mut positions,
        } = Elements::new(&mesh, &regions)?;
        let lattice = |part| LatticeOfPoints::new(&mesh, &regions, &settings, &topology, part);
        let lattices: Vec<LatticeOfPoints> = topology
            .lattices
            .iter()
            .map(lattice)
            .collect::<Result<_, _>>()?;
        let cells: Vec<usize> = elements.iter().map(|&(_, cell)| cell).collect();
        let coupling = settings.coupling.tie();
        let mut tied = Tied::default();
        let mut points = Vec::new();
        let mut lattice_cells = Vec::new();
        let mut first = positions.len();
        for (part, lattice) in topology.lattices.iter().zip(&lattices) {
            let parts = Parts {
                mesh: &mesh,
                elements: &cells,
                node_of: &node_of,
                edges: &part.part.edges,
                interface: &part.interface,
                outline: &lattice.outline,
                lattice: &lattice.lattice,
                axes: lattice.axes,
                first_node: first as u32,
                micromodulus: &lattice.micromodulus,
                surface: lattice.surface.as_ref(),
                visibility: &lattice.visibility,
                thickness: settings.thickness,
            };
            let bonds = lattice.bonds(settings.thickness, parts.first_node);
            tied.append(coupling.tie(bonds, &parts));
            let needs_cells = |&region: &usize| {
                let material = &regions[region].material;
                !material.on_lattice(settings.plane).is_of_bonds()
            };
            lattice_cells.push(match part.members.iter().any(needs_cells) {
                true => coupling.cells(&parts).map_err(|[x, y]| {
                    let region = regions[part.leader()].name.clone();
                    ModelError::Cells { region, x, y }
                })?,
                false => Vec::new(),
            });
            points.push(PointRegion::new(part, lattice, first));
            first += lattice.lattice.positions.len();
        }
        let mut region_of = Vec::new();
        let mut areas = Vec::new();
        for (part, lattice) in topology.lattices.iter().zip(lattices) {
            let of_lattice = lattice.positions();
            region_of.extend(topology.regions_of(part, &of_lattice));
            positions.extend(of_lattice);
            areas.extend(lattice.lattice.areas);
        }
        let mut model = Model {
            settings,
            elements,
            node_of,
            positions,
            areas,
            region_of,
            points,
            integrity: vec![1.0; tied.interactions.len()],
            interactions: tied.interactions,
            clipped: tied.family_shares,
            clipped_from: tied.bond_lengths,
            clipped_regions: Vec::new(),
            companions: Companions::default(),
            node_axes: NodeAxes::new(),
            topology,
            mesh,
            regions,
        };
        model.mix_materials();
        model.add_cells(&lattice_cells);
        Ok(model)
    }

    /// Severs the bonds and trusses that meet a crack, and the cells that go with them.
    pub fn with_cracks(mut self, cracks: &Cracks) -> Model {
        if cracks.is_empty() {
            return self;
        }
        let positions = &self.positions;
        let interactions = self.interactions.axial().into_par_iter();
        let integrity = interactions.map(|s| {
            let [a, b] = self.interactions.segment(s, positions);
            if cracks.sever(a, b) { 0.0 } else { 1.0 }
        });
        let severed: Vec<f64> = integrity.collect();
        self.integrity[..severed.len()].copy_from_slice(&severed);
        let broken: Vec<usize> = (0..severed.len()).filter(|&s| severed[s] == 0.0).collect();
        for cell in self.cells_with(&broken, |_| true) {
            self.integrity[cell] = 0.0;
        }
        self
    }

    pub fn node_count(&self) -> usize {
        self.positions.len()
    }

    /// Finite-element nodes come first: their number.
    pub fn fe_node_count(&self) -> usize {
        self.node_count() - self.areas.len()
    }

    /// The node nearest to a point, and its distance from it [m].
    pub fn nearest_node(&self, at: [f64; 2]) -> (usize, f64) {
        let distance = |x: &[f64; 2]| (x[0] - at[0]).hypot(x[1] - at[1]);
        let distances = self.positions.iter().map(distance).enumerate();
        let nearest = distances.min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.expect("a model has nodes")
    }

    /// Lower left and upper right corner of the box around the body [m]: material points may lie
    /// dx/2 within it.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        let outlines = || {
            self.points
                .iter()
                .flat_map(|p| p.outline.loops.iter().flatten())
        };
        let body = || self.positions.iter().chain(outlines());
        let extreme = |pick: fn(f64, f64) -> f64, from: f64| {
            [0, 1].map(|axis| body().map(|x| x[axis]).fold(from, pick))
        };
        [
            extreme(f64::min, f64::INFINITY),
            extreme(f64::max, f64::NEG_INFINITY),
        ]
    }

    pub fn cell(&self, element: usize) -> &Cell {
        &self.mesh.cells[self.elements[element].1]
    }

    /// Nodes of a finite element.
    pub fn element_nodes(&self, element: usize) -> Vec<u32> {
        let used = |&n: &usize| self.node_of[n].expect("nodes of finite elements are numbered");
        self.cell(element).nodes().iter().map(used).collect()
    }

    /// Positions of a finite element's nodes [m].
    pub fn element_coordinates(&self, element: usize) -> Vec<[f64; 2]> {
        self.cell(element)
            .nodes()
            .iter()
            .map(|&n| self.mesh.nodes[n])
            .collect()
    }

    /// Stiffness of every finite element, eq. (12).
    pub fn element_stiffness(&self) -> Vec<ElementStiffness> {
        let stiffness = |element: usize| {
            let material = self.regions[self.elements[element].0].material;
            ElementStiffness {
                nodes: self.element_nodes(element),
                matrix: element::stiffness(
                    self.cell(element).kind,
                    &self.element_coordinates(element),
                    &material.elasticity(self.settings.plane),
                    self.settings.thickness,
                ),
            }
        };
        (0..self.elements.len())
            .into_par_iter()
            .map(stiffness)
            .collect()
    }

    /// Visibility between points of the body, along a lattice's axes.
    pub fn visibility(&self, axes: &Axes, micromodulus: &Micromodulus) -> Visibility {
        let body = axes.outline(&self.topology.body.outline);
        Visibility::new(&body, micromodulus.spacing, micromodulus.reach())
    }

    /// The region that a material point's node belongs to.
    pub fn region_of_point(&self, node: usize) -> Option<usize> {
        let point = node.checked_sub(self.fe_node_count())?;
        self.region_of.get(point).map(|&region| region as usize)
    }

    /// Number of interactions that tie finite elements to material points, and their name.
    pub fn ties(&self) -> (usize, &'static str) {
        let count = self.interactions.axial().len() - self.interactions.bonds().len();
        (count, self.settings.coupling.tie().name())
    }

    /// t, the part of a bond's length that an interaction is [-]; 1 but for clipped bonds.
    pub fn length_share(&self, interaction: usize) -> f64 {
        let clipped = interaction.checked_sub(self.interactions.clipped_bonds().start);
        let bond = clipped.and_then(|index| self.clipped_from.get(index));
        bond.map_or(1.0, |xi| {
            self.interactions.length(interaction, &self.positions) / xi
        })
    }

    /// # Panics
    /// Panics for the node of a finite element.
    pub fn material_of_point(&self, node: usize) -> &Material {
        let region = self.region_of_point(node);
        &self.regions[region.expect("the node of a material point")].material
    }

    /// Whether the points' areas are those of their squares in the region, and not dx² wherever they are.
    pub fn has_clipped_areas(&self, points: &PointRegion) -> bool {
        match self.regions[points.region].method {
            Method::Peridynamics(settings) => settings.lattice.cell_area == CellArea::Clipped,
            Method::FiniteElements => false,
        }
    }

    /// The share of a neighbour's area that counts at the distance `xi` from a material point [-].
    pub fn area_fraction(&self, node: usize, xi: f64) -> f64 {
        let points = self.points.iter().find(|p| p.nodes.contains(&node));
        points.map_or(1.0, |points| points.micromodulus.area_fraction(xi))
    }
}
