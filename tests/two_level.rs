//! Conjugate gradients on two levels against Cholesky's factors, and what they do where there is no
//! solution.
//!
//! Residuals are promised to 1e-10 of the load. A displacement may be off by more, up to the condition
//! number of K; the tolerances are ten times what was measured.

mod common;
mod workplace;

use common::*;
use peristitch::boundary::{Boundary, Directions};
use peristitch::coupling::Coupling;
use peristitch::coupling::truss::NodeArea;
use peristitch::cracks::Cracks;
use peristitch::fracture::bond_laws::BondLaws;
use peristitch::fracture::control::{self, Control, Problem, Resolution, Until};
use peristitch::fracture::laws::Strength;
use peristitch::fracture::laws::brittle::Brittle;
use peristitch::fracture::programme::Programme;
use peristitch::fracture::state::State;
use peristitch::linear_solver::Backend;
use peristitch::material::PlaneState;
use peristitch::mesh::{CellKind, Edge, Mesh};
use peristitch::model::{Method, Model, ModelSettings, PeridynamicSettings};
use peristitch::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use peristitch::peridynamics::surface::SurfaceCorrection;
use peristitch::statics::{self, Solution, Solver, StaticsError};
use workplace::Workplace;

const DX: f64 = 1.25e-3;

/// 100 × 100 mm with elements of 10 mm below and above a band of material points `half` m to either side
/// of the middle, and a crack from the left to a third of the width.
fn plate(half: f64, coupling: Coupling) -> Model {
    let grid = Grid {
        size: [0.1, 0.1],
        count: [10, 10],
        kind: CellKind::Quad8,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "grips", |[_, y]| (y - 0.05).abs() > half);
    name_cells(&mut mesh, "points", |[_, y]| (y - 0.05).abs() < half);
    name_curve(&mut mesh, "top", |[_, y]| y > 0.1 - 1e-9);
    name_curve(&mut mesh, "bottom", |[_, y]| y < 1e-9);
    let cracks = crack(&mut mesh);
    let settings = PeridynamicSettings {
        lattice: LatticeSettings::upright(DX, Placement::CellCentred, CellArea::Clipped),
        isotropised: true,
        surface_correction: SurfaceCorrection::Force,
        ..paper_lattice(DX, Placement::CellCentred)
    };
    let mut regions = vec![region(
        &mesh,
        &["points"],
        steel(),
        Method::Peridynamics(settings),
    )];
    if half < 0.05 {
        regions.push(region(&mesh, &["grips"], steel(), Method::FiniteElements));
    }
    let settings = ModelSettings {
        plane: PlaneState::Stress,
        thickness: 0.7,
        coupling,
    };
    let model = Model::build(mesh, regions, settings).expect("a sound model");
    model.with_cracks(&cracks)
}

/// Through the middle of cells of the coarse level, four spacings wide.
fn crack(mesh: &mut Mesh) -> Cracks {
    let first = mesh.nodes.len();
    let height = 0.05 + 2.2 * DX;
    mesh.nodes.extend([[0.0, height], [0.033, height]]);
    let edge = Edge {
        ends: [first, first + 1],
        middle: None,
    };
    Cracks::new(mesh, &[edge])
}

/// The bottom clamped, the top pulled and pushed aside.
fn grips(model: &Model) -> Boundary {
    let mut boundary = Boundary::new(model);
    let bottom = boundary.displace(model, "bottom", [Some(0.0); 2]);
    bottom.expect("a grip");
    let top = boundary.displace(model, "top", [Some(2e-6), Some(1e-5)]);
    top.expect("a grip");
    boundary
}

/// The bottom clamped, the top on rollers that run 0.4 rad to the x axis, pulled across: nodes with axes of
/// their own.
fn rollers(model: Model) -> (Model, Boundary) {
    let mut boundary = Boundary::new(&model);
    let bottom = boundary.displace(&model, "bottom", [Some(0.0); 2]);
    bottom.expect("a grip");
    let across = [None, Some(1e-5)];
    let top = boundary.displace_along(&model, "top", Directions::Turned(0.4), across);
    top.expect("rollers");
    (model.with_node_axes(&boundary.node_axes), boundary)
}

fn solve(model: &Model, backend: Backend) -> Solution {
    solve_with(model, &grips(model), backend)
}

fn solve_with(model: &Model, boundary: &Boundary, backend: Backend) -> Solution {
    let solution = statics::solve_by(model, boundary, Some(backend));
    solution.expect("a solution")
}

fn difference(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    let largest = |v: &mut dyn Iterator<Item = f64>| v.fold(0.0, |m: f64, x| m.max(x.abs()));
    let (a, b) = (a.as_flattened(), b.as_flattened());
    largest(&mut a.iter().zip(b).map(|(a, b)| a - b)) / largest(&mut b.iter().copied())
}

#[track_caller]
fn assert_same(model: &Model, boundary: &Boundary) {
    let [direct, two_level] = [Backend::Multifrontal, Backend::TwoLevel]
        .map(|backend| solve_with(model, boundary, backend));
    assert_eq!(two_level.size.backend, Backend::TwoLevel);
    assert!(two_level.size.factor_entries < direct.size.factor_entries / 4);
    assert_between(two_level.residual, 1e-16, 1e-10, "the backward error");
    let errors = [
        difference(&two_level.displacement, &direct.displacement),
        difference(&two_level.reaction, &direct.reaction),
    ];
    assert!(errors.iter().all(|&e| e < 1e-9), "{errors:?}");
}

#[test]
fn a_cracked_lattice() {
    let model = plate(0.06, Coupling::Truss(NodeArea::Lumped));
    assert_same(&model, &grips(&model));
}

#[test]
fn a_hybrid_by_trusses() {
    let model = plate(0.03, Coupling::Truss(NodeArea::Lumped));
    assert_same(&model, &grips(&model));
}

#[test]
fn a_hybrid_by_clipped_bonds() {
    let model = plate(0.03, Coupling::Clip);
    assert_same(&model, &grips(&model));
}

/// On elements and on material points.
#[test]
fn turned_rollers() {
    for half in [0.03, 0.06] {
        let (model, boundary) = rollers(plate(half, Coupling::Clip));
        assert!(!model.node_axes.is_empty());
        assert_same(&model, &boundary);
    }
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    let model = plate(0.03, Coupling::Clip);
    let [one, two, three] = [1, 2, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let solution = pool
            .expect("a pool")
            .install(|| solve(&model, Backend::TwoLevel));
        let all = solution.displacement.iter().chain(&solution.reaction);
        all.flatten().map(|x| x.to_bits()).collect::<Vec<u64>>()
    });
    assert!(one == two && one == three);
}

/// A solution is a guess that needs no iteration, and is left as it is.
#[test]
fn a_solution_is_its_own_guess() {
    let model = plate(0.06, Coupling::Clip);
    let boundary = grips(&model);
    let backend = Some(Backend::TwoLevel);
    let solver = Solver::with_backend(&model, &boundary, backend).expect("a structure");
    let mut mechanisms = Default::default();
    let factorised = solver
        .factorise_broken(&model.integrity, &[], &mut mechanisms)
        .expect("no mechanism");
    let solve = |guess: Option<&[[f64; 2]]>| {
        let solution = solver.solve_with(&factorised, &boundary, guess, &mechanisms);
        solution.expect("a solution")
    };
    let first = solve(None);
    let second = solve(Some(&first.displacement));
    assert_eq!(first.displacement, second.displacement);
    // A guess that is off is no worse than none.
    let off: Vec<[f64; 2]> = first
        .displacement
        .iter()
        .map(|u| u.map(|u| 1.1 * u + 1e-7))
        .collect();
    let third = solve(Some(&off));
    assert!(third.residual < 1e-10);
    assert!(difference(&third.displacement, &first.displacement) < 1e-9);
}

/// All interactions across a line broken: the upper part floats, which the coarse level finds. Held where it
/// is, all is well.
#[test]
fn a_part_that_floats_is_found() {
    let model = plate(0.06, Coupling::Clip);
    let mut boundary = Boundary::new(&model);
    let bottom = boundary.displace(&model, "bottom", [Some(0.0), Some(1e-6)]);
    bottom.expect("a grip");
    let is_upper = |node: u32| model.positions[node as usize][1] > 0.07;
    let integrity: Vec<f64> = (0..model.interactions.len())
        .map(|s| {
            let nodes = model.interactions.nodes(s);
            let upper = nodes.iter().filter(|&&n| is_upper(n)).count();
            if upper == 0 || upper == nodes.len() {
                1.0
            } else {
                0.0
            }
        })
        .collect();
    let upper: Vec<usize> = (0..model.node_count())
        .filter(|&n| is_upper(n as u32))
        .collect();
    for backend in [Backend::Multifrontal, Backend::TwoLevel] {
        let solver = Solver::with_backend(&model, &boundary, Some(backend));
        let solver = solver.expect("a structure");
        if backend == Backend::TwoLevel {
            let floating = solver.solve(&integrity, &[]);
            let Err(StaticsError::Mechanism { y, .. }) = floating else {
                panic!("no mechanism was found");
            };
            assert!(y > 0.07);
        }
        let held = solver.solve(&integrity, std::slice::from_ref(&upper));
        let held = held.expect("a solution");
        assert!(
            upper
                .iter()
                .all(|&node| held.displacement[node] == [0.0; 2])
        );
        let lower = (0..model.node_count()).find(|&n| !is_upper(n as u32));
        let u = held.displacement[lower.expect("a point")];
        // The lower part follows its support as a rigid body.
        assert!((u[1] - 1e-6).abs() < 1e-14 && u[0].abs() < 1e-14, "{u:?}");
    }
}

/// The paper's control until a third of the plate is broken: the same bonds in the same order.
#[test]
fn the_same_bonds_break() {
    let model = plate(0.06, Coupling::Truss(NodeArea::Lumped));
    let boundary = grips(&model);
    assert_same_sequence(&model, boundary);
}

#[test]
fn the_same_bonds_break_on_turned_rollers() {
    let (model, boundary) = rollers(plate(0.06, Coupling::Truss(NodeArea::Lumped)));
    assert_same_sequence(&model, boundary);
}

#[track_caller]
fn assert_same_sequence(model: &Model, boundary: Boundary) {
    let strength = Strength::Stress {
        tensile: 2e6,
        compressive: Some(20e6),
    };
    let law = Brittle::new(strength, steel().young, &model.points[0].micromodulus);
    let laws = BondLaws::brittle(vec![law.limits], vec![0; model.interactions.len()]);
    let programme = Programme::proportional(boundary);
    for control in [Control::OnePass, Control::EventDriven] {
        let (steps, least) = match control {
            Control::OnePass => (12, 50),
            _ => (10, 10),
        };
        let broken = |resolution: Resolution| {
            let problem = Problem {
                model,
                programme: &programme,
                laws: &laws,
                control,
                until: Until {
                    steps,
                    separated: true,
                },
                resolution,
            };
            let mut state = State::new(model, &programme);
            let observe = |_: &State, record: control::Record, _: &_| {
                assert!(record.residual < 1e-10);
                Ok::<(), StaticsError>(())
            };
            control::run(&problem, &mut state, observe).expect("no error");
            assert!(state.stopped.is_none());
            (state.broken(), state.load.factor, state.energy)
        };
        let (expected, load, energy) = broken(Resolution::Fast);
        let (found, other_load, other_energy) = broken(Resolution::By(Backend::TwoLevel));
        assert!(expected.len() >= least, "{} bonds", expected.len());
        assert_eq!(found, expected);
        assert!((other_load / load - 1.0).abs() < 1e-9);
        assert!((other_energy.elastic / energy.elastic - 1.0).abs() < 1e-8);
        assert!((other_energy.dissipated / energy.dissipated - 1.0).abs() < 1e-8);
    }
}

/// What `check` says of the memory, and what the run takes: within 20 %, by factors and on two levels,
/// with bonds that break and without. 40 000 points: what a process takes anyway does not count.
#[test]
fn check_knows_the_memory_of_the_run() {
    let place = Workplace::with_plate();
    let loads = "boundary:
  - { group: bottom, displacement: { x: 0, y: 0 } }
  - { group: top, displacement: { x: 0, y: 1.0e-6 m } }
";
    let body = "
geometry: { file: geo/plate.geo, unit: mm, parameters: { element: 5, order: 2, crack: 10, band: 40 } }
materials:
  rock: { young: 30 GPa, poisson: 1/3, tensile_strength: 2 MPa }
regions:
  - { group: grips, model: fem, material: rock }
  - { group: band, model: peridynamics, material: rock, spacing: 0.22 mm, horizon: 4 }
cracks: [crack]
output: { pictures: false }
";
    let breaking = "loading: { control: one-pass, steps: 4 }\n";
    for (name, loading) in [("once", ""), ("breaks", breaking)] {
        place.write(
            &format!("{name}.yaml"),
            format!("name: {name}{body}{loads}{loading}"),
        );
        for flags in [&[][..], &["--iterative-solver"]] {
            let pipeline = format!("{name}.yaml");
            let arguments = |command: &'static str| {
                let mut all = vec![command, &pipeline];
                all.extend(flags);
                all
            };
            let checked = place.call(&arguments("check")).succeeded().out;
            let expected = checked
                .lines()
                .find_map(|l| l.trim().strip_prefix("to expect"));
            let expected: f64 = expected
                .and_then(|text| text.split_whitespace().next()?.parse().ok())
                .unwrap_or_else(|| panic!("{checked}"));
            let mut run = arguments("run");
            run.push("--force");
            place.call(&run).succeeded();
            let summary = place.read(&format!("results/{name}/summary.json"));
            let summary: serde_json::Value = serde_json::from_slice(&summary).expect("JSON");
            let method = summary["sizes"]["method"].as_str().expect("a method");
            assert_eq!(method == "two-level", !flags.is_empty());
            let needed = summary["peak_memory_bytes"].as_f64().expect("a size") / 1e6;
            assert!(needed > 100.0, "{needed} MB");
            println!("{name} {flags:?}: {expected} MB told, {needed} MB taken");
            assert_between(expected / needed, 0.8, 1.2, &format!("{name} {flags:?}"));
        }
    }
}
