//! A plate of material points between two grips of finite elements, on which fracture is tested.
//!
//! ```text
//!   ┌────────────┐   "top": Q4, 10 mm
//!   ├────────────┤
//!   │            │
//!   ╞═════       │   40 × 24 points, 2.5 mm, m = 3
//!   │            │
//!   ├────────────┤
//!   └────────────┘   "bottom"; 100 × 100 mm
//! ```

use super::{build, paper_lattice, region, steel};
use peristitch::boundary::Boundary;
use peristitch::cracks::Cracks;
use peristitch::fracture::bond_laws::BondLaws;
use peristitch::fracture::laws::brittle::Brittle;
use peristitch::fracture::laws::{Strength, StretchLimits};
use peristitch::material::PlaneState;
use peristitch::mesh::grid::{Grid, name_cells, name_curve};
use peristitch::mesh::{CellKind, Edge, Mesh};
use peristitch::model::{Method, Model, PeridynamicSettings, Region};
use peristitch::peridynamics::lattice::Placement;

/// Spacing of the points [m].
pub const DX: f64 = 2.5e-3;

/// A straight crack from one point to another [m].
pub type Segment = [[f64; 2]; 2];

/// The crack from the left to the middle at mid-height.
pub const NOTCH: Segment = [[0.0, 0.05], [0.05, 0.05]];

/// Tensile and compressive strength of the points [Pa].
pub const STRENGTH: [f64; 2] = [2e6, 20e6];

/// Each segment as an edge between two nodes of its own.
pub fn crack_edges(mesh: &mut Mesh, segments: &[Segment]) -> Vec<Edge> {
    let edge = |segment: &Segment| {
        let first = mesh.nodes.len();
        mesh.nodes.extend(segment);
        Edge {
            ends: [first, first + 1],
            middle: None,
        }
    };
    segments.iter().map(edge).collect()
}

/// The lattice of the points, as the paper has it.
pub fn lattice_of_the_plate() -> PeridynamicSettings {
    PeridynamicSettings {
        horizon_ratio: 3.0,
        ..paper_lattice(DX, Placement::CellCentred)
    }
}

/// The plate's mesh, regions and cracks.
pub fn parts_of_the_plate(
    segments: &[Segment],
    settings: PeridynamicSettings,
) -> (Mesh, Vec<Region>, Cracks) {
    let grid = Grid {
        size: [0.1, 0.1],
        count: [10, 10],
        kind: CellKind::Quad4,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "grips", |[_, y]| (y - 0.05).abs() > 0.03);
    name_cells(&mut mesh, "points", |[_, y]| (y - 0.05).abs() < 0.03);
    name_curve(&mut mesh, "top", |[_, y]| y > 0.1 - 1e-9);
    name_curve(&mut mesh, "bottom", |[_, y]| y < 1e-9);
    let edges = crack_edges(&mut mesh, segments);
    let cracks = Cracks::new(&mesh, &edges);
    let regions = vec![
        region(&mesh, &["grips"], steel(), Method::FiniteElements),
        region(&mesh, &["points"], steel(), Method::Peridynamics(settings)),
    ];
    (mesh, regions, cracks)
}

/// The plate with these cracks, its points tied by trusses.
pub fn gripped_plate(segments: &[Segment]) -> Model {
    let (mesh, regions, cracks) = parts_of_the_plate(segments, lattice_of_the_plate());
    build(mesh, regions, PlaneState::Stress).with_cracks(&cracks)
}

/// The brittle law of the bonds of a lattice of steel.
pub fn brittle(model: &Model) -> Brittle {
    let strength = Strength::Stress {
        tensile: STRENGTH[0],
        compressive: Some(STRENGTH[1]),
    };
    Brittle::new(strength, steel().young, &model.points[0].micromodulus)
}

/// The plate's bonds; trusses never break.
pub fn brittle_bonds(model: &Model) -> BondLaws {
    bonds_within(model, brittle(model).limits)
}

/// Bonds with these limits; trusses never break.
pub fn bonds_within(model: &Model, limits: StretchLimits) -> BondLaws {
    let class = |interaction| u32::from(model.interactions.bonds().contains(&interaction));
    BondLaws::brittle(
        vec![StretchLimits::NONE, limits],
        (0..model.interactions.len()).map(class).collect(),
    )
}

/// The bottom held, the top displaced [m].
pub fn bottom_held(model: &Model, top: [f64; 2]) -> Boundary {
    let mut boundary = Boundary::new(model);
    for (group, u) in [("bottom", [0.0; 2]), ("top", top)] {
        let grip = boundary.displace(model, group, u.map(Some));
        grip.expect("a grip");
    }
    boundary
}

/// The grips displaced apart, each by this distance [m].
pub fn pulled_apart(model: &Model, distance: f64) -> Boundary {
    let mut boundary = Boundary::new(model);
    for (group, sign) in [("top", 1.0), ("bottom", -1.0)] {
        let u = [Some(0.0), Some(sign * distance)];
        boundary.displace(model, group, u).expect("a grip");
    }
    boundary
}
