//! The solve stage of a fracture run: history line by line, frames, and a checkpoint after every
//! step, from which a killed run goes on with the same bits.

use super::folder::{file_error, remove};
use super::plan::{Loading, Plan};
use super::run::{Observer, RunError};
use super::stamp;
use super::validate::limits;
use crate::boundary::Boundary;
use crate::fracture::control::{self, Ending, Problem, Record};
use crate::fracture::state::{Energy, Limits, State};
use crate::model::Model;
use crate::output::{partial_name, write_whole};
use crate::phases::Phases;
use crate::statics::{Solution, SystemSize, group_reactions};
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

pub const HISTORY_FILE: &str = "history.csv";
const FRAMES_FOLDER: &str = "frames";
const CHECKPOINT_FILE: &str = ".stamps/checkpoint.bin";

/// One line of `history.csv`: a load step, or an event.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    pub step: usize,
    /// λ [-].
    pub load_factor: f64,
    /// Largest prescribed displacement [m].
    pub grip_displacement: f64,
    /// Largest resultant on a group with prescribed displacements [N].
    pub reaction: f64,
    /// [J].
    pub elastic_energy: f64,
    /// [J].
    pub dissipated_energy: f64,
    /// [J].
    pub external_work: f64,
    pub bonds_broken: usize,
    pub bonds_broken_total: usize,
    pub passes: usize,
    /// Largest relative residual of the step's solves.
    pub residual: f64,
    /// Energy that the broken bonds took at their critical stretch, over the energy release rate [m].
    pub crack_length: f64,
}

const HEADER: &str = "step,load_factor,grip_displacement_m,reaction_n,elastic_energy_j,\
                      dissipated_energy_j,external_work_j,bonds_broken,bonds_broken_total,passes,\
                      residual,crack_length_m";

impl Line {
    fn csv(&self) -> String {
        format!(
            "{},{},{},{},{},{},{},{},{},{},{},{}",
            self.step,
            self.load_factor,
            self.grip_displacement,
            self.reaction,
            self.elastic_energy,
            self.dissipated_energy,
            self.external_work,
            self.bonds_broken,
            self.bonds_broken_total,
            self.passes,
            self.residual,
            self.crack_length
        )
    }
}

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

#[derive(Serialize, Deserialize)]
struct Checkpoint {
    /// Hash of what the run is made from.
    recipe: String,
    step: usize,
    load_factor: f64,
    displacement: Vec<[f64; 2]>,
    intact: Vec<bool>,
    fragments: Vec<Vec<usize>>,
    mechanisms: std::collections::BTreeSet<usize>,
    energy: [f64; 4],
    peak_force: f64,
    just_broken: Vec<(u32, f64)>,
    /// The last response to λ = 1, displacements apart.
    reaction: Vec<[f64; 2]>,
    residual: f64,
    size: [usize; 3],
    history: Vec<Line>,
    frames: Vec<usize>,
}

impl Checkpoint {
    fn state(&self) -> State {
        let [external, elastic, dissipated, force] = self.energy;
        State {
            step: self.step,
            load_factor: self.load_factor,
            displacement: self.displacement.clone(),
            intact: self.intact.clone(),
            fragments: self.fragments.clone(),
            mechanisms: self.mechanisms.clone(),
            energy: Energy {
                external,
                elastic,
                dissipated,
                force,
            },
            peak_force: self.peak_force,
            just_broken: self.just_broken.clone(),
        }
    }

    fn unit(&self) -> Solution {
        let [dofs, stiffness_entries, factor_entries] = self.size;
        Solution {
            displacement: Vec::new(),
            reaction: self.reaction.clone(),
            residual: self.residual,
            size: SystemSize {
                dofs,
                stiffness_entries,
                factor_entries,
            },
        }
    }
}

/// Runs from the start, or from the checkpoint of an interrupted run of the same recipe.
///
/// # Errors
/// See [`RunError`].
pub(super) fn run(
    plan: &Plan,
    loading: Loading,
    model: &Model,
    boundary: &Boundary,
    recipe: &str,
    observer: &mut dyn Observer,
    phases: &mut Phases,
) -> Result<Fractured, RunError> {
    let limits = limits(plan, model);
    let mut writer = Writer::new(plan, model, boundary, &limits, recipe)?;
    let (mut state, mut last) = match writer.resume()? {
        Some((state, unit)) => {
            observer.warns(&format!(
                "an interrupted run goes on after step {}",
                state.step
            ));
            (state, Some(unit))
        }
        None => {
            let state = State::new(model, boundary);
            writer.frame(&state)?;
            (state, None)
        }
    };
    let lost: usize = state.fragments.iter().map(Vec::len).sum();
    if lost > 0 && state.step == 0 {
        observer.warns(&format!(
            "the cracks cut {lost} material points off; they do not move"
        ));
    }
    let Loading { control, until } = loading;
    let problem = Problem {
        model,
        boundary,
        limits: &limits,
        control,
        until,
    };
    let start = Instant::now();
    let first = state.step;
    let ending = control::run(&problem, &mut state, phases, |state, record, unit| {
        writer.step(state, record, unit)?;
        last = Some(unit.clone());
        let rate = start.elapsed().as_secs_f64() / (state.step - first) as f64;
        let line = writer
            .history
            .last()
            .expect("the step has just been written");
        observer.progress(&format!(
            "step {} of at most {}, λ = {:.4}, {} bonds broken ({} in all), {} passes, at most {:.0} s left",
            state.step,
            until.steps,
            state.load_factor,
            line.bonds_broken,
            line.bonds_broken_total,
            line.passes,
            rate * (until.steps - state.step) as f64
        ));
        Ok::<(), RunError>(())
    })?;
    writer.frame(&state)?;
    let unit = match last {
        Some(unit) => unit,
        // No step was possible.
        None => control::unit_response(&problem, &mut state, phases)?,
    };
    writer.finish(&state, unit, ending)
}

/// Puts history, frames and checkpoints on disk.
struct Writer<'a> {
    plan: &'a Plan,
    model: &'a Model,
    boundary: &'a Boundary,
    recipe: String,
    history: Vec<Line>,
    frames: Vec<usize>,
    csv: File,
    csv_path: PathBuf,
    /// Crack length that each spring adds when it breaks [m].
    crack_lengths: Vec<f64>,
    initial_length: f64,
}

impl<'a> Writer<'a> {
    fn new(
        plan: &'a Plan,
        model: &'a Model,
        boundary: &'a Boundary,
        limits: &Limits,
        recipe: &str,
    ) -> Result<Writer<'a>, RunError> {
        let csv_path = plan.folder.join(HISTORY_FILE);
        let csv = File::options().create(true).append(true).open(&csv_path);
        let csv = csv.map_err(|source| file_error("create", &csv_path, source))?;
        let crack_lengths = crack_lengths(model, limits);
        let severed = model
            .intact
            .iter()
            .zip(&crack_lengths)
            .filter(|(intact, _)| !**intact);
        let initial_length = severed.map(|(_, length)| length).sum();
        let recipe = stamp::hash(recipe.as_bytes());
        Ok(Writer {
            plan,
            model,
            boundary,
            recipe,
            history: Vec::new(),
            frames: Vec::new(),
            csv,
            csv_path,
            crack_lengths,
            initial_length,
        })
    }

    /// State and last response of the checkpoint, if it is of this recipe; history and frames go on
    /// from there.
    fn resume(&mut self) -> Result<Option<(State, Solution)>, RunError> {
        let bytes = fs::read(self.plan.folder.join(CHECKPOINT_FILE)).unwrap_or_default();
        let stored: Option<Checkpoint> = postcard::from_bytes(&bytes).ok();
        let has_frame = |&step: &usize| self.plan.folder.join(frame_file(step)).is_file();
        let stored = stored.filter(|checkpoint| {
            checkpoint.recipe == self.recipe && checkpoint.frames.iter().all(has_frame)
        });
        let mut text = format!("{HEADER}\n");
        if let Some(checkpoint) = &stored {
            self.history.clone_from(&checkpoint.history);
            self.frames.clone_from(&checkpoint.frames);
            self.history
                .iter()
                .for_each(|line| text += &format!("{}\n", line.csv()));
        } else {
            forget_frames(&self.plan.folder)?;
            let folder = self.plan.folder.join(FRAMES_FOLDER);
            fs::create_dir_all(&folder).map_err(|source| file_error("create", &folder, source))?;
        }
        write_whole(&self.csv_path, text.as_bytes())?;
        let csv = File::options().append(true).open(&self.csv_path);
        self.csv = csv.map_err(|source| file_error("write", &self.csv_path, source))?;
        Ok(stored.map(|checkpoint| (checkpoint.state(), checkpoint.unit())))
    }

    fn step(&mut self, state: &State, record: Record, unit: &Solution) -> Result<(), RunError> {
        let first_break = record.broken > 0 && self.history.iter().all(|l| l.bonds_broken == 0);
        let line = self.line(state, record, unit);
        self.history.push(line);
        writeln!(self.csv, "{}", line.csv())
            .map_err(|source| file_error("write", &self.csv_path, source))?;
        if first_break || state.step.is_multiple_of(self.plan.output.every) {
            self.frame(state)?;
        }
        self.checkpoint(state, unit)
    }

    fn line(&self, state: &State, record: Record, unit: &Solution) -> Line {
        let prescribed = self.boundary.prescribed.values();
        let largest = prescribed.map(|(value, _)| value.abs()).fold(0.0, f64::max);
        let resultants = group_reactions(self.boundary, unit);
        let resultants = resultants.values().map(|[x, y]| x.hypot(*y));
        let broken = self
            .model
            .intact
            .iter()
            .zip(&state.intact)
            .zip(&self.crack_lengths);
        let grown = broken.filter(|((before, now), _)| **before && !**now);
        Line {
            step: state.step,
            load_factor: state.load_factor,
            grip_displacement: state.load_factor * largest,
            reaction: state.load_factor * resultants.fold(0.0, f64::max),
            elastic_energy: state.energy.elastic,
            dissipated_energy: state.energy.dissipated,
            external_work: state.energy.external,
            bonds_broken: record.broken,
            bonds_broken_total: state.broken(self.model),
            passes: record.passes,
            residual: record.residual,
            crack_length: self.initial_length + grown.map(|(_, length)| length).sum::<f64>(),
        }
    }

    fn frame(&mut self, state: &State) -> Result<(), RunError> {
        if self.frames.last() == Some(&state.step) {
            return Ok(());
        }
        let frame = Frame {
            step: state.step,
            load_factor: state.load_factor,
            displacement: state.displacement.clone(),
            intact: state.intact.clone(),
        };
        self.frames.push(state.step);
        let path = self.plan.folder.join(frame_file(state.step));
        Ok(write_whole(&path, &encode(&frame))?)
    }

    fn checkpoint(&self, state: &State, unit: &Solution) -> Result<(), RunError> {
        let Energy {
            external,
            elastic,
            dissipated,
            force,
        } = state.energy;
        let checkpoint = Checkpoint {
            recipe: self.recipe.clone(),
            step: state.step,
            load_factor: state.load_factor,
            displacement: state.displacement.clone(),
            intact: state.intact.clone(),
            fragments: state.fragments.clone(),
            mechanisms: state.mechanisms.clone(),
            energy: [external, elastic, dissipated, force],
            peak_force: state.peak_force,
            just_broken: state.just_broken.clone(),
            reaction: unit.reaction.clone(),
            residual: unit.residual,
            size: [
                unit.size.dofs,
                unit.size.stiffness_entries,
                unit.size.factor_entries,
            ],
            history: self.history.clone(),
            frames: self.frames.clone(),
        };
        Ok(write_whole(
            &self.plan.folder.join(CHECKPOINT_FILE),
            &encode(&checkpoint),
        )?)
    }

    fn finish(self, state: &State, unit: Solution, ending: Ending) -> Result<Fractured, RunError> {
        let scaled = |r: &[f64; 2]| r.map(|r| state.load_factor * r);
        Ok(Fractured {
            history: self.history,
            frames: self.frames,
            ending,
            intact: state.intact.clone(),
            solution: Solution {
                displacement: state.displacement.clone(),
                reaction: unit.reaction.iter().map(scaled).collect(),
                ..unit
            },
        })
    }
}

/// An interrupted run cannot go on from here.
pub(super) fn forget_checkpoint(folder: &Path) -> Result<(), RunError> {
    let path = folder.join(CHECKPOINT_FILE);
    remove(&partial_name(&path))?;
    remove(&path)
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
        let region = model.region_of_spring(spring);
        let points = region.and_then(|r| model.points.iter().find(|p| p.region == r));
        let breakable = limits.of(spring).tension.is_finite();
        if let (true, Some(points)) = (breakable, points) {
            let xi = model.springs.length(spring, &model.positions);
            // The critical stretch cancels.
            let stiffness = model.bond_share(spring) * model.springs.stiffness[spring];
            let energy = 0.5 * stiffness * xi * xi;
            let rate = points.micromodulus.c0 * points.micromodulus.third_moment();
            *length = energy / (rate * model.settings.thickness);
        }
    }
    lengths
}

fn encode(value: &impl Serialize) -> Vec<u8> {
    postcard::to_stdvec(value).expect("plain data in memory can be encoded")
}
