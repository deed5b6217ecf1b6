//! `boundary` and `gravity`: supports and loads.

use super::Scalar;
use super::names::{name, name_schema};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A support or a load.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Boundary {
    /// A physical curve or point ([rule](method.md#7-supports-and-loads)); for `body_force` a
    /// surface.
    #[serde(deserialize_with = "name")]
    #[schemars(schema_with = "name_schema")]
    pub group: String,
    /// Prescribed components; the others are free. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement: Option<Displacement>,
    /// Force per area on a curve, in fixed directions. Unit: Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub traction: Option<Components>,
    /// Pressure on a curve, against the outward normal; a negative one pulls. Unit: Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Scalar>,
    /// Total force on a curve or a point. Unit: N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<Components>,
    /// Force per volume of a physical surface. Unit: N/m³.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body_force: Option<Components>,
    /// The phase of `loading.phases` that applies it; later phases hold its displacements. Without
    /// it: a support in all phases.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<String>,
}

/// A vector in fixed directions, in the unit of its key. Components without a value are 0.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Components {
    /// Along x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<Scalar>,
    /// Along y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<Scalar>,
}

/// Components along x and y, along axes turned by `angle`, or along the curve's normal and tangent.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Displacement {
    /// Along x, or along x turned by `angle`. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<Scalar>,
    /// Along y, or along y turned by `angle`. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<Scalar>,
    /// Angle of the directions of `x` and `y`, counter-clockwise: `{ y: 0, angle: 30 deg }` is a
    /// roller on a slope. Default: `0`. Unit: rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<Scalar>,
    /// Along the curve's outward normal, instead of `x` and `y`: `{ normal: 0 }` is a roller on a curve.
    /// Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<Scalar>,
    /// Along the curve with the body on the left, instead of `x` and `y`. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tangential: Option<Scalar>,
}

/// The acceleration that gives the body its weight.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Gravity {
    /// Acceleration along x. Unit: m/s².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<Scalar>,
    /// Acceleration along y, such as `-9.81 m/s^2`. Unit: m/s².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<Scalar>,
    /// The phase of `loading.phases` in which the weight grows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase: Option<String>,
}
