//! The files of a run in `results/NAME/`: VTU parts and their PVD, pictures.

use super::animation::AnimationFrames;
use super::output_files::OutputFiles;
use super::parts::{Parts, has_damage};
use crate::boundary::Boundary;
use crate::gmsh::Extract;
use crate::model::Model;
use crate::phases::measure;
use crate::pipeline::account::written_file::WrittenFile;
use crate::pipeline::error::RunError;
use crate::pipeline::read::plan::Plan;
use crate::pipeline::record::solved::Solved;
use crate::trace::Trace;
use std::path::Path;

/// All that the results are made of.
pub struct Outcome<'a> {
    pub plan: &'a Plan,
    pub model: &'a Model,
    pub boundary: &'a Boundary,
    pub solved: &'a Solved,
    /// The source of the mesh.
    pub extract: &'a Extract,
}

impl Outcome<'_> {
    /// Writes everything but the summary and the report into `folder`, and returns its files and the
    /// pictures that the report moves through.
    ///
    /// # Errors
    /// See [`ResultsError`].
    pub(crate) fn write(
        &self,
        folder: &Path,
        trace: &Trace,
    ) -> Result<(Vec<WrittenFile>, Option<AnimationFrames>), RunError> {
        let files = OutputFiles {
            outcome: self,
            folder,
            trace: trace.clone(),
        };
        let mut made = measure("vtu", || files.parts())?;
        made.push(files.view()?);
        if !self.plan.output.pictures.is_none() {
            made.extend(measure("pictures", || files.pictures())?);
        }
        let output = &self.plan.output;
        let is_shown = output.is_animated() || output.is_reported();
        let Some(course) = self.solved.fracture.as_ref().filter(|_| is_shown) else {
            return Ok((made, None));
        };
        let draw = || AnimationFrames::new(self.plan, self.model, course);
        let animation = measure("animation", draw)?;
        if output.is_animated() {
            let film = || animation.film(folder, &files.trace);
            made.push(measure("animation", film)?);
        }
        Ok((made, Some(animation)))
    }

    pub(crate) fn parts(&self) -> Parts<'_> {
        Parts {
            plan: self.plan,
            model: self.model,
        }
    }

    pub(crate) fn has_damage(&self) -> bool {
        has_damage(self.plan)
    }
}

/// The names of the regions that one lattice covers.
pub(crate) fn lattice_name(model: &Model, points: &crate::model::PointRegion) -> String {
    let members = model.members(points.region);
    let names: Vec<&str> = members.map(|r| model.regions[r].name.as_str()).collect();
    names.join("+")
}
