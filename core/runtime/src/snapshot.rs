//! What everyone outside the control path reads: an immutable picture of the fleet, made a few times a second, and the stream of
//! events. Reading it never waits for an actor.

use serde::Serialize;
use skein_domain::exchange::{CommandProgress, Severity};
use skein_domain::{
    Battery, CommandId, FlightMode, FlightState, FormationRequest, Geodetic, Gnss, Incarnation, LandedState,
    LinkHealth, NodeTime, PositionNed, Refusal, Route, SwarmFrame, SystemId, VehicleId, telemetry::VehicleKinematics,
};

/// The fleet at one moment.
#[derive(Debug, Clone, Default, Serialize, ts_rs::TS, schemars::JsonSchema)]
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
}

/// One vehicle at one moment.
#[derive(Debug, Clone, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct VehicleSnapshot {
    /// The swarm's id for it.
    pub id: VehicleId,
    /// Its name from the adoption rule.
    pub name: String,
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
    pub model: ActorHealth,
}

/// A supervised actor or plugin instance.
#[derive(Debug, Clone, Default, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct ActorHealth {
    /// Name in the supervision tree, for example `vehicle-3`.
    pub name: String,
    /// Running, restarting after back-off, or given up.
    pub status: ActorStatus,
    /// How many times it was started.
    pub incarnation: Incarnation,
    /// The last error that ended it; empty if none did.
    pub last_error: String,
    /// Since when it has this status.
    pub since: NodeTime,
}

/// What a supervised actor is doing.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    Serialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
#[serde(rename_all = "snake_case")]
pub enum ActorStatus {
    /// Running.
    #[default]
    Running,
    /// Ended by a failure, starts again after its back-off.
    Restarting,
    /// Failed too often; an operator must look.
    GivenUp,
}

/// A vehicle that is heard but not flown.
#[derive(Debug, Clone, PartialEq, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct UnadoptedVehicle {
    /// Its system id.
    pub system_id: SystemId,
    /// The endpoint it is heard on.
    pub endpoint: String,
    /// Why it is not flown, one sentence.
    pub why: String,
}

/// The formation being flown.
#[derive(Debug, Clone, PartialEq, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct FormationSnapshot {
    /// What was asked for, with the defaults filled in.
    pub request: FormationRequest,
    /// Who leads.
    pub leader: VehicleId,
    /// Who takes part, leader first.
    pub members: Vec<VehicleId>,
    /// The leader's route, if one is being flown.
    pub route: Option<Route>,
    /// Whether the leader has come to the end of its route.
    pub route_finished: bool,
    /// When all are to be in their slots.
    pub settled_at: NodeTime,
    /// Smallest distance between any two vehicles that the plan of the change foresees, in metres.
    pub planned_min_distance_m: f64,
    /// Intent version of the last change.
    pub intent_version: u64,
}

/// One thing that happened.
#[derive(Debug, Clone, PartialEq, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct EventRecord {
    /// Grows by one with every event of this node.
    pub seq: u64,
    /// When.
    pub time: NodeTime,
    /// About which vehicle, if about one.
    pub vehicle: Option<VehicleId>,
    /// How urgent.
    pub severity: Severity,
    /// What.
    pub kind: EventKind,
    /// One sentence for the operator.
    pub text: String,
}

/// What kind of thing happened.
#[derive(Debug, Clone, PartialEq, Serialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum EventKind {
    /// A vehicle was found and taken into the swarm.
    Adopted,
    /// A vehicle is heard but not flown.
    NotAdopted,
    /// A vehicle is not heard any more.
    LinkLost,
    /// It is heard again.
    LinkRegained,
    /// Its autopilot restarted.
    AutopilotRebooted,
    /// Its flight state changed.
    FlightState {
        /// The new state.
        state: FlightState,
    },
    /// A command went on.
    Command {
        /// Which.
        id: CommandId,
        /// Its name.
        command: String,
        /// How.
        progress: CommandProgress,
    },
    /// Something was refused outside of a command (a setpoint, an effect).
    Refused {
        /// Why.
        refusal: Refusal,
    },
    /// The formation was changed, or its leader.
    Formation,
    /// An actor or plugin ended and what its supervisor does about it.
    Supervision {
        /// Name in the supervision tree.
        actor: String,
        /// What it is doing now.
        status: ActorStatus,
    },
    /// The setpoint stream went over to holding, or was given up.
    Stream,
    /// A status text of the autopilot.
    StatusText,
    /// Anything else a plugin or actor wants known.
    Notice,
}
