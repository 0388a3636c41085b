//! What is asked for when vehicles are to fly along waypoints smoothly and in step, and what became of it. The planning itself is
//! `skein-flight`'s; what is flown in the end is [`crate::Trajectory`].
//!
//! Must never do: plan or judge anything.

use crate::{NodeTime, PositionNed, Refusal, VehicleId};
use serde::{Deserialize, Serialize};

/// What is made as small as possible along a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TrajectoryKind {
    /// The jerk: quicker.
    #[default]
    Jerk,
    /// The snap: rounder, for payloads and large airframes.
    Snap,
}

/// When all begin, on the node's clock.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "when", rename_all = "snake_case", deny_unknown_fields)]
pub enum TrajectoryStart {
    /// As soon as all know of it.
    #[default]
    Soon,
    /// So many seconds after the request came in.
    In {
        /// Seconds.
        #[schemars(range(min = 0.0, max = 3600.0))]
        in_s: f64,
    },
    /// At a time of the node's clock.
    At {
        /// Microseconds since the node started, as in `GET /api/v1/health`.
        time: NodeTime,
    },
}

/// The way of one vehicle.
#[derive(Debug, Clone, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JourneyRequest {
    /// The vehicle.
    pub vehicle: VehicleId,
    /// The places it passes, in the swarm's frame; it stops at the last.
    #[schemars(length(min = 1, max = 200))]
    pub waypoints: Vec<PositionNed>,
}

/// Ways that are planned together: all start at one time and pass their k-th waypoints at one time, as slowly as the slowest needs.
#[derive(Debug, Clone, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrajectoryRequest {
    /// Who flies where.
    #[schemars(length(min = 1, max = 64))]
    pub vehicles: Vec<JourneyRequest>,
    /// How smooth.
    #[serde(default)]
    pub kind: TrajectoryKind,
    /// When it begins.
    #[serde(default)]
    pub start: TrajectoryStart,
    /// No faster than this, in metres per second; as fast as vehicles and gate permit if left out.
    #[serde(default)]
    #[schemars(range(max = 200.0), extend("exclusiveMinimum" = 0))]
    pub max_speed_m_s: Option<f64>,
    /// The ways are put on the vehicles' autopilots as missions as well. They are flown by setpoints all the same.
    #[serde(default)]
    pub upload: bool,
}

/// The planned way of one vehicle.
#[derive(Debug, Clone, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct JourneyPlan {
    /// The vehicle.
    pub vehicle: VehicleId,
    /// How long it takes in seconds.
    pub duration_s: f64,
    /// How long the way is, in metres.
    pub length_m: f64,
    /// When it passes each of its waypoints, in seconds after the start.
    pub passes_s: Vec<f64>,
    /// Its largest speed in metres per second: never exceeded, and reached to within a few in a thousand.
    pub max_speed_m_s: f64,
    /// Its largest acceleration in metres per second squared.
    pub max_acceleration_m_s2: f64,
}

/// Ways planned together.
#[derive(Debug, Clone, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct TrajectoryPlan {
    /// When all begin, on the node's clock.
    pub start: NodeTime,
    /// How long after the plan was made that is, in seconds.
    pub starts_in_s: f64,
    /// When the last of them arrives, in seconds after the start.
    pub duration_s: f64,
    /// None of them comes nearer than this to another or to anything that stands in the air, in metres: a proven lower bound. Heights
    /// count by less, as the separation filter counts them. Absent if there is nothing to come near to.
    pub min_distance_m: Option<f64>,
    /// Which two come that near.
    pub nearest: Option<(VehicleId, VehicleId)>,
    /// One by one.
    pub vehicles: Vec<JourneyPlan>,
}

/// One reason against a plan.
#[derive(Debug, Clone, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct TrajectoryObjection {
    /// Whose way it is about; absent if about all of them.
    pub vehicle: Option<VehicleId>,
    /// The reason.
    pub refusal: Refusal,
}

impl std::fmt::Display for TrajectoryObjection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.vehicle {
            Some(vehicle) => write!(f, "vehicle {vehicle}: {}", self.refusal),
            None => self.refusal.fmt(f),
        }
    }
}

/// How a vehicle is getting on with its trajectory.
#[derive(Debug, Clone, PartialEq, Eq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum TrajectoryProgress {
    /// It waits for the start.
    Waiting,
    /// It is under way.
    Flying,
    /// It has come to the end and holds there.
    Flown,
    /// It does something else by now.
    Ended {
        /// Why.
        why: String,
    },
}

/// What became of putting a route on a vehicle.
#[derive(Debug, Clone, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum RouteUpload {
    /// It is being sent.
    Sending {
        /// So many points.
        points: u16,
    },
    /// The autopilot has it.
    Held {
        /// So many points.
        points: u16,
    },
    /// The autopilot does not have it.
    Failed {
        /// Why.
        refusal: Refusal,
    },
}

/// A vehicle's trajectory and how it is getting on.
#[derive(Debug, Clone, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct TrajectoryStatus {
    /// The vehicle.
    pub vehicle: VehicleId,
    /// When it begins, on the node's clock.
    pub start: NodeTime,
    /// As planned.
    pub plan: JourneyPlan,
    /// The waypoints.
    pub waypoints: Vec<PositionNed>,
    /// How many of them it has passed.
    pub passed: u32,
    /// Seconds since the start; negative before it.
    pub elapsed_s: f64,
    /// How it is getting on.
    pub progress: TrajectoryProgress,
    /// The route on its autopilot; absent if none was asked for.
    pub upload: Option<RouteUpload>,
}
