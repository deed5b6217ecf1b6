//! The record of a step of a fracture run, on its way to the thread that writes it.

use super::journal::RunJournal;
use crate::fracture::control::{Ending, Record};
use crate::fracture::earlier;
use crate::fracture::response::Response;
use crate::fracture::state::State;
use crate::phases::measure;
use crate::pipeline::error::RunError;
use crate::pipeline::read::spec::Output;
use crate::pipeline::record::solved::{FractureRun, Solved};
use crate::pipeline::record::sparse_integrity::SparseIntegrity;
use crate::pipeline::record::writer::{RecordWriter, StepRecord, WrittenRecord};
use crate::pipeline::show::live_picture::LivePicture;
use crate::pipeline::stages::course_warnings;
use crate::statics::{Solution, Solver};

/// Hands history, frames and checkpoints over to the thread that writes them.
pub(super) struct Recorder<'a, 'scope> {
    pub journal: RunJournal<'a>,
    /// Until it meets an error, or the end.
    writer: Option<RecordWriter<'scope>>,
    picture: LivePicture<'scope, 'a>,
}

/// The phase of copying a state and of waiting for room in the queue.
pub(super) const HAND_OVER: &str = "hand over";

impl<'a, 'scope> Recorder<'a, 'scope> {
    pub fn new(
        journal: RunJournal<'a>,
        writer: RecordWriter<'scope>,
        picture: LivePicture<'scope, 'a>,
    ) -> Recorder<'a, 'scope> {
        Recorder {
            journal,
            writer: Some(writer),
            picture,
        }
    }

    /// The state before the first step.
    pub fn begin(&mut self, state: &State) -> Result<(), RunError> {
        let frame = self.journal.frame(state);
        let checkpoint = Some(self.journal.checkpoint(state));
        self.give(StepRecord {
            line: None,
            frame,
            checkpoint,
        })
    }

    pub fn step(
        &mut self,
        state: &State,
        record: &Record,
        response: &Response,
    ) -> Result<(), RunError> {
        let RunJournal { plan, problem, .. } = self.journal;
        let first_break = record.changed > 0 && state.changes.len() == record.changed;
        let line = self.journal.line(state, record, response);
        self.journal.history.push(line.clone());
        let Output {
            every, pictures_at, ..
        } = &plan.output;
        let is_pictured = pictures_at.contains(&state.step);
        let wants_frame = first_break || is_pictured || state.step.is_multiple_of(*every);
        let settled = wants_frame.then(|| state.settled(problem, response));
        let frame = settled.and_then(|state| self.journal.frame(&state));
        let checkpoint = response
            .is_reproducible(state)
            .then(|| self.journal.checkpoint(state));
        self.give(StepRecord {
            line: Some((self.journal.csv(&line), line)),
            frame,
            checkpoint,
        })?;
        self.picture.update(state);
        Ok(())
    }

    /// The state after the last step, and that of the largest load, which is known only now.
    pub fn end(&mut self, state: &State) -> Result<(), RunError> {
        let mut frames = Vec::from_iter(self.journal.frame(state));
        // A run that has come to its end is none the worse for a frame that cannot be found.
        if let Some(moment) = self.journal.peak_without_frame()
            && let Ok(peak) = earlier::state_at(self.journal.problem, state, &moment)
        {
            frames.push(self.journal.earlier_frame(&peak));
        }
        frames.into_iter().try_for_each(|frame| {
            self.give(StepRecord {
                frame: Some(frame),
                ..StepRecord::default()
            })
        })
    }

    pub fn give(&mut self, order: StepRecord) -> Result<(), RunError> {
        let writer = self.writer.take_if(|writer| !writer.give(order));
        writer.map_or(Ok(()), |writer| writer.finish().map(|_| ()))
    }

    pub fn finish(
        self,
        state: &State,
        ending: Ending,
    ) -> Result<(Solved, WrittenRecord), RunError> {
        let Recorder {
            journal, writer, ..
        } = self;
        let model = journal.problem.model;
        let size = match state.size {
            Some(size) => size,
            // No step was possible.
            None => {
                let supports = journal.problem.programme.supports();
                Solver::new(journal.problem.model, supports)?.size()
            }
        };
        let writer = writer.expect("an error of the writer ends the run where it is met");
        let written = measure(HAND_OVER, || writer.finish())?;
        let solution = Solution {
            displacement: model.in_space(&state.displacement),
            reaction: model.in_space(&state.reaction),
            residual: state.residual,
            size,
        };
        let course = FractureRun {
            history: journal.history,
            frames: journal.frames,
            ending,
            fragments: state.fragments.iter().map(Vec::len).collect(),
            reason: state.stopped.as_ref().map(|(_, reason)| reason.clone()),
            first_broken: state.broken().first().copied(),
            force_left: (state.force.peak > 0.0).then(|| state.force.now.abs() / state.force.peak),
            warnings: course_warnings::of(journal.problem, state),
        };
        let solved = Solved {
            solution,
            integrity: SparseIntegrity::new(&state.integrity),
            fracture: Some(course),
        };
        Ok((solved, written))
    }
}
