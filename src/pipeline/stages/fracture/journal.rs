//! The record of a fracture run so far, from which an interrupted run continues.

use crate::fracture::control::{Control, Problem, Record};
use crate::fracture::crack_length::crack_lengths;
use crate::fracture::earlier::Moment;
use crate::fracture::event::Load;
use crate::fracture::response::Response;
use crate::fracture::state::State;
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::Plan;
use crate::pipeline::record::checkpoint::{Checkpoint, RecordHash};
use crate::pipeline::record::events;
use crate::pipeline::record::folder::file_error;
use crate::pipeline::record::frames::{FRAMES_FOLDER, Frame, encode, forget_frames, frame_file};
use crate::pipeline::record::history::{HistoryLine, header};
use crate::pipeline::record::stamp;
use crate::pipeline::record::writer::{begin_history, read_journal};
use std::fs;
use std::path::Path;
use std::sync::Arc;

/// The course of the run so far.
pub(super) struct RunJournal<'a> {
    pub plan: &'a Plan,
    pub problem: &'a Problem<'a>,
    recipe: String,
    pub history: Vec<HistoryLine>,
    /// Steps that have a frame.
    pub frames: Vec<usize>,
    /// Crack length that each interaction adds when it breaks [m].
    crack_lengths: Vec<f64>,
    initial_length: f64,
}

impl<'a> RunJournal<'a> {
    pub fn new(plan: &'a Plan, problem: &'a Problem<'a>, recipe: String) -> RunJournal<'a> {
        let crack_lengths = crack_lengths(problem.model, problem.laws);
        let severed = (problem.model.integrity.iter())
            .zip(&crack_lengths)
            .filter(|(phi, _)| **phi == 0.0);
        // A sum of none would be minus zero.
        let initial_length = severed.fold(0.0, |sum, (_, length)| sum + length);
        RunJournal {
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
    pub fn resume(
        &mut self,
        checkpoint: Option<Checkpoint>,
    ) -> Result<Option<(State, RecordHash)>, RunError> {
        let folder = &self.plan.folder;
        let stored = checkpoint.filter(|found| found.recipe == self.recipe);
        let stored = stored.and_then(|checkpoint| {
            let lines = read_journal(folder, checkpoint.lines)?;
            let record_hash = record_hash(folder, &lines, &checkpoint.frames)?;
            let is_whole = record_hash.close() == checkpoint.record_hash;
            (is_whole && checkpoint.fits(self.problem, &lines)).then_some((
                checkpoint,
                lines,
                record_hash,
            ))
        });
        if let Some((checkpoint, lines, _)) = &stored {
            self.history.clone_from(lines);
            self.frames.clone_from(&checkpoint.frames);
        } else {
            forget_frames(folder)?;
            let frames = folder.join(FRAMES_FOLDER);
            fs::create_dir_all(&frames).map_err(|source| file_error("create", &frames, source))?;
        }
        let mut text = header(self.problem.programme.supports(), &self.plan.probes) + "\n";
        for line in &self.history {
            text += &(self.csv(line) + "\n");
        }
        begin_history(folder, &text, &self.history)?;
        Ok(stored.map(|(checkpoint, _, record_hash)| {
            (checkpoint.into_state(self.problem.model), record_hash)
        }))
    }

    pub fn csv(&self, line: &HistoryLine) -> String {
        line.csv(&self.problem.programme.phases[line.phase].name)
    }

    pub fn checkpoint(&self, state: &State) -> Box<Checkpoint> {
        let checkpoint = Checkpoint::new(&self.recipe, state, self.history.len(), &self.frames);
        Box::new(checkpoint)
    }

    /// The frame of a state that has none yet.
    pub fn frame(&mut self, state: &State) -> Option<Arc<Frame>> {
        let is_new = self.frames.last() != Some(&state.step);
        is_new.then(|| {
            self.frames.push(state.step);
            Arc::new(Frame::new(self.problem.model, state))
        })
    }

    /// The step of the largest load, where it has no frame yet.
    pub fn peak_without_frame(&self) -> Option<Moment> {
        let line = events::peak(&self.history)?;
        if self.frames.contains(&line.step) {
            return None;
        }
        let earlier = self.history.iter().rfind(|other| other.step < line.step);
        let before = match self.problem.control {
            Control::Equilibrium { .. } => line.changes,
            Control::OnePass | Control::EventDriven => earlier.map_or(0, |line| line.changes),
        };
        Some(Moment {
            step: line.step,
            phase: line.phase,
            load: Load {
                share: line.load_share,
                factor: line.load_factor,
            },
            changes: [before, line.changes],
        })
    }

    /// The frame of an earlier state, in its place among the others.
    pub fn earlier_frame(&mut self, state: &State) -> Arc<Frame> {
        let place = self.frames.partition_point(|&step| step < state.step);
        self.frames.insert(place, state.step);
        Arc::new(Frame::new(self.problem.model, state))
    }

    pub fn line(&self, state: &State, record: &Record, response: &Response) -> HistoryLine {
        let programme = self.problem.programme;
        let values = response.values();
        let counts = [programme.phases.len(), programme.probes];
        let reactions = values.resultants(counts, state.load);
        let largest = |resultants: &[[f64; 2]]| {
            let amounts = resultants.iter().map(|[x, y]| x.hypot(*y));
            amounts.fold(0.0, f64::max)
        };
        let before = self.history.last();
        let length = before.map_or(self.initial_length, |line| line.crack_length);
        let changes = &state.changes[state.changes.len() - record.changed..];
        let grown = changes.iter().map(|change| {
            let [phi, next] = change.integrity;
            (phi - next) * self.crack_lengths[change.interaction as usize]
        });
        HistoryLine {
            step: state.step,
            phase: state.phase,
            load_factor: state.load.factor,
            envelope_load_factor: state.envelope,
            load_share: state.load.share,
            grip_displacement: programme.largest_prescribed(state.phase, state.load),
            reaction: largest(&reactions),
            breaking_reaction: largest(&record.first_pass.resultants(counts, state.load)),
            elastic_energy: state.energy.elastic,
            dissipated_energy: state.energy.dissipated,
            external_work: state.energy.external,
            bonds_broken: record.broken,
            bonds_broken_total: before.map_or(0, |line| line.bonds_broken_total) + record.broken,
            changes: state.changes.len(),
            passes: record.passes,
            residual: record.residual,
            crack_length: length + grown.fold(0.0, |sum, grown| sum + grown),
            reactions,
            probes: values.probes(programme.probes, state.load),
        }
    }
}

/// Hash of the record in the folder, if all frames are there.
fn record_hash(folder: &Path, lines: &[HistoryLine], frames: &[usize]) -> Option<RecordHash> {
    let mut record_hash = RecordHash::default();
    lines
        .iter()
        .for_each(|line| record_hash.add_line(&encode(line)));
    for &step in frames {
        record_hash.add_frame(&stamp::hash_file(&folder.join(frame_file(step)))?);
    }
    Some(record_hash)
}
