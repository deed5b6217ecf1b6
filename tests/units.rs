//! Results do not depend on units, on the size of the body or on its stiffness: linear elasticity has no
//! length and no pressure of its own. The same body from nanometres to thousands of kilometres and from
//! 1 Pa to 1e15 Pa gives the same numbers, but for rounding; so does a pipeline in mm, MPa and N.

mod common;
mod workplace;

use common::*;
use peristitch::boundary::Boundary;
use peristitch::coupling::Coupling;
use peristitch::coupling::truss::NodeArea;
use peristitch::fem::edge::EdgeLoad;
use peristitch::linear_solver::Backend;
use peristitch::material::{Material, PlaneState};
use peristitch::mesh::CellKind;
use peristitch::model::{Method, Model, ModelSettings, PeridynamicSettings};
use peristitch::peridynamics::lattice::Placement;
use peristitch::statics;
use workplace::{PIPELINE, PLATE, Workplace};

/// Points of the paper, isotropised, since the clip takes no others.
fn lattice(spacing: f64) -> PeridynamicSettings {
    PeridynamicSettings {
        isotropised: true,
        ..paper_lattice(spacing, Placement::CellCentred)
    }
}

/// The cantilever `length` × `length`/2, half elements and half points, under a traction of a millionth of E:
/// u over its length, and the reactions over E times the sides.
fn scaled(length: f64, young: f64, thickness: f64, coupling: Coupling) -> [Vec<f64>; 2] {
    let grid = Grid {
        size: [length, 0.5 * length],
        count: [10, 5],
        kind: CellKind::Quad8,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "elements", |x| x[0] < 0.5 * length);
    name_cells(&mut mesh, "points", |x| x[0] > 0.5 * length);
    name_curve(&mut mesh, "clamp", |x| x[0] < 1e-9 * length);
    name_curve(&mut mesh, "load", |x| x[0] > (1.0 - 1e-9) * length);
    let material = Material {
        young,
        poisson: 1.0 / 3.0,
    };
    let lattice = Method::Peridynamics(lattice(length / 20.0));
    let regions = vec![
        region(&mesh, &["elements"], material, Method::FiniteElements),
        region(&mesh, &["points"], material, lattice),
    ];
    let settings = ModelSettings {
        plane: PlaneState::Stress,
        thickness,
        coupling,
    };
    let model = Model::build(mesh, regions, settings).expect("a sound model");
    let mut boundary = Boundary::new(&model);
    boundary
        .displace(&model, "clamp", [Some(0.0), Some(0.0)])
        .expect("a clamp");
    boundary
        .add_traction(
            &model,
            "load",
            EdgeLoad::Traction([3e-7 * young, -1e-6 * young]),
        )
        .expect("a load");
    let solution = statics::solve(&model, &boundary).expect("a solution");
    let force = young * length * thickness;
    let flat = |values: &[[f64; 2]], unit: f64| values.iter().flatten().map(|v| v / unit).collect();
    [
        flat(&solution.displacement, length),
        flat(&solution.reaction, force),
    ]
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let largest = a.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / largest
}

#[test]
fn size_and_stiffness_play_no_part() {
    for coupling in [Coupling::Truss(NodeArea::Lumped), Coupling::Clip] {
        let expected = scaled(1.0, 1.0, 1.0, coupling);
        let mut worst = 0.0_f64;
        for (length, young, thickness) in [
            (1e-9, 1e11, 1e-9),
            (1e6, 1e11, 1.0),
            (1000.0, 1000.0, 1000.0),
            (1e-3, 1.0, 1e-3),
            (1.0, 1e15, 1.0),
            (1e6, 1.0, 1e6),
            (1e-9, 1e15, 1.0),
            (0.3, 7e10, 0.01),
        ] {
            let found = scaled(length, young, thickness, coupling);
            for (found, expected) in found.iter().zip(&expected) {
                worst = worst.max(difference(expected, found));
            }
        }
        println!("{coupling:?}: {worst:.1e}");
        // Only the last bits of coordinates and of the loads differ.
        assert!(worst < LARGEST, "{coupling:?}: {worst:e}");
    }
}

/// Of what the largest displacement or reaction is.
const LARGEST: f64 = 1e-12;

/// One element of 1 m beside points 0.1 mm apart, 20 mm high and pulled: its mean strain is σ/E, since the force
/// that crosses it is that of the load. What the strip of points does, 0.8 mm wide, is not seen from there.
/// Clipped bonds give it to 3e-6, trusses to 0.34 %.
#[test]
fn points_may_be_ten_thousand_times_smaller_than_elements() {
    const STRESS: f64 = 1e6;
    for coupling in [Coupling::Truss(NodeArea::Lumped), Coupling::Clip] {
        let grid = Grid {
            size: [2.0, 0.02],
            count: [2, 1],
            kind: CellKind::Quad8,
        };
        // The right half is pushed together to 0.8 mm.
        let mut mesh = grid.mesh(|[x, _]| [(8e-4 - 1.0) * f64::max(0.0, x - 1.0), 0.0]);
        name_cells(&mut mesh, "elements", |x| x[0] < 1.0);
        name_cells(&mut mesh, "points", |x| x[0] > 1.0);
        name_curve(&mut mesh, "left", |x| x[0] < 1e-9);
        name_curve(&mut mesh, "bottom", |x| x[1] < 1e-9 && x[0] < 1.0 + 1e-9);
        name_curve(&mut mesh, "load", |x| x[0] > 1.0 + 7.9e-4);
        let lattice = Method::Peridynamics(lattice(1e-4));
        let regions = vec![
            region(&mesh, &["elements"], steel(), Method::FiniteElements),
            region(&mesh, &["points"], steel(), lattice),
        ];
        let settings = ModelSettings {
            plane: PlaneState::Stress,
            thickness: 1.0,
            coupling,
        };
        let model = Model::build(mesh, regions, settings).expect("a sound model");
        let is_truss = matches!(coupling, Coupling::Truss(_));
        assert_eq!(model.areas.len(), 200 * 8);
        let mut boundary = Boundary::new(&model);
        let held = [("left", [Some(0.0), None]), ("bottom", [None, Some(0.0)])];
        for (group, values) in held {
            boundary.displace(&model, group, values).expect("a support");
        }
        boundary
            .add_traction(&model, "load", EdgeLoad::Traction([STRESS, 0.0]))
            .expect("a load");
        let solution = statics::solve(&model, &boundary);
        let solution = solution.expect("a right solve is accepted");
        let on_interface = |n: &usize| (model.positions[*n][0] - 1.0).abs() < 1e-9;
        let nodes: Vec<usize> = (0..model.fe_node_count()).filter(on_interface).collect();
        assert_eq!(nodes.len(), 3);
        // Simpson's rule along the interface.
        let weight = |n: usize| {
            if (model.positions[n][1] - 0.01).abs() < 1e-9 {
                4.0
            } else {
                1.0
            }
        };
        let mean: f64 = nodes
            .iter()
            .map(|&n| weight(n) / 6.0 * solution.displacement[n][0])
            .sum();
        let error = mean / (STRESS / steel().young) - 1.0;
        println!(
            "{coupling:?}: {error:.1e}, residual {:.1e}",
            solution.residual
        );
        // Trusses to three nodes of 20 mm of interface hold the points by their corners, which pull the middle.
        let [low, high] = match is_truss {
            true => [3e-3, 4e-3],
            false => [-1e-4, 1e-4],
        };
        assert_between(error, low, high, &format!("{coupling:?}"));
        // Rounding has no part in it: another factorisation, in another order, leaves the same.
        let backend = Some(Backend::Faer);
        let other = statics::solve_by(&model, &boundary, backend);
        let other = other.expect("a solution").displacement;
        let differ = (other.iter().flatten())
            .zip(solution.displacement.iter().flatten())
            .fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        assert!(differ < 1e-6 * mean, "{coupling:?}: {differ:e}");
    }
}

/// The history's columns.
fn history(place: &Workplace) -> Vec<Vec<f64>> {
    let text = String::from_utf8(place.read("results/plate/history.csv")).expect("UTF-8");
    let number = |cell: &str| cell.parse().unwrap_or(0.0);
    text.lines()
        .skip(1)
        .map(|line| line.split(',').map(number).collect())
        .collect()
}

/// λ [-], reaction [N], elastic and dissipated energy, work [J], crack length [m], and bonds broken.
const SCALED: [usize; 6] = [2, 6, 7, 8, 9, 14];
const BROKEN: usize = 11;

#[test]
fn a_pipeline_in_mm_and_mpa_is_the_one_in_si() {
    let si = Workplace::new();
    si.run(&[]);
    let other = Workplace::new();
    let text = PIPELINE
        .replace("100 GPa", "100000 N/mm^2")
        .replace("12.5 mm", "0.0125")
        .replace("1.05 MPa", "1050 kN/m^2")
        .replace("at: [1000 mm, 100 mm]", "at: [1, 0.1]")
        .replace("1.05e-5 m", "0.0105 mm");
    other.write("bar.yaml", text);
    other.run(&[]);
    let tip = |place: &Workplace| {
        place.summary()["probes"][0]["displacement_m"]
            .as_f64()
            .expect("u")
    };
    let error = (tip(&si) - tip(&other)).abs() / tip(&si).abs();
    println!("bar: {error:.1e}");
    assert!(error < 1e-12, "{error:e}");
}

/// The plate a thousand times and a million times as large, a thousand times smaller, as soft as 1 Pa, as stiff
/// as 1e15 Pa: the same bonds break in the same steps, and every number scales.
#[test]
fn a_plate_of_any_size_and_stiffness_breaks_in_the_same_steps() {
    let plate = Workplace::with_plate();
    plate.call(&["run", "plate.yaml"]).succeeded();
    let expected = history(&plate);
    assert!(expected.len() > 100);
    for (unit, length, young) in [
        ("m", 1e3, 30e9),
        ("km", 1e6, 30e9),
        ("um", 1e-3, 30e9),
        ("mm", 1.0, 1.0),
        ("m", 1e3, 1e15),
    ] {
        let place = Workplace::with_plate();
        let stress = young / 30e9;
        let text = PLATE
            .replace("unit: mm", &format!("unit: {unit}"))
            .replace("30 GPa", &format!("{young:e} Pa"))
            .replace("2.01 MPa", &format!("{:e} Pa", 2.01e6 * stress))
            .replace("20.1 MPa", &format!("{:e} Pa", 20.1e6 * stress))
            .replace("spacing: 1 mm", &format!("spacing: {:e} m", 1e-3 * length))
            .replace("2.0e-8 m", &format!("{:e} m", 2.0e-8 * length));
        place.write("plate.yaml", text);
        let ended = place.call(&["run", "plate.yaml"]);
        assert_eq!(ended.code, Some(0), "{unit}, {young:e}: {}", ended.err);
        let found = history(&place);
        let broken = |lines: &[Vec<f64>]| lines.iter().map(|line| line[BROKEN]).collect::<Vec<_>>();
        assert_eq!(broken(&found), broken(&expected), "{unit}, {young:e}");
        // The thickness stays: forces grow as stress times length, energies as that times length.
        let force = stress * length;
        let energy = force * length;
        let factors = [1.0, force, energy, energy, energy, length];
        for (column, factor) in SCALED.into_iter().zip(factors) {
            let of = |lines: &[Vec<f64>], factor: f64| {
                lines
                    .iter()
                    .map(|line| line[column] / factor)
                    .collect::<Vec<_>>()
            };
            let error = difference(&of(&expected, 1.0), &of(&found, factor));
            println!("{unit}, {young:e}: column {column}: {error:.1e}");
            assert!(
                error < 1e-9,
                "{unit}, {young:e}: column {column}: {error:e}"
            );
        }
    }
}
