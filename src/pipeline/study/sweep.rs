//! A study: the runs that `sweep` asks for, each the pipeline with some values set as `--set` does.

use crate::pipeline::read::files::{default_results, read_text};
use crate::pipeline::read::plan::Plan;
use crate::pipeline::read::quantity;
use crate::pipeline::read::source::{InputError, Source};
use crate::pipeline::read::spec::{Combine, Range, Scalar, Scale, Sweep, Values};
use crate::pipeline::read::yaml;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A sweep, taken apart into runs.
#[derive(Clone, Debug)]
pub struct Study {
    /// `NAME`, of the pipeline.
    pub name: String,
    pub pipeline: PathBuf,
    /// `results/NAME_sweep`: a folder for each run, and the table of all.
    pub folder: PathBuf,
    /// The varied keys, such as `regions.1.spacing`, in alphabetical order.
    pub parameters: Vec<String>,
    pub combine: Combine,
    pub runs: Vec<Run>,
}

/// One run of a study.
#[derive(Clone, Debug)]
pub struct Run {
    /// Its folder; made of the values, so that a study that grows keeps the runs that it has.
    pub name: String,
    /// Values as they are written, one for each parameter.
    pub values: Vec<String>,
    /// `--set`s of the command line, of the values and of the name.
    pub overrides: Vec<String>,
    pub plan: Plan,
}

/// More runs than this are a slip of the pen.
const MOST_RUNS: usize = 100_000;

/// Longer names of runs are cut: file systems take 255 bytes.
const LONGEST_NAME: usize = 120;

impl Study {
    /// Reads and checks the pipeline of every run. `overrides` and `results` as for [`Plan::read`].
    ///
    /// # Errors
    /// No `sweep`; the first thing that is wrong with it or with a run.
    pub fn read(
        path: &Path,
        overrides: &[String],
        results: Option<&Path>,
    ) -> Result<Study, InputError> {
        let source = Source::new(path, read_text(path)?, yaml::parse_overrides(overrides)?);
        let spec = yaml::parse(&source)?;
        let Some(sweep) = &spec.sweep else {
            let help = "add, say, `sweep: { over: { regions.1.spacing: [1 mm, 0.5 mm] } }`";
            return Err(source.error_in_file("there is no `sweep`", Some(help.to_owned())));
        };
        let folder = results
            .map_or_else(|| default_results(path), Path::to_owned)
            .join(format!("{}_sweep", spec.name));
        let parameters: Vec<String> = sweep.over.keys().cloned().collect();
        let points = points(&source, sweep)?;
        let names = names(&parameters, &points);
        let runs = names.into_iter().zip(points).map(|(name, values)| {
            let sets = parameters.iter().zip(&values);
            let mut overrides = overrides.to_vec();
            overrides.extend(sets.map(|(key, value)| format!("{key}={value}")));
            overrides.push(format!("name={name}"));
            let plan = Plan::read(path, &overrides, Some(&folder))?;
            Ok(Run {
                name,
                values,
                overrides,
                plan,
            })
        });
        Ok(Study {
            name: spec.name.clone(),
            pipeline: path.to_owned(),
            runs: runs.collect::<Result<_, InputError>>()?,
            folder,
            parameters,
            combine: sweep.combine,
        })
    }

    /// The shortest ends of the parameters' names that tell them apart.
    pub fn labels(&self) -> Vec<String> {
        labels(&self.parameters)
    }
}

/// The values of every run, in the order of the parameters; of crossed ones the last changes fastest.
fn points(source: &Source, sweep: &Sweep) -> Result<Vec<Vec<String>>, InputError> {
    let lists = sweep.over.iter().map(|(key, values)| {
        list(values).map_err(|(message, help)| {
            source.error(&format!("sweep/over/{key}"), message, Some(help))
        })
    });
    let lists: Vec<Vec<String>> = lists.collect::<Result<_, InputError>>()?;
    let Some(first) = lists.first() else {
        let help = "name what is varied: `over: { regions.1.spacing: [1 mm, 0.5 mm] }`";
        let message = "nothing is varied";
        return Err(source.error("sweep/over", message, Some(help.to_owned())));
    };
    match sweep.combine {
        Combine::Zipped => {
            if let Some(other) = lists.iter().position(|list| list.len() != first.len()) {
                let keys: Vec<&String> = sweep.over.keys().collect();
                let message = format!(
                    "`{}` has {} values and `{}` {}: they cannot be zipped",
                    keys[0],
                    first.len(),
                    keys[other],
                    lists[other].len()
                );
                let help = "give all the same number of values, or write `combine: crossed`";
                return Err(source.error("sweep/over", message, Some(help.to_owned())));
            }
            let point = |k: usize| lists.iter().map(|list| list[k].clone()).collect();
            Ok((0..first.len()).map(point).collect())
        }
        Combine::Crossed => {
            let count: f64 = lists.iter().map(|list| list.len() as f64).product();
            if count > MOST_RUNS as f64 {
                let message = format!("these values make {count:.0} runs; the most is {MOST_RUNS}");
                let help = "fewer values, or `combine: zipped`".to_owned();
                return Err(source.error("sweep/over", message, Some(help)));
            }
            let mut points = vec![Vec::new()];
            for list in &lists {
                let with = |point: &Vec<String>| -> Vec<Vec<String>> {
                    let longer = list
                        .iter()
                        .map(|value| [point.as_slice(), std::slice::from_ref(value)].concat());
                    longer.collect()
                };
                points = points.iter().flat_map(with).collect();
            }
            Ok(points)
        }
    }
}

/// An error and its fix.
type Wrong = (String, String);

/// The values as they would be written.
fn list(values: &Values) -> Result<Vec<String>, Wrong> {
    let list = match values {
        Values::List(list) => list.iter().map(|Scalar(text)| text.clone()).collect(),
        Values::Range(range) => expand(range)?,
    };
    if list.is_empty() {
        let help = "write at least one, such as `[1 mm, 0.5 mm]`";
        return Err(("there are no values".to_owned(), help.to_owned()));
    }
    let mut sorted = list.clone();
    sorted.sort_unstable();
    match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(twice) => {
            let message = format!("`{}` is there twice", twice[0]);
            Err((message, "remove one of the two".to_owned()))
        }
        None => Ok(list),
    }
}

/// Digits of the values of a range: no rounding error shows.
const DIGITS: usize = 12;

fn expand(range: &Range) -> Result<Vec<String>, Wrong> {
    let example = || "write, say, `{ from: 0.5 mm, to: 2 mm, count: 4 }`".to_owned();
    fn read(Scalar(text): &Scalar) -> Result<(f64, &str), Wrong> {
        let wrong = || {
            let message = format!("`{text}` is not a number with a unit");
            (message, "write, say, `0.5 mm`".to_owned())
        };
        quantity::number_and_unit(text).ok_or_else(wrong)
    }
    let ((from, unit), (to, other)) = (read(&range.from)?, read(&range.to)?);
    if unit != other {
        let message = format!("`from` is in `{unit}` and `to` in `{other}`");
        return Err((message, "write both in one unit".to_owned()));
    }
    if range.count < 2 {
        let message = "a range has at least two values".to_owned();
        return Err((message, example()));
    }
    if range.count > MOST_RUNS {
        return Err((format!("{} values are too many", range.count), example()));
    }
    if range.scale == Scale::Log && !(from > 0.0 && to > 0.0) {
        let message = "`scale: log` needs values above zero".to_owned();
        return Err((message, example()));
    }
    let value = |k: usize| {
        let share = k as f64 / (range.count - 1) as f64;
        let number = match range.scale {
            Scale::Linear => from + share * (to - from),
            Scale::Log => from * (to / from).powf(share),
        };
        let rounded: f64 = format!("{number:.*e}", DIGITS - 1)
            .parse()
            .expect("a number that was just written");
        match unit {
            "" => rounded.to_string(),
            unit => format!("{rounded} {unit}"),
        }
    };
    Ok((0..range.count).map(value).collect())
}

fn labels(parameters: &[String]) -> Vec<String> {
    let end = |parameter: &str, steps: usize| {
        let all: Vec<&str> = parameter.split('.').collect();
        all[all.len().saturating_sub(steps)..].join(".")
    };
    let label = |parameter: &String| {
        let is_alone = |steps: &usize| {
            let label = end(parameter, *steps);
            parameters
                .iter()
                .filter(|p| end(p, *steps) == label)
                .count()
                == 1
        };
        let steps = (1..=parameter.split('.').count()).find(is_alone);
        steps.map_or_else(|| parameter.clone(), |steps| end(parameter, steps))
    };
    parameters.iter().map(label).collect()
}

/// `horizon-4_spacing-0.5mm`, one for each run and all different.
fn names(parameters: &[String], points: &[Vec<String>]) -> Vec<String> {
    let labels = labels(parameters);
    let plain = |text: &str| -> String {
        let kept = text.chars().filter(|c| !c.is_whitespace());
        kept.map(|c| {
            if c.is_alphanumeric() || matches!(c, '.' | '-') {
                c
            } else {
                '-'
            }
        })
        .collect()
    };
    let name = |values: &Vec<String>| {
        let parts = labels.iter().zip(values);
        let parts: Vec<String> = parts
            .map(|(label, value)| format!("{}-{}", plain(label), plain(value)))
            .collect();
        parts.join("_")
    };
    let names: Vec<String> = points.iter().map(name).collect();
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    names
        .iter()
        .for_each(|name| *counts.entry(name).or_default() += 1);
    let distinct = |(name, values): (&String, &Vec<String>)| {
        if counts[name.as_str()] == 1 && name.len() <= LONGEST_NAME {
            return name.clone();
        }
        let end = (0..=LONGEST_NAME)
            .rev()
            .find(|&end| name.is_char_boundary(end.min(name.len())));
        let end = end.unwrap_or(0).min(name.len());
        let hash = blake3::hash(values.join("\n").as_bytes()).to_hex();
        format!("{}_{}", &name[..end], &hash[..8])
    };
    names.iter().zip(points).map(distinct).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(from: &str, to: &str, count: usize, scale: Scale) -> Values {
        let scalar = |text: &str| Scalar(text.to_owned());
        Values::Range(Range {
            from: scalar(from),
            to: scalar(to),
            count,
            scale,
        })
    }

    #[test]
    fn ranges_hold_both_ends_and_show_no_rounding_error() {
        let linear = list(&range("0.1 mm", "0.4 mm", 4, Scale::Linear)).expect("sound");
        assert_eq!(linear, ["0.1 mm", "0.2 mm", "0.3 mm", "0.4 mm"]);
        let log = list(&range("1", "1000", 4, Scale::Log)).expect("sound");
        assert_eq!(log, ["1", "10", "100", "1000"]);
        let wrong = |values| list(&values).expect_err("wrong").0;
        assert_eq!(
            wrong(range("1 mm", "1 m", 3, Scale::Linear)),
            "`from` is in `mm` and `to` in `m`"
        );
        assert_eq!(
            wrong(range("-1", "1", 3, Scale::Log)),
            "`scale: log` needs values above zero"
        );
        let twice = ["3", "4", "3"].map(|text| Scalar(text.to_owned())).to_vec();
        assert_eq!(wrong(Values::List(twice)), "`3` is there twice");
    }

    #[test]
    fn names_are_made_of_the_values_and_differ() {
        let parameters = [
            "materials.a.young",
            "regions.0.spacing",
            "regions.1.spacing",
        ];
        let parameters = parameters.map(str::to_owned);
        assert_eq!(labels(&parameters), ["young", "0.spacing", "1.spacing"]);
        let point = |values: [&str; 3]| values.map(str::to_owned).to_vec();
        // These two differ by a character that no name may hold.
        let points = [
            point(["30 GPa", "1/2 mm", "1 mm"]),
            point(["30 GPa", "1-2 mm", "1 mm"]),
            point(["31 GPa", "2 mm", "1 mm"]),
        ];
        let names = names(&parameters, &points);
        assert_eq!(names[2], "young-31GPa_0.spacing-2mm_1.spacing-1mm");
        assert!(names[0].starts_with("young-30GPa_0.spacing-1-2mm_1.spacing-1mm_"));
        assert!(names[0] != names[1] && names[1].len() == names[0].len());
    }
}
