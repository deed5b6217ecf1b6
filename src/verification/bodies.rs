//! Bodies of the cases, and their solution.

use super::VerificationError;
use crate::boundary::Boundary;
use crate::coupling::Coupling;
use crate::coupling::truss::NodeArea;
use crate::material::{Material, PlaneState};
use crate::mesh::{Edge, Mesh};
use crate::model::{Method, Model, ModelSettings, PeridynamicSettings, Region};
use crate::peridynamics::kernel::{Kernel, PartialArea};
use crate::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use crate::peridynamics::surface::SurfaceCorrection;
use crate::statics::{self, Solution};

/// Bond-based in plane stress; `young` is E [Pa].
pub fn material(young: f64) -> Material {
    Material {
        young,
        poisson: PlaneState::Stress.bond_based_poisson(),
    }
}

/// A lattice as the paper has it, on cell centres: quartic kernel, m = 4, nothing corrected. `spacing`
/// is dx [m].
pub fn paper_lattice(spacing: f64) -> PeridynamicSettings {
    PeridynamicSettings {
        lattice: LatticeSettings::upright(spacing, Placement::CellCentred, CellArea::Full),
        horizon_ratio: 4.0,
        kernel: Kernel::Quartic,
        partial_area: PartialArea::Full,
        isotropised: false,
        surface_correction: SurfaceCorrection::None,
    }
}

/// A lattice as pipelines have it unless they say otherwise: isotropised, clipped cells, surfaces
/// corrected by force. `spacing` is dx [m].
pub fn default_lattice(spacing: f64) -> PeridynamicSettings {
    let paper = paper_lattice(spacing);
    PeridynamicSettings {
        lattice: LatticeSettings {
            cell_area: CellArea::Clipped,
            ..paper.lattice
        },
        isotropised: true,
        surface_correction: SurfaceCorrection::Force,
        ..paper
    }
}

/// The surfaces `groups` of the mesh as one region.
pub fn region(mesh: &Mesh, groups: &[&str], material: Material, method: Method) -> Region {
    let surfaces = groups.iter().filter_map(|group| mesh.surfaces.get(*group));
    let mut cells: Vec<usize> = surfaces.flatten().copied().collect();
    cells.sort_unstable();
    Region {
        name: groups.join("+"),
        cells,
        material,
        method,
    }
}

/// The paper's coupling, by the reading of its Table 1.
pub const TRUSS: Coupling = Coupling::Truss(NodeArea::Lumped);

/// Builds a model in plane stress, of the thickness 1 m.
///
/// # Errors
/// Errors of [`Model::build`].
pub fn build(
    mesh: Mesh,
    regions: Vec<Region>,
    coupling: Coupling,
) -> Result<Model, VerificationError> {
    build_in(PlaneState::Stress, mesh, regions, coupling)
}

/// Builds a model of the thickness 1 m.
///
/// # Errors
/// Errors of [`Model::build`].
pub fn build_in(
    plane: PlaneState,
    mesh: Mesh,
    regions: Vec<Region>,
    coupling: Coupling,
) -> Result<Model, VerificationError> {
    let settings = ModelSettings {
        plane,
        thickness: 1.0,
        coupling,
    };
    Ok(Model::build(mesh, regions, settings)?)
}

/// The finite-element nodes on the outline of the whole mesh, ascending.
pub fn outer_nodes(model: &Model) -> Vec<usize> {
    let all: Vec<usize> = (0..model.mesh.cells.len()).collect();
    let outline = model.mesh.outline(&all);
    let nodes = outline.iter().flat_map(Edge::nodes);
    let mut nodes: Vec<usize> = nodes
        .filter_map(|n| model.node_of[n].map(|n| n as usize))
        .collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Prescribes u(x) [m] at the given nodes.
pub fn hold(
    model: &Model,
    nodes: impl IntoIterator<Item = usize>,
    field: impl Fn([f64; 2]) -> [f64; 2],
) -> Boundary {
    let mut boundary = Boundary::new(model);
    for node in nodes {
        for (axis, value) in field(model.positions[node]).into_iter().enumerate() {
            let entry = (value, "held".to_owned());
            boundary.prescribed.insert(2 * node + axis, entry);
        }
    }
    boundary
}

/// Prescribes u(x) [m] on the outline of the whole mesh.
pub fn hold_outline(model: &Model, field: impl Fn([f64; 2]) -> [f64; 2]) -> Boundary {
    hold(model, outer_nodes(model), field)
}

pub fn solve(model: &Model, boundary: &Boundary) -> Result<Solution, VerificationError> {
    Ok(statics::solve(model, boundary)?)
}

/// The node of a model nearest to a position [m].
///
/// # Panics
/// Without a node.
pub fn nearest(positions: &[[f64; 2]], at: [f64; 2]) -> usize {
    let distance = |p: &[f64; 2]| (p[0] - at[0]).hypot(p[1] - at[1]);
    (0..positions.len())
        .min_by(|&a, &b| distance(&positions[a]).total_cmp(&distance(&positions[b])))
        .expect("a model has nodes")
}

/// max|u − u_exact| / max|u_exact| over all dofs [-].
pub fn relative_error(
    model: &Model,
    displacement: &[[f64; 2]],
    exact: impl Fn([f64; 2]) -> [f64; 2],
) -> f64 {
    let (mut error, mut scale) = (0.0f64, 0.0f64);
    for (u, x) in displacement.iter().zip(&model.positions) {
        for (u, exact) in u.iter().zip(exact(*x)) {
            error = error.max((u - exact).abs());
            scale = scale.max(exact.abs());
        }
    }
    error / scale
}
