//! `report.html`: a run on one page. Times and memory, which differ from run to run, stay in `summary.json`:
//! the same run gives the same page.

mod numbers;
mod page;

use super::animation::AnimationFrames;
use super::charts::load_displacement;
use super::pictures::ResultPicture;
use super::results::Outcome;
use crate::output::number::quantity;
use crate::output::write_whole;
use crate::pipeline::account::summary::Summary;
use crate::pipeline::account::written_file::WrittenFile;
use crate::pipeline::error::ResultsError;
use crate::pipeline::error::RunError;
use crate::pipeline::read::spec::Format;
use crate::pipeline::record::events;
use crate::pipeline::record::folder::file_error;
use crate::pipeline::record::history::HistoryLine;
use numbers::{headline, numbers};
use page::{Figure, FramePicture, HistoryPoint, Input, Report};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

pub const REPORT_FILE: &str = "report.html";

/// A larger `.geo` is named, not shown [bytes].
const LARGEST_SCRIPT: u64 = 200_000;
/// The slider's pictures together, before they become text [bytes].
const MOST_FRAMES: usize = 2_500_000;
/// Points of the chart that can be pointed at.
const MOST_POINTS: usize = 1000;
/// Keys of the summary that differ from run to run, or have a place of their own.
const LEFT_OUT: [&str; 10] = [
    "warnings",
    "pipeline",
    "phases",
    "seconds",
    "behind",
    "written",
    "memory",
    "peak_memory_bytes",
    "files",
    "frames",
];

impl Outcome<'_> {
    /// Writes the page into `folder`, where the pictures are.
    ///
    /// # Errors
    /// A file that cannot be read or written.
    pub(crate) fn report(
        &self,
        folder: &Path,
        made: &[WrittenFile],
        animation: Option<&AnimationFrames>,
        summary: &Summary,
    ) -> Result<(), RunError> {
        let report = Report {
            title: match &self.plan.study {
                Some(study) => format!("{study}: {}", self.plan.name),
                None => self.plan.name.clone(),
            },
            outcome: headline(summary),
            numbers: numbers(self.plan, summary),
            frames: match animation {
                Some(animation) => self.frames(animation)?,
                None => Vec::new(),
            },
            chart: self.chart()?,
            pictures: self.figures(folder, made)?,
            inputs: self.inputs(),
            table: table(&json!(summary)),
        };
        let html = report.to_html();
        let path = folder.join(REPORT_FILE);
        Ok(write_whole(&path, html.as_bytes())?)
    }

    fn frames(&self, animation: &AnimationFrames) -> Result<Vec<FramePicture>, RunError> {
        let course = self.solved.fracture.as_ref();
        let by_forces = course.is_some_and(|c| events::is_driven_by_forces(&c.history));
        let reaction = |line: &HistoryLine| match by_forces {
            true => String::new(),
            false => format!("reaction {}, ", quantity(line.reaction, "N")),
        };
        let mut frames = Vec::new();
        for (&step, still) in animation.steps.iter().zip(&animation.stills) {
            let png = still.to_png().map_err(ResultsError::from)?;
            let line = course.and_then(|c| c.history.iter().find(|line| line.step == step));
            let text = match line {
                Some(line) => format!(
                    "step {step}: load factor {:.4}, {}{} bonds broken",
                    line.load_factor,
                    reaction(line),
                    line.bonds_broken_total
                ),
                None => format!("step {step}: before the first load"),
            };
            frames.push(FramePicture { step, text, png });
        }
        Ok(fitting(frames))
    }

    fn chart(&self) -> Result<Option<(String, Vec<HistoryPoint>)>, RunError> {
        let Some(course) = self
            .solved
            .fracture
            .as_ref()
            .filter(|c| !c.history.is_empty())
        else {
            return Ok(None);
        };
        let chart = load_displacement(self.plan, course, self.unit_load());
        let composition = chart.compose().map_err(ResultsError::from)?;
        let svg = composition.svg().map_err(ResultsError::from)?;
        // The curve begins with the origin, where there is no step.
        let places = chart.curves.iter().take(1).flat_map(|c| &c.points).skip(1);
        let points: Vec<HistoryPoint> = course
            .history
            .iter()
            .zip(places)
            .map(|(line, &[x, y])| HistoryPoint {
                step: line.step,
                at: composition.place_of([x, y]),
                text: format!(
                    "step {}: {} = {}, {} = {}",
                    line.step,
                    chart.x.name,
                    quantity(x, &chart.x.unit),
                    chart.y.name,
                    quantity(y, &chart.y.unit)
                ),
            })
            .collect();
        let is_kept = |(index, point): &(usize, HistoryPoint)| {
            let every = points.len().div_ceil(MOST_POINTS);
            index % every == 0 || course.frames.contains(&point.step)
        };
        let kept = points.iter().cloned().enumerate().filter(is_kept);
        let kept = kept.map(|(_, point)| point).collect();
        Ok(Some((svg, kept)))
    }

    /// The pictures as they were written, or as SVG where they are only in a form that pages cannot show;
    /// those of chosen steps are the slider's business.
    fn figures(&self, folder: &Path, made: &[WrittenFile]) -> Result<Vec<Figure>, RunError> {
        let result_pictures = self.result_pictures().into_iter();
        let result_pictures =
            result_pictures.filter(|picture| !matches!(picture, ResultPicture::DamageAt(_)));
        let figure = |picture: ResultPicture| {
            let formats = [(Format::Png, "image/png"), (Format::Svg, "image/svg+xml")];
            let mut there = formats.into_iter().map(|(f, kind)| (picture.file(f), kind));
            let written = there.find(|(file, _)| made.iter().any(|m| m.name == *file));
            let (kind, bytes) = match written {
                Some((file, kind)) => {
                    let path = folder.join(file);
                    let bytes = fs::read(&path).map_err(|source| file_error("read", &path, source));
                    (kind, bytes?)
                }
                None => {
                    let svg = self.compose(picture)?.svg().map_err(ResultsError::from)?;
                    ("image/svg+xml", svg.into_bytes())
                }
            };
            Ok(Figure {
                caption: picture.describe(),
                kind,
                bytes,
            })
        };
        result_pictures.map(figure).collect()
    }

    fn inputs(&self) -> Vec<Input> {
        let source = &self.plan.source;
        let mut inputs = vec![Input {
            name: format!("{}, as it was run", name_of(&source.path)),
            text: source.text().to_owned(),
        }];
        if !source.overrides().is_empty() {
            let changes = source.overrides().iter();
            let changes = changes.map(|(key, value)| format!("{}={value}", key.replace('/', ".")));
            inputs.push(Input {
                name: "what --set changed in it".to_owned(),
                text: changes.collect::<Vec<_>>().join("\n"),
            });
        }
        let file = &self.plan.geometry.file;
        let is_script = file.extension().is_some_and(|e| e == "geo");
        let is_short = fs::metadata(file).is_ok_and(|data| data.len() <= LARGEST_SCRIPT);
        let text = (is_script && is_short)
            .then(|| fs::read(file).ok())
            .flatten();
        inputs.push(Input {
            name: name_of(file),
            text: match text {
                Some(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
                None => "(not shown)".to_owned(),
            },
        });
        inputs
    }
}

fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// Every second one is left out until they fit, but the last.
fn fitting(mut frames: Vec<FramePicture>) -> Vec<FramePicture> {
    while frames.len() > 2 && frames.iter().map(|f| f.png.len()).sum::<usize>() > MOST_FRAMES {
        let last = frames.len() - 1;
        let mut index = 0..;
        frames.retain(|_| {
            index
                .next()
                .is_some_and(|k| k == last || (last - k).is_multiple_of(2))
        });
    }
    frames
}

/// All values of the summary that are the same in every run, by their path.
fn table(summary: &Value) -> Vec<[String; 2]> {
    let mut rows = Vec::new();
    flatten("", summary, &mut rows);
    rows
}

fn flatten(path: &str, value: &Value, rows: &mut Vec<[String; 2]>) {
    let is_plain = |value: &Value| !value.is_object() && !value.is_array();
    match value {
        Value::Object(map) => {
            for (key, value) in map
                .iter()
                .filter(|(key, _)| !LEFT_OUT.contains(&key.as_str()))
            {
                let path = match path {
                    "" => key.clone(),
                    path => format!("{path}.{key}"),
                };
                flatten(&path, value, rows);
            }
        }
        Value::Array(list) if list.iter().all(is_plain) => {
            let values: Vec<String> = list.iter().map(plain).collect();
            rows.push([path.to_owned(), values.join(", ")]);
        }
        Value::Array(list) => {
            for (index, value) in list.iter().enumerate() {
                flatten(&format!("{path}.{index}"), value, rows);
            }
        }
        value => rows.push([path.to_owned(), plain(value)]),
    }
}

fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Null => "–".to_owned(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_the_numbers_and_no_costs() {
        let summary = json!({
            "name": "a", "seconds": 1.5, "sizes": { "dofs": 3 },
            "probes": [{ "name": "tip", "at_m": [1.0, 2.0] }], "fracture": null,
        });
        let expected = [
            ["name", "a"],
            ["sizes.dofs", "3"],
            ["probes.0.name", "tip"],
            ["probes.0.at_m", "1.0, 2.0"],
            ["fracture", "–"],
        ];
        assert_eq!(table(&summary), expected.map(|row| row.map(str::to_owned)));
    }

    #[test]
    fn frames_are_thinned_until_they_fit_and_the_last_stays() {
        let frame = |step: usize| FramePicture {
            step,
            text: String::new(),
            png: vec![0; MOST_FRAMES / 10],
        };
        let kept: Vec<usize> = fitting((0..32).map(frame).collect())
            .iter()
            .map(|frame| frame.step)
            .collect();
        assert_eq!(kept, [3, 7, 11, 15, 19, 23, 27, 31]);
    }
}
