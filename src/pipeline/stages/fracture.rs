//! The solve stage of a fracture run: history line by line, frames, and a checkpoint whenever a new
//! factorisation follows, from which a killed run goes on with the same bits: what is between two
//! factorisations is a function of the state at the first.

mod journal;
mod recorder;

use super::course_warnings;
use super::run::{Observer, Step};
use super::validate::{laws, programme};
use crate::fracture::control::{self, Problem, Resolution, Until};
use crate::fracture::response::Response;
use crate::fracture::state::State;
use crate::model::Model;
use crate::phases::measure;
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::{Loading, Plan};
use crate::pipeline::read::source::InputError;
use crate::pipeline::record::checkpoint::RecordHash;
use crate::pipeline::record::format::other_format;
use crate::pipeline::record::history::HistoryLine;
use crate::pipeline::record::solved::Solved;
use crate::pipeline::record::stamp;
use crate::pipeline::record::writer::{
    CHECKPOINT_FILE, RecordWriter, WrittenRecord, read_checkpoint,
};
use crate::pipeline::show::live_picture::LivePicture;
use crate::trace::{Kind, Trace};
use journal::RunJournal;
use recorder::{HAND_OVER, Recorder};
use std::thread;
use std::time::Instant;

/// The run and its settings.
pub(crate) struct Task<'a> {
    pub plan: &'a Plan,
    pub loading: &'a Loading,
    pub model: &'a Model,
    /// Recipe of the solve stage.
    pub recipe: &'a str,
    pub resolution: Resolution,
    pub trace: &'a Trace,
}

/// Runs from the start, or from the checkpoint of an interrupted run of the same recipe.
///
/// # Errors
/// See [`RunError`].
pub(crate) fn run(
    task: &Task,
    observer: &mut dyn Observer,
) -> Result<(Solved, WrittenRecord), RunError> {
    let Task {
        plan,
        loading,
        model,
        ..
    } = *task;
    let problem = Problem {
        model,
        programme: &programme(plan, model)?,
        laws: &measure("bond laws", || laws(plan, model)),
        control: loading.control,
        until: loading.until,
        resolution: task.resolution,
    };
    let recipe = format!("{} {:?}", task.recipe, task.resolution);
    let mut journal = RunJournal::new(plan, &problem, stamp::hash(recipe.as_bytes()));
    let checkpoint = read_checkpoint(&plan.folder).unwrap_or_else(|found| {
        let why = other_format(found);
        observer.warns(&format!(
            "{CHECKPOINT_FILE} is refused: {why}; the run begins anew"
        ));
        None
    });
    let (resumed, record_hash) = match journal.resume(checkpoint)? {
        Some((state, record_hash)) => (Some(state), record_hash),
        None => (None, RecordHash::default()),
    };
    let trace = task.trace;
    thread::scope(|scope| {
        let writer = RecordWriter::start(scope, &plan.folder, record_hash, trace.clone())?;
        let picture = LivePicture::new(scope, plan, model);
        let mut recorder = Recorder::new(journal, writer, picture);
        let mut state = match resumed {
            Some(state) => {
                let step = state.step;
                observer.warns(&format!("an interrupted run goes on after step {step}"));
                state
            }
            None => {
                let state = State::new(model, problem.programme);
                recorder.begin(&state)?;
                state
            }
        };
        let start = Instant::now();
        let first = state.step;
        let mut step_start = start;
        trace.set_step(Some(first + 1));
        let ending = control::run(&problem, &mut state, |state, record, response| {
            if state.step == 1 {
                check_control_probe(plan, loading, state, response)?;
            }
            measure(HAND_OVER, || recorder.step(state, &record, response))?;
            if course_warnings::is_due(state, record.changed) {
                course_warnings::of(&problem, state)
                    .iter()
                    .for_each(|warning| observer.warns(warning));
            }
            let rate = (state.step - first) as f64 / start.elapsed().as_secs_f64();
            if let Some(line) = recorder.journal.history.last() {
                observer.step(&step(&problem, line, rate));
            }
            trace.record(Kind::Step, "step", step_start, step_start.elapsed());
            trace.set_step(Some(state.step + 1));
            step_start = Instant::now();
            Ok::<(), RunError>(())
        });
        trace.set_step(None);
        let ending = ending?;
        recorder.end(&state)?;
        if !course_warnings::are_told(&state) {
            course_warnings::of(&problem, &state)
                .iter()
                .for_each(|warning| observer.warns(warning));
        }
        recorder.finish(&state, ending)
    })
}

/// A probe that moves by less than this share of the largest displacement reads rounding.
const STILL: f64 = 1e-9;

/// Checks that the load moves the probe that controls it.
fn check_control_probe(
    plan: &Plan,
    loading: &Loading,
    state: &State,
    response: &Response,
) -> Result<(), InputError> {
    let Some(probe) = loading.by else {
        return Ok(());
    };
    let moved = response.values().probes(plan.probes.len(), state.load)[probe];
    let largest = (state.displacement.iter().flatten()).fold(0.0, |u, v| f64::max(u, v.abs()));
    if moved.abs() > STILL * largest {
        return Ok(());
    }
    let message = format!(
        "the load does not move the probe `{}`",
        plan.probes[probe].name
    );
    let help = "take another `component`, or points on both sides of the crack".to_owned();
    Err(plan.source.error("loading/by", message, Some(help)))
}

/// Position of the run, for the observer.
fn step(problem: &Problem, line: &HistoryLine, steps_per_second: f64) -> Step {
    let phases = &problem.programme.phases;
    let phase = match phases.len() {
        1 => String::new(),
        _ => phases[line.phase].name.clone(),
    };
    Step {
        phase,
        step: line.step,
        most_steps: Some(problem.until.steps).filter(|&steps| steps != Until::NO_LIMIT),
        load_factor: line.load_factor,
        bonds_broken: line.bonds_broken,
        bonds_broken_total: line.bonds_broken_total,
        passes: line.passes,
        steps_per_second,
    }
}
