//! The library for its users: the example computes what it says, and a model that the pipeline would refuse is
//! refused by [`Model::build`] too.

#[allow(dead_code)]
#[path = "../examples/plate.rs"]
mod plate;

use peristitch::coupling::Coupling;
use peristitch::coupling::truss::NodeArea;
use peristitch::material::{Material, PlaneState};
use peristitch::mesh::grid::{Grid, name_cells};
use peristitch::mesh::{Cell, CellKind, Mesh};
use peristitch::model::{
    Method, Model, ModelError, ModelSettings, PeridynamicSettings, Region, SettingsError,
};
use peristitch::peridynamics::kernel::{Kernel, PartialArea};
use peristitch::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use peristitch::peridynamics::surface::SurfaceCorrection;

#[test]
fn the_plate_of_the_example_is_as_long_as_it_should_be() {
    let [elongation, exact] = plate::elongation().expect("a sound model");
    // Uniform strain passes the interface; the band's free edges, corrected by force, leave −0.05 % at half this
    // spacing (`cantilever_clip_q8_rollers`), twice as much here.
    let error = elongation / exact - 1.0;
    assert!((error + 1e-3).abs() < 5e-5, "{error}");
}

/// Mesh, regions and settings of a bar: elements on the left, points on the right.
struct Input {
    mesh: Mesh,
    regions: Vec<Region>,
    settings: ModelSettings,
}

fn lattice() -> PeridynamicSettings {
    PeridynamicSettings {
        lattice: LatticeSettings::upright(0.01, Placement::CellCentred, CellArea::Clipped),
        horizon_ratio: 3.0,
        kernel: Kernel::Quartic,
        partial_area: PartialArea::Full,
        isotropised: true,
        surface_correction: SurfaceCorrection::Force,
    }
}

fn input() -> Input {
    let grid = Grid {
        size: [0.4, 0.1],
        count: [8, 2],
        kind: CellKind::Quad4,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "elements", |[x, _]| x < 0.2);
    name_cells(&mut mesh, "points", |[x, _]| x > 0.2);
    let material = Material {
        young: 1e9,
        poisson: 1.0 / 3.0,
    };
    let region = |name: &str, method: Method| Region {
        name: name.to_owned(),
        cells: mesh.surfaces[name].clone(),
        material,
        method,
    };
    let regions = vec![
        region("elements", Method::FiniteElements),
        region("points", Method::Peridynamics(lattice())),
    ];
    Input {
        mesh,
        regions,
        settings: ModelSettings {
            plane: PlaneState::Stress,
            thickness: 1.0,
            coupling: Coupling::Clip,
        },
    }
}

/// The error of a sound input after a change.
fn error(change: impl FnOnce(&mut Input)) -> ModelError {
    let mut input = input();
    change(&mut input);
    let model = Model::build(input.mesh, input.regions, input.settings);
    model.expect_err("the change makes the model impossible")
}

/// The error of a region's settings after a change of the points' settings.
fn settings_error(change: impl FnOnce(&mut PeridynamicSettings)) -> SettingsError {
    let found = error(|input| {
        let mut settings = lattice();
        change(&mut settings);
        input.regions[1].method = Method::Peridynamics(settings);
    });
    match found {
        ModelError::Settings { region, source } => {
            assert_eq!(region, "points");
            source
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_sound_input_is_a_model() {
    let Input {
        mesh,
        regions,
        settings,
    } = input();
    assert!(Model::build(mesh, regions, settings).is_ok());
}

/// Cells carry what central forces cannot, and there are none where bonds are enough.
#[test]
fn a_lattice_has_cells_where_bonds_do_not_have_the_poissons_ratio() {
    for (plane, poisson, has_cells) in [
        (PlaneState::Stress, 0.2, true),
        (PlaneState::Stress, 0.333_333_3, false),
        (PlaneState::Strain, 0.25, false),
        (PlaneState::Strain, 1.0 / 3.0, true),
    ] {
        let mut input = input();
        input.settings.plane = plane;
        input.regions[1].material.poisson = poisson;
        let model = Model::build(input.mesh, input.regions, input.settings).expect("a sound model");
        assert_eq!(
            !model.interactions.cells().is_empty(),
            has_cells,
            "{plane:?} {poisson}"
        );
    }
}

#[test]
fn constants_of_materials_are_those_of_an_elastic_body() {
    for young in [0.0, -1e9, f64::NAN, f64::INFINITY] {
        let found = error(|input| input.regions[0].material.young = young);
        let text = found.to_string();
        assert!(
            text.contains("region `elements`: Young's modulus"),
            "{text}"
        );
    }
    for poisson in [-1.0, 0.5, 0.7, f64::NAN] {
        let found = error(|input| input.regions[0].material.poisson = poisson);
        let text = found.to_string();
        assert!(text.contains("not between -1 and 1/2"), "{text}");
    }
}

#[test]
fn lattices_have_a_spacing_and_a_horizon() {
    for spacing in [0.0, -0.01, f64::NAN, f64::INFINITY] {
        let found = settings_error(|settings| settings.lattice.spacing = spacing);
        assert!(
            matches!(found, SettingsError::SpacingNotPositive { .. }),
            "{found:?}"
        );
    }
    for ratio in [0.0, 1.9, -3.0, f64::NAN] {
        let found = settings_error(|settings| settings.horizon_ratio = ratio);
        assert!(
            matches!(found, SettingsError::HorizonTooSmall { least: 2.0, .. }),
            "{found:?}"
        );
    }
    for ratio in [20.5, f64::INFINITY] {
        let found = settings_error(|settings| settings.horizon_ratio = ratio);
        let expected = SettingsError::HorizonTooLarge { ratio, most: 20.0 };
        assert_eq!(found, expected);
    }
    let found = settings_error(|settings| settings.lattice.angle = f64::INFINITY);
    let angle = f64::INFINITY;
    assert_eq!(found, SettingsError::AngleNotFinite { angle });
    let found = settings_error(|settings| settings.lattice.origin = Some([0.0, f64::INFINITY]));
    let (x, y) = (0.0, f64::INFINITY);
    assert_eq!(found, SettingsError::OriginNotFinite { x, y });
    let found = settings_error(|settings| settings.isotropised = false);
    assert_eq!(found, SettingsError::RawMicromodulusUnderClip);
}

#[test]
fn thickness_and_node_area_are_positive() {
    for value in [0.0, -1.0, f64::NAN] {
        let found = error(|input| input.settings.thickness = value);
        assert!(
            matches!(found, ModelError::ThicknessNotPositive { .. }),
            "{found:?}"
        );
        let found = error(|input| {
            input.settings.coupling = Coupling::Truss(NodeArea::Given(value));
        });
        assert!(
            matches!(found, ModelError::NodeAreaNotPositive { .. }),
            "{found:?}"
        );
    }
}

#[test]
fn every_cell_belongs_to_one_region_at_most() {
    let found = error(|input| input.regions.clear());
    assert!(matches!(found, ModelError::NoRegion), "{found:?}");
    let found = error(|input| input.regions[1].cells.clear());
    assert!(
        matches!(&found, ModelError::RegionEmpty { region } if region == "points"),
        "{found:?}"
    );
    let found = error(|input| {
        let shared = input.regions[0].cells[0];
        input.regions[1].cells.push(shared);
    });
    assert!(
        matches!(&found, ModelError::RegionsOverlap { first, second, cells: 1 }
            if first == "elements" && second == "points"),
        "{found:?}"
    );
    let found = error(|input| {
        let again = input.regions[0].cells[2];
        input.regions[0].cells.push(again);
    });
    assert!(
        matches!(&found, ModelError::CellTwice { region, .. } if region == "elements"),
        "{found:?}"
    );
    let found = error(|input| input.regions[0].cells.push(1000));
    assert!(
        matches!(
            found,
            ModelError::CellMissing {
                cell: 1000,
                cells: 16,
                ..
            }
        ),
        "{found:?}"
    );
}

#[test]
fn meshes_have_places_for_all_nodes() {
    let found = error(|input| input.mesh.nodes[5][1] = f64::NAN);
    assert!(
        matches!(found, ModelError::NodeNotFinite { node: 5, .. }),
        "{found:?}"
    );
    let found = error(|input| {
        input.mesh.cells[3] = Cell::new(CellKind::Quad4, &[0, 1, 2, 999]);
    });
    assert!(
        matches!(
            found,
            ModelError::NodeMissing {
                cell: 3,
                node: 999,
                ..
            }
        ),
        "{found:?}"
    );
}
