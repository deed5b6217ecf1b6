//! Mistakes in a YAML document, found by the schema of the types that read it. A message has the user's
//! words and the key that it concerns, whatever the reader's own messages are.

use super::familiar;
use super::removed::RemovedWord;
use super::source::{InputError, Source, choices, quoted};
use super::spec::Spec;
use schemars::schema_for;
use serde_json::Value as Schema;
use serde_yaml::Value as Yaml;
use std::sync::LazyLock;

static SCHEMA: LazyLock<Schema> = LazyLock::new(|| schema_for!(Spec).to_value());

/// Form of the scalars that are checked.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Strictness {
    /// From the text, where `5` may be a name.
    AsText,
    /// From values, where `5` is a number.
    AsValues,
}

/// Refuses a document that is no pipeline.
///
/// # Errors
/// The first mistake in the order of the document.
pub fn check(source: &Source, document: &Yaml, strictness: Strictness) -> Result<(), InputError> {
    Checker { source, strictness }.check(&SCHEMA, document, "")
}

struct Checker<'a> {
    source: &'a Source,
    strictness: Strictness,
}

impl Checker<'_> {
    fn check(&self, schema: &Schema, value: &Yaml, key: &str) -> Result<(), InputError> {
        let forms = forms(schema);
        if value.is_null() && forms.iter().any(|form| has_type(form, "null")) {
            return Ok(());
        }
        // The reader takes nothing for an empty list, map or text.
        let is_text = matches!(forms[..], [form] if form.get("type") == Some(&Schema::from("string")))
            && words(forms[0]).is_none();
        let fits = |form: &&&Schema| match value {
            Yaml::Null => ["array", "object"].iter().any(|kind| has_type(form, kind)),
            Yaml::Bool(_) => has_type(form, "boolean"),
            Yaml::Number(number) => {
                let is_count = number.is_u64();
                has_type(form, "number") || (is_count && has_type(form, "integer"))
            }
            Yaml::String(word) => match words(form) {
                Some(words) => words.contains(&word.as_str()),
                None => has_type(form, "string"),
            },
            Yaml::Sequence(_) => has_type(form, "array"),
            Yaml::Mapping(_) => has_type(form, "object"),
            // The reader knows tags, or says that it does not.
            Yaml::Tagged(_) => true,
        };
        match (forms.iter().find(fits), value) {
            (Some(form), Yaml::Sequence(list)) => self.check_list(form, list, key),
            (Some(form), Yaml::Mapping(map)) => self.check_map(form, map, key),
            (Some(form), Yaml::Null) if form.get("properties").is_some() => {
                self.check_map(form, &serde_yaml::Mapping::new(), key)
            }
            (Some(_), _) => Ok(()),
            (None, Yaml::Null) if is_text => Ok(()),
            (None, Yaml::Bool(_) | Yaml::Number(_))
                if is_text && self.strictness == Strictness::AsText =>
            {
                Ok(())
            }
            (None, _) => Err(self.misfit(&forms, value, key)),
        }
    }

    fn check_list(&self, form: &Schema, list: &[Yaml], key: &str) -> Result<(), InputError> {
        let count = |bound: &str| form.get(bound).and_then(Schema::as_u64);
        let least = count("minItems").unwrap_or(0);
        let most = count("maxItems").unwrap_or(u64::MAX);
        if !(least..=most).contains(&(list.len() as u64)) {
            let message = format!(
                "{} has {} values, but must be {}",
                subject(key),
                list.len(),
                described(form)
            );
            return Err(self.source.error(key, message, None));
        }
        let Some(items) = form.get("items") else {
            return Ok(());
        };
        let mut numbered = list.iter().enumerate();
        numbered
            .try_for_each(|(index, item)| self.check(items, item, &below(key, &index.to_string())))
    }

    fn check_map(
        &self,
        form: &Schema,
        map: &serde_yaml::Mapping,
        key: &str,
    ) -> Result<(), InputError> {
        let properties = form.get("properties").and_then(Schema::as_object);
        let within = match key {
            "" => String::new(),
            key => format!(" in `{}`", key.replace('/', ".")),
        };
        for (name, value) in map {
            let name = text(name);
            let place = below(key, &name);
            match (properties, form.get("additionalProperties")) {
                (Some(known), _) if known.contains_key(&name) => {
                    self.check(&known[&name], value, &place)?;
                }
                (_, Some(schema)) if schema.is_object() => self.check(schema, value, &place)?,
                (known, _) => {
                    let known = known.into_iter().flatten().map(|(name, _)| name.as_str());
                    let known: Vec<&str> = known.collect();
                    let advice = familiar::advice(&name, &known).map(str::to_owned);
                    let help = advice.or_else(|| Some(choices(&name, known)));
                    let message = format!("unknown key `{name}`{within}");
                    return Err(self.source.error_at_name(&place, message, help));
                }
            }
        }
        let Some(missing) = required(form).find(|name| !map.contains_key(*name)) else {
            return Ok(());
        };
        let message = format!("the key `{missing}` is missing{within}");
        let help = example(missing).map(|example| format!("add, say, `{example}`"));
        Err(match key {
            "" => self.source.error_in_file(message, help),
            key => self.source.error(key, message, help),
        })
    }

    /// Why a value has none of the forms.
    fn misfit(&self, forms: &[&Schema], value: &Yaml, key: &str) -> InputError {
        let known: Vec<&str> = forms
            .iter()
            .filter_map(|form| words(form))
            .flatten()
            .collect();
        let is_word = !matches!(value, Yaml::Null | Yaml::Sequence(_) | Yaml::Mapping(_));
        if is_word && !known.is_empty() {
            let word = text(value);
            let path = key.replace('/', ".");
            return match RemovedWord::find(&path, &word) {
                Some(removed) => {
                    let message = format!("`{path}` cannot be `{word}`: {}", removed.reason);
                    let help = Some(removed.replacement.to_owned());
                    self.source.error(key, message, help)
                }
                None => {
                    let message = format!("`{path}` cannot be `{word}`");
                    self.source.error(key, message, Some(choices(&word, known)))
                }
            };
        }
        let given = match value {
            Yaml::Null => "empty".to_owned(),
            Yaml::Sequence(_) => "a list".to_owned(),
            Yaml::Mapping(_) => "a group of keys".to_owned(),
            scalar => format!("`{}`", text(scalar)),
        };
        let mut allowed: Vec<String> = Vec::new();
        if !known.is_empty() {
            allowed.push(format!("one of {}", quoted(&known)));
        }
        let others = forms.iter().filter(|form| words(form).is_none());
        allowed.extend(
            others
                .filter(|form| !is_null(form))
                .map(|form| described(form)),
        );
        let message = format!(
            "{} is {given}, but must be {}",
            subject(key),
            allowed.join(" or ")
        );
        self.source.error(key, message, None)
    }
}

/// The alternatives of a schema, each without alternatives of its own.
fn forms(schema: &Schema) -> Vec<&Schema> {
    let name = schema.get("$ref").and_then(Schema::as_str);
    if let Some(pointer) = name.and_then(|name| name.strip_prefix('#')) {
        let target = SCHEMA.pointer(pointer);
        return forms(target.expect("a schema holds what it refers to"));
    }
    let choice = ["anyOf", "oneOf"]
        .iter()
        .find_map(|key| schema.get(key)?.as_array());
    match choice {
        Some(list) => list.iter().flat_map(forms).collect(),
        None => vec![schema],
    }
}

fn has_type(form: &Schema, name: &str) -> bool {
    match form.get("type") {
        Some(Schema::String(single)) => single == name,
        Some(Schema::Array(several)) => several.iter().any(|one| one == name),
        _ => false,
    }
}

/// Whether a form takes nothing but an empty value.
fn is_null(form: &Schema) -> bool {
    matches!(form.get("type"), Some(Schema::String(only)) if only == "null")
}

/// The words that a form lists, if it does.
fn words(form: &Schema) -> Option<Vec<&str>> {
    match (form.get("enum"), form.get("const")) {
        (Some(Schema::Array(words)), _) => Some(words.iter().filter_map(Schema::as_str).collect()),
        (_, Some(Schema::String(word))) => Some(vec![word]),
        _ => None,
    }
}

/// A form in words.
fn described(form: &Schema) -> String {
    let kinds = ["number", "string", "integer", "boolean", "array", "object"];
    let kinds: Vec<&str> = kinds
        .into_iter()
        .filter(|kind| has_type(form, kind))
        .collect();
    let text = match kinds.as_slice() {
        ["number", "string"] => "a number or a quantity such as `30 GPa`",
        ["string", "integer"] => "a name",
        ["string"] => "a text",
        ["integer"] => "a whole number",
        ["boolean"] => "`true` or `false`",
        ["array"] if form.get("maxItems").is_some() => "two, such as `[1 m, 0]`",
        ["array"] => "a list",
        ["object"] => match required(form).collect::<Vec<&str>>().as_slice() {
            [] => "a group of keys, such as `{ key: value }`",
            keys => return format!("a group with the keys {}", quoted(keys)),
        },
        _ => "another value",
    };
    text.to_owned()
}

/// The keys that a map must have.
fn required(form: &Schema) -> impl Iterator<Item = &str> {
    let list = form.get("required").and_then(Schema::as_array);
    list.into_iter().flatten().filter_map(Schema::as_str)
}

fn subject(key: &str) -> String {
    format!("`{}`", key.replace('/', "."))
}

fn below(key: &str, step: &str) -> String {
    match key {
        "" => step.to_owned(),
        key => format!("{key}/{step}"),
    }
}

/// A scalar as one would write it.
fn text(scalar: &Yaml) -> String {
    match scalar {
        Yaml::String(text) => text.clone(),
        Yaml::Number(number) => number.to_string(),
        Yaml::Bool(is_true) => is_true.to_string(),
        _ => String::new(),
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
    use std::path::Path;

    const SOUND: &str = "
name: plate
geometry: { file: plate.geo }
materials: { rock: { young: 30 GPa, poisson: 1/3 } }
regions: [ { group: a, model: fem, material: rock } ]
boundary: []
plane: stress
output: { every: 2 }
probes: { tip: { at: [0, 0], component: x } }
";

    fn message(text: &str) -> Option<String> {
        let source = Source::new(Path::new("plate.yaml"), text.to_owned(), Vec::new());
        let document = serde_yaml::from_str(text).expect("YAML");
        let error = check(&source, &document, Strictness::AsText).err()?;
        Some(error.message)
    }

    #[test]
    fn mistakes_are_told_with_their_key() {
        assert_eq!(message(SOUND), None);
        let cases = [
            (
                "model: fem",
                "model: fem, kernal: quartic",
                "unknown key `kernal` in `regions.0`",
            ),
            ("plane: stress", "plane: stres", "`plane` cannot be `stres`"),
            (
                "young: 30 GPa, ",
                "",
                "the key `young` is missing in `materials.rock`",
            ),
            (
                "every: 2",
                "every: -2",
                "`output.every` is `-2`, but must be a whole number",
            ),
            (
                "[0, 0]",
                "[0]",
                "`probes.tip.at` has 1 values, but must be two, such as `[1 m, 0]`",
            ),
            (
                "boundary: []",
                "boundary: 3",
                "`boundary` is `3`, but must be a list",
            ),
            (
                "{ file: plate.geo }",
                "5",
                "`geometry` is `5`, but must be a group with the keys `file`",
            ),
            (
                "30 GPa",
                "",
                "`materials.rock.young` is empty, but must be a number or a quantity such as `30 GPa`",
            ),
        ];
        for (old, new, told) in cases {
            assert!(SOUND.contains(old), "{old}");
            assert_eq!(message(&SOUND.replace(old, new)).as_deref(), Some(told));
        }
    }

    #[test]
    fn numbers_are_names_and_nothing_is_an_empty_list_in_a_text() {
        for (old, new) in [("name: plate", "name: 5"), ("boundary: []", "boundary:")] {
            assert_eq!(message(&SOUND.replace(old, new)), None, "{new}");
        }
    }
}
