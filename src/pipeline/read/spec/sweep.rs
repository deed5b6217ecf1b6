//! `sweep`: a study of many runs.

use super::Scalar;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A study of many runs.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// Values of each key, named as in `--set`.
    pub over: BTreeMap<String, Values>,
    /// `crossed`: every combination of values; `zipped`: the first of each, the second of each.
    #[serde(default)]
    pub combine: Combine,
}

/// How the values of several parameters are combined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Combine {
    /// Every value with every other.
    #[default]
    Crossed,
    /// The first of each, the second of each, …
    Zipped,
}

/// A list, or a range.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(untagged)]
pub enum Values {
    List(Vec<Scalar>),
    Range(Range),
}

/// `count` values from `from` to `to`, both included.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// The first value.
    pub from: Scalar,
    /// The last value.
    pub to: Scalar,
    /// The number of values, both ends included.
    pub count: usize,
    /// `linear`: equal differences; `log`: equal ratios.
    #[serde(default)]
    pub scale: Scale,
}

/// The quantity that is constant from one value of a range to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// The difference.
    #[default]
    Linear,
    /// The ratio.
    Log,
}
