//! `boundary` and `gravity`: supports and loads.

use super::{Name, Scalar};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A support or a load.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Boundary {
    /// A physical curve or point ([rule](method.md#7-supports-and-loads)); for `body_force` a
    /// surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub group: Option<Name>,
    /// Selects edges or nodes of the mesh by position, in place of `group`.
    #[serde(rename = "where", skip_serializing_if = "Option::is_none")]
    pub position: Option<Position>,
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

/// A place by its coordinates: `x`, `y` or both, or one of the other ways. Edges of the outline that lie there
/// are taken; where there are none, inner edges, and then single nodes.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Position {
    /// `min` or `max`, the smallest or the largest x of the body; or a coordinate. With `y` the corner of both.
    /// Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<Scalar>,
    /// `min` or `max`, the smallest or the largest y of the body; or a coordinate. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<Scalar>,
    /// Everything in a rectangle, given by two opposite corners: `[[0 mm, 0 mm], [10 mm, 2 mm]]`. Unit: m.
    #[serde(rename = "box", skip_serializing_if = "Option::is_none")]
    pub rectangle: Option<[[Scalar; 2]; 2]>,
    /// The node nearest to a point `[20 mm, 10 mm]`; in a peridynamic region the point itself. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub near: Option<[Scalar; 2]>,
    /// The outline from one of its nodes to another, the shorter way round: `[[0 mm, 0 mm], [0 mm, 5 mm]]`.
    /// Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between: Option<[[Scalar; 2]; 2]>,
    /// Distance within which a coordinate counts as the one given. Default: a millionth of the body's larger
    /// side. Unit: m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<Scalar>,
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
