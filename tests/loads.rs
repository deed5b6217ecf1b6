//! Loads and supports balance: Σ reactions + Σ loads = 0 and the same for the moments, to 1e-12 of
//! Σ|loads|, on straight and curved edges of elements and on layers of material points; and loads
//! or supports that contradict each other are errors.
//!
//! A solve is refined to a residual of 1e-14, whose sum over some hundred nodes is what is left.

mod common;

use common::*;
use peristitch::boundary::{Boundary, BoundaryError};
use peristitch::fem::edge::EdgeLoad;
use peristitch::material::PlaneState;
use peristitch::mesh::{Cell, CellKind, Mesh};
use peristitch::model::{Method, Model};
use peristitch::peridynamics::lattice::Placement;
use peristitch::statics;
use std::f64::consts::PI;

const BALANCE: f64 = 1e-12;

/// Force in x, in y and moment about the origin.
fn resultant<'a>(model: &Model, forces: impl IntoIterator<Item = &'a [f64]>) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (f, x) in forces.into_iter().zip(&model.positions) {
        sum[0] += f[0];
        sum[1] += f[1];
        sum[2] += x[0] * f[1] - x[1] * f[0];
    }
    sum
}

fn applied(model: &Model, boundary: &Boundary) -> [f64; 3] {
    resultant(model, boundary.load.chunks(2))
}

fn size(boundary: &Boundary) -> f64 {
    boundary.load.iter().map(|f| f.abs()).sum()
}

fn assert_close(values: [f64; 3], expected: [f64; 3], scale: f64, what: &str) {
    for (value, expected) in values.into_iter().zip(expected) {
        let error = (value - expected).abs() / scale;
        assert!(
            error <= BALANCE,
            "{what}: {values:?} for {expected}, {error:e}"
        );
    }
}

fn assert_balance(model: &Model, boundary: &Boundary, what: &str) {
    let solution = statics::solve(model, boundary).expect("a solution");
    let reactions = resultant(model, solution.reaction.iter().map(|r| r.as_slice()));
    let loads = applied(model, boundary);
    assert!(
        loads[0].abs() + loads[1].abs() > 0.1 * size(boundary),
        "{what}: a load that is none"
    );
    assert_close(reactions, loads.map(|f| -f), size(boundary), what);
}

/// 2 × 1 m with named sides, halves and the corner at the origin.
fn bar(kind: CellKind) -> Mesh {
    let mut mesh = Grid {
        size: [2.0, 1.0],
        count: [8, 4],
        kind,
    }
    .distorted();
    halves(&mut mesh);
    mesh
}

fn halves(mesh: &mut Mesh) {
    // Cells are numbered row by row: halves by columns, whatever the distortion.
    let per_row = mesh.cells.len() / 4;
    let all: Vec<usize> = (0..mesh.cells.len()).collect();
    let (left, right): (Vec<usize>, Vec<usize>) =
        all.iter().partition(|&c| c % per_row < per_row / 2);
    let interface = mesh.shared_edges(&left, &right);
    mesh.surfaces.insert("left half".to_owned(), left);
    mesh.surfaces.insert("right half".to_owned(), right);
    mesh.curves.insert("interface".to_owned(), interface);
    name_curve(mesh, "left", |x| x[0] < 1e-9);
    name_curve(mesh, "right", |x| x[0] > 2.0 - 1e-9);
    name_curve(mesh, "bottom", |x| x[1] < 1e-9);
    name_curve(mesh, "top", |x| x[1] > 1.0 - 1e-9);
    let corner = nearest(&mesh.nodes, [0.0, 0.0]);
    mesh.points.insert("corner".to_owned(), vec![corner]);
}

fn press(boundary: &mut Boundary, model: &Model, group: &str, load: EdgeLoad) {
    boundary
        .add_traction(model, group, load)
        .expect("a loaded side");
}

fn clamped(model: &Model) -> Boundary {
    let mut boundary = Boundary::new(model);
    boundary
        .displace(model, "left", [Some(0.0); 2])
        .expect("a side");
    boundary
}

const TRACTION: EdgeLoad = EdgeLoad::Traction([2e6, -3e6]);
const PRESSURE: EdgeLoad = EdgeLoad::Pressure(5e6);

#[test]
fn straight_edges_of_elements() {
    for kind in CellKind::ALL {
        let model = finite_elements(bar(kind), steel(), PlaneState::Stress);
        let h = model.settings.thickness;
        let mut traction = clamped(&model);
        press(&mut traction, &model, "right", TRACTION);
        // On 1 m at x = 2 m, y = 0.5 m on average.
        let expected = [2e6 * h, -3e6 * h, (2.0 * -3e6 - 0.5 * 2e6) * h];
        assert_close(
            applied(&model, &traction),
            expected,
            size(&traction),
            "traction",
        );
        assert_balance(&model, &traction, "traction");
        let mut pressure = clamped(&model);
        press(&mut pressure, &model, "top", PRESSURE);
        let expected = [0.0, -2.0 * 5e6 * h, -2.0 * 5e6 * h];
        assert_close(
            applied(&model, &pressure),
            expected,
            size(&pressure),
            "pressure",
        );
        assert_balance(&model, &pressure, "pressure");
    }
}

fn all_points() -> Model {
    let mesh = bar(CellKind::Quad4);
    let method = Method::Peridynamics(paper_lattice(0.1, Placement::CellCentred));
    let body = region(&mesh, &["left half", "right half"], steel(), method);
    build(mesh, vec![body], PlaneState::Stress)
}

fn hybrid(kind: CellKind) -> Model {
    let mut mesh = Grid {
        size: [2.0, 1.0],
        count: [8, 4],
        kind,
    }
    .plain();
    halves(&mut mesh);
    let method = Method::Peridynamics(paper_lattice(0.1, Placement::CellCentred));
    let regions = vec![
        region(&mesh, &["left half"], steel(), Method::FiniteElements),
        region(&mesh, &["right half"], steel(), method),
    ];
    build(mesh, regions, PlaneState::Stress)
}

#[test]
fn layers_of_material_points() {
    for (model, what) in [
        (all_points(), "points"),
        (hybrid(CellKind::Quad8), "hybrid"),
    ] {
        let h = model.settings.thickness;
        let mut traction = clamped(&model);
        press(&mut traction, &model, "right", TRACTION);
        // The last column of points is dx/2 inside: x = 1.95 m.
        let expected = [2e6 * h, -3e6 * h, (1.95 * -3e6 - 0.5 * 2e6) * h];
        assert_close(applied(&model, &traction), expected, size(&traction), what);
        assert_balance(&model, &traction, what);
        let mut pressure = clamped(&model);
        press(&mut pressure, &model, "top", PRESSURE);
        assert_balance(&model, &pressure, what);
        let [x, y, _] = applied(&model, &pressure);
        assert_close(
            [x, y, 0.0],
            [0.0, -2.0 * 5e6 * h, 0.0],
            size(&pressure),
            what,
        );
    }
}

/// A ring 0.5 m … 1 m around (3, 1), `around` × `across` quadrilaterals, curved when quadratic.
fn ring(kind: CellKind, around: usize, across: usize) -> Mesh {
    let mut mesh = Grid {
        size: [2.0 * PI, 0.5],
        count: [around, across],
        kind,
    }
    .plain();
    // The last column of nodes is the first one.
    let turn = 2.0 * PI;
    let flat = mesh.nodes.clone();
    let same = |n: usize| {
        if (flat[n][0] - turn).abs() < 1e-9 {
            nearest(&flat, [0.0, flat[n][1]])
        } else {
            n
        }
    };
    let onto = |[angle, height]: [f64; 2]| {
        let r = 1.0 - height;
        [3.0 + r * angle.cos(), 1.0 + r * angle.sin()]
    };
    mesh.cells = mesh
        .cells
        .iter()
        .map(|cell| {
            let nodes: Vec<usize> = cell.nodes().iter().map(|&n| same(n)).collect();
            Cell::new(cell.kind, &nodes)
        })
        .collect();
    mesh.nodes = flat.iter().map(|&x| onto(x)).collect();
    let radius = |x: [f64; 2]| (x[0] - 3.0).hypot(x[1] - 1.0);
    name_curve(&mut mesh, "hole", |x| radius(x) < 0.5 + 1e-9);
    name_curve(&mut mesh, "rim", |x| radius(x) > 1.0 - 1e-9);
    name_curve(&mut mesh, "arc", |x| {
        radius(x) > 1.0 - 1e-9 && x[1] > 1.0 - 1e-9
    });
    name_cells(&mut mesh, "body", |_| true);
    mesh
}

#[test]
fn pressure_in_a_hole_has_no_resultant() {
    for kind in CellKind::ALL {
        let model = finite_elements(ring(kind, 16, 3), steel(), PlaneState::Stress);
        let mut boundary = Boundary::new(&model);
        press(&mut boundary, &model, "hole", PRESSURE);
        assert_close(
            applied(&model, &boundary),
            [0.0; 3],
            size(&boundary),
            &format!("{kind:?}"),
        );
        // Outward, on the upper half: p times the hole's width.
        let upper: f64 = boundary.load.chunks(2).map(|f| f[1].max(0.0)).sum();
        let expected = 5e6 * model.settings.thickness;
        assert!((upper / expected - 1.0).abs() < 0.06, "{kind:?} {upper:e}");
    }
}

#[test]
fn pressure_on_a_layer_around_a_hole_has_no_resultant() {
    // 80 × 80 squares around the ring's box: the lattice has the ring's symmetry.
    let mesh = ring(CellKind::Quad8, 16, 3);
    let method = Method::Peridynamics(paper_lattice(0.025, Placement::CellCentred));
    let body = region(&mesh, &["body"], steel(), method);
    let model = build(mesh, vec![body], PlaneState::Stress);
    let mut boundary = Boundary::new(&model);
    press(&mut boundary, &model, "hole", PRESSURE);
    assert_close(
        applied(&model, &boundary),
        [0.0; 3],
        size(&boundary),
        "layer",
    );
    // The forces are normal and of total size p · 2πr h_t, within the chords' 1e-3.
    let normal: f64 = boundary.load.chunks(2).map(|f| f[0].hypot(f[1])).sum();
    assert!((normal / (5e6 * PI * 0.7) - 1.0).abs() < 1e-3, "{normal:e}");
}

/// 2 × 1 m with dx = 0.07 m: the last row is 0.29 dx from the top, but the last column 0.57 dx from the
/// right side, not within dx/2; it takes its load all the same.
#[test]
fn a_side_that_no_multiple_of_the_spacing_reaches() {
    let mut mesh = bar(CellKind::Quad4);
    name_curve(&mut mesh, "right and top", |x| {
        x[0] > 2.0 - 1e-9 || x[1] > 1.0 - 1e-9
    });
    let mut settings = paper_lattice(0.07, Placement::GridNodes);
    settings.lattice.origin = Some([0.0; 2]);
    let method = Method::Peridynamics(settings);
    let body = region(&mesh, &["left half", "right half"], steel(), method);
    let model = build(mesh, vec![body], PlaneState::Stress);
    let columns = model.positions.iter().filter(|x| x[1] < 1e-9).count();
    assert_eq!(model.areas.len(), columns * (model.areas.len() / columns));
    let mut boundary = Boundary::new(&model);
    press(&mut boundary, &model, "right and top", PRESSURE);
    let loaded: Vec<&[f64; 2]> = (0..model.node_count())
        .filter(|&node| boundary.load[2 * node] != 0.0 || boundary.load[2 * node + 1] != 0.0)
        .map(|node| &model.positions[node])
        .collect();
    let rows = model.areas.len() / columns;
    assert_eq!(
        loaded.len(),
        columns + rows - 1,
        "the last row and the last column"
    );
    // Forces are shared by areas, which differ from row to column: some percent.
    let [x, y, _] = applied(&model, &boundary);
    let force = -5e6 * model.settings.thickness;
    assert!(
        (x / force - 1.0).abs() < 0.1 && (y / force / 2.0 - 1.0).abs() < 0.1,
        "{x:e} {y:e}"
    );
    boundary
        .displace(&model, "left", [Some(0.0); 2])
        .expect("a side");
    assert_balance(&model, &boundary, "right and top");
}

#[test]
fn curved_edges_of_elements() {
    for kind in CellKind::ALL {
        let model = finite_elements(ring(kind, 16, 3), steel(), PlaneState::Strain);
        let h = model.settings.thickness;
        for load in [TRACTION, PRESSURE] {
            let mut boundary = Boundary::new(&model);
            boundary
                .displace(&model, "hole", [Some(0.0); 2])
                .expect("the hole");
            press(&mut boundary, &model, "arc", load);
            assert_balance(&model, &boundary, &format!("{kind:?} {load:?}"));
            if load == PRESSURE {
                // Of any arc between (4, 1) and (2, 1): p times its chord of 2 m, about x = 3 m.
                let expected = [0.0, -2.0 * 5e6 * h, 3.0 * -2.0 * 5e6 * h];
                assert_close(
                    applied(&model, &boundary),
                    expected,
                    size(&boundary),
                    "chord",
                );
            }
        }
    }
}

#[test]
fn two_values_for_one_dof_are_a_conflict() {
    let model = finite_elements(bar(CellKind::Quad8), steel(), PlaneState::Stress);
    let mut boundary = clamped(&model);
    boundary
        .displace(&model, "bottom", [None, Some(0.0)])
        .expect("the same value twice is none");
    let error = boundary.displace(&model, "corner", [Some(1e-3), None]);
    let Err(BoundaryError::Conflict {
        group,
        other,
        axis,
        x,
        y,
        value,
        other_value,
    }) = error
    else {
        panic!("{error:?}");
    };
    assert_eq!(
        (group.as_str(), other.as_str(), axis),
        ("corner", "left", 'x')
    );
    assert_eq!([x, y, value, other_value], [0.0, 0.0, 1e-3, 0.0]);
}

#[test]
fn an_interface_carries_no_load() {
    for kind in [CellKind::Quad4, CellKind::Quad8] {
        let model = hybrid(kind);
        let mut boundary = Boundary::new(&model);
        for load in [TRACTION, PRESSURE] {
            let error = boundary.add_traction(&model, "interface", load);
            assert!(
                matches!(&error, Err(BoundaryError::NoOutline { group }) if group == "interface"),
                "{error:?}"
            );
        }
        assert!(boundary.load.iter().all(|&f| f == 0.0));
        let error = boundary.add_traction(&model, "corner", TRACTION);
        assert!(
            matches!(error, Err(BoundaryError::LoadOnPoint { .. })),
            "{error:?}"
        );
    }
}
