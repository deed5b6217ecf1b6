//! Lattices of bonds and cells: any Poisson's ratio (docs/method.md, section 1).

mod common;

use common::gripped_plate::*;
use common::*;
use peristitch::boundary::Boundary;
use peristitch::coupling::Coupling;
use peristitch::coupling::truss::NodeArea;
use peristitch::fem::edge::EdgeLoad;
use peristitch::fields::points::PointFields;
use peristitch::fracture::bond_laws::BondLaws;
use peristitch::fracture::control::{self, Control, Problem, Record, Resolution, Until};
use peristitch::fracture::programme::{LoadPhase, Programme};
use peristitch::fracture::response::Response;
use peristitch::fracture::state::State;
use peristitch::material::{Material, PlaneState};
use peristitch::mesh::CellKind;
use peristitch::model::{Method, Model, ModelSettings, PeridynamicSettings, Region};
use peristitch::peridynamics::kernel::Kernel;
use peristitch::peridynamics::lattice::{CellArea, LatticeSettings, Placement};
use peristitch::peridynamics::surface::SurfaceCorrection;
use peristitch::statics::StaticsError;
use peristitch::verification::any_poisson::energy_error;

const PLANES: [PlaneState; 2] = [PlaneState::Stress, PlaneState::Strain];
const RATIOS: [f64; 7] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.45, 0.49];

fn lattice(dx: f64, angle: f64) -> PeridynamicSettings {
    PeridynamicSettings {
        lattice: LatticeSettings {
            angle,
            ..LatticeSettings::upright(dx, Placement::CellCentred, CellArea::Clipped)
        },
        isotropised: true,
        ..paper_lattice(dx, Placement::CellCentred)
    }
}

fn build_with(
    mesh: peristitch::mesh::Mesh,
    regions: Vec<Region>,
    plane: PlaneState,
    coupling: Coupling,
) -> Model {
    let settings = ModelSettings {
        plane,
        thickness: 0.7,
        coupling,
    };
    Model::build(mesh, regions, settings).expect("a sound model")
}

/// A square of `count` × `count` points of one material, dx = 1.
fn square(
    count: usize,
    settings: PeridynamicSettings,
    material: Material,
    plane: PlaneState,
) -> Model {
    let side = count as f64;
    let grid = Grid {
        size: [side, side],
        count: [1, 1],
        kind: CellKind::Quad4,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "body", |_| true);
    let regions = vec![region(
        &mesh,
        &["body"],
        material,
        Method::Peridynamics(settings),
    )];
    build_with(mesh, regions, plane, Coupling::Clip)
}

#[test]
fn moduli_of_the_lattice_are_those_of_the_material() {
    let mut largest: f64 = 0.0;
    for kernel in Kernel::ALL {
        for m in [3.0, 4.0, 5.0, 6.0] {
            for plane in PLANES {
                for poisson in RATIOS {
                    let young = 3.0;
                    let material = Material { young, poisson };
                    let settings = PeridynamicSettings {
                        kernel,
                        horizon_ratio: m,
                        ..lattice(1.0, 0.0)
                    };
                    let error = energy_error(settings, material, plane);
                    largest = largest.max(error.expect("a sound model"));
                }
            }
        }
    }
    // Sums of some hundred terms.
    assert!(largest < 1e-12, "{largest:e}");
}

/// A lattice under a uniform strain has it and the stress D(ν) ε at its points, at any angle.
#[test]
fn strain_and_stress_at_points_are_those_of_the_material() {
    for plane in PLANES {
        for poisson in [0.0, 0.2, 0.4] {
            let material = Material {
                young: 3.0,
                poisson,
            };
            let model = square(24, lattice(1.0, 0.3), material, plane);
            let [xx, yy, xy] = [1e-3, -2e-3, 0.4e-3];
            let u: Vec<[f64; 2]> = model
                .positions
                .iter()
                .map(|[x, y]| [xx * x + xy * y, xy * x + yy * y])
                .collect();
            let fields = PointFields::new(&model, &u, &model.integrity);
            let stress = material.elasticity(plane) * nalgebra::Vector3::new(xx, yy, 2.0 * xy);
            // A uniform strain that is prescribed beside a side is not a uniform stress there.
            let all = model.positions.iter().zip(&fields.stress);
            let inner: Vec<_> = all
                .filter(|(x, _)| x.iter().all(|x| (x - 12.0).abs() < 3.5))
                .collect();
            assert!(inner.len() > 40);
            for (_, found) in inner {
                for (found, exact) in [found[0], found[1], found[3]]
                    .into_iter()
                    .zip(stress.iter())
                {
                    assert!(
                        (found - exact).abs() < 1e-13,
                        "{plane:?} {poisson}: {found} {exact}"
                    );
                }
            }
        }
    }
}

/// A bar in tension between elements, its sides free: 16 | 24 | 16 dx long and 20 dx high. u of the end is σL/E₂; the cells
/// that own what lies beyond the last rows make it as good as bonds alone are (0.42 % there).
#[test]
fn a_bar_with_free_sides_stretches_as_it_should() {
    for (plane, poisson, degrees, within) in [
        (PlaneState::Stress, 0.0, 0.0, 0.5),
        (PlaneState::Stress, 0.2, 0.0, 0.5),
        (PlaneState::Stress, 0.4, 0.0, 0.5),
        (PlaneState::Strain, 0.2, 0.0, 0.5),
        (PlaneState::Strain, 0.45, 0.0, 0.5),
        // Where the interface meets a free side it cuts squares with a corner beyond both. Free sides that cut
        // through a turned lattice leave more, with bonds alone too (0.31 % at 45° in the bar of Table 1, 0.28 %
        // with cells).
        (PlaneState::Stress, 0.2, 20.0, 1.0),
        (PlaneState::Stress, 0.2, 45.0, 1.5),
        (PlaneState::Stress, 0.4, 67.5, 1.5),
    ] {
        let material = Material {
            young: 30e9,
            poisson,
        };
        let grid = Grid {
            size: [56.0, 20.0],
            count: [14, 5],
            kind: CellKind::Quad8,
        };
        let mut mesh = grid.plain();
        let is_middle = |x: f64| (x - 28.0).abs() < 12.0;
        name_cells(&mut mesh, "points", |[x, _]| is_middle(x));
        name_cells(&mut mesh, "ends", |[x, _]| !is_middle(x));
        name_curve(&mut mesh, "left", |[x, _]| x < 1e-9);
        name_curve(&mut mesh, "right", |[x, _]| x > 56.0 - 1e-9);
        let settings = PeridynamicSettings {
            surface_correction: SurfaceCorrection::Force,
            ..lattice(1.0, f64::to_radians(degrees))
        };
        let regions = vec![
            region(&mesh, &["ends"], material, Method::FiniteElements),
            region(&mesh, &["points"], material, Method::Peridynamics(settings)),
        ];
        let model = build_with(mesh, regions, plane, Coupling::Clip);
        let mut boundary = Boundary::new(&model);
        boundary
            .displace(&model, "left", [Some(0.0), None])
            .expect("a side");
        boundary
            .add_traction(&model, "right", EdgeLoad::Traction([1e6, 0.0]))
            .expect("a side");
        let corner = nearest(&model.positions, [0.0, 0.0]);
        boundary
            .prescribed
            .insert(2 * corner + 1, (0.0, "corner".to_owned()));
        let u = displacements(&model, &boundary);
        let modulus = match plane {
            PlaneState::Stress => material.young,
            PlaneState::Strain => material.young / (1.0 - poisson * poisson),
        };
        let end = u[nearest(&model.positions, [56.0, 10.0])][0];
        let error = 100.0 * (end / (1e6 * 56.0 / modulus) - 1.0);
        println!("{plane:?} {poisson} {degrees}°: {error:+.3} %");
        // The prototype of the formulation: −0.10 to −0.38 %, and +0.05 % at 0.45.
        assert!(
            error.abs() < within,
            "{plane:?} {poisson} {degrees}°: {error:+.3} %"
        );
    }
}

/// The plate between two grips with another Poisson's ratio, and a crack from the left.
fn plate(poisson: f64, coupling: Coupling) -> (Model, BondLaws) {
    let settings = PeridynamicSettings {
        horizon_ratio: 3.0,
        ..lattice(DX, 0.0)
    };
    let crack = [[-1e-3, 0.05], [0.03, 0.05]];
    let (mesh, mut regions, cracks) = parts_of_the_plate(&[crack], settings);
    regions
        .iter_mut()
        .for_each(|region| region.material.poisson = poisson);
    let model = build_with(mesh, regions, PlaneState::Stress, coupling).with_cracks(&cracks);
    let laws = brittle_bonds(&model);
    (model, laws)
}

struct Course {
    state: State,
    /// Load factor and energies of each step.
    steps: Vec<[f64; 4]>,
}

fn run((model, laws): &(Model, BondLaws), control: Control, resolution: Resolution) -> Course {
    let boundary = bottom_held(model, [0.0, 1e-8]);
    let phase = LoadPhase {
        name: "tension".to_owned(),
        boundary,
        increment: 30.0,
        end: None,
    };
    let programme = Programme::new(vec![phase]);
    let problem = Problem {
        model,
        programme: &programme,
        laws,
        control,
        until: Until {
            steps: 120,
            separated: true,
        },
        resolution,
    };
    let mut state = State::new(model, &programme);
    let mut steps = Vec::new();
    let observe = |state: &State, _: Record, _: &Response| {
        let energy = state.energy;
        steps.push([
            state.load.factor,
            energy.external,
            energy.elastic,
            energy.dissipated,
        ]);
        Ok::<(), StaticsError>(())
    };
    control::run(&problem, &mut state, observe).expect("no error");
    Course { state, steps }
}

/// A bond takes its cells along in one event: the same by updates, look ahead and factorisations; the energies
/// balance, and no cell outlives one of its bonds.
#[test]
fn cells_break_with_their_bonds() {
    let truss = Coupling::Truss(NodeArea::HalfEdge);
    for (poisson, coupling) in [(0.2, Coupling::Clip), (0.4, Coupling::Clip), (0.2, truss)] {
        let plate = plate(poisson, coupling);
        let model = &plate.0;
        let cells = model.interactions.cells();
        let severed = cells.clone().filter(|&s| model.integrity[s] == 0.0).count();
        assert!(
            severed >= 11 && severed < cells.len() / 4,
            "the crack severs cells: {severed}"
        );
        for control in [
            Control::EventDriven,
            Control::Equilibrium { most_passes: 500 },
        ] {
            let what = format!("{poisson} {coupling:?} {control:?}");
            let [fast, reference] = [Resolution::Fast, Resolution::Reference]
                .map(|resolution| run(&plate, control, resolution));
            assert!(
                fast.state.broken().len() > 100,
                "{what}: {}",
                fast.state.broken().len()
            );
            assert_eq!(
                fast.state.changes.len(),
                reference.state.changes.len(),
                "{what}"
            );
            assert_eq!(fast.state.broken(), reference.state.broken(), "{what}");
            for (own, other) in fast.steps.iter().zip(&reference.steps) {
                // Updates of a factor leave some 1e-13.
                assert!(
                    (own[0] - other[0]).abs() <= 1e-9 * other[0].abs(),
                    "{what}: {own:?} {other:?}"
                );
            }
            let [_, external, elastic, dissipated] = fast.steps[fast.steps.len() - 1];
            assert!(
                (external - elastic - dissipated).abs() <= 1e-9 * external,
                "{what}: {external} {elastic} {dissipated}"
            );
            let gone = |s: usize| fast.state.integrity[s] == 0.0;
            for s in model.interactions.axial().filter(|&s| gone(s)) {
                let mut companions = model.companions.of(s).iter();
                assert!(companions.all(|&cell| gone(cell as usize)), "{what}: {s}");
            }
            let lost = cells.clone().filter(|&s| gone(s)).count() - severed;
            let changes = fast.state.changes.len() - fast.state.broken().len();
            assert_eq!(lost, changes, "{what}: the changes hold every cell once");
            println!(
                "{what}: {} bonds, {lost} functionals",
                fast.state.broken().len()
            );
            let mut restored = fast.state.clone();
            restored.restore_integrity(model);
            assert_eq!(restored, fast.state, "{what}");
        }
    }
}

/// Two materials on one lattice: each corner of a cell brings its own.
#[test]
fn cells_between_two_materials_have_the_mean_of_both() {
    let grid = Grid {
        size: [12.0, 6.0],
        count: [2, 1],
        kind: CellKind::Quad4,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "left", |[x, _]| x < 6.0);
    name_cells(&mut mesh, "right", |[x, _]| x > 6.0);
    let [stiff, soft] =
        [(30e9, 0.2), (10e9, 1.0 / 3.0)].map(|(young, poisson)| Material { young, poisson });
    let settings = PeridynamicSettings {
        horizon_ratio: 3.0,
        ..lattice(1.0, 0.0)
    };
    let regions = vec![
        region(&mesh, &["left"], stiff, Method::Peridynamics(settings)),
        region(&mesh, &["right"], soft, Method::Peridynamics(settings)),
    ];
    let model = build_with(mesh, regions, PlaneState::Stress, Coupling::Clip);
    let sum = |from: f64, to: f64| -> f64 {
        let middle = |s: usize| {
            let nodes = model.interactions.nodes(s);
            nodes
                .iter()
                .map(|&n| model.positions[n as usize][0])
                .sum::<f64>()
                / nodes.len() as f64
        };
        let cells = model
            .interactions
            .cells()
            .filter(|&s| (from..to).contains(&middle(s)));
        cells.map(|s| model.interactions.stiffness[s]).sum()
    };
    // Two functionals of k = μ_D A h_t/dx² each; the corner columns are 1.5 dx wide.
    let whole = 2.0 * 0.7 * stiff.on_lattice(PlaneState::Stress).deviator;
    for (from, to, area) in [(0.0, 5.4, 33.0), (5.6, 6.4, 3.0), (6.6, 12.0, 0.0)] {
        let found = sum(from, to) / whole;
        assert!((found - area).abs() < 1e-12, "{from}: {found} {area}");
    }
}
