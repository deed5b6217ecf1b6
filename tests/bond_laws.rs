//! A bond law of two steps, written as a user of the library would: φ falls to one half at s_t and to nothing at
//! 2 s_t. Each control must find the same changes by updates as by factorisations, and the energies must
//! balance.

mod common;

use common::gripped_plate::*;
use peristitch::fracture::bond_laws::BondLaws;
use peristitch::fracture::control::{self, Control, Problem, Record, Resolution, Until};
use peristitch::fracture::laws::{BondLaw, StretchLimits};
use peristitch::fracture::programme::Programme;
use peristitch::fracture::response::Response;
use peristitch::fracture::state::State;
use peristitch::model::Model;
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

/// Runs to the end, or so many steps.
fn run(model: &Model, control: Control, resolution: Resolution, steps: usize) -> State {
    let programme = Programme::proportional(bottom_held(model, [0.0, 2e-7]));
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
    let model = gripped_plate(&[NOTCH]);
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
