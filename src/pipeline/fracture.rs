//! The solve stage of a fracture run: history line by line, frames, and a checkpoint whenever a new
//! factorisation follows, from which a killed run goes on with the same bits: what is between two
//! factorisations is a function of the state at the first.

use super::checkpoint::Checkpoint;
use super::damage_picture::Latest;
use super::folder::{file_error, remove};
use super::history::{Line, header};
use super::plan::{Loading, Plan};
use super::run::{Observer, RunError};
use super::spec::Output;
use super::stamp;
use super::validate::{limits, programme};
use crate::fracture::control::{self, Ending, Problem, Record, Resolution};
use crate::fracture::response::Response;
use crate::fracture::state::{Limits, State};
use crate::model::Model;
use crate::output::{partial_name, write_whole};
use crate::phases::Phases;
use crate::statics::{Solution, Solver};
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

pub const HISTORY_FILE: &str = "history.csv";
const FRAMES_FOLDER: &str = "frames";
const CHECKPOINT_FILE: &str = ".stamps/checkpoint.bin";
const JOURNAL_FILE: &str = ".stamps/journal.bin";

/// A moment of the run that is kept whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    pub step: usize,
    pub load_factor: f64,
    /// [m].
    pub displacement: Vec<[f64; 2]>,
    pub intact: Vec<bool>,
}

/// What a fracture run leaves.
#[derive(Clone, Debug)]
pub struct Fractured {
    pub history: Vec<Line>,
    /// Steps that have a frame.
    pub frames: Vec<usize>,
    pub ending: Ending,
    /// Number of nodes of each part that has come off.
    pub fragments: Vec<usize>,
    /// Why there is no solution any more, where the run ended so.
    pub reason: Option<String>,
    /// The last state.
    pub solution: Solution,
    /// The springs that are intact in it.
    pub intact: Vec<bool>,
}

/// The name of a step's frame in the results folder.
pub(super) fn frame_file(step: usize) -> String {
    format!("{FRAMES_FOLDER}/{step:06}.bin")
}

/// # Errors
/// A frame that cannot be read.
pub(super) fn read_frame(folder: &Path, step: usize) -> Result<Frame, RunError> {
    let path = folder.join(frame_file(step));
    let bytes = fs::read(&path).map_err(|source| file_error("read", &path, source))?;
    postcard::from_bytes(&bytes)
        .map_err(|error| file_error("read", &path, std::io::Error::other(error)))
}

/// Runs from the start, or from the checkpoint of an interrupted run of the same recipe.
///
/// # Errors
/// See [`RunError`].
pub(super) fn run(
    plan: &Plan,
    loading: &Loading,
    model: &Model,
    recipe: &str,
    resolution: Resolution,
    observer: &mut dyn Observer,
    phases: &mut Phases,
) -> Result<Fractured, RunError> {
    let problem = Problem {
        model,
        programme: &programme(plan, model)?,
        limits: &limits(plan, model),
        control: loading.control,
        until: loading.until,
        resolution,
    };
    let mut writer = Writer::new(plan, &problem, recipe)?;
    let mut state = match writer.resume()? {
        Some(state) => {
            let step = state.step;
            observer.warns(&format!("an interrupted run goes on after step {step}"));
            state
        }
        None => {
            let state = State::new(model, problem.programme);
            writer.frame(&state)?;
            writer.checkpoint(&state)?;
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
    let mut latest = Latest::default();
    let ending = control::run(&problem, &mut state, phases, |state, record, response| {
        writer.step(state, record, response)?;
        latest.show(plan, model, state.step, &state.intact)?;
        let rate = start.elapsed().as_secs_f64() / (state.step - first) as f64;
        observer.progress(&progress(&problem, writer.history.last(), rate));
        Ok::<(), RunError>(())
    })?;
    writer.frame(&state)?;
    if let Some(warning) = nothing_broke(&problem, &state) {
        observer.warns(&warning);
    }
    writer.finish(&state, ending, phases)
}

/// Where the run is, in a line.
fn progress(problem: &Problem, line: Option<&Line>, seconds_per_step: f64) -> String {
    let Some(line) = line else {
        return String::new();
    };
    let most = problem.until.steps;
    let phases = &problem.programme.phases;
    let phase = match phases.len() {
        1 => String::new(),
        _ => format!("{}, ", phases[line.phase].name),
    };
    format!(
        "{phase}step {} of at most {most}, λ = {:.4}, {} bonds broken ({} in all), {} passes, at most {:.0} s left",
        line.step,
        line.load_factor,
        line.bonds_broken,
        line.bonds_broken_total,
        line.passes,
        seconds_per_step * (most - line.step) as f64
    )
}

/// A load that could not break a bond, told with what it has reached.
fn nothing_broke(problem: &Problem, state: &State) -> Option<String> {
    let Problem { model, limits, .. } = problem;
    if state.step == 0 || !state.broken.is_empty() {
        return None;
    }
    let (spring, utilisation) = state.most_strained(model, limits)?;
    let [a, b] = model.springs.segment(spring, &model.positions);
    let [x, y] = [0, 1].map(|axis| 500.0 * (a[axis] + b[axis]));
    Some(format!(
        "no bond has broken: at λ = {:.4} the largest stretch is {:.0} % of its limit, at ({x:.4}, {y:.4}) mm",
        state.load.factor,
        100.0 * utilisation
    ))
}

/// Puts history, frames and checkpoints on disk.
struct Writer<'a> {
    plan: &'a Plan,
    problem: &'a Problem<'a>,
    recipe: String,
    history: Vec<Line>,
    frames: Vec<usize>,
    csv: File,
    journal: Journal,
    csv_path: PathBuf,
    /// Crack length that each spring adds when it breaks [m].
    crack_lengths: Vec<f64>,
    initial_length: f64,
}

impl<'a> Writer<'a> {
    fn new(plan: &'a Plan, problem: &'a Problem<'a>, recipe: &str) -> Result<Writer<'a>, RunError> {
        let csv_path = plan.folder.join(HISTORY_FILE);
        let csv = File::options().create(true).append(true).open(&csv_path);
        let csv = csv.map_err(|source| file_error("create", &csv_path, source))?;
        let crack_lengths = crack_lengths(problem.model, problem.limits);
        let severed = (problem.model.intact.iter())
            .zip(&crack_lengths)
            .filter(|(intact, _)| !**intact);
        let initial_length = severed.map(|(_, length)| length).sum();
        Ok(Writer {
            plan,
            problem,
            recipe: stamp::hash(format!("{recipe} {:?}", problem.resolution).as_bytes()),
            history: Vec::new(),
            frames: Vec::new(),
            csv,
            journal: Journal::new(&plan.folder),
            csv_path,
            crack_lengths,
            initial_length,
        })
    }

    /// The state of the checkpoint, if it is of this recipe; history and frames go on from there.
    fn resume(&mut self) -> Result<Option<State>, RunError> {
        let bytes = fs::read(self.plan.folder.join(CHECKPOINT_FILE)).unwrap_or_default();
        let stored: Option<Checkpoint> = postcard::from_bytes(&bytes).ok();
        let has_frame = |&step: &usize| self.plan.folder.join(frame_file(step)).is_file();
        let stored = stored.filter(|checkpoint| {
            checkpoint.recipe == self.recipe && checkpoint.frames.iter().all(has_frame)
        });
        let stored = stored.and_then(|checkpoint| {
            let lines = self.journal.read(checkpoint.lines)?;
            Some((checkpoint, lines))
        });
        if let Some((checkpoint, lines)) = &stored {
            self.history.clone_from(lines);
            self.frames.clone_from(&checkpoint.frames);
        } else {
            forget_frames(&self.plan.folder)?;
            let folder = self.plan.folder.join(FRAMES_FOLDER);
            fs::create_dir_all(&folder).map_err(|source| file_error("create", &folder, source))?;
        }
        let mut text = header(self.problem.programme.supports()) + "\n";
        for line in &self.history {
            text += &(self.csv(line) + "\n");
        }
        write_whole(&self.csv_path, text.as_bytes())?;
        let csv = File::options().append(true).open(&self.csv_path);
        self.csv = csv.map_err(|source| file_error("write", &self.csv_path, source))?;
        self.journal.begin(&self.history)?;
        Ok(stored.map(|(checkpoint, _)| checkpoint.into_state()))
    }

    fn csv(&self, line: &Line) -> String {
        line.csv(&self.problem.programme.phases[line.phase].name)
    }

    fn step(&mut self, state: &State, record: Record, response: &Response) -> Result<(), RunError> {
        let first_break = record.broken > 0 && state.broken.len() == record.broken;
        let line = self.line(state, record, response);
        writeln!(self.csv, "{}", self.csv(&line))
            .map_err(|source| file_error("write", &self.csv_path, source))?;
        self.journal.add(&line)?;
        self.history.push(line);
        let Output {
            every, pictures_at, ..
        } = &self.plan.output;
        let is_pictured = pictures_at.contains(&state.step);
        if first_break || is_pictured || state.step.is_multiple_of(*every) {
            if response.foresees_next() {
                let mut whole = state.clone();
                whole.settle(self.problem, response);
                self.frame(&whole)?;
            } else {
                self.frame(state)?;
            }
        }
        if response.is_reproducible(state) {
            self.checkpoint(state)?;
        }
        Ok(())
    }

    fn checkpoint(&self, state: &State) -> Result<(), RunError> {
        let checkpoint = Checkpoint::new(&self.recipe, state, self.history.len(), &self.frames);
        let path = self.plan.folder.join(CHECKPOINT_FILE);
        Ok(write_whole(&path, &encode(&checkpoint))?)
    }

    fn line(&self, state: &State, record: Record, response: &Response) -> Line {
        let programme = self.problem.programme;
        let reactions = response
            .values()
            .resultants(programme.phases.len(), state.load);
        let before = self.history.last();
        let length = before.map_or(self.initial_length, |line| line.crack_length);
        let broken = &state.broken[before.map_or(0, |line| line.bonds_broken_total)..];
        let grown = broken.iter().map(|&bond| self.crack_lengths[bond as usize]);
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
            bonds_broken_total: state.broken.len(),
            passes: record.passes,
            residual: record.residual,
            crack_length: length + grown.sum::<f64>(),
            reactions,
        }
    }

    fn frame(&mut self, state: &State) -> Result<(), RunError> {
        if self.frames.last() == Some(&state.step) {
            return Ok(());
        }
        let frame = Frame {
            step: state.step,
            load_factor: state.load.factor,
            displacement: state.displacement.clone(),
            intact: state.intact.clone(),
        };
        self.frames.push(state.step);
        let path = self.plan.folder.join(frame_file(state.step));
        Ok(write_whole(&path, &encode(&frame))?)
    }

    fn finish(
        self,
        state: &State,
        ending: Ending,
        phases: &mut Phases,
    ) -> Result<Fractured, RunError> {
        let Problem {
            model, programme, ..
        } = self.problem;
        let size = match state.size {
            Some(size) => size,
            // No step was possible.
            None => Solver::new(model, programme.supports(), phases)?.size(),
        };
        Ok(Fractured {
            history: self.history,
            frames: self.frames,
            ending,
            fragments: state.fragments.iter().map(Vec::len).collect(),
            reason: state.stopped.as_ref().map(|(_, reason)| reason.clone()),
            intact: state.intact.clone(),
            solution: Solution {
                displacement: state.displacement.clone(),
                reaction: state.reaction.clone(),
                residual: state.residual,
                size,
            },
        })
    }
}

/// The history as it is in memory, line by line, so that a checkpoint need not repeat it.
struct Journal {
    path: PathBuf,
    file: Option<File>,
}

impl Journal {
    fn new(folder: &Path) -> Journal {
        Journal {
            path: folder.join(JOURNAL_FILE),
            file: None,
        }
    }

    /// The first lines, where there are as many.
    fn read(&self, count: usize) -> Option<Vec<Line>> {
        let bytes = fs::read(&self.path).unwrap_or_default();
        let mut rest = bytes.as_slice();
        let mut line = || {
            let (line, after) = postcard::take_from_bytes(rest).ok()?;
            rest = after;
            Some(line)
        };
        (0..count).map(|_| line()).collect()
    }

    /// Starts with these lines.
    fn begin(&mut self, lines: &[Line]) -> Result<(), RunError> {
        let bytes: Vec<u8> = lines.iter().flat_map(encode).collect();
        write_whole(&self.path, &bytes)?;
        let file = File::options().append(true).open(&self.path);
        self.file = Some(file.map_err(|source| file_error("write", &self.path, source))?);
        Ok(())
    }

    fn add(&mut self, line: &Line) -> Result<(), RunError> {
        let Journal { path, file } = self;
        let file = file
            .as_mut()
            .expect("a journal is begun before its first line");
        file.write_all(&encode(line))
            .map_err(|source| file_error("write", path, source))
    }
}

/// An interrupted run cannot go on from here.
pub(super) fn forget_checkpoint(folder: &Path) -> Result<(), RunError> {
    for file in [CHECKPOINT_FILE, JOURNAL_FILE] {
        let path = folder.join(file);
        remove(&partial_name(&path))?;
        remove(&path)?;
    }
    Ok(())
}

/// Frames of another recipe, or of an interrupted run that no manifest lists. What else is in their
/// folder is the user's.
pub(super) fn forget_frames(folder: &Path) -> Result<(), RunError> {
    let frames = folder.join(FRAMES_FOLDER);
    let is_frame = |name: &str| {
        let name = name.strip_suffix(".partial").unwrap_or(name);
        let digits = name.strip_suffix(".bin").unwrap_or_default();
        !digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit())
    };
    for entry in fs::read_dir(&frames).into_iter().flatten().flatten() {
        if entry.file_name().to_str().is_some_and(is_frame) {
            remove(&entry.path())?;
        }
    }
    // Fails where the user keeps something there, or where there is none.
    let _ = fs::remove_dir(&frames);
    Ok(())
}

/// ½ k (ξ s_t)² / (G h_t) of every spring, with G = c0 s_t² M3: the length of crack that its breaking
/// stands for [m]; zero where it never breaks.
fn crack_lengths(model: &Model, limits: &Limits) -> Vec<f64> {
    let mut lengths = vec![0.0; model.springs.len()];
    for (spring, length) in lengths.iter_mut().enumerate() {
        let regions = model.regions_of_spring(spring);
        let points = regions.and_then(|[r, _]| model.points_of(r));
        let breakable = limits.of(spring).tension.is_finite();
        if let (true, Some(points)) = (breakable, points) {
            let xi = model.springs.length(spring, &model.positions);
            // The critical stretch cancels.
            let stiffness = model.bond_share(spring) * model.springs.stiffness[spring];
            // A part of a clipped bond takes the energy of the whole.
            let energy = 0.5 * stiffness * xi * xi / model.length_share(spring).min(1.0);
            let c0 = model.material_factor(spring) * points.micromodulus.c0;
            let rate = c0 * points.micromodulus.third_moment();
            *length = energy / (rate * model.settings.thickness);
        }
    }
    lengths
}

fn encode(value: &impl Serialize) -> Vec<u8> {
    postcard::to_stdvec(value).expect("plain data in memory can be encoded")
}
