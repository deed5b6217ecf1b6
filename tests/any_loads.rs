//! Loads and supports anywhere: total forces on points and curves, weight, and rollers along any direction,
//! on finite elements and on material points.

mod common;

use common::*;
use peristitch::boundary::{Boundary, BoundaryError, Directions};
use peristitch::coupling::Coupling;
use peristitch::coupling::truss::NodeArea;
use peristitch::material::{Material, PlaneState};
use peristitch::mesh::{CellKind, Mesh};
use peristitch::model::{Method, Model, ModelSettings, PeridynamicSettings};
use peristitch::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use peristitch::peridynamics::surface::SurfaceCorrection;
use peristitch::statics::{self, Solution, group_reactions};

const DX: f64 = 0.05;
const THICKNESS: f64 = 0.7;

fn settings(angle: f64) -> PeridynamicSettings {
    PeridynamicSettings {
        lattice: LatticeSettings {
            angle,
            ..LatticeSettings::upright(DX, Placement::CellCentred, CellArea::Clipped)
        },
        isotropised: true,
        surface_correction: SurfaceCorrection::Force,
        ..paper_lattice(DX, Placement::CellCentred)
    }
}

/// 2 × 1 m in two halves, turned about the origin.
fn bar(kind: CellKind, angle: f64) -> Mesh {
    let grid = Grid {
        size: [2.0, 1.0],
        count: [8, 4],
        kind,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "left half", |x| x[0] < 1.0);
    name_cells(&mut mesh, "right half", |x| x[0] > 1.0);
    name_curve(&mut mesh, "left", |x| x[0] < 1e-9);
    name_curve(&mut mesh, "right", |x| x[0] > 2.0 - 1e-9);
    name_curve(&mut mesh, "bottom", |x| x[1] < 1e-9);
    name_curve(&mut mesh, "top", |x| x[1] > 1.0 - 1e-9);
    for (name, at) in [
        ("corner", [0.0, 0.0]),
        ("loaded", [1.5, 1.0]),
        ("inner", [0.5, 0.5]),
        ("middle", [1.0, 0.5]),
    ] {
        let node = nearest(&mesh.nodes, at);
        mesh.points.insert(name.to_owned(), vec![node]);
    }
    let (s, c) = angle.sin_cos();
    for x in &mut mesh.nodes {
        *x = [c * x[0] - s * x[1], s * x[0] + c * x[1]];
    }
    mesh
}

fn model(mesh: Mesh, methods: [Method; 2], coupling: Coupling) -> Model {
    let regions = ["left half", "right half"]
        .iter()
        .zip(methods)
        .map(|(group, method)| region(&mesh, &[group], steel(), method))
        .collect();
    let settings = ModelSettings {
        plane: PlaneState::Stress,
        thickness: THICKNESS,
        coupling,
    };
    Model::build(mesh, regions, settings).expect("a sound model")
}

/// Every method and coupling.
fn models(kind: CellKind, angle: f64) -> Vec<(&'static str, Model)> {
    let points = Method::Peridynamics(settings(angle));
    let elements = Method::FiniteElements;
    let truss = Coupling::Truss(NodeArea::Lumped);
    let build = |methods, coupling| model(bar(kind, angle), methods, coupling);
    vec![
        ("elements", build([elements; 2], truss)),
        ("points", build([points; 2], truss)),
        ("trusses", build([elements, points], truss)),
        ("clip", build([elements, points], Coupling::Clip)),
    ]
}

/// Force in x, in y and moment about a position.
fn resultant(model: &Model, load: &[f64], about: [f64; 2]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (f, x) in load.chunks_exact(2).zip(&model.positions) {
        sum[0] += f[0];
        sum[1] += f[1];
        sum[2] += (x[0] - about[0]) * f[1] - (x[1] - about[1]) * f[0];
    }
    sum
}

fn solve(model: &Model, boundary: &Boundary) -> Solution {
    statics::solve(model, boundary).expect("a solution")
}

#[track_caller]
fn assert_close(found: &[f64], expected: &[f64], within: f64, what: &str) {
    let error = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
    let error = error.fold(0.0, f64::max);
    assert!(
        error <= within,
        "{what}: {found:?} for {expected:?}, {error:e}"
    );
}

/// On an edge, inside, and on the interface; resultant and moment to rounding.
#[test]
fn a_force_on_a_point_has_its_resultant_and_its_moment() {
    for (name, model) in models(CellKind::Quad8, 0.0) {
        for group in ["loaded", "inner", "middle", "corner"] {
            let at = model.mesh.nodes[model.mesh.points[group][0]];
            for force in [[3.0, 0.0], [0.0, -2.0], [1.0, 1.5]] {
                let mut boundary = Boundary::new(&model);
                boundary.add_force(&model, group, force).expect("a load");
                let found = resultant(&model, &boundary.load, at);
                let what = format!("{name} {group} {force:?}");
                // Some dozens of terms.
                assert_close(&found, &[force[0], force[1], 0.0], 1e-13, &what);
                // Spread over a family at least, in a peridynamic region.
                let loaded = boundary.load.iter().filter(|f| **f != 0.0).count();
                let is_point = name == "points" || (name != "elements" && group == "loaded");
                // A quarter of a disc of δ in the corner, a force along one axis.
                assert!(!is_point || loaded >= 20, "{what} {loaded}");
            }
        }
    }
}

#[test]
fn a_force_on_a_curve_is_shared_along_it() {
    for (name, model) in models(CellKind::Quad8, 0.0) {
        for (group, about) in [("top", [1.0, 1.0]), ("right", [2.0, 0.5])] {
            let mut boundary = Boundary::new(&model);
            boundary
                .add_force(&model, group, [5.0, -7.0])
                .expect("a load");
            let mut found = resultant(&model, &boundary.load, about);
            // A layer of points is dx/2 inside.
            found[2] *= 0.0;
            assert_close(&found, &[5.0, -7.0, 0.0], 1e-12, &format!("{name} {group}"));
        }
        let mut boundary = Boundary::new(&model);
        let error = boundary.add_force(&model, "nowhere", [1.0, 0.0]);
        assert!(
            matches!(error, Err(BoundaryError::NothingThere { .. })),
            "{name}"
        );
    }
}

/// The weight of a surface acts to rounding, and about its centroid.
#[test]
fn weight_has_the_resultant_of_its_surface() {
    for kind in [
        CellKind::Quad8,
        CellKind::Quad4,
        CellKind::Tri6,
        CellKind::Tri3,
    ] {
        for (name, model) in models(kind, 0.0) {
            for (group, centroid) in [("left half", [0.5, 0.5]), ("right half", [1.5, 0.5])] {
                let mut boundary = Boundary::new(&model);
                boundary
                    .add_body_force(&model, group, [2e3, -5e3])
                    .expect("a load");
                let found = resultant(&model, &boundary.load, centroid);
                let expected = [2e3 * THICKNESS, -5e3 * THICKNESS, 0.0];
                let what = format!("{name} {kind:?} {group}");
                // The lattice fits the halves. Under the clip no points lie by the interface, and their
                // squares are the next ones'; what that does to the moment is told by the sum.
                let within = if name == "clip" { 40.0 } else { 1e-9 };
                assert_close(&found[..2], &expected[..2], 1e-9, &what);
                assert_close(&found[2..], &expected[2..], within, &what);
            }
        }
    }
}

/// A column that stands on rollers under its own weight: u = −(ρg/E)(L y − y²/2), which eight-node elements
/// hold exactly where ν = 0, and points nearly.
#[test]
fn a_column_shortens_under_its_own_weight() {
    let weight = 25e3;
    let grid = Grid {
        size: [1.0, 2.0],
        count: [4, 8],
        kind: CellKind::Quad8,
    };
    let named = || {
        let mut mesh = grid.plain();
        name_cells(&mut mesh, "left half", |x| x[1] < 1.0);
        name_cells(&mut mesh, "right half", |x| x[1] > 1.0);
        name_curve(&mut mesh, "bottom", |x| x[1] < 1e-9);
        name_curve(&mut mesh, "side", |x| x[0] < 1e-9);
        mesh
    };
    let shortening = |model: &Model, roller: &str| {
        let mut boundary = Boundary::new(model);
        let down = [None, Some(0.0)];
        boundary.displace(model, "bottom", down).expect("a side");
        boundary
            .displace(model, roller, [Some(0.0), None])
            .expect("a side");
        for group in ["left half", "right half"] {
            boundary
                .add_body_force(model, group, [0.0, -weight])
                .expect("a load");
        }
        let solution = solve(model, &boundary);
        let reaction = group_reactions(&boundary, &solution.reaction)["bottom"][1];
        let top = nearest(&model.positions, [0.5, 2.0]);
        let y = model.positions[top][1];
        let sunk = |y: f64| -weight / steel().young * (2.0 * y - 0.5 * y * y);
        // A layer of points is held dx/2 above the side.
        let held = nearest(&model.positions, [0.5, 0.0]);
        let exact = sunk(y) - sunk(model.positions[held][1]);
        (
            reaction / (2.0 * weight * THICKNESS) - 1.0,
            solution.displacement[top][1] / exact - 1.0,
        )
    };
    let mesh = named();
    let stiff = Material {
        poisson: 0.0,
        ..steel()
    };
    let all = ["left half", "right half"];
    let elements = region(&mesh, &all, stiff, Method::FiniteElements);
    let elements = build(mesh, vec![elements], PlaneState::Stress);
    let (reaction, top) = shortening(&elements, "side");
    assert_close(&[reaction, top], &[0.0; 2], 1e-11, "elements");
    let points = Method::Peridynamics(settings(0.0));
    let truss = Coupling::Truss(NodeArea::Lumped);
    for (name, methods, coupling) in [
        ("points", [points; 2], truss),
        ("clip", [Method::FiniteElements, points], Coupling::Clip),
    ] {
        let model = model(named(), methods, coupling);
        let (reaction, top) = shortening(&model, "side");
        println!("{name}: reaction {reaction:e}, top {top:e}");
        assert_close(&[reaction], &[0.0], 1e-12, name);
        // The points are 1 % softer along their free sides.
        assert_close(&[top], &[0.0], 0.01, name);
    }
}

/// Turned by 30° with its supports, its loads and its lattice a body answers as before, turned.
#[test]
fn turned_rollers_hold_a_turned_body_as_upright_ones_an_upright_body() {
    let angle = f64::to_radians(30.0);
    let (s, c) = angle.sin_cos();
    let upright = models(CellKind::Quad8, 0.0);
    let turned = models(CellKind::Quad8, angle);
    for ((name, upright), (_, turned)) in upright.into_iter().zip(turned) {
        let supports = |model: &Model, directions: Directions| {
            let mut boundary = Boundary::new(model);
            let hold = |b: &mut Boundary, group, components| {
                b.displace_along(model, group, directions, components)
                    .expect("a side");
            };
            hold(&mut boundary, "left", [Some(0.0), None]);
            hold(&mut boundary, "bottom", [None, Some(0.0)]);
            hold(&mut boundary, "right", [Some(1e-3), None]);
            boundary
        };
        let mut straight = supports(&upright, Directions::Turned(0.0));
        straight
            .add_force(&upright, "loaded", [2e5, -3e5])
            .expect("a load");
        let mut along = supports(&turned, Directions::Turned(angle));
        let force = [c * 2e5 + s * 3e5, s * 2e5 - c * 3e5];
        along.add_force(&turned, "loaded", force).expect("a load");
        let turned = turned.with_node_axes(&along.node_axes);
        let (first, second) = (solve(&upright, &straight), solve(&turned, &along));
        let largest = 1e-3;
        for (node, (u, v)) in first
            .displacement
            .iter()
            .zip(&second.displacement)
            .enumerate()
        {
            let back = [c * v[0] + s * v[1], c * v[1] - s * v[0]];
            // Rotations round by 1e-16, and a condition number of some thousands makes that 1e-12.
            let what = format!("{name} node {node} at {:?}", upright.positions[node]);
            assert_close(&back, u, 1e-10 * largest, &what);
        }
        let sums = |boundary: &Boundary, solution: &Solution| {
            group_reactions(boundary, &solution.reaction)
        };
        let (upright, turned) = (sums(&straight, &first), sums(&along, &second));
        for group in ["left", "bottom", "right"] {
            let v = turned[group];
            let back = [c * v[0] + s * v[1], c * v[1] - s * v[0]];
            let scale = upright["right"][0].abs();
            assert_close(
                &back,
                &upright[group],
                1e-9 * scale,
                &format!("{name} {group}"),
            );
        }
    }
}

/// The normal of a straight side is the axis that `angle` would give.
#[test]
fn normal_and_tangential_are_those_of_the_curve() {
    let angle = f64::to_radians(30.0);
    for (name, model) in models(CellKind::Quad8, angle) {
        let mut by_curve = Boundary::new(&model);
        let mut by_angle = Boundary::new(&model);
        for (group, components) in [("right", [Some(1e-3), None]), ("top", [Some(0.0), None])] {
            by_curve
                .displace_along(&model, group, Directions::Curve, components)
                .expect("a curve");
        }
        // Outward on the right is along the first axis, on top along the second one.
        let turned = Directions::Turned(angle);
        for (group, components) in [("right", [Some(1e-3), None]), ("top", [None, Some(0.0)])] {
            by_angle
                .displace_along(&model, group, turned, components)
                .expect("a curve");
        }
        for boundary in [&mut by_curve, &mut by_angle] {
            boundary
                .displace(&model, "left", [Some(0.0); 2])
                .expect("a side");
        }
        let u = |boundary: &Boundary| {
            let model = model.clone().with_node_axes(&boundary.node_axes);
            solve(&model, boundary).displacement
        };
        for (a, b) in u(&by_curve).iter().zip(&u(&by_angle)) {
            assert_close(a, b, 1e-12 * 1e-3 * 1e2, name);
        }
        // Where sides meet they must not contradict each other.
        let error = by_angle.displace_along(&model, "top", turned, [Some(-2e-3), None]);
        let is_told = matches!(
            error,
            Err(BoundaryError::Conflict { .. } | BoundaryError::Contradiction { .. })
        );
        assert!(is_told, "{name}");
        let error = Boundary::new(&model).displace_along(
            &model,
            "corner",
            Directions::Curve,
            [Some(0.0), None],
        );
        assert!(
            matches!(error, Err(BoundaryError::NoNormal { .. })),
            "{name}"
        );
    }
}
