//! `sweep.csv`: a line for each run of a study, with its values and its results; and charts of it.

use super::sweep::{Run, Study};
use crate::gmsh;
use crate::output::picture::PictureError;
use crate::output::picture::chart::{Axis, Chart, Curve, Mark};
use crate::output::{WriteError, write_whole};
use crate::pipeline::account::summary::{DrivenBy, Summary, read_summary};
use crate::pipeline::error::RunError;
use crate::pipeline::read::quantity;
use crate::pipeline::read::spec::Combine;
use crate::pipeline::record::history::quoted;
use crate::pipeline::stages::standing::{Standing, standings};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

pub const TABLE_FILE: &str = "sweep.csv";
/// Folder of the runs' output, a file for each.
pub const LOG_FOLDER: &str = "logs";

/// State of a run of a study.
#[derive(Clone, Debug)]
pub struct Row {
    pub status: Status,
    /// Columns and what stands there.
    pub results: Vec<(String, Value)>,
    pub warnings: Vec<String>,
}

impl Row {
    pub fn result(&self, column: &str) -> Option<&Value> {
        let found = self.results.iter().find(|(name, _)| name == column);
        found.map(|(_, value)| value)
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Status {
    Done,
    /// It ended with this message.
    Failed(String),
    /// It has not run, or not with this pipeline and geometry.
    Missing,
}

/// File of a run's messages.
pub fn log_file(study: &Study, run: &Run) -> PathBuf {
    study
        .folder
        .join(LOG_FOLDER)
        .join(format!("{}.txt", run.name))
}

/// Results of a run: they count only if they are of today's pipeline and geometry.
///
/// # Errors
/// An unreadable geometry.
pub fn row(study: &Study, run: &Run) -> Result<Row, RunError> {
    let is_fresh = |standings: Vec<_>| standings.iter().all(|(_, s)| *s == Standing::Fresh);
    let summary = standings(&run.plan)
        .map(is_fresh)?
        .then(|| read_summary(&run.plan.folder))
        .flatten();
    Ok(match summary {
        Some(summary) => Row {
            status: Status::Done,
            results: results(&summary),
            warnings: summary.warnings,
        },
        None => Row {
            status: failure(&log_file(study, run)).map_or(Status::Missing, Status::Failed),
            results: Vec::new(),
            warnings: Vec::new(),
        },
    })
}

/// The message that a log ends with: the first line that miette marks, and those that belong to it.
fn failure(log: &Path) -> Option<String> {
    let text = fs::read_to_string(log).ok()?;
    let message = text.lines().skip_while(|line| !line.contains('×'));
    let lines: Vec<&str> = message
        .take_while(|line| {
            !line.trim().is_empty() && !line.contains('╭') && !line.contains("help:")
        })
        .map(|line| line.trim_matches(|c: char| c.is_whitespace() || matches!(c, '×' | '│')))
        .collect();
    (!lines.is_empty()).then(|| lines.join(" "))
}

/// The numbers of a summary that runs are compared by. Times are none: the same study gives the same table.
fn results(summary: &Summary) -> Vec<(String, Value)> {
    let mut all = vec![
        ("outcome".to_owned(), json!(summary.outcome)),
        ("dofs".to_owned(), json!(summary.sizes.dofs)),
    ];
    if let Some(fracture) = &summary.fracture {
        let events = [
            ("first_break", &fracture.first_break),
            ("peak", &fracture.peak),
            ("envelope_peak", &fracture.envelope_peak),
            ("end", &fracture.end),
        ];
        for (name, event) in events {
            let Some(event) = event else {
                continue;
            };
            let mut put = |key: &str, value: Value| all.push((format!("{name}_{key}"), value));
            put("step", json!(event.step));
            put("load_factor", json!(event.load_factor));
            if let Some(load) = event.load_n {
                put("load_n", json!(load));
            }
            // Where only forces load the body, nothing is displaced and reactions may be rounding.
            if fracture.driven_by == DrivenBy::Displacements {
                put("grip_displacement_m", json!(event.grip_displacement_m));
                put("reaction_n", json!(event.reaction_n));
            }
        }
        all.push(("bonds_broken".to_owned(), json!(fracture.bonds_broken)));
        let length = fracture.crack_length_m;
        all.extend(length.map(|length| ("crack_length_m".to_owned(), json!(length))));
    }
    for probe in &summary.probes {
        let column = format!("probe_{}_m", probe.name);
        all.push((column, json!(probe.displacement_m)));
    }
    if summary.fracture.is_none() {
        for (group, reaction) in &summary.reactions_n {
            for (axis, force) in ["x", "y"].into_iter().zip(reaction) {
                all.push((format!("reaction_{group}_{axis}_n"), json!(force)));
            }
        }
    }
    all
}

/// Writes the table, and returns where it is.
///
/// # Errors
/// The file cannot be written.
pub fn write_table(study: &Study, rows: &[Row]) -> Result<PathBuf, WriteError> {
    let path = study.folder.join(TABLE_FILE);
    write_whole(&path, table(study, rows).as_bytes())?;
    Ok(path)
}

fn table(study: &Study, rows: &[Row]) -> String {
    let columns = columns(rows);
    let mut head: Vec<String> = vec!["run".to_owned(), "status".to_owned(), "message".to_owned()];
    head.extend(study.parameters.iter().cloned());
    head.extend(columns.iter().map(|&column| column.to_owned()));
    let mut text = line(&head);
    for (run, row) in study.runs.iter().zip(rows) {
        let (status, message) = match &row.status {
            Status::Done => ("done", row.warnings.join("; ")),
            Status::Failed(message) => ("failed", message.clone()),
            Status::Missing => ("missing", String::new()),
        };
        let mut cells = vec![run.name.clone(), status.to_owned(), message];
        cells.extend(run.values.iter().cloned());
        cells.extend(columns.iter().map(|&column| cell(row.result(column))));
        text += &line(&cells);
    }
    text
}

/// The columns of all rows, in the order in which they appear.
fn columns(rows: &[Row]) -> Vec<&str> {
    let mut columns = Vec::new();
    for (name, _) in rows.iter().flat_map(|row| &row.results) {
        if !columns.contains(&name.as_str()) {
            columns.push(name);
        }
    }
    columns
}

fn line(cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| quoted(cell)).collect();
    cells.join(",") + "\n"
}

fn cell(value: Option<&Value>) -> String {
    match value {
        None => String::new(),
        Some(Value::String(text)) => text.clone(),
        Some(number) => number.to_string(),
    }
}

/// The largest load of a fracture run: column, name, unit. Runs that only forces load have no reaction.
const PEAKS: [[&str; 3]; 2] = [
    ["peak_reaction_n", "peak reaction", "N"],
    ["peak_load_factor", "largest load factor", ""],
];

/// More curves than this cannot be told apart.
const MOST_CURVES: usize = 8;

/// A result that is drawn over a parameter.
struct Shown<'a> {
    column: &'a str,
    axis: Axis,
}

/// A chart of the largest load and of each probe over each parameter with several numbers, a curve for
/// each combination of the others.
///
/// # Errors
/// A picture cannot be drawn or written.
pub fn draw_charts(study: &Study, rows: &[Row]) -> Result<Vec<PathBuf>, PictureError> {
    let labels = study.labels();
    let mut files = Vec::new();
    for (over, label) in labels.iter().enumerate() {
        let Some((numbers, axis)) = scale(study, over, label) else {
            continue;
        };
        for shown in shown(rows) {
            let curves = curves(study, rows, &labels, over, &numbers, shown.column);
            if curves.is_empty() {
                continue;
            }
            let path = study
                .folder
                .join(format!("{}_over_{label}.png", shown.column));
            chart(study, axis.clone(), shown, curves)
                .draw()?
                .write(&path)?;
            files.push(path);
        }
    }
    Ok(files)
}

/// The values of a parameter that are numbers and differ, and their axis: in degrees where they are written
/// so, in the unit of the script for plain numbers of the geometry, else in SI units.
fn scale(study: &Study, over: usize, label: &str) -> Option<(Vec<f64>, Axis)> {
    let values = || study.runs.iter().map(|run| &run.values[over]);
    let quantities = || values().map(|value| quantity::parse_any(value).ok());
    let degrees = values().map(|value| quantity::parse_degrees(value));
    let (numbers, own_unit) = match degrees.collect::<Option<Vec<f64>>>() {
        Some(degrees) => (degrees, Some("°".to_owned())),
        None => {
            let plain = quantities().all(|quantity| matches!(quantity, Some((_, None))));
            let unit = if plain {
                unit_in_script(study, over)
            } else {
                None
            };
            let numbers = quantities().map(|quantity| Some(quantity?.0));
            (numbers.collect::<Option<_>>()?, unit)
        }
    };
    let differ = numbers.iter().any(|&x| x != numbers[0]);
    let si_unit = || Some(quantities().next()??.1?.symbol());
    let axis = Axis {
        name: label.to_owned(),
        keeps_unit: own_unit.is_some(),
        unit: own_unit.or_else(si_unit).unwrap_or_default(),
        is_cropped: true,
    };
    differ.then_some((numbers, axis))
}

/// The unit of a parameter of the geometry, as the script names it.
fn unit_in_script(study: &Study, over: usize) -> Option<String> {
    let name = study.parameters[over].strip_prefix("geometry.parameters.")?;
    let script = gmsh::read_script(&study.runs[0].plan.geometry.file).ok()??;
    script.parameters.get(name)?.unit.clone()
}

fn shown(rows: &[Row]) -> Vec<Shown<'_>> {
    let all = columns(rows);
    let peak = PEAKS.into_iter().find(|[column, ..]| all.contains(column));
    let name = |column: &str| match (column.strip_prefix("probe_"), peak) {
        (Some(probe), _) => Some((probe.trim_end_matches("_m").to_owned(), "m")),
        (None, Some([of_peak, name, unit])) if column == of_peak => Some((name.to_owned(), unit)),
        _ => None,
    };
    let shown = all.into_iter().filter_map(|column| {
        let (name, unit) = name(column)?;
        let unit = unit.to_owned();
        Some(Shown {
            column,
            axis: Axis {
                name,
                unit,
                is_cropped: true,
                ..Axis::default()
            },
        })
    });
    shown.collect()
}

/// One for each combination of the other parameters' values; of a zipped study one of all runs.
fn curves(
    study: &Study,
    rows: &[Row],
    labels: &[String],
    over: usize,
    numbers: &[f64],
    column: &str,
) -> Vec<Curve> {
    let name = |run: &Run| {
        let others = labels.iter().zip(&run.values).enumerate();
        let others = others.filter(|&(k, _)| k != over && study.combine == Combine::Crossed);
        let others: Vec<String> = others.map(|(_, (l, v))| format!("{l} = {v}")).collect();
        others.join(", ")
    };
    let mut curves: Vec<Curve> = Vec::new();
    for ((run, row), &x) in study.runs.iter().zip(rows).zip(numbers) {
        let Some(y) = row.result(column).and_then(Value::as_f64) else {
            continue;
        };
        let name = name(run);
        match curves.iter_mut().find(|curve| curve.name == name) {
            Some(curve) => curve.points.push([x, y]),
            None => curves.push(Curve {
                name,
                points: vec![[x, y]],
                ..Curve::default()
            }),
        }
    }
    for curve in &mut curves {
        curve.points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mark = |&at: &[f64; 2]| Mark {
            at,
            label: String::new(),
        };
        curve.marks = curve.points.iter().map(mark).collect();
    }
    curves
}

fn chart(study: &Study, over: Axis, shown: Shown, mut curves: Vec<Curve>) -> Chart {
    let hidden = curves.len().saturating_sub(MOST_CURVES);
    curves.truncate(MOST_CURVES);
    let mut title = format!("{}: {} over {}", study.name, shown.axis.name, over.name);
    if hidden > 0 {
        title += &format!(" ({hidden} more curves in {TABLE_FILE})");
    }
    Chart {
        title,
        x: over,
        y: shown.axis,
        curves,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_tells_its_message() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let log = folder.path().join("a.txt");
        let text = "a: mesh  0.1 s\n  × region `band` holds no material point\n  │ at all\n  help: smaller\n";
        fs::write(&log, text).expect("writable");
        let message = failure(&log).expect("a message");
        assert_eq!(message, "region `band` holds no material point at all");
        fs::write(&log, "a: mesh  0.1 s\n").expect("writable");
        assert_eq!(failure(&log), None);
    }

    /// An angle in degrees, a parameter in the unit that its script names, a quantity in SI units.
    #[test]
    fn an_axis_has_the_unit_in_which_a_parameter_is_thought_of() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let geo = "DefineConstant[ a = {25, Name \"Geometry/Crack [mm]\"} ];\n";
        fs::write(folder.path().join("plate.geo"), geo).expect("writable");
        let yaml = "name: plate\ngeometry: { file: plate.geo, unit: mm }\nthickness: 1 mm\n\
            materials: { m: { young: 30 GPa, poisson: 1/3 } }\n\
            regions: [{ group: body, model: peridynamics, material: m, spacing: 1 mm, horizon: 3 }]\n\
            boundary: [{ group: low, displacement: { x: 0, y: 0 } }]\n\
            sweep:\n  combine: zipped\n  over:\n    geometry.parameters.a: [20, 25]\n\
            \x20   regions.0.angle: [0 deg, 45 deg]\n    regions.0.spacing: [1 mm, 2 mm]\n\
            \x20   plane: [stress, strain]\n";
        let path = folder.path().join("plate.yaml");
        fs::write(&path, yaml).expect("writable");
        let study = Study::read(&path, &[], None).expect("a study");
        let found = |parameter: &str| {
            let over = study.parameters.iter().position(|name| name == parameter);
            let (numbers, axis) = scale(&study, over.expect("it is varied"), "")?;
            Some((numbers, axis.unit, axis.keeps_unit))
        };
        let kept = |numbers: [f64; 2], unit: &str| Some((numbers.to_vec(), unit.to_owned(), true));
        assert_eq!(found("geometry.parameters.a"), kept([20.0, 25.0], "mm"));
        assert_eq!(found("regions.0.angle"), kept([0.0, 45.0], "°"));
        let spacing = Some((vec![1e-3, 2e-3], "m".to_owned(), false));
        assert_eq!(found("regions.0.spacing"), spacing);
        assert_eq!(found("plane"), None);
    }
}
