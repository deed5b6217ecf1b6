//! The text of a pipeline file, with what `--set` changes, to a [`Spec`].

use super::mistakes::{Strictness, check};
use super::nesting::is_shallow;
use super::source::{InputError, Source};
use super::spec::Spec;
use marked_yaml::{LoadError, LoaderOptions, parse_yaml_with_options};
use serde_yaml::Value as Yaml;

/// Reads the `key=value` of each `--set`; keys come out as `a/b/c`.
///
/// # Errors
/// A text of another form.
pub fn parse_overrides(overrides: &[String]) -> Result<Vec<(String, String)>, InputError> {
    let parse = |text: &String| match text.split_once('=') {
        Some((key, value)) if !key.is_empty() && !value.trim().is_empty() => {
            Ok((key.replace('.', "/"), value.to_owned()))
        }
        _ => Err(InputError::plain(
            format!("`--set {text}` is not of the form key=value"),
            Some(
                "write, say, `--set regions.0.horizon=3` or `--set geometry.parameters.h=5`".into(),
            ),
        )),
    };
    overrides.iter().map(parse).collect()
}

/// The pipeline as it is written, and as the command line changes it.
///
/// # Errors
/// The first thing that is no pipeline.
pub fn parse(source: &Source) -> Result<Spec, InputError> {
    let written = document(source)?;
    check(source, &written, Strictness::AsText)?;
    let overrides = source.overrides();
    let spec = if overrides.is_empty() {
        serde_yaml::from_str(source.text())
    } else {
        let document = overridden(written, overrides)?;
        check(source, &document, Strictness::AsValues)?;
        serde_yaml::from_value(document)
    };
    // The schema has let it pass: what is left is rare, and serde's words must do.
    spec.map_err(|error| located(source, &error, None))
}

fn option((key, value): &(String, String)) -> String {
    format!("--set {}={value}", key.replace('/', "."))
}

/// Well-formed YAML without a key that is written twice.
fn document(source: &Source) -> Result<Yaml, InputError> {
    let options = LoaderOptions::default().error_on_duplicate_keys(true);
    if is_shallow(source.text())
        && let Err(LoadError::DuplicateKey(twice)) =
            parse_yaml_with_options(0, source.text(), options)
    {
        let line = twice.prev_key.span().start().map_or(0, |mark| mark.line());
        let message = format!(
            "the key `{}` is written twice, first in line {line}",
            twice.key.as_str()
        );
        let help = "remove one of the two".to_owned();
        return Err(source.error_at_mark(twice.key.span(), message, Some(help)));
    }
    let document: Yaml = serde_yaml::from_str(source.text()).map_err(|error| {
        let at = error.location().map_or(0, |location| location.index());
        let line = source.line_at_byte(at);
        let help = if line.starts_with('\t') || line.trim_start_matches(' ').starts_with('\t') {
            "indent with spaces: YAML does not take tabs"
        } else {
            "this is not YAML: look at indentation, colons, brackets and quotes here and above"
        };
        located(source, &error, Some(help.to_owned()))
    })?;
    match document {
        Yaml::Mapping(_) => Ok(document),
        Yaml::Null => Err(source.error_in_file("the file is empty", Some(NEEDED.to_owned()))),
        _ => {
            let message = "a pipeline consists of keys with values, such as `name: plate`";
            Err(source.error_in_file(message, Some(NEEDED.to_owned())))
        }
    }
}

const NEEDED: &str = "a pipeline needs `name`, `geometry`, `materials`, `regions` and `boundary`; \
                      copy one from pipelines/ to begin";

fn overridden(mut document: Yaml, overrides: &[(String, String)]) -> Result<Yaml, InputError> {
    for (key, value) in overrides {
        override_value(&mut document, key, value).map_err(|help| {
            let option = option(&(key.clone(), value.clone()));
            InputError::plain(
                format!("`{option}` names no place in the pipeline"),
                Some(help),
            )
        })?;
    }
    Ok(document)
}

/// Puts `value` at `key`; list entries on the way must exist, keys need not. A word on the way that is
/// the next step stands for the map with this key alone.
fn override_value(document: &mut Yaml, key: &str, value: &str) -> Result<(), String> {
    let mut place = document;
    let mut way = String::new();
    for step in key.split('/') {
        place = match place {
            Yaml::Sequence(list) => {
                let count = list.len();
                let index = step.parse().ok().filter(|k: &usize| *k < count);
                let index = index.ok_or_else(|| {
                    format!(
                        "`{way}` is a list of {count}: write a number from 0 to {}, not `{step}`",
                        count.saturating_sub(1)
                    )
                })?;
                &mut list[index]
            }
            Yaml::Mapping(mapping) => mapping.entry(step.into()).or_insert(Yaml::Null),
            // Nothing yet, or `coupling: truss`, short for `coupling: { truss: … }`.
            single if single.is_null() || single.as_str() == Some(step) => {
                *single = Yaml::Mapping(Default::default());
                let mapping = single.as_mapping_mut().expect("it was just made");
                mapping.entry(step.into()).or_insert(Yaml::Null)
            }
            _ => return Err(format!("`{way}` is a single value and holds no `{step}`")),
        };
        way = if way.is_empty() {
            step.to_owned()
        } else {
            format!("{way}.{step}")
        };
    }
    *place = serde_yaml::from_str(value).unwrap_or_else(|_| Yaml::String(value.to_owned()));
    Ok(())
}

/// A message of the YAML reader, at its place in the file.
fn located(source: &Source, error: &serde_yaml::Error, help: Option<String>) -> InputError {
    let full = error.to_string();
    let message = full.split(" at line ").next().unwrap_or(&full).to_owned();
    match error.location() {
        Some(location) => source.error_at_byte(location.index(), message, help),
        None => source.error_in_file(message, help),
    }
}

/// The `name` in the text of the file, whatever `--set` makes of it.
pub(super) fn written_name(source: &Source) -> Option<String> {
    let document: Yaml = serde_yaml::from_str(source.text()).ok()?;
    Some(document.get("name")?.as_str()?.to_owned())
}
