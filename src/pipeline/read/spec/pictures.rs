//! `output.pictures` and `output.formats`: which pictures, and in which form.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Format {
    Png,
    Svg,
    Pdf,
}

#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, JsonSchema, Serialize,
)]
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
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(untagged)]
pub enum Pictures {
    /// The usual ones, or none.
    Usual(bool),
    Listed(Vec<PictureKind>),
}

/// The pictures without a choice. Von Mises' stress, which is for metals that yield, is drawn on request.
const USUAL: [PictureKind; 10] = [
    PictureKind::Mesh,
    PictureKind::DisplacementX,
    PictureKind::DisplacementY,
    PictureKind::StressXx,
    PictureKind::StressYy,
    PictureKind::StressXy,
    PictureKind::PrincipalStress,
    PictureKind::Damage,
    PictureKind::LoadDisplacement,
    PictureKind::Energies,
];

impl Pictures {
    /// The pictures in the order of [`PictureKind`], in which the results list them, each once.
    pub fn kinds(&self) -> Vec<PictureKind> {
        let mut kinds = match self {
            Pictures::Usual(true) => USUAL.to_vec(),
            Pictures::Usual(false) => Vec::new(),
            Pictures::Listed(kinds) => kinds.clone(),
        };
        kinds.sort();
        kinds.dedup();
        kinds
    }

    pub fn wants(&self, kind: PictureKind) -> bool {
        self.kinds().contains(&kind)
    }

    pub fn is_none(&self) -> bool {
        self.kinds().is_empty()
    }
}
