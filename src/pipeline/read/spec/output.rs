//! `probes` and `output`: what is reported and written.

use super::{Format, Pictures, Scalar};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A displacement to report.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// A place in the box around the body; the nearest element node or material point is read.
    /// Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<[Scalar; 2]>,
    /// In place of `at`, two places: the displacement of the second less that of the first is
    /// read, such as a crack mouth opening. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between: Option<[[Scalar; 2]; 2]>,
    /// Component of the displacement.
    pub component: Component,
    /// Expected value; the error is reported. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<Scalar>,
}

#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Component {
    X,
    Y,
}

/// The files in `results/NAME/`.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Fields in the VTU files.
    pub fields: Vec<OutputField>,
    /// Steps from one frame of a fracture run to the next. The start, the first break and the end
    /// always have one.
    pub every: usize,
    /// Write bonds and trusses as lines.
    pub bonds: bool,
    /// The pictures to draw; `true`: all but `von-mises`.
    pub pictures: Pictures,
    /// Steps of a fracture run whose damage is drawn, as `damage_000057.png`; they have a frame.
    pub pictures_at: Vec<usize>,
    /// Formats of the pictures.
    pub formats: Vec<Format>,
    /// Whether pictures have a title.
    pub titles: bool,
    /// Factor ≥ 0 by which pictures exaggerate displacements; it is written in each. Default: 1, so that
    /// places can be read off the axes; in `crack.gif` a round number that makes the largest displacement
    /// about a twentieth of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exaggeration: Option<f64>,
    /// Ends of the colour bar of maps of displacement and stress, as percentiles of the values shown, from
    /// 0 to 100: `[1, 99]` keeps the peak at a crack's tip from taking all colours. Default: the least and
    /// the largest value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub percentiles: Option<[f64; 2]>,
    /// Ends of the colour bar of single maps: `{ stress-yy: [0 MPa, 5 MPa] }`. Units: m, Pa.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub colour_ranges: BTreeMap<String, [Scalar; 2]>,
    /// Write `crack.gif` of a fracture run. Default: as `pictures`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub animation: Option<bool>,
    /// Write `report.html`. Default: as `pictures`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub report: Option<bool>,
}

impl Default for Output {
    fn default() -> Output {
        use OutputField::{Displacement, Strain, Stress};
        Output {
            fields: vec![Displacement, Stress, Strain],
            every: 1,
            bonds: false,
            pictures: Pictures::Usual(true),
            pictures_at: Vec::new(),
            formats: vec![Format::Png],
            titles: true,
            exaggeration: None,
            percentiles: None,
            colour_ranges: BTreeMap::new(),
            animation: None,
            report: None,
        }
    }
}

impl Output {
    /// The formats, each once.
    pub fn formats(&self) -> Vec<Format> {
        let all = [Format::Png, Format::Svg, Format::Pdf].into_iter();
        all.filter(|format| self.formats.contains(format)).collect()
    }

    pub fn is_animated(&self) -> bool {
        self.animation
            .unwrap_or(self.pictures != Pictures::Usual(false))
    }

    pub fn is_reported(&self) -> bool {
        self.report
            .unwrap_or(self.pictures != Pictures::Usual(false))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputField {
    Displacement,
    Stress,
    Strain,
}
