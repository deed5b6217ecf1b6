//! `coupling`: how finite elements are tied to material points.

use super::Scalar;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// `clip`, `truss`, or `truss: { node_area: … }`.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case", from = "Written")]
pub enum Coupling {
    Truss(Truss),
    Clip,
}

/// The truss elements of the paper.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Truss {
    /// A_FE: `lumped`, `half-edge` ([definitions](method.md#6-truss-coupling)), or one area for all
    /// nodes, such as `12.5 mm^2`. Unit: m².
    #[serde(default = "lumped")]
    pub node_area: Scalar,
    /// Whether trusses break, at the limit of the material at their point.
    #[serde(default)]
    pub breakable: bool,
}

fn lumped() -> Scalar {
    Scalar("lumped".to_owned())
}

impl Default for Coupling {
    fn default() -> Coupling {
        Coupling::Truss(Truss {
            node_area: lumped(),
            breakable: false,
        })
    }
}

impl JsonSchema for Coupling {
    fn schema_name() -> Cow<'static, str> {
        "Coupling".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let truss = generator.subschema_for::<Truss>();
        json_schema!({
            "description": "How finite elements are tied to material points",
            "oneOf": [
                { "enum": ["truss", "clip"] },
                {
                    "type": "object",
                    "properties": { "truss": truss },
                    "required": ["truss"],
                    "additionalProperties": false
                }
            ]
        })
    }
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    Word(Word),
    Settings { truss: Truss },
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Word {
    Truss,
    Clip,
}

impl From<Written> for Coupling {
    fn from(written: Written) -> Coupling {
        match written {
            Written::Word(Word::Truss) => Coupling::default(),
            Written::Word(Word::Clip) => Coupling::Clip,
            Written::Settings { truss } => Coupling::Truss(truss),
        }
    }
}
