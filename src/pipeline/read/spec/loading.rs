//! `loading`: how the load grows while bonds break.

use super::Scalar;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the load grows while bonds break.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Loading {
    /// When the load grows, and what breaks at once ([controls](pipeline.md#controls)).
    pub control: Control,
    /// The most load steps, or events, from 1 on.
    pub steps: usize,
    /// `separated`: ends earlier, when the force falls under 2 % of its peak; `steps`: does not.
    #[serde(default)]
    pub until: Until,
    /// Under `equilibrium`, solves at one load.
    #[serde(default = "most_passes")]
    pub most_passes: usize,
    /// Δλ of a load step. Default: `1`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub increment: Option<Scalar>,
    /// λ at which the run ends; the last step is as short as it must be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<Scalar>,
    /// A [programme](pipeline.md#programmes) of several phases; `increment` and `to` then stand in
    /// the phases.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<Phase>,
    /// Load steps that another source reports, printed beside the result.
    #[serde(default, skip_serializing_if = "ReferenceSteps::is_empty")]
    pub reference: ReferenceSteps,
}

/// A part of the load that grows by itself while the others rest.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Phase {
    /// What `boundary` calls it.
    pub name: String,
    /// Δλ of a load step. Default: `1`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub increment: Option<Scalar>,
    /// λ at the phase's end, where the next one begins; only the last phase may do without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<Scalar>,
}

/// Steps that another source reports.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceSteps {
    /// The load step of the first break.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_break: Option<usize>,
    /// The load step at which the body is in two.
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
