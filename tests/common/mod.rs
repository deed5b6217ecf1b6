//! Models on structured meshes made in code, so that the physics is tested without a mesher.
#![allow(dead_code, unused_imports)]

pub mod gripped_plate;

use peristitch::boundary::Boundary;
use peristitch::coupling::Coupling;
use peristitch::coupling::truss::NodeArea;
use peristitch::material::{Material, PlaneState};
pub use peristitch::mesh::grid::{Grid, centre, name_cells, name_curve};
use peristitch::mesh::{Edge, Mesh};
use peristitch::model::{Method, Model, ModelSettings, PeridynamicSettings, Region};
use peristitch::peridynamics::kernel::{Kernel, PartialArea};
use peristitch::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use peristitch::peridynamics::surface::SurfaceCorrection;
use peristitch::statics;
pub use peristitch::verification::bodies::{hold_outline, nearest, outer_nodes, relative_error};

pub fn region(mesh: &Mesh, groups: &[&str], material: Material, method: Method) -> Region {
    let mut cells: Vec<usize> = groups
        .iter()
        .flat_map(|g| mesh.surfaces[*g].clone())
        .collect();
    cells.sort_unstable();
    Region {
        name: groups.join("+"),
        cells,
        material,
        method,
    }
}

/// Stiff and bond-based in plane stress.
pub fn steel() -> Material {
    Material {
        young: 100e9,
        poisson: PlaneState::Stress.bond_based_poisson(),
    }
}

/// A displacement field u(x) [m].
pub type Field = fn([f64; 2]) -> [f64; 2];

/// Parallelograms of different sizes, all with the same two directions: affine images of the square.
pub fn parallelograms(grid: &Grid) -> Mesh {
    grid.mesh(|[x, y]| {
        let (s, t) = (0.3 * x * x, 0.4 * y * y);
        [s + 0.3 * (y + t), t + 0.2 * (x + s)]
    })
}

/// The whole mesh as one region of finite elements.
pub fn finite_elements(mesh: Mesh, material: Material, plane: PlaneState) -> Model {
    let region = Region {
        name: "body".to_owned(),
        cells: (0..mesh.cells.len()).collect(),
        material,
        method: Method::FiniteElements,
    };
    build(mesh, vec![region], plane)
}

/// A model of thickness 0.7 m, so that a forgotten thickness shows.
pub fn build(mesh: Mesh, regions: Vec<Region>, plane: PlaneState) -> Model {
    let settings = ModelSettings {
        plane,
        thickness: 0.7,
        coupling: Coupling::Truss(NodeArea::Lumped),
    };
    Model::build(mesh, regions, settings).expect("a sound model")
}

/// A square lattice as the paper has it: quartic kernel, m = 4, full areas.
pub fn paper_lattice(spacing: f64, placement: Placement) -> PeridynamicSettings {
    PeridynamicSettings {
        lattice: LatticeSettings::upright(spacing, placement, CellArea::Full),
        horizon_ratio: 4.0,
        kernel: Kernel::Quartic,
        partial_area: PartialArea::Full,
        isotropised: false,
        surface_correction: SurfaceCorrection::None,
    }
}

/// Displacements of all nodes under the given supports and loads [m].
pub fn displacements(model: &Model, boundary: &Boundary) -> Vec<[f64; 2]> {
    statics::solve(model, boundary)
        .expect("a solution")
        .displacement
}

/// Asserts low ≤ value ≤ high, and says what came out otherwise.
#[track_caller]
pub fn assert_between(value: f64, low: f64, high: f64, what: &str) {
    assert!(
        low <= value && value <= high,
        "{what}: {value:.6e} is not within {low:e} … {high:e}"
    );
}
