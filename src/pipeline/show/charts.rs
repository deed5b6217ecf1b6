//! The course of a fracture run as charts: load over displacement, energies.

use super::maps::titled;
use crate::fracture::control::Control;
use crate::fracture::envelope::envelope;
use crate::output::picture::{Axis, Chart, Curve, Mark};
use crate::pipeline::read::plan::{Loading, Plan};
use crate::pipeline::record::events;
use crate::pipeline::record::history::HistoryLine;
use crate::pipeline::record::solved::FractureRun;

/// Steps that break bonds are shown one by one if there are no more of them.
const MOST_DOTS: usize = 100;

/// The place of a line of the history on a chart.
type PlaceOnChart = Box<dyn Fn(&HistoryLine) -> [f64; 2]>;

/// Axes of the chart of load over displacement, and the place of a line of the history on them.
struct Scales {
    x: Axis,
    y: Axis,
    at: PlaceOnChart,
}

impl Scales {
    /// The reaction over the displacement of the grips. Where only forces load the body, λ over the
    /// displacement that works with them, f·u / Σ |f_i| for the forces f at λ = 1, of which the elastic energy is
    /// ½ λ f·u. In a programme of several phases of forces, λ over the step.
    fn of(history: &[HistoryLine], unit_load: f64) -> Scales {
        if !events::is_driven_by_forces(history) {
            return Scales {
                x: axis("grip displacement", "m"),
                y: axis("reaction", "N"),
                at: Box::new(|line| [line.grip_displacement, line.reaction]),
            };
        }
        let y = axis("load factor", "");
        if history.iter().any(|line| line.phase > 0) || unit_load == 0.0 {
            return Scales {
                x: axis("step", ""),
                y,
                at: Box::new(|line| [line.step as f64, line.load_factor]),
            };
        }
        let displacement = move |line: &HistoryLine| match line.load_factor {
            0.0 => 0.0,
            factor => 2.0 * line.elastic_energy / (factor * unit_load),
        };
        Scales {
            x: axis("displacement along the loads", "m"),
            y,
            at: Box::new(move |line| [displacement(line), line.load_factor]),
        }
    }
}

/// Load over displacement, with the events of the run. `unit_load`: sum of the amounts of the forces at λ = 1 [N].
pub(crate) fn load_displacement(plan: &Plan, course: &FractureRun, unit_load: f64) -> Chart {
    let history = &course.history;
    let Scales { x, y, at } = Scales::of(history, unit_load);
    let mark = |(line, what): (&HistoryLine, String)| Mark {
        at: at(line),
        label: format!("{what}, step {}", line.step),
    };
    let breaking = history.iter().filter(|line| line.bonds_broken > 0);
    let dots: Vec<[f64; 2]> = breaking.map(&at).collect();
    let start = std::iter::once([0.0, 0.0]);
    let on_envelope = on_envelope(history);
    let envelope = (on_envelope.len() < history.len()).then(|| Curve {
        name: "envelope".to_owned(),
        points: on_envelope.into_iter().map(&at).collect(),
        ..Curve::default()
    });
    let path = Curve {
        name: y.name.clone(),
        points: start.chain(history.iter().map(&at)).collect(),
        dots: if dots.len() <= MOST_DOTS {
            dots
        } else {
            Vec::new()
        },
        marks: marked(course).into_iter().map(mark).collect(),
    };
    Chart {
        title: titled(plan, &format!("{} over {}", y.name, x.name)),
        x,
        y,
        curves: std::iter::once(path).chain(envelope).collect(),
    }
}

/// First break, largest load, end.
fn marked(course: &FractureRun) -> Vec<(&HistoryLine, String)> {
    let history = &course.history;
    let first = events::first_break(history);
    let peak = events::peak(history);
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
        title: titled(plan, &format!("energies over {name}")),
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
        ..Axis::default()
    }
}

/// The lines of the last phase on the envelope of its path.
fn on_envelope(history: &[HistoryLine]) -> Vec<&HistoryLine> {
    let phase = history.last().map(|line| line.phase);
    let lines: Vec<&HistoryLine> = history.iter().filter(|l| Some(l.phase) == phase).collect();
    let factors: Vec<f64> = lines.iter().map(|line| line.load_factor).collect();
    envelope(&factors).into_iter().map(|k| lines[k]).collect()
}
