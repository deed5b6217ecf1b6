//! Stress at the material points against that of the elements: equal under a uniform stress, whatever
//! the family, and zero where all bonds are broken. With the couplings that pass the patch test it is the
//! one that is applied, to rounding.

mod common;

use common::*;
use peristitch::boundary::Boundary;
use peristitch::coupling::Coupling;
use peristitch::fem::edge::EdgeLoad;
use peristitch::fields::NodalFields;
use peristitch::fields::points::PointFields;
use peristitch::material::PlaneState;
use peristitch::mesh::CellKind;
use peristitch::model::{Method, Model, ModelSettings, PeridynamicSettings};
use peristitch::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use peristitch::phases::Phases;
use peristitch::statics;

/// Uniform strain in both regions of a hybrid model; free sides, corners and an interface cut families.
#[test]
fn a_uniform_stress_is_the_same_on_both_sides_of_the_interface() {
    for (plane, spacing) in [(PlaneState::Stress, 2.5e-3), (PlaneState::Strain, 3.3e-3)] {
        let grid = Grid {
            size: [0.1, 0.1],
            count: [10, 10],
            kind: CellKind::Quad8,
        };
        let mut mesh = grid.plain();
        name_cells(&mut mesh, "elements", |[x, _]| x < 0.05);
        name_cells(&mut mesh, "points", |[x, _]| x > 0.05);
        let mut material = steel();
        material.poisson = plane.bond_based_poisson();
        let method = Method::Peridynamics(paper_lattice(spacing, Placement::CellCentred));
        let regions = vec![
            region(&mesh, &["elements"], material, Method::FiniteElements),
            region(&mesh, &["points"], material, method),
        ];
        let model = build(mesh, regions, plane);
        let (xx, yy, xy) = (3e-4, -1e-4, 2e-4);
        let u: Vec<[f64; 2]> = (model.positions.iter())
            .map(|[x, y]| [xx * x + xy * y, xy * x + yy * y])
            .collect();
        let elements = NodalFields::new(&model, &u);
        let points = PointFields::new(&model, &u, &model.intact);
        assert_eq!(points.stress.len(), model.areas.len());
        let expected = elements.stress[0];
        let scale = expected.iter().fold(0.0f64, |a, s| a.max(s.abs()));
        for stress in elements.stress.iter().chain(&points.stress) {
            for (found, expected) in stress.iter().zip(expected) {
                // The inverse of a family's sum, of condition number ten or so.
                assert!((found - expected).abs() < 1e-11 * scale, "{plane:?}");
            }
        }
        for strain in &points.strain {
            for (found, expected) in [(strain[0], xx), (strain[1], yy), (strain[3], xy)] {
                assert!((found - expected).abs() < 1e-11 * xx, "{plane:?}");
            }
        }
        let broken = vec![false; model.springs.len()];
        let none = PointFields::new(&model, &u, &broken);
        assert!(none.stress.iter().flatten().all(|s| *s == 0.0));
    }
}

/// An island of 15 × 10 dx within 25 × 20 dx of elements of 2.5 dx.
fn islanded_plate(coupling: Coupling, kind: CellKind, degrees: f64) -> Model {
    let grid = Grid {
        size: [0.25, 0.2],
        count: [10, 8],
        kind,
    };
    let mut mesh = grid.plain();
    let inside = |[x, y]: [f64; 2]| (x - 0.125).abs() < 0.075 && (y - 0.1).abs() < 0.05;
    name_cells(&mut mesh, "points", inside);
    name_cells(&mut mesh, "elements", |x| !inside(x));
    name_curve(&mut mesh, "left", |[x, _]| x < 1e-9);
    name_curve(&mut mesh, "right", |[x, _]| x > 0.25 - 1e-9);
    name_curve(&mut mesh, "bottom", |[_, y]| y < 1e-9);
    let settings = PeridynamicSettings {
        lattice: LatticeSettings {
            angle: degrees.to_radians(),
            ..LatticeSettings::upright(0.01, Placement::CellCentred, CellArea::Clipped)
        },
        isotropised: true,
        ..paper_lattice(0.01, Placement::CellCentred)
    };
    let method = Method::Peridynamics(settings);
    let regions = vec![
        region(&mesh, &["elements"], steel(), Method::FiniteElements),
        region(&mesh, &["points"], steel(), method),
    ];
    let settings = ModelSettings {
        plane: PlaneState::Stress,
        thickness: 0.7,
        coupling,
    };
    Model::build(mesh, regions, settings).expect("a sound model")
}

/// A plate on rollers, pulled at its right side. Solved for, σ is the traction at every point and at every node
/// on both sides of the interface, beside its corners too.
#[test]
fn what_is_pulled_uniformly_has_one_stress() {
    const TRACTION: f64 = 1.05e6;
    let coupling = Coupling::Clip;
    for kind in [CellKind::Quad8, CellKind::Quad4, CellKind::Tri6] {
        for degrees in [0.0, 20.0] {
            let what = format!("{coupling:?} {kind:?} {degrees}°");
            let model = islanded_plate(coupling, kind, degrees);
            let mut boundary = Boundary::new(&model);
            for (group, u) in [("left", [Some(0.0), None]), ("bottom", [None, Some(0.0)])] {
                boundary.displace(&model, group, u).expect("a support");
            }
            let pull = EdgeLoad::Traction([TRACTION, 0.0]);
            boundary.press(&model, "right", pull).expect("a side");
            let solution = statics::solve(&model, &boundary, &mut Phases::default());
            let u = solution.expect("a solution").displacement;
            let elements = NodalFields::new(&model, &u).stress;
            let points = PointFields::new(&model, &u, &model.intact).stress;
            assert!(points.len() > 100, "{what}: {} points", points.len());
            let all = elements.iter().chain(&points);
            let error = |stress: &[f64; 4]| {
                let expected = [TRACTION, 0.0, 0.0, 0.0];
                let parts = stress.iter().zip(expected).map(|(s, e)| (s - e).abs());
                parts.fold(0.0, f64::max) / TRACTION
            };
            let largest = all.map(error).fold(0.0, f64::max);
            // Differences of displacements that are exact to rounding: up to 4e-14.
            assert!(largest < 1e-12, "{what}: {largest:.1e}");
        }
    }
}
