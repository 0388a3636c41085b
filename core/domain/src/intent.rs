//! Intent: what the coordinator wants, small and versioned. Each vehicle makes its own setpoints from it and its peers' states,
//! so that nothing stops flying when the coordinator does.

use crate::{AccelerationNed, NodeTime, OffsetFrd, PositionNed, VehicleId, VelocityNed};
use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The whole intent. A newer version replaces an older one; a vehicle looks only at its own task.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Intent {
    /// Grows with every change.
    pub version: u64,
    /// Who leads the formation, if one is flown.
    pub leader: Option<VehicleId>,
    /// Per vehicle, its task with the version at which it was last changed.
    pub tasks: BTreeMap<VehicleId, VehicleTask>,
}

/// A vehicle's task and the intent version that last changed it. An operator's command outranks it until a newer version comes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Encode, Decode)]
pub struct VehicleTask {
    /// Intent version of the last change of this task.
    #[n(0)]
    pub version: u64,
    /// The task.
    #[n(1)]
    pub task: Task,
}

/// What the coordinator wants of one vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Encode, Decode)]
pub enum Task {
    /// Lead: fly the route, or hold the place where the task was taken up if there is none.
    #[n(0)]
    Lead {
        /// The route; none to hold.
        #[n(0)]
        route: Option<Route>,
        /// How the formation's heading is chosen.
        #[n(1)]
        heading: FormationHeading,
    },
    /// Follow the leader in a slot.
    #[n(1)]
    Follow {
        /// Whom to follow.
        #[n(0)]
        leader: VehicleId,
        /// The slot, and the way into it.
        #[n(1)]
        slot: SlotMove,
    },
    /// Leave the formation and hold.
    #[n(2)]
    Hold,
}

/// How a formation's heading is chosen.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Serialize,
    Deserialize,
    Encode,
    Decode,
    ts_rs::TS,
    schemars::JsonSchema
)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum FormationHeading {
    /// Always the same, in radians clockwise from north.
    #[n(0)]
    Fixed {
        /// Heading in radians.
        #[n(0)]
        heading_rad: f64,
    },
    /// Along the leader's course, turning no faster than the outermost vehicle can fly.
    #[n(1)]
    Course {
        /// Limit of the turning rate in radians per second.
        #[n(0)]
        max_rate_rad_s: f64,
    },
}

/// The way from one slot into another, flown by all vehicles over the same time, so that planned distances hold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, Encode, Decode)]
pub struct SlotMove {
    /// Offset from the anchor at the start.
    #[n(0)]
    pub from: OffsetFrd,
    /// Offset from the anchor at the end.
    #[n(1)]
    pub to: OffsetFrd,
    /// Height of a detour upwards at half-way in metres (negative: downwards), to pass another vehicle.
    #[n(2)]
    pub detour_up_m: f64,
    /// When it starts.
    #[n(3)]
    pub start: NodeTime,
    /// How long it takes in seconds; 0 = at once.
    #[n(4)]
    pub duration_s: f64,
}

/// A leader's route in the swarm frame, flown with rounded corners at one speed.
#[derive(
    Debug,
    Clone,
    PartialEq,
    Serialize,
    Deserialize,
    Encode,
    Decode,
    ts_rs::TS,
    schemars::JsonSchema
)]
#[serde(deny_unknown_fields)]
pub struct Route {
    /// Corners to pass, then the end. The route starts where the leader is.
    #[n(0)]
    pub waypoints: Vec<PositionNed>,
    /// Speed along it in metres per second.
    #[n(1)]
    pub speed_m_s: f64,
    /// Radius of the rounded corners in metres.
    #[n(2)]
    pub corner_radius_m: f64,
}

/// The anchor of a formation as its leader publishes it, once per control period: measured state with the leader's own
/// feed-forward. Followers add their rotated slot to it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, Encode, Decode)]
pub struct AnchorReference {
    /// Position in the swarm frame at `time`.
    #[n(0)]
    pub position: PositionNed,
    /// Velocity at `time`.
    #[n(1)]
    pub velocity: VelocityNed,
    /// Acceleration the leader asks for at `time`.
    #[n(2)]
    pub acceleration: AccelerationNed,
    /// Heading of the formation in radians, clockwise from north.
    #[n(3)]
    pub heading_rad: f64,
    /// Its rate in radians per second.
    #[n(4)]
    pub heading_rate_rad_s: f64,
    /// When this was true.
    #[n(5)]
    pub time: NodeTime,
}
