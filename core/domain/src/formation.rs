//! What an operator says of a formation: shape, its parameters, heading, what it is anchored to and how it is kept. The geometry
//! itself is `skein-flight`'s.

use crate::{OffsetFrd, PositionNed, Route, VehicleId};
use serde::{Deserialize, Serialize};

/// The outline of a formation. What "forward" and "right" mean is the formation's heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// Side by side, across the heading; the leader in the middle.
    Line,
    /// One behind the other; the leader in front.
    Column,
    /// A V with the leader at its tip.
    Wedge,
    /// One arm of a wedge, to the left and rear of the leader.
    EchelonLeft,
    /// One arm of a wedge, to the right and rear of the leader.
    EchelonRight,
    /// Squares that stand on a corner, one around the other; the leader at the front corner of the outermost.
    Diamond,
    /// On a circle; the leader at its front.
    Circle,
    /// On a part of a circle that opens to the rear (`arc_deg` of it); the leader in its middle, at the front.
    Arc,
    /// Along the sides of a square; the leader in the middle of its front side.
    Square,
    /// Rows and columns as near to a square as the number allows; the leader in the middle of the front row.
    Grid,
    /// Grids one above the other (`layers` of them); the leader in the middle of the front row of the lowest.
    Box,
    /// On a sphere, evenly; the leader at its foremost place.
    Sphere,
    /// Along a helix about the vertical (`pitch_m` per turn, upwards); the leader at its foot, at the front.
    Helix,
    /// At the places of `offsets`.
    Free,
}

impl Shape {
    /// All shapes, in the order they are offered.
    pub const ALL: &'static [Self] = &[
        Self::Line,
        Self::Column,
        Self::Wedge,
        Self::EchelonLeft,
        Self::EchelonRight,
        Self::Diamond,
        Self::Circle,
        Self::Arc,
        Self::Square,
        Self::Grid,
        Self::Box,
        Self::Sphere,
        Self::Helix,
        Self::Free,
    ];
}

/// How the heading of a formation is chosen, as an operator asks for it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
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
        #[schemars(range(min = -57_296.0, max = 57_296.0))]
        heading_deg: f64,
    },
}

/// What a formation's slots are relative to.
#[derive(Debug, Clone, PartialEq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum FormationAnchor {
    /// Its leader: the vehicle in the first slot. Routes are flown by it, and another takes over when it is lost.
    #[default]
    Leader,
    /// A virtual leader that flies this route on the common clock; every vehicle is a follower.
    Path {
        /// The route. It begins where the formation is anchored now: at its first waypoint if it is not anchored yet.
        route: Route,
    },
    /// Something that moves and whose position is told: over the API, MAVLink or ROS 2.
    Reference {
        /// Its name, as in the list of references.
        name: String,
    },
    /// A fixed place.
    Place {
        /// The place in the swarm frame.
        position: PositionNed,
        /// Heading of the formation there in degrees clockwise from north; the present one if left out.
        #[serde(default)]
        #[schemars(range(min = -57_296.0, max = 57_296.0))]
        heading_deg: Option<f64>,
    },
}

/// Who works out where each vehicle should be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FormationControl {
    /// The coordinator gives each vehicle a slot relative to the anchor.
    #[default]
    Slots,
    /// Each vehicle keeps its distances to its neighbours, from their states alone.
    Distances,
    /// Each vehicle keeps the directions to its neighbours, from their states alone. The heading of the formation is fixed.
    Bearings,
}

/// A formation as an operator asks for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FormationRequest {
    /// The shape.
    pub shape: Shape,
    /// Distance between neighbours in metres.
    #[schemars(range(max = 100_000.0), extend("exclusiveMinimum" = 0))]
    pub spacing_m: f64,
    /// Heading; automatic if left out.
    #[serde(default)]
    pub heading: HeadingRequest,
    /// Each next slot is this much higher, in metres; 0 = all level.
    #[serde(default)]
    #[schemars(range(min = -10_000.0, max = 10_000.0))]
    pub altitude_step_m: f64,
    /// The shape is turned by this about its anchor, in degrees clockwise seen from above.
    #[serde(default)]
    #[schemars(range(min = -57_296.0, max = 57_296.0))]
    pub rotation_deg: f64,
    /// The shape is made so many times as large, spacing and altitudes included.
    #[serde(default = "unscaled")]
    #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0))]
    pub scale: f64,
    /// For an arc: how much of the circle, in degrees; 180 if left out.
    #[serde(default)]
    #[schemars(range(max = 360.0), extend("exclusiveMinimum" = 0))]
    pub arc_deg: Option<f64>,
    /// For a box: how many layers; as near to a cube as the number allows if left out.
    #[serde(default)]
    #[schemars(range(min = 1))]
    pub layers: Option<u16>,
    /// For a helix: height gained in one turn, in metres; twice the spacing if left out.
    #[serde(default)]
    #[schemars(range(max = 10_000.0), extend("exclusiveMinimum" = 0))]
    pub pitch_m: Option<f64>,
    /// For a free shape: the places relative to the anchor, the leader's first. At least as many as vehicles take part.
    #[serde(default)]
    #[schemars(length(min = 1, max = 1024))]
    pub offsets: Option<Vec<OffsetFrd>>,
    /// What the slots are relative to; the leader if left out.
    #[serde(default)]
    pub anchor: FormationAnchor,
    /// Who works out the places; the coordinator if left out.
    #[serde(default)]
    pub control: FormationControl,
    /// Who leads; the present leader, or else the first that can in the configured order, if left out.
    #[serde(default)]
    pub leader: Option<VehicleId>,
    /// Who takes part; every available vehicle in the air if left out.
    #[serde(default)]
    #[schemars(length(min = 1, max = 1024), extend("uniqueItems" = true))]
    pub members: Option<Vec<VehicleId>>,
}

fn unscaled() -> f64 {
    1.0
}

impl FormationRequest {
    /// A level formation of everyone available behind a leader, with automatic heading.
    #[must_use]
    pub fn new(shape: Shape, spacing_m: f64) -> Self {
        Self {
            shape,
            spacing_m,
            heading: HeadingRequest::Auto,
            altitude_step_m: 0.0,
            rotation_deg: 0.0,
            scale: 1.0,
            arc_deg: None,
            layers: None,
            pitch_m: None,
            offsets: None,
            anchor: FormationAnchor::Leader,
            control: FormationControl::Slots,
            leader: None,
            members: None,
        }
    }
}
