//! `loading`: how the load grows while bonds break.

use super::Scalar;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the load grows while bonds break.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Loading {
    /// The [load control](pipeline.md#controls).
    pub control: Control,
    /// The largest number of load steps or events. Default: none; the run ends by itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<usize>,
    /// `separated`: the run ends when the reaction falls below 2 % of its peak, or when the cracks have come to
    /// what cannot break; `steps`: after all steps.
    #[serde(default)]
    pub until: Until,
    /// The largest number of solves at one load under `equilibrium`.
    #[serde(default = "most_passes")]
    pub most_passes: usize,
    /// Δλ of a load step; with `by`, the increment of the probe, a length. Default: `1`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub increment: Option<Scalar>,
    /// Name of a probe: each load step moves it by `increment`, and λ follows, up or down. Not with
    /// `event-driven`, which has no load steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
    /// λ at which the run ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<Scalar>,
    /// A [programme](pipeline.md#programmes) of phases, which then have `increment` and `to`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<Phase>,
    /// Load steps of another source, printed beside the result.
    #[serde(default, skip_serializing_if = "ReferenceSteps::is_empty")]
    pub reference: ReferenceSteps,
}

/// A part of the load that grows while the others are constant.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Phase {
    /// Its name in `boundary`.
    pub name: String,
    /// Δλ of a load step. Default: `1`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub increment: Option<Scalar>,
    /// λ at the end of the phase; only the last phase may omit it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<Scalar>,
}

/// Load steps of another source.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceSteps {
    /// The load step of the first break.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_break: Option<usize>,
    /// The load step of the separation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub separated: Option<usize>,
}

impl ReferenceSteps {
    fn is_empty(&self) -> bool {
        self.first_break.is_none() && self.separated.is_none()
    }
}

fn most_passes() -> usize {
    1000
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Control {
    OnePass,
    Equilibrium,
    EventDriven,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Until {
    #[default]
    Separated,
    Steps,
}
