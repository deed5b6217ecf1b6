//! Programmes of several phases: what is held stays, and the event-driven control finds the next bond
//! on top of it. Compared with the same load in one phase, with brute force over all bonds, and with
//! the balance of energy.

mod common;

use common::gripped_plate::*;
use common::nearest;
use peristitch::boundary::Boundary;
use peristitch::fem::edge::EdgeLoad;
use peristitch::fracture::bond_laws::BondLaws;
use peristitch::fracture::control::{self, Control, Ending, Problem, Record, Resolution, Until};
use peristitch::fracture::functional::Functional;
use peristitch::fracture::programme::{LoadPhase, Programme};
use peristitch::fracture::response::Response;
use peristitch::fracture::state::State;
use peristitch::model::Model;
use peristitch::statics::StaticsError;
use std::sync::Arc;

/// Prescribed on either grip per unit of a load factor [m].
const STEP: f64 = 5e-8;

const EVENTS: Control = Control::EventDriven;

fn plate() -> (Model, BondLaws) {
    let model = gripped_plate(&[NOTCH]);
    let laws = brittle_bonds(&model);
    (model, laws)
}

/// The bottom held, the top shifted and pulled by a traction [Pa].
fn pulled(model: &Model, shift: f64, traction: f64) -> Boundary {
    let mut boundary = Boundary::new(model);
    let bottom = boundary.displace(model, "bottom", [Some(0.0); 2]);
    bottom.expect("a grip");
    let top = boundary.displace(model, "top", [Some(shift), None]);
    top.expect("a grip");
    let load = EdgeLoad::Traction([0.0, traction]);
    boundary.add_traction(model, "top", load).expect("a load");
    boundary
}

fn phase(name: &str, boundary: Boundary, end: Option<f64>) -> LoadPhase {
    LoadPhase {
        name: name.to_owned(),
        boundary,
        increment: 1.0,
        end,
    }
}

struct Step {
    state: State,
    record: Record,
    /// The largest stretch over its limit among the bonds that were intact before this step's breaks.
    utilisation: f64,
}

fn run(
    model: &Model,
    laws: &BondLaws,
    programme: &Programme,
    control: Control,
    steps: usize,
) -> (Ending, Vec<Step>) {
    let problem = Problem {
        model,
        programme,
        laws,
        control,
        until: Until {
            steps,
            separated: true,
        },
        resolution: Resolution::Fast,
    };
    let mut state = State::new(model, programme);
    let mut list: Vec<Step> = Vec::new();
    let observe = |state: &State, record: Record, response: &Response| {
        let state = state.settled(&problem, response).into_owned();
        let integrity = list.last().map_or(&model.integrity, |s| &s.state.integrity);
        let before = (0..model.interactions.len()).filter(|&s| integrity[s] > 0.0);
        let utilisation = before.map(|s| laws.first_limits(s).utilisation(state.stretch(model, s)));
        let utilisation = utilisation.fold(0.0, f64::max);
        list.push(Step {
            state,
            record,
            utilisation,
        });
        Ok::<(), StaticsError>(())
    };
    let ending = control::run(&problem, &mut state, observe);
    (ending.expect("no error"), list)
}

/// External work = elastic + dissipated energy, relative to the work's largest amount so far: the
/// identity behind it is exact, and each of some hundred solves to 1e-14.
fn assert_balanced(steps: &[Step]) {
    let mut scale = 0.0f64;
    for Step { state, .. } in steps {
        let energy = state.energy;
        scale = scale.max(energy.external.abs());
        let balance = energy.external - energy.elastic - energy.dissipated;
        assert!(
            balance.abs() < 1e-10 * scale,
            "step {}: {energy:?}",
            state.step
        );
    }
}

/// On the event-driven path no bond is over its limit, and one is at it whenever bonds break.
fn assert_admissible(steps: &[Step]) {
    for Step {
        state,
        record,
        utilisation,
    } in steps
    {
        // A bond that ties is at most a thousandth beyond; otherwise solves to 1e-14.
        assert!(
            *utilisation < 1.0 + 1e-9,
            "step {}: {utilisation}",
            state.step
        );
        assert!(
            record.broken == 0 || (utilisation - 1.0).abs() < 1e-9,
            "step {}: {utilisation}",
            state.step
        );
    }
}

/// A load cut in two phases breaks the same bonds at the same loads as in one: in the second, λ counts
/// from where the first ended.
#[test]
fn two_phases_of_the_same_load_are_one() {
    let (model, laws) = plate();
    let load = || bottom_held(&model, [0.0, 2.0 * STEP]);
    let whole = Programme::proportional(load());
    let (one_ending, one) = run(&model, &laws, &whole, EVENTS, 10_000);
    let onset = one[0].state.load.factor;
    let cut = 0.4 * onset;
    let halves = Programme::new(vec![
        phase("first", load(), Some(cut)),
        phase("second", load(), None),
    ]);
    let (_, two) = run(&model, &laws, &halves, EVENTS, 10_000);
    assert_eq!(one_ending, Ending::Separated);
    let Step { state, record, .. } = &two[0];
    assert_eq!((state.load.factor, record.broken), (cut, 0));
    // The separation is told by the force of the phase itself, so that the ends may differ.
    let common = one.len().min(two.len() - 1);
    assert!(common > 100, "{common} events");
    for (one, two) in one.iter().zip(&two[1..]) {
        assert_eq!(
            one.state.integrity, two.state.integrity,
            "event {}",
            one.state.step
        );
        let sum = cut + two.state.load.factor;
        assert!(
            (one.state.load.factor - sum).abs() < 1e-9 * onset,
            "event {}",
            one.state.step
        );
        let work = one.state.energy.dissipated - two.state.energy.dissipated;
        assert!(work.abs() < 1e-9 * one.state.energy.external.abs());
    }
    assert_balanced(&two);
    assert_admissible(&two);
}

/// Up, down and up again under each control: nothing breaks on the way down, nothing heals, and the
/// way up to the old load is elastic.
#[test]
fn unloading_and_reloading_break_nothing_below_the_old_load() {
    let (model, laws) = plate();
    let load = |sign: f64| bottom_held(&model, [0.0, sign * 2.0 * STEP]);
    let whole = Programme::proportional(load(1.0));
    let onset = run(&model, &laws, &whole, EVENTS, 1).1[0].state.load.factor;
    let top = (1.3 * onset).ceil();
    let cycle = Programme::new(vec![
        phase("up", load(1.0), Some(top)),
        phase("down", load(-1.0), Some(top)),
        phase("again", load(1.0), Some(top + 4.0)),
    ]);
    let control = Control::Equilibrium { most_passes: 1000 };
    let (ending, steps) = run(&model, &laws, &cycle, control, 1000);
    assert!(matches!(ending, Ending::LoadLimit | Ending::Separated));
    let of_phase = |p: usize| steps.iter().filter(move |step| step.state.phase == p);
    let broken = |p: usize| of_phase(p).map(|step| step.record.broken).sum::<usize>();
    assert!(broken(0) > 0);
    assert_eq!(of_phase(1).count(), top as usize);
    assert_eq!(broken(1), 0, "on the way down");
    let down = of_phase(1).next_back().expect("a step");
    // Back at the start: nothing is stored, and the displacement is that of the intact body, zero.
    assert!(down.state.energy.elastic.abs() < 1e-12 * down.state.energy.external);
    let largest = down.state.displacement.iter().flatten();
    let largest = largest.fold(0.0f64, |a, u| a.max(u.abs()));
    assert!(largest < 1e-12 * top * STEP, "{largest:e}");
    let again = |step: &&Step| step.record.broken > 0;
    let first = of_phase(2).find(again).map(|step| step.state.load.factor);
    assert!(first.is_none_or(|factor| factor > top), "{first:?}");
    assert_balanced(&steps);
}

/// Shear under a constant pull: each break leaves less to carry the pull, until no shear helps. Then all
/// loads recede together, and come back when the body can carry them.
#[test]
fn what_is_held_recedes_where_it_cannot_be_carried() {
    let (model, laws) = plate();
    let pull = pulled(&model, 0.0, 1e3);
    let alone = Programme::proportional(pull.clone());
    let onset = run(&model, &laws, &alone, EVENTS, 1).1[0].state.load.factor;
    let programme = Programme::new(vec![
        phase("pull", pull, Some(0.9 * onset)),
        phase("shear", pulled(&model, STEP, 0.0), None),
    ]);
    let (ending, steps) = run(&model, &laws, &programme, EVENTS, 400);
    assert!(
        matches!(ending, Ending::Separated | Ending::StepLimit),
        "{ending:?}"
    );
    assert_balanced(&steps);
    assert_admissible(&steps);
    let receded = steps.iter().filter(|s| s.state.load.share < 1.0).count();
    let full = steps.iter().filter(|s| s.state.load.share == 1.0).count();
    assert!(receded > 0 && full > 1, "{receded} receded, {full} in full");
}

/// Under a dead load the body is separated when the loaded part hangs on nothing; off the middle it hangs
/// on a hinge before, and swings.
#[test]
fn under_a_dead_load_the_loaded_part_comes_off_or_swings() {
    let (model, laws) = plate();
    let programme = Programme::proportional(pulled(&model, 0.0, 2e4));
    for control in [
        Control::OnePass,
        Control::Equilibrium { most_passes: 1000 },
        EVENTS,
    ] {
        let (ending, steps) = run(&model, &laws, &programme, control, 10_000);
        let last = &steps.last().expect("a step").state;
        // On the last bonds but one K is so close to singular that no solution may be left.
        let expected: &[Ending] = if last.load_lost {
            &[Ending::Separated]
        } else {
            &[Ending::Collapsed, Ending::Singular]
        };
        assert!(expected.contains(&ending), "{control:?}: {ending:?}");
        assert!(last.broken().len() > 100, "{control:?}");
        assert_balanced(&steps);
    }
    let is_above = |node: u32| model.positions[node as usize][1] > 0.05;
    let mut state = State::new(&model, &programme);
    for (interaction, ends) in model.interactions.pairs().iter().enumerate() {
        if is_above(ends[0]) != is_above(ends[1]) {
            Arc::make_mut(&mut state.integrity)[interaction] = 0.0;
        }
    }
    let problem = Problem {
        model: &model,
        programme: &programme,
        laws: &laws,
        control: Control::OnePass,
        until: Until {
            steps: 3,
            separated: true,
        },
        resolution: Resolution::Fast,
    };
    state.change(&problem, None, &[0]);
    assert!(state.load_lost && state.fragments.is_empty());
}

/// The upper half hangs on bonds that meet in one point, off the middle, and is pulled.
#[test]
fn a_loaded_part_on_a_hinge_ends_the_run() {
    let (model, laws) = plate();
    let mut pull = Boundary::new(&model);
    let held = pull.displace(&model, "bottom", [Some(0.0); 2]);
    held.expect("a grip");
    let load = EdgeLoad::Traction([0.0, 1e3]);
    pull.add_traction(&model, "top", load).expect("a load");
    let programme = Programme::proportional(pull);
    let problem = Problem {
        model: &model,
        programme: &programme,
        laws: &laws,
        control: Control::OnePass,
        until: Until {
            steps: 3,
            separated: true,
        },
        resolution: Resolution::Fast,
    };
    let hinge = nearest(&model.positions, [0.08, 0.05 + 0.5 * DX]) as u32;
    let mut state = State::new(&model, &programme);
    let is_above = |node: u32| node != hinge && model.positions[node as usize][1] > 0.05;
    for (interaction, ends) in model.interactions.pairs().iter().enumerate() {
        let crosses = is_above(ends[0]) != is_above(ends[1]);
        if crosses && !ends.contains(&hinge) {
            Arc::make_mut(&mut state.integrity)[interaction] = 0.0;
        }
    }
    let observe = |_: &State, _: Record, _: &Response| Ok::<(), StaticsError>(());
    let ending = control::run(&problem, &mut state, observe);
    assert_eq!(ending.expect("no error"), Ending::Collapsed);
    assert!(!state.load_lost);
    // Resumed, it ends the same way.
    let ending = control::run(&problem, &mut state, observe);
    assert_eq!(ending.expect("no error"), Ending::Collapsed);
}

/// Increments of the opening of the crack's mouth in place of λ: the opening is what was asked for after every
/// step, whatever has broken, and a traction goes back when the crack grows, which increments of λ never do.
#[test]
fn a_probe_controls_the_load() {
    let (model, laws) = plate();
    let [below, above] = [-1.0, 1.0].map(|side| nearest(&model.positions, [0.0, 0.05 + side * DX]));
    let opening = |state: &State| state.displacement[above][1] - state.displacement[below][1];
    let boundary = pulled(&model, 0.0, 1e4);
    let by_load = Programme::proportional(boundary.clone());
    let (_, events) = run(&model, &laws, &by_load, EVENTS, 1);
    // The first bond breaks in the fifth step.
    let increment = opening(&events[0].state) / 4.5;

    let mut phase = phase("", boundary, None);
    phase.increment = increment;
    let weights = vec![(2 * below + 1, -1.0), (2 * above + 1, 1.0)];
    let by_probe = Programme::new(vec![phase])
        .with_probes([Functional::of_displacement(weights)])
        .controlled_by(Some(0));
    let control = Control::Equilibrium { most_passes: 1000 };
    let (_, steps) = run(&model, &laws, &by_probe, control, 20);
    for (step, Step { state, record, .. }) in steps.iter().enumerate() {
        let expected = increment * (step + 1) as f64;
        // Updates leave 1e-12 of the displacement, of which the opening is a tenth and more.
        let error = (opening(state) / expected - 1.0).abs();
        assert!(error < 1e-9, "step {}: {error:e}", step + 1);
        assert_eq!(
            record.broken > 0 && step < 5,
            step == 4,
            "step {}",
            step + 1
        );
    }
    let factors: Vec<f64> = steps.iter().map(|step| step.state.load.factor).collect();
    assert!(factors[3] < events[0].state.load.factor);
    let back = factors.windows(2).filter(|pair| pair[1] < pair[0]);
    assert!(back.count() >= 5, "{factors:?}");
    assert_balanced(&steps);
}
