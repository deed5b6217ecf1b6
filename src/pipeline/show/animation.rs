//! The damage of a fracture run's frames, picture after picture on one page and one scale: the film, and
//! what the report's slider moves through.

use super::damage_picture::damage_picture;
use super::deformed::{Deformed, visible_exaggeration};
use crate::model::Model;
use crate::output::animation::{self, Still};
use crate::output::picture::{Composition, FieldPicture};
use crate::output::write_whole;
use crate::pipeline::account::written_file::WrittenFile;
use crate::pipeline::error::ResultsError;
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::Plan;
use crate::pipeline::record::frames::{Frame, read_frame};
use crate::pipeline::record::solved::FractureRun;
use crate::trace::Trace;
use rayon::prelude::*;
use std::path::Path;

pub(crate) const FILM_FILE: &str = "crack.gif";

/// So many pictures show a crack grow; more make the file large.
const MOST: usize = 40;
/// Against a picture's own pixels: for a screen.
const ZOOM: f64 = 0.5;

/// The pictures of some frames.
pub(crate) struct AnimationFrames {
    pub steps: Vec<usize>,
    pub stills: Vec<Still>,
}

impl AnimationFrames {
    /// # Errors
    /// A frame that cannot be read.
    pub fn new(
        plan: &Plan,
        model: &Model,
        course: &FractureRun,
    ) -> Result<AnimationFrames, RunError> {
        let steps = chosen(course);
        let read = |&step: &usize| read_frame(&plan.folder, model, step);
        let view = View::of(plan, model, steps.iter().map(read))?;
        let picture = |frame: &Frame| {
            let body = Deformed::by(view.exaggeration, model, &frame.displacement);
            FieldPicture {
                in_view: view.bounds.to_vec(),
                ..damage_picture(plan, &body, Some(frame.step), &frame.integrity.to_vec())
            }
        };
        let last = steps.last().map(read).transpose()?;
        let Some(last) = last else {
            return Ok(AnimationFrames {
                steps,
                stills: Vec::new(),
            });
        };
        // The page of the last one, whose step has the most digits.
        let page = picture(&last).compose().map_err(ResultsError::from)?;
        let still = |step: &usize| {
            let frame = read(step)?;
            let drawn: Result<Composition, _> = picture(&frame).compose_like(&page);
            let drawn = drawn.map_err(ResultsError::from)?;
            Ok(Still::of(&drawn.zoomed(ZOOM)))
        };
        let stills: Vec<Result<Still, RunError>> = steps.par_iter().map(still).collect();
        let stills: Result<Vec<Still>, RunError> = stills.into_iter().collect();
        Ok(AnimationFrames {
            steps,
            stills: stills?,
        })
    }

    /// Writes the film into `folder`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn film(&self, folder: &Path, trace: &Trace) -> Result<WrittenFile, ResultsError> {
        WrittenFile::measured(FILM_FILE.to_owned(), trace, |file| {
            let bytes = animation::film(&self.stills)?;
            write_whole(&folder.join(file), &bytes)?;
            let pixels: usize = self.stills.iter().map(|still| still.indices.len()).sum();
            Ok([pixels as u64, bytes.len() as u64])
        })
    }
}

/// The frames from the last one before the first break on, evenly thinned out; the last one always.
fn chosen(course: &FractureRun) -> Vec<usize> {
    let broken = course.history.iter().find(|line| line.bonds_broken > 0);
    let first = broken.map_or(usize::MAX, |line| line.step);
    let begin = course.frames.iter().rposition(|&step| step < first);
    thinned(&course.frames[begin.unwrap_or(0)..], MOST)
}

/// At most `most` of `steps`, the first and the last among them.
fn thinned(steps: &[usize], most: usize) -> Vec<usize> {
    if steps.len() <= most {
        return steps.to_vec();
    }
    let place = |k: usize| k * (steps.len() - 1) / (most - 1);
    (0..most).map(|k| steps[place(k)]).collect()
}

/// Scale and bounds that all pictures share.
struct View {
    exaggeration: Option<f64>,
    /// Corners of the box around all of them [m].
    bounds: [[f64; 2]; 2],
}

impl View {
    /// In one pass over the frames: the box is that of the largest displacements to each side, whatever
    /// their node.
    fn of(
        plan: &Plan,
        model: &Model,
        frames: impl Iterator<Item = Result<Frame, RunError>>,
    ) -> Result<View, RunError> {
        let node_count = model.node_count();
        let mut extremes = vec![[[0.0_f64; 2]; 2]; node_count];
        let mut largest = [0.0_f64; 2];
        for frame in frames {
            for (u, [low, high]) in frame?.displacement.iter().zip(&mut extremes) {
                for k in [0, 1] {
                    low[k] = low[k].min(u[k]);
                    high[k] = high[k].max(u[k]);
                }
                if u[0].hypot(u[1]) > largest[0].hypot(largest[1]) {
                    largest = *u;
                }
            }
        }
        let exaggeration = visible_exaggeration(plan, model, std::iter::once(largest));
        let scale = exaggeration.unwrap_or(0.0);
        let mut bounds = model.bounds();
        for (x, [low, high]) in model.positions.iter().zip(&extremes) {
            for k in [0, 1] {
                bounds[0][k] = bounds[0][k].min(x[k] + scale * low[k]);
                bounds[1][k] = bounds[1][k].max(x[k] + scale * high[k]);
            }
        }
        Ok(View {
            exaggeration,
            bounds,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinned_steps_keep_both_ends() {
        let steps: Vec<usize> = (100..300).collect();
        let few = thinned(&steps, 40);
        assert_eq!([few.len(), few[0], few[39]], [40, 100, 299]);
        assert!(
            few.windows(2)
                .all(|pair| (4..=7).contains(&(pair[1] - pair[0])))
        );
        assert_eq!(thinned(&steps[..7], 40), steps[..7]);
    }
}
