//! The fleet as everyone outside the control path sees it: an immutable picture, made a few times a second. Reading it never waits for an actor.
//!
//! Must never do: decide anything, or hold what only one room understands.

use crate::health::{ActorHealth, PluginHealth};
use crate::swarm::SwarmSnapshot;
use serde::{Deserialize, Serialize};
use skein_domain::payload::{CoordinatorCapability, FrameHeader, PayloadKind, TrackEstimate};
use skein_domain::{
    Battery, EnergyState, FailsafeState, FlightLimits, FlightMode, FlightState, FormationRequest, Geodetic, Gnss,
    LandedState, LinkHealth, NodeId, NodeTime, PositionNed, Route, SwarmFrame, SystemId, VehicleId, VehicleWay,
    telemetry::VehicleKinematics,
};

/// The fleet at one moment.
#[derive(Debug, Clone, Default, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct FleetSnapshot {
    /// When it was made, on the node's clock.
    pub time: NodeTime,
    /// Grows with every snapshot.
    pub sequence: u64,
    /// The swarm's common frame, once known.
    pub frame: Option<SwarmFrame>,
    /// Adopted vehicles by ascending id.
    pub vehicles: Vec<VehicleSnapshot>,
    /// Vehicles that are heard but not flown, and why.
    pub unadopted: Vec<UnadoptedVehicle>,
    /// The formation being flown, if any.
    pub formation: Option<FormationSnapshot>,
    /// Actors of the node under supervision.
    pub actors: Vec<ActorHealth>,
    /// What is tracked: what was told, and what the swarm made of what its sensors saw.
    pub tracks: Vec<TrackEstimate>,
    /// The swarm this node is part of, if it is part of one.
    pub swarm: Option<SwarmSnapshot>,
    /// What an operator is asked after this node ended in flight and has started again.
    pub resume: Option<ResumeQuestion>,
}

/// Whether vehicles that were taken back after a restart of the node are to fly on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct ResumeQuestion {
    /// They hold where they are.
    pub vehicles: Vec<VehicleId>,
    /// Those that were not taken back.
    pub left: Vec<LeftVehicle>,
    /// A formation is flown on; else what each of them was commanded.
    pub formation: bool,
    /// Since when it is asked.
    pub since: NodeTime,
}

/// A vehicle that was not taken back after a restart of the node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct LeftVehicle {
    /// Which.
    pub vehicle: VehicleId,
    /// Why.
    pub why: String,
}

/// One vehicle at one moment.
#[derive(Debug, Clone, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct VehicleSnapshot {
    /// The swarm's id for it.
    pub id: VehicleId,
    /// The node of the swarm that flies it; absent for this node's own without a swarm.
    #[serde(default)]
    pub node: Option<NodeId>,
    /// Its name from the adoption rule.
    pub name: String,
    /// It is simulated, for all its node knows; who does not say so is real.
    #[serde(default)]
    pub simulated: bool,
    /// MAVLink system id on its link.
    pub system_id: SystemId,
    /// Name of the UAV-model plugin that flies it.
    pub plugin: String,
    /// Version of that plugin.
    pub plugin_version: String,
    /// Flight state as the model decides it.
    pub flight_state: FlightState,
    /// Why it is in that state; may be empty.
    pub state_detail: String,
    /// Autopilot mode.
    pub mode: FlightMode,
    /// Motors armed.
    pub armed: bool,
    /// On the ground or in the air.
    pub landed: LandedState,
    /// Whether the autopilot would arm; `None` until it says.
    pub ready_to_arm: Option<bool>,
    /// Place on Earth.
    pub global: Option<Geodetic>,
    /// Position, velocity, yaw in the swarm frame.
    pub kinematics: Option<VehicleKinematics>,
    /// Roll in radians.
    pub roll_rad: f32,
    /// Pitch in radians.
    pub pitch_rad: f32,
    /// Launch place.
    pub home: Option<Geodetic>,
    /// Battery.
    pub battery: Battery,
    /// Satellite navigation.
    pub gnss: Gnss,
    /// Link measured by this node.
    pub link: LinkHealth,
    /// Its two links, the preferred one first, where it has two; known at the node that flies it.
    #[serde(default)]
    pub ways: Vec<VehicleWay>,
    /// Seconds since the last frame was heard.
    pub age_s: f64,
    /// Where its task wants it now.
    pub slot: Option<PositionNed>,
    /// Distance to that place in metres.
    pub tracking_error_m: Option<f64>,
    /// Whether it leads.
    pub is_leader: bool,
    /// Its actor.
    pub actor: ActorHealth,
    /// Its UAV-model plugin instance.
    pub model: PluginHealth,
    /// What the model reports of itself, as its state schema has it.
    #[ts(type = "unknown")]
    pub model_state: Option<serde_json::Value>,
    /// What is changed of its setpoints at this moment; absent if nothing.
    pub avoiding: Option<Avoidance>,
    /// What is wrong with it in flight and what is done about it; absent if nothing is.
    pub failsafe: Option<FailsafeState>,
    /// Its charge against its way home; absent as long as one of them is not known.
    pub energy: Option<EnergyState>,
    /// Its motors were stopped in an emergency.
    pub stopped: bool,
    /// What it can do, if its model says.
    pub limits: Option<FlightLimits>,
    /// Whether it can host the coordinator; absent if its model does not say.
    pub capability: Option<CoordinatorCapability>,
    /// What it carries, by name.
    pub payloads: Vec<PayloadSnapshot>,
    /// Why it can do less than it was built for; empty if nothing is amiss.
    pub degraded: Vec<String>,
}

/// One payload at one moment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct PayloadSnapshot {
    /// Its name on the vehicle.
    pub name: String,
    /// What it is.
    pub kind: PayloadKind,
    /// Its actor.
    pub actor: ActorHealth,
    /// Its plugin instance.
    pub plugin: PluginHealth,
    /// What it reports of itself, as its state schema has it; absent while it does not run.
    #[ts(type = "unknown")]
    pub state: Option<serde_json::Value>,
    /// Why its transport does not work; empty if it does or has none.
    pub transport_fault: String,
    /// The last frame it gave.
    pub frame: Option<FrameHeader>,
}

/// A vehicle that is heard but not flown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct UnadoptedVehicle {
    /// Its system id.
    pub system_id: SystemId,
    /// The endpoint it is heard on.
    pub endpoint: String,
    /// Why it is not flown, one sentence.
    pub why: String,
}

/// What is changed of a vehicle's setpoints at a moment, to keep it off others or inside of a fence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct Avoidance {
    /// How far the flown velocity is from the wanted one, in metres per second.
    pub by_m_s: f64,
    /// Because of whom, in words; absent if because of a fence.
    pub because: Option<String>,
    /// How far that is away now, in metres.
    pub distance_m: Option<f64>,
    /// How near the wanted velocity would have come, in metres.
    pub predicted_m: Option<f64>,
    /// Whether the distance can be kept. If not, the vehicle is kept as far away as it can be.
    pub feasible: bool,
}

/// The formation being flown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct FormationSnapshot {
    /// What was asked for, with the defaults filled in.
    pub request: FormationRequest,
    /// Who leads; nobody if it is anchored to something else than a vehicle.
    pub leader: Option<VehicleId>,
    /// The anchor at this moment.
    pub anchor: Option<PositionNed>,
    /// Its members keep their places by their neighbours now.
    pub keeps_itself: bool,
    /// How fast it can go as a whole, in metres per second.
    pub max_speed_m_s: f64,
    /// Who takes part, leader first.
    pub members: Vec<VehicleId>,
    /// Members that carry a camera and whose places leave it no free view, neither ahead nor outwards.
    pub view_blocked: Vec<VehicleId>,
    /// The leader's route, if one is being flown.
    pub route: Option<Route>,
    /// Whether the leader has come to the end of its route.
    pub route_finished: bool,
    /// When all are to be in their slots.
    pub settled_at: NodeTime,
    /// Smallest distance between any two vehicles that the plan of the change foresees, in metres; null for one alone.
    pub planned_min_distance_m: Option<f64>,
    /// Intent version of the last change.
    pub intent_version: u64,
}
