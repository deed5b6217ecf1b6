//! The text of a pipeline file, with what `--set` changes, to a [`Spec`]; what does not fit is told
//! in the user's words, not in serde's.

use super::nesting::is_shallow;
use super::removed::RemovedWord;
use super::source::{InputError, Source, choices};
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
    let document = document(source)?;
    let overrides = source.overrides();
    if overrides.is_empty() {
        return serde_yaml::from_str(source.text()).map_err(|error| located(source, &error));
    }
    let error = match overridden(&document, overrides)? {
        Ok(spec) => return Ok(spec),
        Err(error) => error,
    };
    if let Err(error) = serde_yaml::from_str::<Spec>(source.text()) {
        return Err(located(source, &error));
    }
    // The file alone is sound: the first override with which it no longer is has to be mended.
    let first_bad =
        |count: &usize| !matches!(overridden(&document, &overrides[..*count]), Ok(Ok(_)));
    let count = (1..overrides.len())
        .find(first_bad)
        .unwrap_or(overrides.len());
    let (key, _) = &overrides[count - 1];
    let Told { message, help, .. } = tell(&error, key);
    let option = option(&overrides[count - 1]);
    Err(InputError::plain(
        format!("{message} (by `{option}`)"),
        help,
    ))
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
        let Told { message, .. } = tell(&error, "");
        let at = error.location().map_or(0, |location| location.index());
        let line = source.line_at_byte(at);
        let help = if line.starts_with('\t') || line.trim_start_matches(' ').starts_with('\t') {
            "indent with spaces: YAML does not take tabs"
        } else {
            "this is not YAML: look at indentation, colons, brackets and quotes here and above"
        };
        match error.location() {
            Some(location) => {
                source.error_at_byte(location.index(), message, Some(help.to_owned()))
            }
            None => source.error_in_file(message, Some(help.to_owned())),
        }
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

type Parsed = Result<Spec, serde_yaml::Error>;

fn overridden(document: &Yaml, overrides: &[(String, String)]) -> Result<Parsed, InputError> {
    let mut document = document.clone();
    for (key, value) in overrides {
        override_value(&mut document, key, value).map_err(|help| {
            let option = option(&(key.clone(), value.clone()));
            InputError::plain(
                format!("`{option}` names no place in the pipeline"),
                Some(help),
            )
        })?;
    }
    Ok(serde_yaml::from_value(document))
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

fn located(source: &Source, error: &serde_yaml::Error) -> InputError {
    let Told {
        message,
        help,
        of_file,
    } = tell(error, "");
    match error.location() {
        Some(location) if !of_file => source.error_at_byte(location.index(), message, help),
        _ => source.error_in_file(message, help),
    }
}

/// A message of serde in the user's words.
struct Told {
    message: String,
    help: Option<String>,
    /// It concerns the file as a whole, not the line at which serde noticed.
    of_file: bool,
}

/// `key`: the key that holds the error, if serde does not name it.
fn tell(error: &serde_yaml::Error, key: &str) -> Told {
    let full = error.to_string();
    tell_text(full.split(" at line ").next().unwrap_or(&full), key)
}

/// serde's ways to begin, behind the path.
const KINDS: [&str; 5] = [
    "unknown field ",
    "unknown variant ",
    "missing field ",
    "invalid type: ",
    "invalid length ",
];

fn tell_text(text: &str, key: &str) -> Told {
    let found = KINDS
        .iter()
        .filter_map(|kind| Some((text.find(kind)?, *kind)))
        .min();
    let Some((at, kind)) = found else {
        return Told {
            message: text.to_owned(),
            help: None,
            of_file: false,
        };
    };
    let path = text[..at]
        .trim_end_matches(": ")
        .replace('[', ".")
        .replace(']', "");
    let rest = &text[at + kind.len()..];
    let mut quoted = rest.split('`').skip(1).step_by(2);
    let within = if path.is_empty() {
        String::new()
    } else {
        format!(" in `{path}`")
    };
    let subject = if path.is_empty() {
        "the value".to_owned()
    } else {
        format!("`{path}`")
    };
    let (given, expected) = rest
        .split_once(", expected ")
        .unwrap_or((rest, "something else"));
    let must = format!("must be {}", kind_name(expected));
    let (message, help) = match kind {
        "unknown field " => {
            let key = quoted.next().unwrap_or_default();
            (
                format!("unknown key `{key}`{within}"),
                Some(choices(key, quoted)),
            )
        }
        "unknown variant " => {
            let word = quoted.next().unwrap_or_default();
            let key = if path.is_empty() { key } else { &path };
            match RemovedWord::find(key, word) {
                Some(removed) => (
                    format!("`{key}` cannot be `{word}`: {}", removed.reason),
                    Some(removed.replacement.to_owned()),
                ),
                None => (
                    format!("{subject} cannot be `{word}`"),
                    Some(choices(word, quoted)),
                ),
            }
        }
        "missing field " => {
            let key = quoted.next().unwrap_or_default();
            let help = example(key).map(|example| format!("add, say, `{example}`"));
            (format!("the key `{key}` is missing{within}"), help)
        }
        "invalid length " => (format!("{subject} has {given} values, but {must}"), None),
        _ => (
            format!("{subject} is {}, but {must}", kind_name(given)),
            None,
        ),
    };
    Told {
        message,
        help,
        of_file: path.is_empty() && kind == "missing field ",
    }
}

/// serde's name of a kind of value in the user's words.
fn kind_name(serde: &str) -> String {
    match serde {
        "unit value" => "empty".to_owned(),
        "sequence" | "a sequence" => "a list".to_owned(),
        "map" | "a map" => "a group of keys".to_owned(),
        "a boolean" => "`true` or `false`".to_owned(),
        "a string" => "a text".to_owned(),
        "an array of length 2" | "sequence of 2 elements" => "two, such as `[1 m, 0]`".to_owned(),
        _ if serde.starts_with("struct ") => "a group of keys, such as `{ key: value }`".to_owned(),
        _ => ["string ", "integer ", "floating point ", "boolean "]
            .iter()
            .find_map(|kind| serde.strip_prefix(kind))
            .unwrap_or(serde)
            .to_owned(),
    }
}

fn example(key: &str) -> Option<&'static str> {
    Some(match key {
        "name" => "name: plate",
        "geometry" => "geometry: { file: plate.geo, unit: mm }",
        "materials" => "materials: { steel: { young: 210 GPa, poisson: 1/3 } }",
        "regions" => "regions: [ { group: plate, model: fem, material: steel } ]",
        "boundary" => "boundary: [ { group: left, displacement: { x: 0, y: 0 } } ]",
        "file" => "file: plate.geo",
        "young" => "young: 210 GPa",
        "poisson" => "poisson: 1/3",
        "group" => "group: plate",
        "model" => "model: fem",
        "material" => "material: steel",
        "at" => "at: [1 m, 0]",
        "component" => "component: x",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn serde_speaks_the_users_words() {
        let cases = [
            (
                "regions[1]: unknown field `kernal`, expected `kernel`",
                "unknown key `kernal` in `regions.1`",
            ),
            (
                "plane: unknown variant `stres`, expected `stress` or `strain`",
                "`plane` cannot be `stres`",
            ),
            ("missing field `name`", "the key `name` is missing"),
            (
                "a.b: invalid type: unit value, expected a number",
                "`a.b` is empty, but must be a number",
            ),
            (
                "probes.tip.at: invalid length 1, expected an array of length 2",
                "`probes.tip.at` has 1 values, but must be two, such as `[1 m, 0]`",
            ),
            (
                "invalid type: integer `3`, expected a sequence",
                "the value is `3`, but must be a list",
            ),
            (
                "did not find expected ',' or ']'",
                "did not find expected ',' or ']'",
            ),
        ];
        for (serde, told) in cases {
            assert_eq!(tell_text(serde, "").message, told);
        }
    }
}
