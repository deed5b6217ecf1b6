//! Physical groups as a pipeline names them.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// A physical group: one without a name goes by its number.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(from = "NameOrTag")]
pub struct Name(pub String);

impl JsonSchema for Name {
    fn schema_name() -> Cow<'static, str> {
        "Name".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": ["string", "integer"] })
    }
}

#[derive(Deserialize)]
#[serde(untagged)]
enum NameOrTag {
    Name(String),
    Tag(u64),
}

impl From<NameOrTag> for Name {
    fn from(written: NameOrTag) -> Name {
        Name(match written {
            NameOrTag::Name(name) => name,
            NameOrTag::Tag(tag) => tag.to_string(),
        })
    }
}

/// One name or a list of them.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(from = "OneOrMore")]
pub struct Names(pub Vec<String>);

impl JsonSchema for Names {
    fn schema_name() -> Cow<'static, str> {
        "Names".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "oneOf": [
                { "type": ["string", "integer"] },
                { "type": "array", "items": Name::json_schema(generator), "minItems": 1 }
            ]
        })
    }
}

#[derive(Deserialize)]
#[serde(untagged)]
enum OneOrMore {
    One(Name),
    More(Vec<Name>),
}

impl From<OneOrMore> for Names {
    fn from(written: OneOrMore) -> Names {
        let names = match written {
            OneOrMore::One(name) => vec![name],
            OneOrMore::More(names) => names,
        };
        Names(names.into_iter().map(|Name(name)| name).collect())
    }
}
