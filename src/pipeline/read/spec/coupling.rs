//! `coupling`: how finite elements are tied to material points.

use super::Scalar;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::borrow::Cow;
use std::fmt;

/// `clip`, `truss`, or `truss: { node_area: … }`.
#[derive(Clone, Debug)]
pub enum Coupling {
    Truss(Truss),
    Clip,
}

/// The words that `coupling` knows.
const COUPLINGS: &[&str] = &["truss", "clip"];

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
                { "enum": COUPLINGS },
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

impl Serialize for Coupling {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Coupling::Truss(truss) => {
                let mut map = serializer.serialize_map(Some(1))?;
                map.serialize_entry("truss", truss)?;
                map.end()
            }
            Coupling::Clip => serializer.serialize_str("clip"),
        }
    }
}

impl<'de> Deserialize<'de> for Coupling {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Coupling, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = Coupling;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("`clip`, `truss` or `truss: { node_area: … }`")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Coupling, E> {
                match text {
                    "truss" => Ok(Coupling::default()),
                    "clip" => Ok(Coupling::Clip),
                    _ => Err(E::unknown_variant(text, COUPLINGS)),
                }
            }

            fn visit_map<A: de::MapAccess<'de>>(self, mut map: A) -> Result<Coupling, A::Error> {
                let mut truss = None;
                while let Some(key) = map.next_key::<String>()? {
                    match key.as_str() {
                        "truss" => truss = Some(map.next_value()?),
                        _ => return Err(de::Error::unknown_field(&key, &["truss"])),
                    }
                }
                truss
                    .map(Coupling::Truss)
                    .ok_or_else(|| de::Error::missing_field("truss"))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}
