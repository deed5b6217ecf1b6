//! The output stage's files, written on all threads; their order and their bytes do not depend on those.

use super::parts::{PartKind, Parts};
use super::results::Outcome;
use super::view::VIEW_FILE;
use crate::output::{pvd, write_whole};
use crate::pipeline::account::written_file::WrittenFile;
use crate::pipeline::error::ResultsError;
use crate::pipeline::error::RunError;
use crate::pipeline::record::frames::{Frame, read_frame};
use crate::trace::Trace;
use rayon::prelude::*;
use std::path::Path;

pub(crate) struct OutputFiles<'a> {
    pub outcome: &'a Outcome<'a>,
    /// Folder of the files.
    pub folder: &'a Path,
    pub trace: Trace,
}

/// Moments are written side by side until they take so much memory [bytes].
const MEMORY: usize = 1 << 28;

impl OutputFiles<'_> {
    /// One set of parts, or one for each frame of a fracture run; and the series.
    pub fn parts(&self) -> Result<Vec<WrittenFile>, RunError> {
        let parts = self.outcome.parts();
        let steps: Vec<Option<usize>> = match &self.outcome.solved.fracture {
            None => vec![None],
            Some(course) => course.frames.iter().copied().map(Some).collect(),
        };
        let mut made = Vec::new();
        for some in steps.chunks((MEMORY / parts.memory().max(1)).max(1)) {
            let of_step = |&step: &Option<usize>| self.parts_of(&parts, step);
            made.extend(in_order(some.par_iter().map(of_step))?);
        }
        let mut made: Vec<WrittenFile> = made.into_iter().flatten().collect();
        made.push(self.series(&parts, &steps)?);
        Ok(made)
    }

    fn parts_of(&self, parts: &Parts, step: Option<usize>) -> Result<Vec<WrittenFile>, RunError> {
        let kinds = parts.kinds();
        let frame = self.frame(step)?;
        let write = |&kind: &PartKind| parts.write(kind, &frame, step, self.folder, &self.trace);
        Ok(in_order(kinds.par_iter().map(write))?)
    }

    fn frame(&self, step: Option<usize>) -> Result<Frame, RunError> {
        let Outcome {
            plan,
            model,
            solved,
            ..
        } = self.outcome;
        match step {
            Some(step) => read_frame(&plan.folder, model, step),
            None => Ok(Frame {
                step: 0,
                load_factor: 1.0,
                displacement: solved.solution.displacement.clone(),
                integrity: solved.integrity.clone(),
            }),
        }
    }

    fn series(&self, parts: &Parts, steps: &[Option<usize>]) -> Result<WrittenFile, ResultsError> {
        let entries: Vec<pvd::Entry> = steps.iter().flat_map(|&s| parts.entries(s)).collect();
        let name = format!("{}.pvd", self.outcome.plan.name);
        WrittenFile::measured(name, &self.trace, |name| {
            let xml = pvd::to_xml(&entries)?;
            write_whole(&self.folder.join(name), xml.as_bytes())?;
            Ok([xml.len() as u64; 2])
        })
    }

    /// The script that shows the parts.
    pub fn view(&self) -> Result<WrittenFile, ResultsError> {
        WrittenFile::measured(VIEW_FILE.to_owned(), &self.trace, |name| {
            let text = self.outcome.view();
            write_whole(&self.folder.join(name), text.as_bytes())?;
            Ok([text.len() as u64; 2])
        })
    }

    /// The pictures that there are to make.
    pub fn pictures(&self) -> Result<Vec<WrittenFile>, RunError> {
        let result_pictures = self.outcome.result_pictures();
        let formats = self.outcome.plan.output.formats();
        let draw = |&picture| {
            self.outcome
                .draw(picture, &formats, self.folder, &self.trace)
        };
        let made = in_order(result_pictures.par_iter().map(draw))?;
        Ok(made.into_iter().flatten().collect())
    }
}

/// All results, or the first error in their order, not in time.
fn in_order<T: Send, E: Send>(
    results: impl IndexedParallelIterator<Item = Result<T, E>>,
) -> Result<Vec<T>, E> {
    let results: Vec<Result<T, E>> = results.collect();
    results.into_iter().collect()
}
