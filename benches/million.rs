//! Large lattices: time and memory of each phase of an elastic solve, `cargo bench --bench million`, or
//! `cargo bench --bench million -- 500 direct` for 500² points by Cholesky's factors.
//!
//! A square of material points, m = 4, with all that pipelines do unless told otherwise, clamped at one
//! side and pulled at the other.

use peristitch::boundary::Boundary;
use peristitch::coupling::Coupling;
use peristitch::coupling::truss::NodeArea;
use peristitch::fem::edge::EdgeLoad;
use peristitch::linear_solver::Backend;
use peristitch::material::{Material, PlaneState};
use peristitch::mesh::grid::Grid;
use peristitch::mesh::{CellKind, Edge, Mesh};
use peristitch::model::{self, Model, ModelSettings, PeridynamicSettings, Region};
use peristitch::peridynamics::kernel::{Kernel, PartialArea};
use peristitch::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use peristitch::peridynamics::surface::SurfaceCorrection;
use peristitch::phases::{collect, peak_memory};
use peristitch::statics::Solver;
use peristitch::support;
use peristitch::trace::Trace;
use std::time::Instant;

/// A clamped side, a pulled one.
const SIDES: [&str; 2] = ["bottom", "top"];

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let side = arguments
        .iter()
        .find_map(|a| a.parse().ok())
        .unwrap_or(1000);
    let backend = Backend::ALL
        .into_iter()
        .find(|backend| arguments.iter().any(|a| a == backend.describe()));
    println!(
        "{side} × {side} points\n{:<16} {:>8} {:>10}",
        "phase", "s", "peak MB"
    );
    let model = step("discretisation", || plate(side));
    let boundary = step("boundary", || loads(&model));
    step("support", || {
        support::check(&model, &boundary).expect("it is clamped");
        assert!(support::loose_parts(&model, &boundary, &model.integrity).is_empty());
    });
    let (solution, phases) = collect(&Trace::default(), || {
        let solver = step("structure", || {
            Solver::with_backend(&model, &boundary, backend).expect("a structure")
        });
        step("solve", || {
            let solved = solver.solve(&model.integrity, &[]);
            solved.expect("a solution")
        })
    });
    for phase in &phases.list {
        println!("  {:<14} {:>8.2}", phase.name, phase.time.as_secs_f64());
    }
    println!(
        "{}, {} bonds, {} entries of L, residual {:.1e}",
        solution.size.backend.describe(),
        model.interactions.len(),
        solution.size.factor_entries,
        solution.residual
    );
}

fn step<T>(name: &str, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    let megabytes = peak_memory().unwrap_or(0) as f64 / 1e6;
    println!(
        "{name:<16} {:>8.2} {megabytes:>10.0}",
        start.elapsed().as_secs_f64()
    );
    result
}

fn plate(side: usize) -> Model {
    let grid = Grid {
        size: [1.0, 1.0],
        count: [10, 10],
        kind: CellKind::Quad8,
    };
    let mut mesh = grid.mesh(|_| [0.0; 2]);
    for (name, y) in SIDES.into_iter().zip([0.0, 1.0]) {
        let edges = edges_at(&mesh, y);
        mesh.curves.insert(name.to_owned(), edges);
    }
    let method = model::Method::Peridynamics(PeridynamicSettings {
        lattice: LatticeSettings::upright(
            1.0 / side as f64,
            Placement::CellCentred,
            CellArea::Clipped,
        ),
        horizon_ratio: 4.0,
        kernel: Kernel::Quartic,
        partial_area: PartialArea::Full,
        isotropised: true,
        surface_correction: SurfaceCorrection::Force,
    });
    let region = Region {
        name: "plate".to_owned(),
        cells: (0..mesh.cells.len()).collect(),
        material: Material {
            young: 30e9,
            poisson: PlaneState::Stress.bond_based_poisson(),
        },
        method,
    };
    let settings = ModelSettings {
        plane: PlaneState::Stress,
        thickness: 1.0,
        coupling: Coupling::Truss(NodeArea::Lumped),
    };
    Model::build(mesh, vec![region], settings).expect("a sound model")
}

/// The edges of the outline at this height [m].
fn edges_at(mesh: &Mesh, y: f64) -> Vec<Edge> {
    let all: Vec<usize> = (0..mesh.cells.len()).collect();
    let is_there = |edge: &Edge| {
        edge.nodes()
            .all(|node| (mesh.nodes[node][1] - y).abs() < 1e-9)
    };
    let outline = mesh.outline(&all).into_iter();
    outline.filter(is_there).collect()
}

fn loads(model: &Model) -> Boundary {
    let [clamped, pulled] = SIDES;
    let mut boundary = Boundary::new(model);
    boundary
        .displace(model, clamped, [Some(0.0), Some(0.0)])
        .expect("a clamp");
    boundary
        .add_traction(model, pulled, EdgeLoad::Traction([0.0, 1e6]))
        .expect("a load");
    boundary
}
