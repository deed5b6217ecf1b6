//! Rigid-body motions store no energy, and nothing else does: of the eigenvalues of the assembled K
//! exactly three are zero, for every kind of element, for a lattice of bonds and for the hybrid.
//!
//! Zero is relative to the largest eigenvalue: rounding leaves up to 3.3e-16, asserted
//! 2e-15; K times a rigid motion leaves up to 4.4e-16 of the largest entry of K, asserted the same. The
//! fourth is that of the softest deformation, asserted from both sides with the figure measured, so
//! that neither a spurious mode nor a lost stiffness passes.

mod common;

use common::*;
use nalgebra::DMatrix;
use peristitch::material::PlaneState;
use peristitch::mesh::CellKind;
use peristitch::model::{Method, Model};
use peristitch::peridynamics::lattice::Placement;
use peristitch::verification::rigid_modes::{dense, spectrum};

/// Some tens of entries of order one are summed, each with a rounding error of 1e-16.
const ZERO: f64 = 2e-15;

/// max|K r| over max_ij|K_ij| for the three rigid motions r with |r| ≤ 1 at every node.
fn rigid_forces(model: &Model, k: &DMatrix<f64>) -> f64 {
    let reach = model
        .positions
        .iter()
        .map(|x| x[0].hypot(x[1]))
        .fold(0.0, f64::max);
    let motions: [&dyn Fn([f64; 2]) -> [f64; 2]; 3] =
        [&|_| [1.0, 0.0], &|_| [0.0, 1.0], &|[x, y]| {
            [-y / reach, x / reach]
        }];
    let forces = motions.iter().map(|motion| {
        let r: Vec<f64> = model.positions.iter().flat_map(|&x| motion(x)).collect();
        (k * nalgebra::DVector::from_vec(r)).amax()
    });
    forces.fold(0.0, f64::max) / k.amax()
}

/// Three zeros, and the fourth within a thousandth of `fourth`.
fn assert_three_rigid_modes(model: &Model, fourth: f64, what: &str) {
    let k = dense(model);
    let forces = rigid_forces(model, &k);
    let spectrum = spectrum(&k);
    assert!(forces < ZERO, "{what}: {forces:e}");
    assert!(spectrum[2].abs() < ZERO, "{what}: {:?}", &spectrum[..4]);
    assert_between(spectrum[3], 0.999 * fourth, 1.001 * fourth, what);
}

#[test]
fn of_every_kind_of_element() {
    let measured = [
        (CellKind::Tri3, 1.731e-2),
        (CellKind::Tri6, 3.126e-3),
        (CellKind::Quad4, 2.253e-2),
        (CellKind::Quad8, 2.969e-3),
    ];
    for (kind, fourth) in measured {
        let mesh = Grid {
            size: [1.2, 0.8],
            count: [4, 3],
            kind,
        }
        .distorted();
        let model = finite_elements(mesh, steel(), PlaneState::Stress);
        assert_three_rigid_modes(&model, fourth, &format!("{kind:?}"));
    }
}

#[test]
fn of_a_single_element() {
    // The full rules leave no element a spurious mode of its own; 2 × 2 points would leave Q8 one.
    let measured = [
        (CellKind::Tri3, 0.2038),
        (CellKind::Tri6, 1.254e-2),
        (CellKind::Quad4, 0.2778),
        (CellKind::Quad8, 3.336e-2),
    ];
    for (kind, fourth) in measured {
        let mut mesh = Grid {
            size: [1.0, 1.0],
            count: [1, 1],
            kind,
        }
        .plain();
        mesh.cells.truncate(1);
        let model = finite_elements(mesh, steel(), PlaneState::Strain);
        assert_three_rigid_modes(&model, fourth, &format!("one {kind:?}"));
    }
}

#[test]
fn of_a_lattice_of_bonds() {
    let mesh = Grid {
        size: [1.2, 0.8],
        count: [3, 2],
        kind: CellKind::Quad4,
    }
    .plain();
    let mut body = finite_elements(mesh.clone(), steel(), PlaneState::Stress).regions;
    body[0].method = Method::Peridynamics(paper_lattice(0.1, Placement::CellCentred));
    let model = build(mesh, body, PlaneState::Stress);
    assert_three_rigid_modes(&model, 2.248e-2, "bonds");
}

#[test]
fn of_the_truss_hybrid() {
    for (kind, fourth) in [(CellKind::Quad4, 1.772e-3), (CellKind::Quad8, 9.367e-4)] {
        let mut mesh = Grid {
            size: [2.0, 0.8],
            count: [5, 2],
            kind,
        }
        .plain();
        name_cells(&mut mesh, "elements", |x| x[0] < 0.8);
        name_cells(&mut mesh, "points", |x| x[0] > 0.8);
        let method = Method::Peridynamics(paper_lattice(0.1, Placement::CellCentred));
        let regions = vec![
            region(&mesh, &["elements"], steel(), Method::FiniteElements),
            region(&mesh, &["points"], steel(), method),
        ];
        let model = build(mesh, regions, PlaneState::Stress);
        assert_three_rigid_modes(&model, fourth, &format!("hybrid {kind:?}"));
    }
}
