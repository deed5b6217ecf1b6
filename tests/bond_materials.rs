//! Peridynamic regions that touch: one lattice, bonds across, and what a bond between two materials is.

mod common;

use common::*;
use peristitch::boundary::Boundary;
use peristitch::material::{Material, PlaneState};
use peristitch::mesh::{CellKind, Mesh};
use peristitch::model::{Method, Model, PeridynamicSettings};
use peristitch::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use peristitch::peridynamics::surface::SurfaceCorrection;

const DX: f64 = 2.5e-3;

/// A bar of 200 × 50 mm in two halves.
fn bar() -> Mesh {
    let grid = Grid {
        size: [0.2, 0.05],
        count: [8, 2],
        kind: CellKind::Quad4,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "left", |[x, _]| x < 0.1);
    name_cells(&mut mesh, "right", |[x, _]| x > 0.1);
    name_curve(&mut mesh, "held", |[x, _]| x < 1e-9);
    name_curve(&mut mesh, "pulled", |[x, _]| x > 0.2 - 1e-9);
    mesh
}

fn settings() -> PeridynamicSettings {
    PeridynamicSettings {
        lattice: LatticeSettings::upright(DX, Placement::CellCentred, CellArea::Clipped),
        isotropised: true,
        surface_correction: SurfaceCorrection::LeastSquares,
        ..paper_lattice(DX, Placement::CellCentred)
    }
}

fn two(young: [f64; 2]) -> Model {
    let mesh = bar();
    let method = Method::Peridynamics(settings());
    let half = |name: &str, young: f64| {
        let material = Material { young, ..steel() };
        region(&mesh, &[name], material, method)
    };
    let regions = vec![half("left", young[0]), half("right", young[1])];
    build(mesh, regions, PlaneState::Stress)
}

#[test]
fn two_regions_of_one_material_are_one_region() {
    let two = two([steel().young; 2]);
    let mesh = bar();
    let method = Method::Peridynamics(settings());
    let both = region(&mesh, &["left", "right"], steel(), method);
    let one = build(mesh, vec![both], PlaneState::Stress);
    assert_eq!(two.positions, one.positions);
    assert_eq!(two.areas, one.areas);
    assert_eq!(two.interactions, one.interactions);
    assert_eq!(two.points.len(), 1);
    for (node, [x, _]) in two.positions.iter().enumerate() {
        assert_eq!(two.region_of_point(node), Some(usize::from(*x > 0.1)));
    }
}

/// k of each bond is that of the uniform bar times E_i, or the harmonic mean of both across the joint.
#[test]
fn a_bond_between_two_materials_has_the_harmonic_mean() {
    let (soft, stiff) = (steel().young, 5.0 * steel().young);
    let (uniform, mixed) = (two([soft; 2]), two([soft, stiff]));
    let mut across = 0;
    for bond in mixed.interactions.bonds() {
        let [a, b] = mixed.interactions.segment(bond, &mixed.positions);
        let factor = match [a[0] > 0.1, b[0] > 0.1] {
            [false, false] => 1.0,
            [true, true] => 5.0,
            _ => {
                across += 1;
                2.0 * 5.0 / 6.0
            }
        };
        let found = mixed.interactions.stiffness[bond];
        let expected = factor * uniform.interactions.stiffness[bond];
        // A product and a quotient.
        assert!((found - expected).abs() <= 1e-15 * expected, "bond {bond}");
    }
    assert!(across > 100, "{across}");
}

/// Two bars in a row: u = σ (L/2) (1/E_1 + 1/E_2) between the outermost rows, which are half a spacing
/// inside.
#[test]
fn two_bars_in_a_row_stretch_as_two_springs() {
    let young = [steel().young, 3.0 * steel().young];
    let model = two(young);
    let mut boundary = Boundary::new(&model);
    let (held, pulled) = ([Some(0.0), None], [Some(1e-5), None]);
    boundary.displace(&model, "held", held).expect("a support");
    boundary.displace(&model, "pulled", pulled).expect("a grip");
    let corner = nearest(&model.positions, [0.0, 0.0]);
    boundary
        .prescribed
        .insert(2 * corner + 1, (0.0, "corner".to_owned()));
    let solution = peristitch::statics::solve(&model, &boundary);
    let reactions =
        peristitch::statics::group_reactions(&boundary, &solution.expect("held").reaction);
    let force = reactions["pulled"][0];
    let compliance: f64 = young.iter().map(|e| (0.1 - 0.5 * DX) / (e * 0.05)).sum();
    let error = force * compliance / (model.settings.thickness * 1e-5) - 1.0;
    // Ends held by one row are soft in a skin of δ, half a spacing or so each, of 160 between them; the mean
    // across the joint is taken bond by bond. 0.5 % here.
    assert!(error.abs() < 0.01, "{error}");
}
