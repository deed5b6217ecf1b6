//! The course of a fracture run as charts: reaction over grip displacement, energies.

use crate::fracture::control::Control;
use crate::fracture::envelope::envelope;
use crate::output::picture::{Axis, Chart, Curve, Mark};
use crate::pipeline::read::plan::{Loading, Plan};
use crate::pipeline::record::history::HistoryLine;
use crate::pipeline::record::solved::FractureRun;

/// Steps that break bonds are shown one by one if there are no more of them.
const MOST_DOTS: usize = 100;

/// Reaction over grip displacement; over the load factor where nothing is displaced.
pub(crate) fn load_displacement(plan: &Plan, course: &FractureRun) -> Chart {
    let history = &course.history;
    let grips_move = history.iter().any(|line| line.grip_displacement > 0.0);
    let at = |line: &HistoryLine| {
        let x = if grips_move {
            line.grip_displacement
        } else {
            line.load_factor
        };
        [x, line.reaction]
    };
    let (name, unit) = if grips_move {
        ("grip displacement", "m")
    } else {
        ("load factor", "")
    };
    let mark = |(line, what): (&HistoryLine, String)| Mark {
        at: at(line),
        label: format!("{what}, step {}", line.step),
    };
    let breaking = history.iter().filter(|line| line.bonds_broken > 0);
    let dots: Vec<[f64; 2]> = breaking.map(at).collect();
    let start = std::iter::once([0.0, 0.0]);
    let on_envelope = on_envelope(history);
    let envelope = (on_envelope.len() < history.len()).then(|| Curve {
        name: "envelope".to_owned(),
        points: on_envelope.into_iter().map(at).collect(),
        ..Curve::default()
    });
    let reaction = Curve {
        name: "reaction".to_owned(),
        points: start.chain(history.iter().map(at)).collect(),
        dots: if dots.len() <= MOST_DOTS {
            dots
        } else {
            Vec::new()
        },
        marks: events(course).into_iter().map(mark).collect(),
    };
    Chart {
        title: format!("{}: reaction over {name}", plan.name),
        x: axis(name, unit),
        y: axis("reaction", "N"),
        curves: std::iter::once(reaction).chain(envelope).collect(),
    }
}

/// First break, largest reaction, end.
fn events(course: &FractureRun) -> Vec<(&HistoryLine, String)> {
    let history = &course.history;
    let first = history.iter().find(|line| line.bonds_broken > 0);
    let peak = history
        .iter()
        .max_by(|a, b| a.reaction.total_cmp(&b.reaction));
    let last = history.last();
    // The end may be the peak, and the first break too.
    let peak = peak.filter(|peak| {
        let others = [first, last].into_iter().flatten();
        others.into_iter().all(|line| line.step != peak.step)
    });
    let named = [
        (first, "first bond"),
        (peak, "peak"),
        (last, course.ending.describe()),
    ];
    let there = named.into_iter();
    there
        .filter_map(|(line, what)| Some((line?, what.to_owned())))
        .collect()
}

/// Elastic and dissipated energy and the work of the loads; over the load factor where it only grows, else,
/// event-driven or in a programme of several phases, over the step.
pub(crate) fn energies(plan: &Plan, course: &FractureRun) -> Chart {
    let history = &course.history;
    let turns = |loading: &Loading| {
        loading.phases.len() > 1 || matches!(loading.control, Control::EventDriven)
    };
    let (name, of): (&str, fn(&HistoryLine) -> f64) = match &plan.loading {
        Some(loading) if turns(loading) => ("step", |line| line.step as f64),
        _ => ("load factor", |line| line.load_factor),
    };
    let curve = |name: &str, energy: fn(&HistoryLine) -> f64| Curve {
        name: name.to_owned(),
        points: std::iter::once([0.0, 0.0])
            .chain(history.iter().map(|line| [of(line), energy(line)]))
            .collect(),
        ..Curve::default()
    };
    Chart {
        title: format!("{}: energies over {name}", plan.name),
        x: axis(name, ""),
        y: axis("energy", "J"),
        curves: vec![
            curve("elastic energy", |line| line.elastic_energy),
            curve("dissipated energy", |line| line.dissipated_energy),
            curve("work of the loads", |line| line.external_work),
        ],
    }
}

fn axis(name: &str, unit: &str) -> Axis {
    Axis {
        name: name.to_owned(),
        unit: unit.to_owned(),
    }
}

/// The lines of the last phase on the envelope of its path.
fn on_envelope(history: &[HistoryLine]) -> Vec<&HistoryLine> {
    let phase = history.last().map(|line| line.phase);
    let lines: Vec<&HistoryLine> = history.iter().filter(|l| Some(l.phase) == phase).collect();
    let factors: Vec<f64> = lines.iter().map(|line| line.load_factor).collect();
    envelope(&factors).into_iter().map(|k| lines[k]).collect()
}
