//! The program's own Cholesky factorisation against faer's, which shares no more than the order of METIS with it:
//! the same displacements of elastic bodies, the same bonds in the same order, and the same bodies refused.

mod common;
mod workplace;

use common::*;
use peristitch::boundary::{Boundary, Directions};
use peristitch::coupling::Coupling;
use peristitch::coupling::truss::NodeArea;
use peristitch::fracture::bond_laws::BondLaws;
use peristitch::fracture::control::{self, Control, Problem, Resolution, Until};
use peristitch::fracture::laws::Strength;
use peristitch::fracture::laws::brittle::Brittle;
use peristitch::fracture::programme::Programme;
use peristitch::fracture::state::State;
use peristitch::linear_solver::Backend;
use peristitch::material::PlaneState;
use peristitch::mesh::CellKind;
use peristitch::model::{Method, Model, ModelSettings, PeridynamicSettings};
use peristitch::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use peristitch::peridynamics::surface::SurfaceCorrection;
use peristitch::statics::{self, Solution, Solver, StaticsError};
use workplace::Workplace;

const DX: f64 = 2.5e-3;

const TRUSS: Coupling = Coupling::Truss(NodeArea::Lumped);

/// 100 × 100 mm: elements of 10 mm outside of a band of material points, `half` m to either side of the middle.
fn plate(kind: CellKind, half: f64, coupling: Coupling) -> Model {
    let grid = Grid {
        size: [0.1, 0.1],
        count: [10, 10],
        kind,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "grips", |[_, y]| (y - 0.05).abs() > half);
    name_cells(&mut mesh, "points", |[_, y]| (y - 0.05).abs() < half);
    name_curve(&mut mesh, "top", |[_, y]| y > 0.1 - 1e-9);
    name_curve(&mut mesh, "bottom", |[_, y]| y < 1e-9);
    let points = PeridynamicSettings {
        lattice: LatticeSettings::upright(DX, Placement::CellCentred, CellArea::Clipped),
        isotropised: true,
        surface_correction: SurfaceCorrection::Force,
        ..paper_lattice(DX, Placement::CellCentred)
    };
    let both = [
        ("points", Method::Peridynamics(points)),
        ("grips", Method::FiniteElements),
    ];
    let there = both
        .iter()
        .filter(|(name, _)| !mesh.surfaces[*name].is_empty());
    let regions = there.map(|&(name, method)| region(&mesh, &[name], steel(), method));
    let regions = regions.collect();
    let settings = ModelSettings {
        plane: PlaneState::Stress,
        thickness: 0.7,
        coupling,
    };
    Model::build(mesh, regions, settings).expect("a sound model")
}

/// The bottom clamped, the top pulled and pushed aside.
fn grips(model: &Model) -> Boundary {
    let mut boundary = Boundary::new(model);
    for (group, displacement) in [
        ("bottom", [Some(0.0); 2]),
        ("top", [Some(1e-7), Some(5e-7)]),
    ] {
        let done = boundary.displace(model, group, displacement);
        done.expect("a grip");
    }
    boundary
}

fn solve(model: &Model, boundary: &Boundary, backend: Backend) -> Solution {
    let solution = statics::solve_by(model, boundary, Some(backend));
    solution.expect("a solution")
}

fn difference(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    let largest = |v: &mut dyn Iterator<Item = f64>| v.fold(0.0, |m: f64, x| m.max(x.abs()));
    let (a, b) = (a.as_flattened(), b.as_flattened());
    largest(&mut a.iter().zip(b).map(|(a, b)| a - b)) / largest(&mut b.iter().copied())
}

#[track_caller]
fn assert_same_solution(what: &str, model: &Model, boundary: &Boundary) {
    let [own, faer] =
        [Backend::Multifrontal, Backend::Faer].map(|backend| solve(model, boundary, backend));
    assert_eq!(
        [own.size.backend, faer.size.backend],
        [Backend::Multifrontal, Backend::Faer]
    );
    let errors = [
        difference(&own.displacement, &faer.displacement),
        difference(&own.reaction, &faer.reaction),
    ];
    println!("{what}: {errors:?}");
    // Residuals are 1e-14 and less, and so were the differences, to a factor of two.
    assert!(errors.iter().all(|&e| e < 1e-13), "{what}: {errors:?}");
}

#[test]
fn elastic_bodies_have_the_same_displacements() {
    for (what, kind, half, coupling) in [
        ("points", CellKind::Quad4, 0.06, TRUSS),
        ("elements, Q8", CellKind::Quad8, 0.0, TRUSS),
        ("elements, T6", CellKind::Tri6, 0.0, TRUSS),
        ("trusses, Q8", CellKind::Quad8, 0.03, TRUSS),
        ("clipped bonds, Q4", CellKind::Quad4, 0.03, Coupling::Clip),
    ] {
        let model = plate(kind, half, coupling);
        assert_same_solution(what, &model, &grips(&model));
    }
}

/// The top on rollers that run 0.4 rad to the x axis: nodes with axes of their own.
#[test]
fn nodes_with_axes_of_their_own() {
    let model = plate(CellKind::Quad8, 0.06, TRUSS);
    let mut boundary = Boundary::new(&model);
    let bottom = boundary.displace(&model, "bottom", [Some(0.0); 2]);
    bottom.expect("a grip");
    let across = [None, Some(1e-5)];
    let top = boundary.displace_along(&model, "top", Directions::Turned(0.4), across);
    top.expect("rollers");
    let model = model.with_node_axes(&boundary.node_axes);
    assert_same_solution("rollers", &model, &boundary);
}

/// All interactions across a line broken: the upper part floats. Both find a pivot of rounding size there; held where it
/// is, the rest is solved.
#[test]
fn a_singular_matrix_is_refused() {
    let model = plate(CellKind::Quad4, 0.06, TRUSS);
    let mut boundary = Boundary::new(&model);
    let bottom = boundary.displace(&model, "bottom", [Some(0.0), Some(1e-6)]);
    bottom.expect("a grip");
    let is_upper = |node: u32| model.positions[node as usize][1] > 0.07;
    let is_one_sided = |interaction: usize| {
        let nodes = model.interactions.nodes(interaction);
        nodes.iter().all(|&n| is_upper(n)) || !nodes.iter().any(|&n| is_upper(n))
    };
    let integrity: Vec<f64> = (0..model.interactions.len())
        .map(|interaction| f64::from(u8::from(is_one_sided(interaction))))
        .collect();
    let upper: Vec<usize> = (0..model.node_count())
        .filter(|&n| is_upper(n as u32))
        .collect();
    for backend in [Backend::Multifrontal, Backend::Faer] {
        let solver = Solver::with_backend(&model, &boundary, Some(backend));
        let solver = solver.expect("a structure");
        let floating = solver.solve(&integrity, &[]);
        let Err(StaticsError::Mechanism { y, .. }) = floating else {
            panic!("{backend:?} finds no mechanism");
        };
        assert!(y > 0.07, "{backend:?}");
        let held = solver.solve(&integrity, std::slice::from_ref(&upper));
        let u = held.expect("a solution").displacement;
        assert!(upper.iter().all(|&node| u[node] == [0.0; 2]));
    }
}

/// Under every control, to separation if it comes to that: hinges and fragments on the way.
#[test]
fn the_same_bonds_break() {
    let model = plate(CellKind::Quad8, 0.03, Coupling::Clip);
    let strength = Strength::Stress {
        tensile: 2e6,
        compressive: Some(20e6),
    };
    let law = Brittle::new(strength, steel().young, &model.points[0].micromodulus);
    let laws = BondLaws::brittle(vec![law.limits], vec![0; model.interactions.len()]);
    let programme = Programme::proportional(grips(&model));
    for (control, steps, least) in [
        (Control::OnePass, 40, 500),
        (Control::Equilibrium { most_passes: 1000 }, 10, 500),
        (Control::EventDriven, 40, 60),
    ] {
        let run = |resolution: Resolution| {
            let problem = Problem {
                model: &model,
                programme: &programme,
                laws: &laws,
                control,
                until: Until {
                    steps,
                    separated: true,
                },
                resolution,
            };
            let mut state = State::new(&model, &programme);
            let mut loads = Vec::new();
            let observe = |state: &State, record: control::Record, _: &_| {
                assert!(record.residual < 1e-10);
                loads.push(state.load.factor);
                Ok::<(), StaticsError>(())
            };
            control::run(&problem, &mut state, observe).expect("no error");
            (state, loads)
        };
        let (own, own_loads) = run(Resolution::Fast);
        let (faer, faer_loads) = run(Resolution::By(Backend::Faer));
        let count = own.broken().len();
        println!("{control:?}: {count} bonds in {} steps", own.step);
        assert!(count >= least, "{control:?}: {count} bonds");
        assert_eq!(own.broken(), faer.broken(), "{control:?}");
        assert_eq!(own.step, faer.step, "{control:?}");
        for (own, faer) in own_loads.iter().zip(&faer_loads) {
            assert!((own / faer - 1.0).abs() < 1e-9, "{control:?}: {own} {faer}");
        }
        let u = difference(&own.displacement, &faer.displacement);
        assert!(u < 1e-9, "{control:?}: {u:e}");
    }
}

#[test]
fn the_solver_of_a_run_is_an_option() {
    let place = Workplace::with_plate();
    let mut lines = Vec::new();
    for (solver, method) in [
        ("own", "direct"),
        ("faer", "faer"),
        ("two-level", "two-level"),
    ] {
        place
            .call(&["run", "plate.yaml", "--force", "--solver", solver])
            .succeeded();
        let summary = place.read("results/plate/summary.json");
        let summary: serde_json::Value = serde_json::from_slice(&summary).expect("JSON");
        assert_eq!(summary["sizes"]["method"], method);
        let history = String::from_utf8(place.read("results/plate/history.csv"));
        lines.push(history.expect("UTF-8").lines().count());
    }
    assert!(
        lines[0] > 100 && lines.iter().all(|&count| count == lines[0]),
        "{lines:?}"
    );
    let both = [
        "run",
        "plate.yaml",
        "--solver",
        "faer",
        "--reference-solver",
    ];
    let refused = place.call(&both);
    assert_eq!(refused.code, Some(2));
    assert!(
        refused.err.contains("cannot be used with"),
        "{}",
        refused.err
    );
}
