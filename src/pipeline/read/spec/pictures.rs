//! `output.pictures` and `output.formats`: which pictures, and in which form.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::borrow::Cow;
use std::fmt;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Format {
    Png,
    Svg,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PictureKind {
    Mesh,
    DisplacementX,
    DisplacementY,
    StressXx,
    StressYy,
    StressXy,
    PrincipalStress,
    VonMises,
    Damage,
    LoadDisplacement,
    Energies,
}

/// Choice of the pictures: `true`, `false`, or a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Pictures {
    Usual,
    None,
    Listed(Vec<PictureKind>),
}

impl Pictures {
    /// The pictures in the order in which the results list them, each once.
    pub fn kinds(&self) -> Vec<PictureKind> {
        use PictureKind::{
            Damage, DisplacementX, DisplacementY, Energies, LoadDisplacement, Mesh,
            PrincipalStress, StressXx, StressXy, StressYy, VonMises,
        };
        let all = [
            Mesh,
            DisplacementX,
            DisplacementY,
            StressXx,
            StressYy,
            StressXy,
            PrincipalStress,
            VonMises,
            Damage,
            LoadDisplacement,
            Energies,
        ];
        all.into_iter().filter(|&kind| self.wants(kind)).collect()
    }

    pub fn wants(&self, kind: PictureKind) -> bool {
        match self {
            // What yields is metal; what breaks follows the largest tension.
            Pictures::Usual => kind != PictureKind::VonMises,
            Pictures::None => false,
            Pictures::Listed(kinds) => kinds.contains(&kind),
        }
    }

    pub fn is_none(&self) -> bool {
        self.kinds().is_empty()
    }
}

impl Serialize for Pictures {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Pictures::Usual => serializer.serialize_bool(true),
            Pictures::None => serializer.serialize_bool(false),
            Pictures::Listed(kinds) => kinds.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Pictures {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Pictures, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = Pictures;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("true, false, or a list such as [mesh, damage]")
            }

            fn visit_bool<E: de::Error>(self, all: bool) -> Result<Pictures, E> {
                Ok(if all { Pictures::Usual } else { Pictures::None })
            }

            fn visit_seq<A: de::SeqAccess<'de>>(self, seq: A) -> Result<Pictures, A::Error> {
                let list = de::value::SeqAccessDeserializer::new(seq);
                Ok(Pictures::Listed(Vec::deserialize(list)?))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

impl JsonSchema for Pictures {
    fn schema_name() -> Cow<'static, str> {
        "Pictures".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Which pictures are drawn",
            "oneOf": [
                { "type": "boolean" },
                { "type": "array", "items": generator.subschema_for::<PictureKind>() }
            ]
        })
    }
}
