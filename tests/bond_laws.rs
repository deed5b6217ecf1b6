//! A bond law of two steps, written as a user of the library would: φ falls to one half at s_t and to nothing at
//! 2 s_t. Each control must find the same changes by updates as by factorisations, and the energies must
//! balance.

mod common;

use common::{Grid, build, name_cells, name_curve, paper_lattice, region, steel};
use peristitch::boundary::Boundary;
use peristitch::cracks::Cracks;
use peristitch::fracture::bond_laws::BondLaws;
use peristitch::fracture::control::{self, Control, Problem, Record, Resolution, Until};
use peristitch::fracture::laws::{BondLaw, StretchLimits};
use peristitch::fracture::programme::Programme;
use peristitch::fracture::response::Response;
use peristitch::fracture::state::State;
use peristitch::material::PlaneState;
use peristitch::mesh::{CellKind, Edge};
use peristitch::model::{Method, Model, PeridynamicSettings};
use peristitch::peridynamics::lattice::Placement;
use peristitch::statics::StaticsError;
use std::sync::Arc;

const S_T: f64 = 2e-5;

/// Breaks in two steps.
#[derive(Debug)]
struct TwoSteps;

impl BondLaw for TwoSteps {
    fn limits(&self, integrity: f64) -> StretchLimits {
        StretchLimits {
            tension: if integrity == 1.0 { S_T } else { 2.0 * S_T },
            compression: f64::INFINITY,
        }
    }

    fn next(&self, integrity: f64, _: f64) -> f64 {
        if integrity == 1.0 { 0.5 } else { 0.0 }
    }

    fn of_part(&self, _: f64) -> Arc<dyn BondLaw> {
        Arc::new(TwoSteps)
    }
}

/// 100 × 100 mm, grips of finite elements below and above 40 × 24 points, cracked from the left to the
/// middle at mid-height.
fn plate() -> Model {
    let grid = Grid {
        size: [0.1, 0.1],
        count: [10, 10],
        kind: CellKind::Quad4,
    };
    let mut mesh = grid.plain();
    name_cells(&mut mesh, "grips", |[_, y]| (y - 0.05).abs() > 0.03);
    name_cells(&mut mesh, "points", |[_, y]| (y - 0.05).abs() < 0.03);
    name_curve(&mut mesh, "top", |[_, y]| y > 0.1 - 1e-9);
    name_curve(&mut mesh, "bottom", |[_, y]| y < 1e-9);
    let first = mesh.nodes.len();
    mesh.nodes.extend([[0.0, 0.05], [0.05, 0.05]]);
    let crack = Edge {
        ends: [first, first + 1],
        middle: None,
    };
    let cracks = Cracks::new(&mesh, &[crack]);
    let settings = PeridynamicSettings {
        horizon_ratio: 3.0,
        ..paper_lattice(0.0025, Placement::CellCentred)
    };
    let regions = vec![
        region(&mesh, &["grips"], steel(), Method::FiniteElements),
        region(&mesh, &["points"], steel(), Method::Peridynamics(settings)),
    ];
    build(mesh, regions, PlaneState::Stress).with_cracks(&cracks)
}

/// Runs to the end, or so many steps.
fn run(model: &Model, control: Control, resolution: Resolution, steps: usize) -> State {
    let mut boundary = Boundary::new(model);
    for (group, u) in [("bottom", 0.0), ("top", 2e-7)] {
        let grip = boundary.displace(model, group, [Some(0.0), Some(u)]);
        grip.expect("a grip");
    }
    let programme = Programme::proportional(boundary);
    let laws: Vec<Arc<dyn BondLaw>> = vec![Arc::new(TwoSteps)];
    let problem = Problem {
        model,
        programme: &programme,
        laws: &BondLaws::new(laws, vec![0; model.interactions.len()]),
        control,
        until: Until {
            steps,
            separated: true,
        },
        resolution,
    };
    let mut state = State::new(model, &programme);
    let observe = |state: &State, _: Record, _: &Response| {
        let energy = state.energy;
        let rest = energy.external - energy.elastic - energy.dissipated;
        // Rounding of the sums, against an identity that is exact for every change.
        assert!(rest.abs() <= 1e-10 * energy.external.abs(), "{energy:?}");
        Ok::<(), StaticsError>(())
    };
    let ending = control::run(&problem, &mut state, observe);
    ending.expect("no error");
    state
}

#[test]
fn a_law_of_two_steps_is_followed_by_every_control() {
    let model = plate();
    let controls = [
        (Control::EventDriven, 150),
        (Control::OnePass, 60),
        (Control::Equilibrium { most_passes: 1000 }, 60),
    ];
    for (control, steps) in controls {
        let fast = run(&model, control, Resolution::Fast, steps);
        let reference = run(&model, control, Resolution::Reference, steps);
        let of = |state: &State| -> Vec<(u32, [f64; 2])> {
            let changes = state.changes.iter();
            changes.map(|c| (c.interaction, c.integrity)).collect()
        };
        assert_eq!(of(&fast), of(&reference), "{control:?}");
        let halves = fast.integrity.iter().filter(|phi| **phi == 0.5).count();
        assert!(
            halves > 20 && fast.broken().len() > 20,
            "{control:?}: {halves}"
        );
        let steps = [[1.0, 0.5], [0.5, 0.0]];
        assert!(fast.changes.iter().all(|c| steps.contains(&c.integrity)));
        let off = (fast.load.factor / reference.load.factor - 1.0).abs();
        assert!(off < 1e-9, "{control:?}: {off:e}");
    }
}
