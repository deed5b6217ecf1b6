//! What is not held is named in the user's words: which regions, which motions, about which point;
//! and what connectivity cannot see ends as an error of the solve, not as numbers.

mod common;

use common::*;
use peristitch::boundary::Boundary;
use peristitch::material::PlaneState;
use peristitch::mesh::{CellKind, Mesh};
use peristitch::model::{Method, Model};
use peristitch::peridynamics::kernel::Kernel;
use peristitch::peridynamics::lattice::Placement;
use peristitch::statics::{self, StaticsError};
use peristitch::support::{self, NotHeld, RigidMotion};

/// Three squares of 1 m in a row, 4 × 4 elements each; the middle one is a gap.
fn two_squares() -> Mesh {
    let mut mesh = Grid {
        size: [3.0, 1.0],
        count: [12, 4],
        kind: CellKind::Quad4,
    }
    .plain();
    name_cells(&mut mesh, "left", |x| x[0] < 1.0);
    name_cells(&mut mesh, "right", |x| x[0] > 2.0);
    name_curve(&mut mesh, "wall", |x| x[0] < 1e-9);
    let node = nearest(&mesh.nodes, [0.75, 0.25]);
    mesh.points.insert("pin".to_owned(), vec![node]);
    mesh
}

fn points(spacing: f64) -> Method {
    Method::Peridynamics(paper_lattice(spacing, Placement::CellCentred))
}

fn left_alone() -> Model {
    let mesh = two_squares();
    let left = region(&mesh, &["left"], steel(), Method::FiniteElements);
    build(mesh, vec![left], PlaneState::Stress)
}

fn held(model: &Model, group: &str, components: [Option<f64>; 2]) -> Boundary {
    let mut boundary = Boundary::new(model);
    boundary
        .displace(model, group, components)
        .expect("a group of the mesh");
    boundary
}

/// The same answer of the check and of the solve.
fn not_held(model: &Model, boundary: &Boundary) -> NotHeld {
    let checked = support::check(model, boundary).expect_err("not held");
    let solved = statics::solve(model, boundary);
    let Err(StaticsError::NotHeld(solved)) = solved else {
        panic!("the solve says {solved:?}");
    };
    assert_eq!(checked.to_string(), solved.to_string());
    checked
}

/// Moves in x, in y and turns: all that a plane body can.
fn assert_floats(answer: &NotHeld) {
    let [a, b, c] = answer.free[..] else {
        panic!("{:?}", answer.free);
    };
    assert_eq!([a, b], [RigidMotion::MoveX, RigidMotion::MoveY]);
    assert!(matches!(c, RigidMotion::Turn(_)), "{c:?}");
    assert!(!answer.whole);
}

#[test]
fn of_two_squares_the_one_that_nothing_holds_is_named() {
    for method in [Method::FiniteElements, points(0.1)] {
        let mesh = two_squares();
        let regions = vec![
            region(&mesh, &["left"], steel(), Method::FiniteElements),
            region(&mesh, &["right"], steel(), method),
        ];
        let model = build(mesh, regions, PlaneState::Stress);
        let answer = not_held(&model, &held(&model, "wall", [Some(0.0); 2]));
        assert_eq!(answer.regions, ["right"]);
        assert_floats(&answer);
        let message = answer.to_string();
        assert!(
            message.starts_with("region `right` is tied to nothing that is held: it can move in x"),
            "{message}"
        );
    }
}

#[test]
fn rollers_along_y_leave_the_motion_in_y() {
    let model = left_alone();
    let answer = not_held(&model, &held(&model, "wall", [Some(0.0), None]));
    assert_eq!(answer.free, [RigidMotion::MoveY]);
    assert!(answer.whole);
    assert_eq!(answer.to_string(), "the body can move in y freely");
}

#[test]
fn a_single_pin_leaves_the_turn_about_it() {
    let model = left_alone();
    let answer = not_held(&model, &held(&model, "pin", [Some(0.0); 2]));
    let [RigidMotion::Turn([x, y])] = answer.free[..] else {
        panic!("{:?}", answer.free);
    };
    // Coordinates of order one through an eigenvector of a 3 × 3 matrix.
    assert!(
        (x - 0.75).abs() < 1e-14 && (y - 0.25).abs() < 1e-14,
        "({x}, {y})"
    );
    assert!(answer.whole);
}

#[test]
fn a_pin_and_a_roller_that_pulls_through_it_leave_the_turn() {
    // The roller at (0, 0.25) holds x, in line with the pin at (0.75, 0.25).
    let mut mesh = two_squares();
    let node = nearest(&mesh.nodes, [0.0, 0.25]);
    mesh.points.insert("roller".to_owned(), vec![node]);
    let left = region(&mesh, &["left"], steel(), Method::FiniteElements);
    let model = build(mesh, vec![left], PlaneState::Stress);
    let mut boundary = held(&model, "pin", [Some(0.0); 2]);
    boundary
        .displace(&model, "roller", [Some(0.0), None])
        .expect("a point");
    let answer = not_held(&model, &boundary);
    assert!(
        matches!(answer.free[..], [RigidMotion::Turn(_)]),
        "{:?}",
        answer.free
    );
    // In y instead, it holds.
    boundary
        .displace(&model, "roller", [None, Some(0.0)])
        .expect("a point");
    support::check(&model, &boundary).expect("held");
    statics::solve(&model, &boundary).expect("a solution");
}

/// A square of points clamped on the left, with the given m and kernel.
fn lattice(horizon_ratio: f64, kernel: Kernel) -> Model {
    let mesh = two_squares();
    let mut settings = paper_lattice(0.1, Placement::CellCentred);
    settings.horizon_ratio = horizon_ratio;
    settings.kernel = kernel;
    let left = region(&mesh, &["left"], steel(), Method::Peridynamics(settings));
    build(mesh, vec![left], PlaneState::Stress)
}

fn assert_refused(model: &Model, boundary: &Boundary, what: &str) -> StaticsError {
    support::check(model, boundary).expect("connectivity sees nothing wrong");
    let solved = statics::solve(model, boundary);
    let error = match solved {
        Ok(solution) => {
            let largest = solution
                .displacement
                .iter()
                .flatten()
                .fold(0.0f64, |m, u| m.max(u.abs()));
            panic!(
                "{what}: a solution with |u| up to {largest:e} and residual {:e}",
                solution.residual
            )
        }
        Err(error) => error,
    };
    assert!(
        matches!(
            error,
            StaticsError::Mechanism { .. } | StaticsError::Residual { .. }
        ),
        "{what}: {error}"
    );
    error
}

#[test]
fn bonds_along_the_axes_only_are_a_mechanism() {
    let mut model = lattice(2.0, Kernel::Constant);
    let pairs = model.interactions.pairs().to_vec();
    for (ends, k) in pairs.iter().zip(&mut model.interactions.stiffness) {
        let [a, b] = ends.map(|node| model.positions[node as usize]);
        if (0..2).all(|axis| (b[axis] - a[axis]).abs() > 1e-9) {
            *k = 0.0;
        }
    }
    let mut boundary = held(&model, "wall", [Some(0.0); 2]);
    boundary.load[2 * 57 + 1] = 1.0;
    assert_refused(&model, &boundary, "a grid of axial bonds");
}

/// Point 44 (column 4, row 4) keeps the bonds that are parallel to `direction` alone.
fn dangling(direction: [f64; 2]) -> Model {
    let mut model = lattice(4.0, Kernel::Quartic);
    let centre = model.positions[44];
    let pairs = model.interactions.pairs().to_vec();
    for (ends, k) in pairs.iter().zip(&mut model.interactions.stiffness) {
        if ends.contains(&44) {
            let other = ends[usize::from(ends[0] == 44)];
            let x = model.positions[other as usize];
            let cross = (x[0] - centre[0]) * direction[1] - (x[1] - centre[1]) * direction[0];
            if cross.abs() > 1e-9 {
                *k = 0.0;
            }
        }
    }
    model
}

#[test]
fn a_point_on_collinear_bonds_is_a_mechanism_wherever_the_load_is() {
    for direction in [
        [1.0, 0.0],
        [0.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [2.0, -1.0],
        [3.0, 1.0],
        [1.0, -3.0],
        [3.0, 2.0],
    ] {
        for (loaded, force) in [(44, [0.3, 1.0]), (57, [1.0, 0.2]), (99, [-0.7, 0.1])] {
            let model = dangling(direction);
            let mut boundary = held(&model, "wall", [Some(0.0); 2]);
            boundary.load[2 * loaded..][..2].copy_from_slice(&force);
            let error = assert_refused(
                &model,
                &boundary,
                &format!("{direction:?}, load at {loaded}"),
            );
            if let StaticsError::Mechanism {
                x, y, interactions, ..
            } = error
            {
                assert!(
                    (x - 0.45).abs() < 1e-9 && (y - 0.45).abs() < 1e-9,
                    "({x}, {y})"
                );
                assert!((2..=6).contains(&interactions), "{interactions}");
            }
        }
    }
}
