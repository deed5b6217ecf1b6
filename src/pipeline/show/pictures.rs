//! The pictures of a run: which there are, and how each is drawn into the results.

use super::charts::{energies, load_displacement};
use super::damage_picture::damage_picture;
use super::deformed::Deformed;
use super::maps::{Measure, displacement_map, stress_map};
use super::mesh_picture::mesh_picture;
use super::results::Outcome;
use crate::output::picture::{Composition, PictureError};
use crate::output::write_whole;
use crate::pipeline::account::written_file::WrittenFile;
use crate::pipeline::error::ResultsError;
use crate::pipeline::error::RunError;
use crate::pipeline::read::spec::{Format, PictureKind};
use crate::pipeline::record::events;
use crate::pipeline::record::frames::{Frame, read_frame};
use crate::pipeline::record::solved::FractureRun;
use crate::trace::Trace;
use std::borrow::Cow;
use std::path::Path;

/// A picture of the results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ResultPicture {
    Mesh,
    /// A component of the displacement; of a fracture run at the peak.
    Displacement(usize),
    /// A stress of that state.
    Stress(Measure),
    /// Damage of the last state.
    Damage,
    /// At a step that the pipeline names.
    DamageAt(usize),
    LoadDisplacement,
    Energies,
}

impl ResultPicture {
    pub fn file(self, format: Format) -> String {
        let stem = match self {
            ResultPicture::Mesh => "mesh".to_owned(),
            ResultPicture::Displacement(axis) => format!("displacement_{}", ['x', 'y'][axis]),
            ResultPicture::Stress(measure) => measure.stem().to_owned(),
            ResultPicture::Damage => "damage".to_owned(),
            ResultPicture::DamageAt(step) => format!("damage_{step:06}"),
            ResultPicture::LoadDisplacement => "load_displacement".to_owned(),
            ResultPicture::Energies => "energies".to_owned(),
        };
        match format {
            Format::Png => stem + ".png",
            Format::Svg => stem + ".svg",
            Format::Pdf => stem + ".pdf",
        }
    }

    /// Caption in a report.
    pub fn describe(self) -> String {
        match self {
            ResultPicture::Mesh => "Mesh and regions".to_owned(),
            ResultPicture::Displacement(axis) => format!("Displacement u_{}", ['x', 'y'][axis]),
            ResultPicture::Stress(measure) => measure.describe().to_owned(),
            ResultPicture::Damage => "Damage at the end".to_owned(),
            ResultPicture::DamageAt(step) => format!("Damage at step {step}"),
            ResultPicture::LoadDisplacement => "Reaction over displacement".to_owned(),
            ResultPicture::Energies => "Energies".to_owned(),
        }
    }
}

impl From<PictureKind> for ResultPicture {
    fn from(kind: PictureKind) -> ResultPicture {
        match kind {
            PictureKind::Mesh => ResultPicture::Mesh,
            PictureKind::DisplacementX => ResultPicture::Displacement(0),
            PictureKind::DisplacementY => ResultPicture::Displacement(1),
            PictureKind::StressXx => ResultPicture::Stress(Measure::Xx),
            PictureKind::StressYy => ResultPicture::Stress(Measure::Yy),
            PictureKind::StressXy => ResultPicture::Stress(Measure::Xy),
            PictureKind::PrincipalStress => ResultPicture::Stress(Measure::Principal),
            PictureKind::VonMises => ResultPicture::Stress(Measure::VonMises),
            PictureKind::Damage => ResultPicture::Damage,
            PictureKind::LoadDisplacement => ResultPicture::LoadDisplacement,
            PictureKind::Energies => ResultPicture::Energies,
        }
    }
}

impl Outcome<'_> {
    /// The pictures that there are, in the order in which they are listed.
    pub(crate) fn result_pictures(&self) -> Vec<ResultPicture> {
        let course = self.solved.fracture.as_ref();
        let mut result_pictures = Vec::new();
        for kind in self.plan.output.pictures.kinds() {
            let is_there = match kind {
                PictureKind::Damage => self.has_damage(),
                PictureKind::LoadDisplacement | PictureKind::Energies => course.is_some(),
                _ => true,
            };
            result_pictures.extend(is_there.then(|| ResultPicture::from(kind)));
        }
        // The steps follow the end.
        let pictured = course.map_or_else(Vec::new, |course| self.pictured(course));
        if let Some(damage) = result_pictures
            .iter()
            .position(|picture| *picture == ResultPicture::Damage)
        {
            let pictured = pictured.into_iter().map(ResultPicture::DamageAt);
            result_pictures.splice(damage + 1..damage + 1, pictured);
        }
        result_pictures
    }

    /// Draws one into `folder`, in each format.
    pub(crate) fn draw(
        &self,
        picture: ResultPicture,
        formats: &[Format],
        folder: &Path,
        trace: &Trace,
    ) -> Result<Vec<WrittenFile>, RunError> {
        // What the first file takes includes what is drawn.
        let mut drawn = None;
        let mut made = Vec::new();
        for &format in formats {
            let one = WrittenFile::measured(picture.file(format), trace, |file| {
                let composition = match drawn.take() {
                    Some(composition) => composition,
                    None => self.compose(picture)?,
                };
                let bytes = put(&composition, format, &folder.join(file));
                drawn = Some(composition);
                Ok::<_, RunError>(bytes.map_err(ResultsError::from)?)
            });
            made.push(one?);
        }
        Ok(made)
    }

    pub(super) fn compose(&self, picture: ResultPicture) -> Result<Composition, RunError> {
        let Outcome {
            plan,
            model,
            solved,
            ..
        } = self;
        let course = solved.fracture.as_ref();
        let last = course.and_then(|course| course.history.last());
        let last_step = last.map(|line| line.step);
        let u = &solved.solution.displacement;
        let composition = match (picture, course) {
            (ResultPicture::LoadDisplacement, Some(course)) => {
                load_displacement(plan, course, self.unit_load()).compose()
            }
            (ResultPicture::Energies, Some(course)) => energies(plan, course).compose(),
            (ResultPicture::Displacement(axis), _) => {
                let frame = self.most_loaded()?;
                let step = course.map(|_| frame.step);
                displacement_map(plan, model, axis, step, &frame.displacement).compose()
            }
            (ResultPicture::Stress(measure), _) => {
                let frame = self.most_loaded()?;
                let step = course.map(|_| frame.step);
                stress_map(plan, model, measure, step, &frame).compose()
            }
            (ResultPicture::Damage, _) => {
                let body = Deformed::new(plan, model, u);
                damage_picture(plan, &body, last_step, &solved.integrity.to_vec()).compose()
            }
            (ResultPicture::DamageAt(step), _) => {
                let frame = read_frame(&plan.folder, model, step)?;
                let body = Deformed::new(plan, model, &frame.displacement);
                damage_picture(plan, &body, Some(step), &frame.integrity.to_vec()).compose()
            }
            (
                ResultPicture::Mesh | ResultPicture::LoadDisplacement | ResultPicture::Energies,
                _,
            ) => mesh_picture(plan, model).compose(),
        };
        Ok(composition.map_err(ResultsError::from)?)
    }

    /// The state that is mapped: when a body has come apart, it carries nothing.
    fn most_loaded(&self) -> Result<Frame, RunError> {
        let solved = self.solved;
        let peak = solved.fracture.as_ref().and_then(|course| {
            let peak = events::peak(&course.history);
            peak.filter(|line| course.frames.contains(&line.step))
        });
        match peak {
            Some(peak) => read_frame(&self.plan.folder, self.model, peak.step),
            None => Ok(Frame {
                step: 0,
                load_factor: 1.0,
                displacement: solved.solution.displacement.clone(),
                integrity: solved.integrity.clone(),
            }),
        }
    }

    /// The steps of `output.pictures_at` that the run has come to.
    fn pictured(&self, course: &FractureRun) -> Vec<usize> {
        let wanted = |step: &usize| self.plan.output.pictures_at.contains(step);
        course.frames.iter().copied().filter(wanted).collect()
    }

    /// A note about steps in `output.pictures_at` that the run has not reached.
    pub(crate) fn missing_pictures(&self) -> Option<String> {
        let course = self.solved.fracture.as_ref();
        let frames = course.map_or(&[][..], |course| &course.frames);
        let output = &self.plan.output;
        let missing = output.pictures_at.iter().filter(|s| !frames.contains(s));
        let missing: Vec<String> = missing.map(ToString::to_string).collect();
        if !output.pictures.wants(PictureKind::Damage) || missing.is_empty() {
            return None;
        }
        let end = match course.and_then(|course| course.history.last()) {
            Some(line) => format!("the run ended with step {}", line.step),
            None => "without `loading` there are no steps".to_owned(),
        };
        let missing = missing.join(", ");
        Some(format!(
            "output.pictures_at: no picture of step {missing}: {end}"
        ))
    }
}

/// Writes a picture; gives the bytes of its pixels and of the file.
pub(crate) fn put(
    composition: &Composition,
    format: Format,
    path: &Path,
) -> Result<[u64; 2], PictureError> {
    let bytes: Cow<[u8]> = match format {
        Format::Png => composition.picture().to_png()?.into(),
        Format::Svg => composition.svg()?.into_bytes().into(),
        Format::Pdf => composition.pdf().into(),
    };
    write_whole(path, &bytes)?;
    let [width, height] = composition.size().map(u64::from);
    Ok([3 * width * height, bytes.len() as u64])
}
