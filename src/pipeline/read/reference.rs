//! The reference of the pipeline file, from the types that read it: a section for each map, a list item
//! for each key.

use super::spec::Spec;
use schemars::schema_for;
use serde_json::Value;

const HEAD: &str = "# Reference of the pipeline file\n\n\
    `peristitch schema --markdown` writes this page from the types that read a pipeline; \
    [pipeline.md](pipeline.md) is the guide. A *quantity* is a number with a unit, such as `30 GPa`; \
    a bare number is SI. In parentheses: type, unit, default. A key without a default that is not \
    required may be omitted.\n";

/// The page, as `docs/pipeline_reference.md` holds it.
pub fn text() -> String {
    let schema = schema_for!(Spec).to_value();
    let types = &schema["$defs"];
    let maps = types
        .as_object()
        .expect("the types have names")
        .iter()
        .filter(|(_, schema)| schema.get("properties").is_some());
    let sections = maps.map(|(name, schema)| section(name, schema, types));
    HEAD.to_owned() + &section("Top level", &schema, types) + &sections.collect::<String>()
}

fn section(title: &str, schema: &Value, types: &Value) -> String {
    let keys = schema["properties"].as_object().expect("a map has keys");
    let items = keys
        .iter()
        .map(|(key, value)| item(key, value, schema, types));
    format!(
        "\n## {}\n\n{}{}",
        in_words(title),
        described(schema).map_or(String::new(), |text| text + "\n\n"),
        items.collect::<String>()
    )
}

fn item(key: &str, value: &Value, of: &Value, types: &Value) -> String {
    let meaning = described(value).unwrap_or_default();
    let (meaning, unit) = split(&meaning, " Unit: ");
    let (meaning, told) = split(meaning, " Default: ");
    let is_required = of["required"]
        .as_array()
        .is_some_and(|required| required.iter().any(|name| name == key));
    let default = match value.get("default") {
        _ if is_required => "required".to_owned(),
        Some(default) => written(default),
        None => told.to_owned(),
    };
    let kind = match unit {
        "" => kind(value, types),
        unit => format!("{} [{unit}]", kind(value, types)),
    };
    let default = match default.as_str() {
        "" | "required" => default,
        default => format!("default {default}"),
    };
    let details = [kind, default];
    let details = details.into_iter().filter(|text| !text.is_empty());
    let details: Vec<String> = details.collect();
    format!("- `{key}` ({}): {meaning}\n", details.join("; "))
}

/// A default as a pipeline has it: of a map with settings its name, of another one nothing.
fn written(default: &Value) -> String {
    let text = match default.as_object() {
        Some(map) if map.len() == 1 => map.keys().cloned().collect(),
        Some(_) => return String::new(),
        None => default.to_string().replace('"', ""),
    };
    format!("`{text}`")
}

/// The text before the mark, and the text after it without its full stop.
fn split<'a>(text: &'a str, mark: &str) -> (&'a str, &'a str) {
    let (before, behind) = text.split_once(mark).unwrap_or((text, ""));
    (before, behind.trim_end_matches('.'))
}

fn described(schema: &Value) -> Option<String> {
    let text = schema.get("description")?.as_str()?;
    Some(text.replace('\n', " "))
}

/// The type in words; that of a map is a link to its section.
fn kind(schema: &Value, types: &Value) -> String {
    if let Some(name) = schema.get("$ref").and_then(Value::as_str) {
        return named(name.trim_start_matches("#/$defs/"), types);
    }
    for choice in ["anyOf", "oneOf"] {
        if let Some(kinds) = schema.get(choice).and_then(Value::as_array) {
            return alternatives(kinds.iter().map(|each| kind(each, types)));
        }
    }
    if let Some(words) = schema.get("enum").and_then(Value::as_array) {
        return alternatives(words.iter().map(word));
    }
    if let Some(value) = schema.get("const") {
        return word(value);
    }
    match &schema["type"] {
        Value::Array(names) => alternatives(names.iter().map(|name| match name.as_str() {
            Some("array") => format!("list of {}", elements(schema, types)),
            _ => simple(name),
        })),
        Value::String(name) if name == "array" => format!("list of {}", elements(schema, types)),
        Value::String(name) if name == "object" => of_map(schema, types),
        name => simple(name),
    }
}

fn elements(schema: &Value, types: &Value) -> String {
    let element = kind(&schema["items"], types);
    match schema.get("maxItems") {
        Some(count) => format!("{count} × {element}"),
        None => element,
    }
}

fn of_map(schema: &Value, types: &Value) -> String {
    match schema.get("properties").and_then(Value::as_object) {
        Some(keys) => keys
            .iter()
            .map(|(key, value)| format!("`{key}`: {}", kind(value, types)))
            .collect(),
        None => format!("map of {}", kind(&schema["additionalProperties"], types)),
    }
}

fn alternatives(kinds: impl Iterator<Item = String>) -> String {
    let kinds: Vec<String> = kinds.filter(|kind| !kind.is_empty()).collect();
    if kinds.iter().any(|kind| kind.contains(" or ")) {
        return kinds.join(", or ");
    }
    match kinds.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
        None => String::new(),
    }
}

fn word(value: &Value) -> String {
    format!("`{}`", value.as_str().expect("choices are words"))
}

fn simple(name: &Value) -> String {
    match name.as_str().unwrap_or_default() {
        "null" => "",
        "string" => "text",
        "integer" => "whole number",
        "boolean" => "true or false",
        other => other,
    }
    .to_owned()
}

/// The type of this name: a quantity as a word, a map as a link, any other spelled out.
fn named(name: &str, types: &Value) -> String {
    let schema = &types[name];
    if name == "Scalar" {
        "quantity".to_owned()
    } else if schema.get("properties").is_some() {
        let title = in_words(name);
        format!("[{title}](#{})", title.to_lowercase().replace(' ', "-"))
    } else {
        kind(schema, types)
    }
}

/// `ReferenceSteps` as `Reference steps`.
fn in_words(name: &str) -> String {
    let mut words = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !words.is_empty() && !words.ends_with(' ') {
            words.push(' ');
            words.extend(letter.to_lowercase());
        } else {
            words.push(letter);
        }
    }
    words
}
