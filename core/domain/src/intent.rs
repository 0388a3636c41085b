//! Intent: what the coordinator wants, small and versioned. Each vehicle makes its own setpoints from it and its peers' states,
//! so that nothing stops flying when the coordinator does.

mod clocks;

use crate::{AccelerationNed, NodeTime, OffsetFrd, PositionNed, VehicleId, VelocityNed};
use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The whole intent. A newer version replaces an older one; a vehicle looks only at its own task.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Intent {
    /// Grows with every change.
    pub version: u64,
    /// Who leads the formation, if one is flown and a vehicle leads it.
    pub leader: Option<VehicleId>,
    /// What the slots are relative to, if that is no vehicle. Every node works out the same from it.
    #[serde(default)]
    pub anchor: Option<AnchorPlan>,
    /// Per vehicle, its task with the version at which it was last changed.
    pub tasks: BTreeMap<VehicleId, VehicleTask>,
}

/// An anchor that is no vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum AnchorPlan {
    /// A virtual leader on a route.
    Path {
        /// The route.
        route: Route,
        /// Where it starts.
        from: PositionNed,
        /// Heading of the formation at the start in radians.
        heading_rad: f64,
        /// How the heading is chosen on the way.
        heading: FormationHeading,
        /// Largest acceleration in metres per second squared.
        acceleration_m_s2: f64,
        /// Largest climb rate in metres per second.
        climb_m_s: f64,
        /// Largest descent rate in metres per second.
        descent_m_s: f64,
        /// When it starts; before that it stands.
        start: NodeTime,
    },
    /// A reference that moves.
    Reference {
        /// Its name.
        name: String,
        /// How the heading is chosen.
        heading: FormationHeading,
        /// Everyone's place about it: it is followed no further than all of them are inside of the fences.
        places: Vec<OffsetFrd>,
    },
    /// A place.
    Place {
        /// Where.
        position: PositionNed,
        /// How the heading is chosen: fixed, or towards it with this rate.
        heading_rad: f64,
        /// Largest turning rate on the way to that heading in radians per second.
        max_rate_rad_s: f64,
    },
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
    /// Keep a slot relative to the formation's anchor.
    #[n(1)]
    Follow {
        /// Whom to follow; absent if the anchor is no vehicle but a virtual leader, a reference that moves, or a place.
        #[n(0)]
        leader: Option<VehicleId>,
        /// The slot, and the way into it.
        #[n(1)]
        slot: SlotMove,
    },
    /// Leave the formation and hold.
    #[n(2)]
    Hold,
    /// Keep a place among neighbours, from their states alone.
    #[n(3)]
    Keep(#[n(0)] Keeping),
    /// Fly a planned trajectory from its start on, then hold at its end.
    #[n(4)]
    Fly(#[n(0)] Trajectory),
}

/// A vehicle's place among its neighbours, for control without a coordinator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Encode, Decode)]
pub struct Keeping {
    /// What is kept.
    #[n(0)]
    pub law: KeepingLaw,
    /// The neighbours and where they belong, relative to this vehicle: north, east, down for the formation's heading when it was laid out.
    #[n(1)]
    pub neighbours: Vec<NeighbourPlace>,
    /// Whoever leads: its motion is what the others take over. Also a neighbour, or known only through neighbours.
    #[n(2)]
    pub leader: Option<VehicleId>,
    /// From when on.
    #[n(3)]
    pub start: NodeTime,
}

/// What a vehicle keeps of its neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, Encode, Decode)]
#[cbor(index_only)]
pub enum KeepingLaw {
    /// Distances; the shape may turn as a whole.
    #[n(0)]
    Distances,
    /// Directions in north, east, down; the shape does not turn.
    #[n(1)]
    Bearings,
}

/// Where a neighbour belongs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, Encode, Decode)]
pub struct NeighbourPlace {
    /// Which.
    #[n(0)]
    pub vehicle: VehicleId,
    /// Its place minus this vehicle's: north in metres.
    #[n(1)]
    pub north_m: f64,
    /// East in metres.
    #[n(2)]
    pub east_m: f64,
    /// Down in metres.
    #[n(3)]
    pub down_m: f64,
    /// How many steps from neighbour to neighbour it is from the leader, 0 for the leader itself; absent if there is none. The
    /// formation's velocity is learnt from those nearer to the leader.
    #[n(4)]
    pub hops: Option<u16>,
}

/// A planned way over time: polynomials, piece after piece, that begin at one time for all who fly together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Encode, Decode)]
pub struct Trajectory {
    /// When it begins, on the common clock.
    #[n(0)]
    pub start: NodeTime,
    /// Its pieces, one after the other.
    #[n(1)]
    pub pieces: Vec<TrajectoryPiece>,
    /// Yaw in radians clockwise from north; along the course if left out.
    #[n(2)]
    pub yaw_rad: Option<f64>,
}

/// One piece: per axis the coefficients of a polynomial in the time since the piece began, constant term first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Encode, Decode)]
pub struct TrajectoryPiece {
    /// How long it takes in seconds.
    #[n(0)]
    pub duration_s: f64,
    /// North in metres, metres per second, …
    #[n(1)]
    pub north: Vec<f64>,
    /// East.
    #[n(2)]
    pub east: Vec<f64>,
    /// Down.
    #[n(3)]
    pub down: Vec<f64>,
}

/// How a formation's heading is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum FormationHeading {
    /// Always the same, in radians clockwise from north.
    #[n(0)]
    Fixed {
        /// Heading in radians.
        #[n(0)]
        heading_rad: f64,
        /// Limit of the turning rate on the way to it in radians per second, by what the outermost vehicle can fly; as the leader's
        /// model has it if left out.
        #[n(1)]
        #[serde(default)]
        max_rate_rad_s: Option<f64>,
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
#[derive(Debug, Clone, PartialEq)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Route {
    /// Corners to pass, then the end. The route starts where the leader is.
    #[n(0)]
    #[schemars(length(min = 1, max = 10_000))]
    pub waypoints: Vec<PositionNed>,
    /// Speed along it in metres per second.
    #[n(1)]
    #[schemars(range(max = 200.0), extend("exclusiveMinimum" = 0))]
    pub speed_m_s: f64,
    /// Radius of the rounded corners in metres.
    #[n(2)]
    #[schemars(range(min = 0.0, max = 100_000.0))]
    pub corner_radius_m: f64,
}

/// The anchor of a formation as its leader publishes it, once per control period: its reference while it is near
/// that, else its measured state, with its own feed-forward. Followers add their rotated slot to it.
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
    /// Its rate's rate in radians per second squared. Zero from who does not tell it.
    #[n(6)]
    #[cbor(default)]
    #[serde(default)]
    pub heading_acceleration_rad_s2: f64,
}
