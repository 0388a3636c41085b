//! What crosses the plugin boundary, as CBOR with numbered fields: events in, effects out. Numbers are never reused; a reader
//! skips numbers it does not know, so that an older plugin works with a newer host and the other way round.

use crate::payload::{CoordinatorCapability, FrameHeader, MavlinkMessage, PayloadKind, Track};
use crate::preflight::PreflightItem;
use crate::telemetry::VehicleKinematics;
use crate::{
    AnchorReference, AutopilotCommand, Battery, CommandId, FlightLimits, FlightMode, FlightState, Geodetic,
    Incarnation, LandedState, NodeTime, PositionNed, Refusal, RequestId, Setpoint, Stick, SystemId, VehicleCommand,
    VehicleId, VehicleTask,
};
use minicbor::{Decode, Encode};

/// Schema id of [`Create`].
pub const CREATE_SCHEMA: u32 = 1;
/// Schema id of [`EventBatch`]: changes only when the meaning of a number changes.
pub const EVENT_BATCH_SCHEMA: u32 = 1;
/// Schema id of [`EffectBatch`].
pub const EFFECT_BATCH_SCHEMA: u32 = 1;

/// What an instance is told when it is created.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub struct Create {
    /// The vehicle it flies, or that carries it.
    #[n(0)]
    pub vehicle: VehicleId,
    /// The instance's incarnation, from 1.
    #[n(1)]
    pub incarnation: Incarnation,
    /// The instance's configuration as JSON text; `{}` if none was given.
    #[n(2)]
    pub config_json: String,
    /// What the previous incarnation last gave as its snapshot; absent at the first start.
    #[n(3)]
    #[cbor(with = "minicbor::bytes")]
    pub snapshot: Option<Vec<u8>>,
    /// Now.
    #[n(4)]
    pub now: NodeTime,
    /// The payload's name on its vehicle; absent for a UAV model.
    #[n(5)]
    pub payload: Option<String>,
    /// System id of the vehicle on its link; absent if it has none.
    #[n(6)]
    pub system_id: Option<SystemId>,
}

/// All events of one period.
#[derive(Debug, Clone, PartialEq, Default, Encode, Decode)]
pub struct EventBatch {
    /// Now.
    #[n(0)]
    pub now: NodeTime,
    /// Oldest first; a [`Event::Tick`], if any, comes last.
    #[n(1)]
    pub events: Vec<Event>,
}

/// One event.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub enum Event {
    /// The control period: make a setpoint if one is due.
    #[n(0)]
    Tick,
    /// The vehicle's own state, once per period before the tick.
    #[n(1)]
    Own(#[n(0)] OwnState),
    /// The task in the intent changed.
    #[n(2)]
    Task(#[n(0)] VehicleTask),
    /// The anchor of the formation this vehicle follows, as its leader last published it.
    #[n(3)]
    Anchor(#[n(0)] AnchorReference),
    /// An operator's command.
    #[n(4)]
    Command {
        /// Its id, for the outcome.
        #[n(0)]
        id: CommandId,
        /// The command.
        #[n(1)]
        command: VehicleCommand,
        /// Not to be begun before this time (staggered take-off).
        #[n(2)]
        not_before: NodeTime,
    },
    /// The autopilot's answer to a request.
    #[n(5)]
    AutopilotResult {
        /// Which request.
        #[n(0)]
        request: RequestId,
        /// Why not; absent if accepted.
        #[n(1)]
        refusal: Option<Refusal>,
    },
    /// The autopilot's mode changed.
    #[n(6)]
    ModeChanged {
        /// Before.
        #[n(0)]
        from: FlightMode,
        /// Now.
        #[n(1)]
        to: FlightMode,
        /// Whether it was asked for from here.
        #[n(2)]
        commanded: bool,
    },
    /// The link was lost (true) or regained (false).
    #[n(7)]
    LinkLost(#[n(0)] bool),
    /// The autopilot restarted.
    #[n(8)]
    Rebooted,
    /// The gate refused the last setpoint or command effect.
    #[n(9)]
    Refused(#[n(0)] Refusal),
    /// A drill: fail in this way, on purpose. Handled by the SDK before the plugin sees it.
    #[n(10)]
    FaultDrill(#[n(0)] FaultDrill),
    /// A command to this payload, as its command schema has it; the host has checked it against that.
    #[n(11)]
    PayloadCommand {
        /// Its id, for the outcome.
        #[n(0)]
        id: CommandId,
        /// The command as JSON text.
        #[n(1)]
        command_json: String,
    },
    /// A MAVLink message that the manifest asks for arrived from this vehicle's system.
    #[n(12)]
    Mavlink(#[n(0)] MavlinkMessage),
    /// Bytes arrived on the payload's own transport: a datagram, or what a serial line gave.
    #[n(13)]
    Received {
        /// The bytes.
        #[n(0)]
        #[cbor(with = "minicbor::bytes")]
        bytes: Vec<u8>,
    },
    /// A payload of the same vehicle reports its state: when it changes, and to a new instance.
    #[n(14)]
    Payload(#[n(0)] PayloadReport),
    /// Where the other vehicles are, once per period before the tick; those with a position, by ascending id.
    #[n(15)]
    Peers(#[n(0)] Vec<PeerState>),
    /// A frame of a camera of the same vehicle. Its bytes can be read during this call.
    #[n(16)]
    Frame(#[n(0)] FrameHeader),
    /// Everything tracked, when it changes.
    #[n(17)]
    Tracks(#[n(0)] Vec<Track>),
    /// A payload's answer to a request of the UAV model: accepted and begun, or why not.
    #[n(18)]
    PayloadResult {
        /// Which request.
        #[n(0)]
        request: RequestId,
        /// Why not; absent if accepted.
        #[n(1)]
        refusal: Option<Refusal>,
    },
    /// How somebody who steers the vehicle by hand wants it to move: the newest, once per period at most.
    #[n(19)]
    Stick(#[n(0)] Stick),
}

/// What a payload last reported.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub struct PayloadReport {
    /// Its name on the vehicle.
    #[n(0)]
    pub name: String,
    /// What it is.
    #[n(1)]
    pub kind: PayloadKind,
    /// Its state as JSON text; absent while it has not reported or is not running.
    #[n(2)]
    pub state_json: Option<String>,
}

/// Another vehicle as a plugin sees it.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub struct PeerState {
    /// Which.
    #[n(0)]
    pub id: VehicleId,
    /// Position, velocity and yaw in the swarm frame.
    #[n(1)]
    pub kinematics: VehicleKinematics,
    /// It flies.
    #[n(2)]
    pub airborne: bool,
}

/// How to fail in a drill.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Encode, Decode)]
#[cbor(index_only)]
pub enum FaultDrill {
    /// Panic.
    #[n(0)]
    Panic,
    /// Never return.
    #[n(1)]
    Hang,
    /// End the process. In the node's own process this is the end of the node: only ever given to instances in a child process.
    #[n(2)]
    Abort,
}

/// The vehicle's own state as its model sees it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Encode, Decode)]
pub struct OwnState {
    /// Position, velocity and yaw in the swarm frame; absent without an estimate.
    #[n(0)]
    pub kinematics: Option<VehicleKinematics>,
    /// Mode.
    #[n(1)]
    pub mode: FlightMode,
    /// Armed.
    #[n(2)]
    pub armed: bool,
    /// Landed or not.
    #[n(3)]
    pub landed: LandedState,
    /// Whether the autopilot would arm; absent until it says.
    #[n(4)]
    pub ready_to_arm: Option<bool>,
    /// Launch place in the swarm frame.
    #[n(5)]
    pub home: Option<PositionNed>,
    /// Battery.
    #[n(6)]
    pub battery: Battery,
    /// Frames arrive.
    #[n(7)]
    pub link_connected: bool,
    /// Roll in radians.
    #[n(8)]
    pub roll_rad: Option<f64>,
    /// Pitch in radians.
    #[n(9)]
    pub pitch_rad: Option<f64>,
    /// Place on Earth.
    #[n(10)]
    pub global: Option<Geodetic>,
    /// Origin of the swarm frame, so that a position in it can be turned into a place on Earth.
    #[n(11)]
    pub frame_origin: Option<Geodetic>,
    /// Share of frames lost on the vehicle's link, 0..=1, as the node measures it.
    #[n(12)]
    pub link_loss: Option<f64>,
    /// Round trip on the vehicle's link in seconds, as the node measures it.
    #[n(13)]
    pub link_round_trip_s: Option<f64>,
}

/// All effects of one period.
#[derive(Debug, Clone, PartialEq, Default, Encode, Decode)]
pub struct EffectBatch {
    /// In the order they are to be carried out.
    #[n(0)]
    pub effects: Vec<Effect>,
}

/// One effect.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub enum Effect {
    /// Stream this setpoint (through the gate).
    #[n(0)]
    Setpoint(#[n(0)] Setpoint),
    /// End the setpoint stream on purpose.
    #[n(1)]
    StopStream,
    /// Ask the autopilot (through the gate).
    #[n(2)]
    Autopilot {
        /// Chosen by the plugin; the result refers to it.
        #[n(0)]
        request: RequestId,
        /// What is asked.
        #[n(1)]
        command: AutopilotCommand,
    },
    /// How an operator's command goes on.
    #[n(3)]
    CommandProgress {
        /// Which command.
        #[n(0)]
        id: CommandId,
        /// How.
        #[n(1)]
        progress: CommandProgress,
    },
    /// The flight state changed.
    #[n(4)]
    State {
        /// The new state.
        #[n(0)]
        state: FlightState,
        /// Why, for the operator; may be empty.
        #[n(1)]
        detail: String,
    },
    /// What followers use as their anchor, while leading.
    #[n(5)]
    Anchor(#[n(0)] AnchorReference),
    /// Something worth an operator's attention.
    #[n(6)]
    Notice {
        /// How urgent.
        #[n(0)]
        severity: Severity,
        /// One sentence.
        #[n(1)]
        text: String,
    },
    /// How far the vehicle is from where its task wants it, in metres; absent when it has no slot or goal.
    #[n(7)]
    TrackingError {
        /// Distance in metres.
        #[n(0)]
        distance_m: f64,
    },
    /// The leader has come to the end of its route.
    #[n(8)]
    RouteFinished,
    /// Send a MAVLink message to this vehicle's system. The gate lets through only what payloads of this kind are for.
    #[n(9)]
    Mavlink(#[n(0)] MavlinkMessage),
    /// Send bytes on the payload's own transport.
    #[n(10)]
    Transmit {
        /// The bytes; one datagram where the transport has such.
        #[n(0)]
        #[cbor(with = "minicbor::bytes")]
        bytes: Vec<u8>,
    },
    /// The plugin's own state, as its state schema has it. Latest wins; say it when it changes.
    #[n(11)]
    Report {
        /// As JSON text.
        #[n(0)]
        state_json: String,
    },
    /// Something happened that is worth a record, as the plugin's event schema has it.
    #[n(12)]
    Occurrence {
        /// As JSON text.
        #[n(0)]
        event_json: String,
    },
    /// A UAV model asks a payload of its own vehicle for something.
    #[n(13)]
    PayloadCommand {
        /// Chosen by the model; the result refers to it.
        #[n(0)]
        request: RequestId,
        /// The payload's name on the vehicle.
        #[n(1)]
        payload: String,
        /// The command as JSON text.
        #[n(2)]
        command_json: String,
    },
    /// A camera gives a frame.
    #[n(14)]
    Frame(#[n(0)] FrameHeader),
    /// Whether the vehicle can host the coordinator.
    #[n(15)]
    Capability(#[n(0)] CoordinatorCapability),
    /// What the vehicle can do; latest wins.
    #[n(16)]
    Limits(#[n(0)] FlightLimits),
    /// What the plugin has to say before the vehicle is armed; replaces what it said before. The ids of its items begin with its name and
    /// a slash.
    #[n(17)]
    Preflight(#[n(0)] Vec<PreflightItem>),
}

/// How a command goes on.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
#[derive(serde::Serialize, serde::Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "progress", rename_all = "snake_case")]
pub enum CommandProgress {
    /// Taken up; being carried out.
    #[n(0)]
    Executing,
    /// What was asked for is the case.
    #[n(1)]
    Done,
    /// Not carried out, or broken off.
    #[n(2)]
    Refused {
        /// Why.
        #[n(0)]
        refusal: Refusal,
    },
}

/// How urgent a notice is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Encode, Decode)]
#[derive(serde::Serialize, serde::Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
#[cbor(index_only)]
pub enum Severity {
    /// For the record.
    #[n(0)]
    Info,
    /// An automatic reaction that an operator should know of.
    #[n(1)]
    Advisory,
    /// Needs attention.
    #[n(2)]
    Warning,
    /// Needs action now.
    #[n(3)]
    Critical,
}

#[cfg(test)]
mod tests;
