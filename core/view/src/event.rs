//! What happened, in the form that operators, programs and other nodes are told it.
//!
//! Must never do: lose the vehicle or the time that an event is about.

use crate::health::ActorStatus;
use serde::{Deserialize, Serialize};
use skein_domain::exchange::{CommandProgress, Severity};
use skein_domain::{CommandId, FailsafeEvent, FlightMode, FlightState, NodeId, NodeTime, Refusal, VehicleId};

/// One thing that happened.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct EventRecord {
    /// Grows by one with every event of this node.
    pub seq: u64,
    /// When.
    pub time: NodeTime,
    /// On which other node of the swarm; absent if on this one.
    #[serde(default)]
    pub node: Option<NodeId>,
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
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
    /// It was taken out of the swarm's control.
    TakenOver {
        /// By its autopilot's own failsafe; else by a pilot or another ground station.
        failsafe: bool,
        /// The mode that was left.
        from: FlightMode,
        /// The mode it is in now.
        to: FlightMode,
    },
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
    /// Something is wrong with a vehicle, or something is done about it.
    Failsafe {
        /// What.
        event: FailsafeEvent,
    },
    /// A setpoint is changed to keep a vehicle off others or inside of a fence.
    Avoidance,
    /// The fences were replaced.
    Fences,
    /// Red items of a preflight report were overridden, or made use of.
    Preflight,
    /// The emergency stop was unlocked or used.
    EmergencyStop,
    /// A parameter of its autopilot was written, or was to be.
    Parameter {
        /// Its name.
        name: String,
    },
    /// The formation was changed, or its leader.
    Formation,
    /// Trajectories were planned, ended, or put on a vehicle.
    Trajectory,
    /// An actor or plugin ended and what its supervisor does about it.
    Supervision {
        /// Name in the supervision tree.
        actor: String,
        /// What it is doing now.
        status: ActorStatus,
    },
    /// The setpoint stream went over to holding, or was given up.
    Stream,
    /// Something tracked has begun or ended, or an operator named, pinned or dropped it.
    Track {
        /// Its number.
        #[ts(type = "number")]
        track: u64,
    },
    /// A status text of the autopilot.
    StatusText,
    /// A payload tells of something, as its event schema has it.
    Occurrence {
        /// The payload's name on the vehicle; absent for the UAV model.
        payload: Option<String>,
        /// What it tells.
        #[ts(type = "unknown")]
        event: serde_json::Value,
    },
    /// A payload was attached, detached or given up.
    Payload {
        /// Its name on the vehicle.
        payload: String,
    },
    /// A plugin was found, exchanged for another version, rolled back or removed.
    Plugin {
        /// Its name.
        plugin: String,
    },
    /// A node came into the swarm or left it, or another one coordinates.
    Swarm,
    /// The control loop of this node came late: its computer was busy with something else, or stood still. What is told of several vehicles
    /// right after it may have this cause.
    Overrun {
        /// By how much, in seconds.
        by_s: f64,
    },
    /// It has come in time for a while.
    OverrunEnded,
    /// Recording was interrupted, goes on, or dropped something.
    Recorder,
    /// An operator has seen alerts. It counts at the node that it was said to.
    Acknowledged {
        /// Their numbers, at this node.
        #[ts(type = "number[]")]
        events: Vec<u64>,
    },
    /// Anything else a plugin or actor wants known.
    Notice,
}
