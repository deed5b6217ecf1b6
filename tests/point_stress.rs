//! Stress at the material points against that of the elements: equal under a uniform stress, whatever
//! the family, and zero where all bonds are broken.

mod common;

use common::*;
use peristitch::fields::NodalFields;
use peristitch::fields::points::PointFields;
use peristitch::material::PlaneState;
use peristitch::mesh::CellKind;
use peristitch::model::Method;
use peristitch::peridynamics::lattice::Placement;

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
