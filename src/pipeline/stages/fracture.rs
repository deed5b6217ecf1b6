//! The solve stage of a fracture run: history line by line, frames, and a checkpoint whenever a new
//! factorisation follows, from which a killed run goes on with the same bits: what is between two
//! factorisations is a function of the state at the first.

use super::run::{Observer, Step};
use super::validate::{laws, programme};
use crate::fracture::control::{self, Ending, Problem, Record, Resolution};
use crate::fracture::crack_length::crack_lengths;
use crate::fracture::response::Response;
use crate::fracture::state::State;
use crate::model::Model;
use crate::phases::Phases;
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::{Loading, Plan};
use crate::pipeline::read::spec::Output;
use crate::pipeline::record::checkpoint::{Checkpoint, Ledger};
use crate::pipeline::record::folder::file_error;
use crate::pipeline::record::format::other_format;
use crate::pipeline::record::frames::{FRAMES_FOLDER, Frame, encode, forget_frames, frame_file};
use crate::pipeline::record::history::{Line, header};
use crate::pipeline::record::solved::{Course, Solved};
use crate::pipeline::record::sparse_integrity::SparseIntegrity;
use crate::pipeline::record::stamp;
use crate::pipeline::record::writer::{
    CHECKPOINT_FILE, Order, Scribe, Written, begin_history, read_checkpoint, read_journal,
};
use crate::pipeline::show::live_picture::LivePicture;
use crate::statics::{Solution, Solver};
use crate::trace::Kind;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::thread;
use std::time::Instant;

/// What to run, and how.
pub(crate) struct Task<'a> {
    pub plan: &'a Plan,
    pub loading: &'a Loading,
    pub model: &'a Model,
    /// What the solve stage is made from.
    pub recipe: &'a str,
    pub resolution: Resolution,
}

/// Runs from the start, or from the checkpoint of an interrupted run of the same recipe.
///
/// # Errors
/// See [`RunError`].
pub(crate) fn run(
    task: &Task,
    observer: &mut dyn Observer,
    phases: &mut Phases,
) -> Result<(Solved, Written), RunError> {
    let Task {
        plan,
        loading,
        model,
        ..
    } = *task;
    let problem = Problem {
        model,
        programme: &programme(plan, model)?,
        laws: &laws(plan, model),
        control: loading.control,
        until: loading.until,
        resolution: task.resolution,
    };
    let recipe = format!("{} {:?}", task.recipe, task.resolution);
    let mut chronicle = Chronicle::new(plan, &problem, stamp::hash(recipe.as_bytes()));
    let checkpoint = read_checkpoint(&plan.folder).unwrap_or_else(|found| {
        let why = other_format(found);
        observer.warns(&format!(
            "{CHECKPOINT_FILE} is refused: {why}; the run begins anew"
        ));
        None
    });
    let (resumed, ledger) = match chronicle.resume(checkpoint)? {
        Some((state, ledger)) => (Some(state), ledger),
        None => (None, Ledger::default()),
    };
    let trace = phases.trace().clone();
    thread::scope(|scope| {
        let scribe = Scribe::start(scope, &plan.folder, ledger, trace.clone())?;
        let mut writer = Writer {
            chronicle,
            scribe: Some(scribe),
            picture: LivePicture::new(scope, plan, model),
            handed_over: Phases::traced(trace.clone()),
        };
        let mut state = match resumed {
            Some(state) => {
                let step = state.step;
                observer.warns(&format!("an interrupted run goes on after step {step}"));
                state
            }
            None => {
                let state = State::new(model, problem.programme);
                writer.begin(&state)?;
                state
            }
        };
        let lost: usize = state.fragments.iter().map(Vec::len).sum();
        if lost > 0 && state.step == 0 {
            observer.warns(&format!(
                "the cracks cut {lost} material points off; they do not move"
            ));
        }
        let start = Instant::now();
        let first = state.step;
        let mut step_start = start;
        trace.set_step(Some(first + 1));
        let ending = control::run(&problem, &mut state, phases, |state, record, response| {
            writer.step(state, record, response)?;
            let rate = (state.step - first) as f64 / start.elapsed().as_secs_f64();
            if let Some(line) = writer.chronicle.history.last() {
                observer.step(&step(&problem, line, rate));
            }
            trace.record(Kind::Step, "step", step_start, step_start.elapsed());
            trace.set_step(Some(state.step + 1));
            step_start = Instant::now();
            Ok::<(), RunError>(())
        });
        trace.set_step(None);
        let ending = ending?;
        writer.end(&state)?;
        if let Some(warning) = nothing_broke(&problem, &state) {
            observer.warns(&warning);
        }
        writer.finish(&state, ending, phases)
    })
}

/// Where the run is.
fn step(problem: &Problem, line: &Line, steps_per_second: f64) -> Step {
    let phases = &problem.programme.phases;
    let phase = match phases.len() {
        1 => String::new(),
        _ => phases[line.phase].name.clone(),
    };
    Step {
        phase,
        step: line.step,
        most_steps: problem.until.steps,
        load_factor: line.load_factor,
        bonds_broken: line.bonds_broken,
        bonds_broken_total: line.bonds_broken_total,
        passes: line.passes,
        steps_per_second,
    }
}

/// A load that could not break a bond, told with what it has reached.
fn nothing_broke(problem: &Problem, state: &State) -> Option<String> {
    let Problem { model, laws, .. } = problem;
    if state.step == 0 || !state.changes.is_empty() {
        return None;
    }
    let (interaction, utilisation) = state.most_strained(model, laws)?;
    let [a, b] = model.interactions.segment(interaction, &model.positions);
    let [x, y] = [0, 1].map(|axis| 500.0 * (a[axis] + b[axis]));
    Some(format!(
        "no bond has broken: at λ = {:.4} the largest stretch is {:.0} % of its limit, at ({x:.4}, {y:.4}) mm",
        state.load.factor,
        100.0 * utilisation
    ))
}

/// Of what lies in the folder, if all frames do.
fn ledger(folder: &Path, lines: &[Line], frames: &[usize]) -> Option<Ledger> {
    let mut ledger = Ledger::default();
    lines.iter().for_each(|line| ledger.add_line(&encode(line)));
    for &step in frames {
        ledger.add_frame(&stamp::hash_file(&folder.join(frame_file(step)))?);
    }
    Some(ledger)
}

/// The course of the run so far.
struct Chronicle<'a> {
    plan: &'a Plan,
    problem: &'a Problem<'a>,
    recipe: String,
    history: Vec<Line>,
    /// Steps that have a frame.
    frames: Vec<usize>,
    /// Crack length that each interaction adds when it breaks [m].
    crack_lengths: Vec<f64>,
    initial_length: f64,
}

impl<'a> Chronicle<'a> {
    fn new(plan: &'a Plan, problem: &'a Problem<'a>, recipe: String) -> Chronicle<'a> {
        let crack_lengths = crack_lengths(problem.model, problem.laws);
        let severed = (problem.model.integrity.iter())
            .zip(&crack_lengths)
            .filter(|(phi, _)| **phi == 0.0);
        let initial_length = severed.map(|(_, length)| length).sum();
        Chronicle {
            plan,
            problem,
            recipe,
            history: Vec::new(),
            frames: Vec::new(),
            crack_lengths,
            initial_length,
        }
    }

    /// The state of the checkpoint, if it is of this recipe; history and frames go on from there.
    fn resume(
        &mut self,
        checkpoint: Option<Checkpoint>,
    ) -> Result<Option<(State, Ledger)>, RunError> {
        let folder = &self.plan.folder;
        let stored = checkpoint.filter(|found| found.recipe == self.recipe);
        let stored = stored.and_then(|checkpoint| {
            let lines = read_journal(folder, checkpoint.lines)?;
            let ledger = ledger(folder, &lines, &checkpoint.frames)?;
            let is_whole = ledger.close() == checkpoint.ledger;
            (is_whole && checkpoint.fits(self.problem, &lines))
                .then_some((checkpoint, lines, ledger))
        });
        if let Some((checkpoint, lines, _)) = &stored {
            self.history.clone_from(lines);
            self.frames.clone_from(&checkpoint.frames);
        } else {
            forget_frames(folder)?;
            let frames = folder.join(FRAMES_FOLDER);
            fs::create_dir_all(&frames).map_err(|source| file_error("create", &frames, source))?;
        }
        let mut text = header(self.problem.programme.supports()) + "\n";
        for line in &self.history {
            text += &(self.csv(line) + "\n");
        }
        begin_history(folder, &text, &self.history)?;
        Ok(stored
            .map(|(checkpoint, _, ledger)| (checkpoint.into_state(self.problem.model), ledger)))
    }

    fn csv(&self, line: &Line) -> String {
        line.csv(&self.problem.programme.phases[line.phase].name)
    }

    fn checkpoint(&self, state: &State) -> Box<Checkpoint> {
        let checkpoint = Checkpoint::new(&self.recipe, state, self.history.len(), &self.frames);
        Box::new(checkpoint)
    }

    /// The frame of a state that has none yet.
    fn frame(&mut self, state: &State) -> Option<Arc<Frame>> {
        let is_new = self.frames.last() != Some(&state.step);
        is_new.then(|| {
            self.frames.push(state.step);
            Arc::new(Frame::new(self.problem.model, state))
        })
    }

    fn line(&self, state: &State, record: Record, response: &Response) -> Line {
        let programme = self.problem.programme;
        let reactions = response
            .values()
            .resultants(programme.phases.len(), state.load);
        let before = self.history.last();
        let length = before.map_or(self.initial_length, |line| line.crack_length);
        let changes = &state.changes[state.changes.len() - record.changed..];
        let grown = changes.iter().map(|change| {
            let [phi, next] = change.integrity;
            (phi - next) * self.crack_lengths[change.interaction as usize]
        });
        Line {
            step: state.step,
            phase: state.phase,
            load_factor: state.load.factor,
            envelope_load_factor: state.envelope,
            load_share: state.load.share,
            grip_displacement: programme.largest_prescribed(state.phase, state.load),
            reaction: (reactions.iter())
                .map(|[x, y]| x.hypot(*y))
                .fold(0.0, f64::max),
            elastic_energy: state.energy.elastic,
            dissipated_energy: state.energy.dissipated,
            external_work: state.energy.external,
            bonds_broken: record.broken,
            bonds_broken_total: before.map_or(0, |line| line.bonds_broken_total) + record.broken,
            passes: record.passes,
            residual: record.residual,
            crack_length: length + grown.sum::<f64>(),
            reactions,
        }
    }
}

/// Hands history, frames and checkpoints over to the threads behind the solve.
struct Writer<'a, 'scope> {
    chronicle: Chronicle<'a>,
    /// Until it meets an error, or the end.
    scribe: Option<Scribe<'scope>>,
    picture: LivePicture<'scope, 'a>,
    /// What the solve spends on it.
    handed_over: Phases,
}

/// The phase of copying a state and of waiting for room in the queue.
const HAND_OVER: &str = "hand over";

impl Writer<'_, '_> {
    /// The state before the first step.
    fn begin(&mut self, state: &State) -> Result<(), RunError> {
        let frame = self.chronicle.frame(state);
        let checkpoint = Some(self.chronicle.checkpoint(state));
        self.give(Order {
            line: None,
            frame,
            checkpoint,
        })
    }

    fn step(&mut self, state: &State, record: Record, response: &Response) -> Result<(), RunError> {
        let start = Instant::now();
        let Chronicle { plan, problem, .. } = self.chronicle;
        let first_break = record.changed > 0 && state.changes.len() == record.changed;
        let line = self.chronicle.line(state, record, response);
        self.chronicle.history.push(line.clone());
        let Output {
            every, pictures_at, ..
        } = &plan.output;
        let is_pictured = pictures_at.contains(&state.step);
        let wants_frame = first_break || is_pictured || state.step.is_multiple_of(*every);
        let settled = wants_frame.then(|| state.settled(problem, response));
        let frame = settled.and_then(|state| self.chronicle.frame(&state));
        let checkpoint = response
            .is_reproducible(state)
            .then(|| self.chronicle.checkpoint(state));
        self.give(Order {
            line: Some((self.chronicle.csv(&line), line)),
            frame,
            checkpoint,
        })?;
        self.picture.update(state);
        self.handed_over.note(HAND_OVER, start);
        Ok(())
    }

    /// The state behind the last step.
    fn end(&mut self, state: &State) -> Result<(), RunError> {
        let frame = self.chronicle.frame(state);
        self.give(Order {
            frame,
            ..Order::default()
        })
    }

    fn give(&mut self, order: Order) -> Result<(), RunError> {
        let scribe = self.scribe.take_if(|scribe| !scribe.give(order));
        scribe.map_or(Ok(()), |scribe| scribe.finish().map(|_| ()))
    }

    fn finish(
        self,
        state: &State,
        ending: Ending,
        phases: &mut Phases,
    ) -> Result<(Solved, Written), RunError> {
        let Writer {
            chronicle,
            scribe,
            handed_over,
            ..
        } = self;
        phases.append(handed_over.list);
        let model = chronicle.problem.model;
        let size = match state.size {
            Some(size) => size,
            // No step was possible.
            None => {
                let supports = chronicle.problem.programme.supports();
                Solver::new(chronicle.problem.model, supports, phases)?.size()
            }
        };
        let scribe = scribe.expect("an error of the scribe ends the run where it is met");
        let written = phases.measure(HAND_OVER, || scribe.finish())?;
        let solution = Solution {
            displacement: model.in_space(&state.displacement),
            reaction: model.in_space(&state.reaction),
            residual: state.residual,
            size,
        };
        let course = Course {
            history: chronicle.history,
            frames: chronicle.frames,
            ending,
            fragments: state.fragments.iter().map(Vec::len).collect(),
            reason: state.stopped.as_ref().map(|(_, reason)| reason.clone()),
        };
        let solved = Solved {
            solution,
            integrity: SparseIntegrity::new(&state.integrity),
            fracture: Some(course),
        };
        Ok((solved, written))
    }
}
