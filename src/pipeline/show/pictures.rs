//! The pictures of a run: which there are, and how each is drawn into the results.

use super::charts::{energies, load_displacement};
use super::damage_picture::damage_picture;
use super::deformed::Deformed;
use super::maps::{Measure, displacement_map, stress_map};
use super::mesh_picture::mesh_picture;
use super::results::Outcome;
use crate::output::picture::{Composition, PictureError};
use crate::output::write_whole;
use crate::pipeline::account::made::Made;
use crate::pipeline::error::ResultsError;
use crate::pipeline::error::RunError;
use crate::pipeline::read::spec::{Format, PictureKind};
use crate::pipeline::record::frames::{Frame, read_frame};
use crate::pipeline::record::solved::Course;
use crate::trace::Trace;
use std::borrow::Cow;
use std::path::Path;

/// A picture of the results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sheet {
    Mesh,
    /// A component of the displacement, of the frame with the largest reaction.
    Displacement(usize),
    /// Of that frame as well.
    Stress(Measure),
    /// Of the last state.
    Damage,
    /// At a step that the pipeline names.
    DamageAt(usize),
    LoadDisplacement,
    Energies,
}

impl Sheet {
    pub fn file(self, format: Format) -> String {
        let stem = match self {
            Sheet::Mesh => "mesh".to_owned(),
            Sheet::Displacement(axis) => format!("displacement_{}", ['x', 'y'][axis]),
            Sheet::Stress(measure) => measure.stem().to_owned(),
            Sheet::Damage => "damage".to_owned(),
            Sheet::DamageAt(step) => format!("damage_{step:06}"),
            Sheet::LoadDisplacement => "load_displacement".to_owned(),
            Sheet::Energies => "energies".to_owned(),
        };
        match format {
            Format::Png => stem + ".png",
            Format::Svg => stem + ".svg",
        }
    }

    /// What the reader of a report calls it.
    pub fn describe(self) -> String {
        match self {
            Sheet::Mesh => "Mesh and regions".to_owned(),
            Sheet::Displacement(axis) => format!("Displacement u_{}", ['x', 'y'][axis]),
            Sheet::Stress(measure) => measure.describe().to_owned(),
            Sheet::Damage => "Damage at the end".to_owned(),
            Sheet::DamageAt(step) => format!("Damage at step {step}"),
            Sheet::LoadDisplacement => "Reaction over displacement".to_owned(),
            Sheet::Energies => "Energies".to_owned(),
        }
    }
}

impl From<PictureKind> for Sheet {
    fn from(kind: PictureKind) -> Sheet {
        match kind {
            PictureKind::Mesh => Sheet::Mesh,
            PictureKind::DisplacementX => Sheet::Displacement(0),
            PictureKind::DisplacementY => Sheet::Displacement(1),
            PictureKind::StressXx => Sheet::Stress(Measure::Xx),
            PictureKind::StressYy => Sheet::Stress(Measure::Yy),
            PictureKind::StressXy => Sheet::Stress(Measure::Xy),
            PictureKind::PrincipalStress => Sheet::Stress(Measure::Principal),
            PictureKind::VonMises => Sheet::Stress(Measure::VonMises),
            PictureKind::Damage => Sheet::Damage,
            PictureKind::LoadDisplacement => Sheet::LoadDisplacement,
            PictureKind::Energies => Sheet::Energies,
        }
    }
}

impl Outcome<'_> {
    /// The pictures that there are, in the order in which they are listed.
    pub(crate) fn sheets(&self) -> Vec<Sheet> {
        let course = self.solved.fracture.as_ref();
        let mut sheets = Vec::new();
        for kind in self.plan.output.pictures.kinds() {
            let is_there = match kind {
                PictureKind::Damage => self.has_damage(),
                PictureKind::LoadDisplacement | PictureKind::Energies => course.is_some(),
                _ => true,
            };
            sheets.extend(is_there.then(|| Sheet::from(kind)));
        }
        // The steps follow the end.
        let pictured = course.map_or_else(Vec::new, |course| self.pictured(course));
        if let Some(damage) = sheets.iter().position(|sheet| *sheet == Sheet::Damage) {
            let pictured = pictured.into_iter().map(Sheet::DamageAt);
            sheets.splice(damage + 1..damage + 1, pictured);
        }
        sheets
    }

    /// Draws one into `folder`, in each format.
    pub(crate) fn draw(
        &self,
        sheet: Sheet,
        formats: &[Format],
        folder: &Path,
        trace: &Trace,
    ) -> Result<Vec<Made>, RunError> {
        // What the first file takes includes what is drawn.
        let mut drawn = None;
        let mut made = Vec::new();
        for &format in formats {
            let one = Made::measured(sheet.file(format), trace, |file| {
                let composition = match drawn.take() {
                    Some(composition) => composition,
                    None => self.compose(sheet)?,
                };
                let bytes = put(&composition, format, &folder.join(file));
                drawn = Some(composition);
                Ok::<_, RunError>(bytes.map_err(ResultsError::from)?)
            });
            made.push(one?);
        }
        Ok(made)
    }

    fn compose(&self, sheet: Sheet) -> Result<Composition, RunError> {
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
        let composition = match (sheet, course) {
            (Sheet::LoadDisplacement, Some(course)) => load_displacement(plan, course).compose(),
            (Sheet::Energies, Some(course)) => energies(plan, course).compose(),
            (Sheet::Displacement(axis), _) => {
                let frame = self.most_loaded()?;
                let step = course.map(|_| frame.step);
                displacement_map(plan, model, axis, step, &frame.displacement).compose()
            }
            (Sheet::Stress(measure), _) => {
                let frame = self.most_loaded()?;
                let step = course.map(|_| frame.step);
                stress_map(plan, model, measure, step, &frame).compose()
            }
            (Sheet::Damage, _) => {
                let body = Deformed::new(model, u);
                damage_picture(plan, &body, last_step, &solved.integrity.to_vec()).compose()
            }
            (Sheet::DamageAt(step), _) => {
                let frame = read_frame(&plan.folder, model, step)?;
                let body = Deformed::new(model, &frame.displacement);
                damage_picture(plan, &body, Some(step), &frame.integrity.to_vec()).compose()
            }
            (Sheet::Mesh | Sheet::LoadDisplacement | Sheet::Energies, _) => {
                mesh_picture(plan, model).compose()
            }
        };
        Ok(composition.map_err(ResultsError::from)?)
    }

    /// The state that is mapped: when a body has come apart, it carries nothing.
    fn most_loaded(&self) -> Result<Frame, RunError> {
        let solved = self.solved;
        match solved.fracture.as_ref().and_then(most_loaded_step) {
            Some(step) => read_frame(&self.plan.folder, self.model, step),
            None => Ok(Frame {
                step: 0,
                load_factor: 1.0,
                displacement: solved.solution.displacement.clone(),
                integrity: solved.integrity.clone(),
            }),
        }
    }

    /// The steps of `output.pictures_at` that the run has come to.
    fn pictured(&self, course: &Course) -> Vec<usize> {
        let wanted = |step: &usize| self.plan.output.pictures_at.contains(step);
        course.frames.iter().copied().filter(wanted).collect()
    }

    /// What to say of steps in `output.pictures_at` that the run has not come to.
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

/// Of the steps with a frame that with the largest reaction.
fn most_loaded_step(course: &Course) -> Option<usize> {
    let framed =
        |line: &&crate::pipeline::record::history::Line| course.frames.contains(&line.step);
    let lines = course.history.iter().filter(framed);
    let most = lines.max_by(|a, b| a.reaction.total_cmp(&b.reaction));
    most.map(|line| line.step)
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
    };
    write_whole(path, &bytes)?;
    let [width, height] = composition.size().map(u64::from);
    Ok([3 * width * height, bytes.len() as u64])
}
