//! The discretisation: elements, material points, bonds and trusses in one numbering of nodes.
//!
//! Nodes are the finite-element nodes in the mesh's order, then the material points, region by
//! region. Immutable once built.

pub mod bodies;
mod check;
mod families;
pub mod node_axes;
mod points;
mod trusses;

use crate::assembly::ElementStiffness;
use crate::coupling::Coupling;
use crate::coupling::clip::FamilyShare;
use crate::cracks::Cracks;
use crate::fem::element;
use crate::geometry::{Outline, chords};
use crate::interactions::Interactions;
use crate::material::{Material, PlaneState};
use crate::mesh::{Cell, Edge, Mesh};
use crate::peridynamics::axes::Axes;
use crate::peridynamics::kernel::{Kernel, Micromodulus, PartialArea};
use crate::peridynamics::lattice::LatticeSettings;
use crate::peridynamics::point_index::PointIndex;
use crate::peridynamics::surface::{SurfaceCorrection, SurfaceError};
use rayon::prelude::*;
use std::ops::Range;
use thiserror::Error;

use check::{check_cells, check_jacobian};

pub use families::FamilyMember;
pub use node_axes::NodeAxes;

/// A part of the body: which cells of the mesh, what material, which method.
#[derive(Clone, Debug)]
pub struct Region {
    pub name: String,
    /// Indices of the mesh's cells, ascending.
    pub cells: Vec<usize>,
    pub material: Material,
    pub method: Method,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    FiniteElements,
    Peridynamics(PeridynamicSettings),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeridynamicSettings {
    pub lattice: LatticeSettings,
    /// m = δ/dx [-].
    pub horizon_ratio: f64,
    pub kernel: Kernel,
    pub partial_area: PartialArea,
    /// Whether c(ξ) is corrected such that the lattice has the material's moduli.
    pub isotropised: bool,
    pub surface_correction: SurfaceCorrection,
}

impl PeridynamicSettings {
    /// c(ξ) of a material on this lattice.
    pub fn micromodulus(&self, material: &Material, plane: PlaneState) -> Micromodulus {
        let spacing = self.lattice.spacing;
        let raw = Micromodulus::new(
            self.kernel,
            self.partial_area,
            material,
            plane,
            self.horizon_ratio * spacing,
            spacing,
        );
        if self.isotropised {
            raw.isotropised()
        } else {
            raw
        }
    }
}

/// What holds for the whole model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelSettings {
    pub plane: PlaneState,
    /// h_t [m].
    pub thickness: f64,
    pub coupling: Coupling,
}

/// Where a finite-element and a peridynamic region meet.
#[derive(Clone, Debug)]
pub struct Interface {
    /// Indices of the regions.
    pub finite_elements: usize,
    pub peridynamics: usize,
    /// With the finite elements on the left.
    pub edges: Vec<Edge>,
}

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
    /// Of the first region's material.
    pub micromodulus: Micromodulus,
    /// The regions' outline, and its area |Ω| [m²].
    pub outline: Outline,
    pub area: f64,
}

impl PointRegion {
    /// The first side of a point's square, as a vector [m].
    pub fn side(&self) -> [f64; 2] {
        self.axes.global([self.micromodulus.spacing, 0.0])
    }
}

/// Everything left of the stiffness matrix.
#[derive(Clone, Debug)]
pub struct Model {
    pub mesh: Mesh,
    pub settings: ModelSettings,
    pub regions: Vec<Region>,
    pub interfaces: Vec<Interface>,
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
    /// For every region the one that leads its lattice.
    leader: Vec<usize>,
    pub points: Vec<PointRegion>,
    pub interactions: Interactions,
    /// What clipped bonds are of the points' families.
    pub clipped: Vec<FamilyShare>,
    /// ξ of the bond that each clipped bond is a part of [m].
    clipped_from: Vec<f64>,
    /// The peridynamic regions in which each clipped bond begins and ends.
    clipped_regions: Vec<Option<[usize; 2]>>,
    /// Integrity φ of every interaction before the first load: 0 where it meets an initial crack, 1
    /// elsewhere [-].
    pub integrity: Vec<f64>,
    /// Axes of nodes that are held along neither x nor y.
    pub node_axes: NodeAxes,
}

#[derive(Debug, Error)]
pub enum ModelError {
    #[error("region `{region}` has no elements in the mesh")]
    RegionEmpty { region: String },
    #[error("regions `{first}` and `{second}` overlap: {cells} cells of the mesh belong to both")]
    RegionsOverlap {
        first: String,
        second: String,
        cells: usize,
    },
    #[error("peridynamic regions `{first}` and `{second}` touch, and their lattices differ")]
    RegionsTouch { first: String, second: String },
    #[error(
        "element {cell} of region `{region}` is folded or clockwise at ({x:.6e}, {y:.6e}) m: \
         its Jacobian there is {determinant:.3e} m²"
    )]
    Jacobian {
        region: String,
        cell: usize,
        x: f64,
        y: f64,
        determinant: f64,
    },
    #[error("region `{region}` holds no material point: the spacing is larger than the region")]
    NoMaterialPoint { region: String },
    #[error("region `{region}` would hold {points:.1e} material points, more than {limit:.0e}")]
    TooManyPoints {
        region: String,
        points: f64,
        limit: f64,
    },
    /// Before memory is taken for them.
    #[error(
        "region `{region}` would hold {points:.1e} material points and {bonds:.1e} bonds: that needs {:.0} \
         GB, and the machine has {:.0}", .bytes / 1e9, .machine / 1e9
    )]
    TooManyBonds {
        region: String,
        points: f64,
        bonds: f64,
        bytes: f64,
        machine: f64,
    },
    #[error("the surface correction of region `{region}` fails: {source}")]
    Surface {
        region: String,
        source: SurfaceError,
    },
}

impl Model {
    /// # Errors
    /// See [`ModelError`].
    pub fn build(
        mesh: Mesh,
        regions: Vec<Region>,
        settings: ModelSettings,
    ) -> Result<Model, ModelError> {
        check_cells(&mesh, &regions)?;
        let interfaces = interfaces(&mesh, &regions);
        let leader = bodies::leaders(&mesh, &regions)?;
        let mut model = Model {
            settings,
            interfaces,
            positions: Vec::new(),
            node_of: vec![None; mesh.nodes.len()],
            elements: Vec::new(),
            areas: Vec::new(),
            points: Vec::new(),
            interactions: Interactions::default(),
            clipped: Vec::new(),
            clipped_from: Vec::new(),
            clipped_regions: Vec::new(),
            integrity: Vec::new(),
            node_axes: NodeAxes::new(),
            leader,
            region_of: Vec::new(),
            mesh,
            regions,
        };
        model.add_finite_elements()?;
        model.add_material_points()?;
        match settings.coupling {
            Coupling::Truss(node_area) => model.add_trusses(node_area),
            // The bonds were clipped where they were made.
            Coupling::Clip => {}
        }
        model.mix_materials();
        model.integrity = vec![1.0; model.interactions.len()];
        Ok(model)
    }

    /// The same model with the bonds and trusses severed that meet a crack.
    pub fn with_cracks(mut self, cracks: &Cracks) -> Model {
        if cracks.is_empty() {
            return self;
        }
        let positions = &self.positions;
        let interactions = (0..self.interactions.len()).into_par_iter();
        let integrity = interactions.map(|s| {
            let [a, b] = self.interactions.segment(s, positions);
            if cracks.sever(a, b) { 0.0 } else { 1.0 }
        });
        self.integrity = integrity.collect();
        self
    }

    pub fn node_count(&self) -> usize {
        self.positions.len()
    }

    /// Finite-element nodes come first: their number.
    pub fn fe_node_count(&self) -> usize {
        self.node_count() - self.areas.len()
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

    /// The region that a material point's node belongs to.
    pub fn region_of_point(&self, node: usize) -> Option<usize> {
        let point = node.checked_sub(self.fe_node_count())?;
        self.region_of.get(point).map(|&region| region as usize)
    }

    /// How many interactions tie finite elements to material points, and what they are called.
    pub fn ties(&self) -> (usize, &'static str) {
        let what = match self.settings.coupling {
            Coupling::Truss(_) => "trusses",
            Coupling::Clip => "clipped bonds",
        };
        (
            self.interactions.len() - self.interactions.bonds().len(),
            what,
        )
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
    /// For the node of a finite element.
    pub fn material_of_point(&self, node: usize) -> &Material {
        let region = self.region_of_point(node);
        &self.regions[region.expect("the node of a material point")].material
    }

    /// The share of a neighbour's area that counts at the distance `xi` from a material point [-].
    pub fn area_fraction(&self, node: usize, xi: f64) -> f64 {
        let points = self.points.iter().find(|p| p.nodes.contains(&node));
        points.map_or(1.0, |points| points.micromodulus.area_fraction(xi))
    }

    fn add_finite_elements(&mut self) -> Result<(), ModelError> {
        for (index, region) in self.regions.iter().enumerate() {
            if region.method != Method::FiniteElements {
                continue;
            }
            for &cell in &region.cells {
                check_jacobian(&self.mesh, region, cell)?;
                self.elements.push((index, cell));
                for &node in self.mesh.cells[cell].nodes() {
                    self.node_of[node] = Some(0);
                }
            }
        }
        for (mesh_node, node) in self.node_of.iter_mut().enumerate() {
            if node.is_some() {
                *node = Some(self.positions.len() as u32);
                self.positions.push(self.mesh.nodes[mesh_node]);
            }
        }
        Ok(())
    }

    /// Length of an edge's chords [m].
    pub fn edge_length(&self, edge: &Edge) -> f64 {
        let points = chords(edge, &self.mesh.nodes);
        points
            .windows(2)
            .map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]))
            .sum()
    }
}

fn interfaces(mesh: &Mesh, regions: &[Region]) -> Vec<Interface> {
    let mut found = Vec::new();
    for (f, fem) in regions.iter().enumerate() {
        for (p, pd) in regions.iter().enumerate() {
            if fem.method == Method::FiniteElements && pd.method != Method::FiniteElements {
                let edges = mesh.shared_edges(&fem.cells, &pd.cells);
                if !edges.is_empty() {
                    found.push(Interface {
                        finite_elements: f,
                        peridynamics: p,
                        edges,
                    });
                }
            }
        }
    }
    found
}
