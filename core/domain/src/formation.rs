//! What an operator says of a formation: shape, spacing, heading, altitude step. The geometry itself is `skein-flight`'s.

use crate::VehicleId;
use serde::{Deserialize, Serialize};

/// The outline of a formation.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// Side by side, across the heading; the leader in the middle.
    Line,
    /// One behind the other; the leader in front.
    Column,
    /// A V with the leader at its tip.
    Wedge,
    /// On a circle; the leader at its front.
    Circle,
    /// Rows and columns as near to a square as the number allows; the leader in the middle of the front row.
    Grid,
}

impl Shape {
    /// All shapes, in the order they are offered.
    pub const ALL: &'static [Self] = &[Self::Line, Self::Column, Self::Wedge, Self::Circle, Self::Grid];
}

/// How the heading of a formation is chosen, as an operator asks for it.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Default,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum HeadingRequest {
    /// Along the leader's course where the outermost vehicle can fly the turns, else fixed at the present heading.
    #[default]
    Auto,
    /// Along the leader's course.
    Course,
    /// Always the same.
    Fixed {
        /// Heading in degrees clockwise from north.
        heading_deg: f64,
    },
}

/// A formation as an operator asks for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FormationRequest {
    /// The shape.
    pub shape: Shape,
    /// Distance between neighbours in metres.
    pub spacing_m: f64,
    /// Heading; automatic if left out.
    #[serde(default)]
    pub heading: HeadingRequest,
    /// Each next slot is this much higher, in metres; 0 = all level.
    #[serde(default)]
    pub altitude_step_m: f64,
    /// Who leads; the present leader, or else the lowest id, if left out.
    #[serde(default)]
    pub leader: Option<VehicleId>,
    /// Who takes part; every available vehicle in the air if left out.
    #[serde(default)]
    pub members: Option<Vec<VehicleId>>,
}

impl FormationRequest {
    /// A level formation of everyone available, with automatic heading and leader.
    #[must_use]
    pub fn new(shape: Shape, spacing_m: f64) -> Self {
        Self {
            shape,
            spacing_m,
            heading: HeadingRequest::Auto,
            altitude_step_m: 0.0,
            leader: None,
            members: None,
        }
    }
}
