//! Why something was refused: one typed reason from the gate, the model, the link or the autopilot to whoever asked.

use crate::{FlightState, Incarnation, VehicleId};
use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A typed refusal. Its display text is the sentence an operator reads.
#[derive(Debug, Clone, PartialEq, Error)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum Refusal {
    /// No vehicle of that id is known here.
    #[error("there is no vehicle {vehicle}")]
    #[n(0)]
    UnknownVehicle {
        /// The id asked for.
        #[n(0)]
        vehicle: VehicleId,
    },
    /// The vehicle is known but not heard.
    #[error("the link to vehicle {vehicle} is lost")]
    #[n(1)]
    LinkLost {
        /// Its id.
        #[n(0)]
        vehicle: VehicleId,
    },
    /// The flight state does not allow the command.
    #[error("cannot {command} while {state}")]
    #[n(2)]
    WrongState {
        /// The state the vehicle is in.
        #[n(0)]
        state: FlightState,
        /// The command's name.
        #[n(1)]
        command: String,
    },
    /// A human pilot or the autopilot's own failsafe is flying.
    #[error("the pilot or the autopilot's failsafe is in control")]
    #[n(3)]
    PilotInControl,
    /// The autopilot says it cannot be armed now.
    #[error("not ready to arm: {detail}")]
    #[n(4)]
    NotReadyToArm {
        /// What the autopilot says.
        #[n(0)]
        detail: String,
    },
    /// The autopilot refused; its result code in words and the status text that came with it.
    #[error("autopilot: {result}{}", if text.is_empty() { String::new() } else { format!(" ({text})") })]
    #[n(5)]
    Autopilot {
        /// The result of the acknowledgement, for example `temporarily_rejected`.
        #[n(0)]
        result: String,
        /// Status text sent beside it, empty if none came.
        #[n(1)]
        text: String,
    },
    /// No acknowledgement after all retries, or the state that should have followed did not come.
    #[error("no answer to {what} within {after_s:.1} s")]
    #[n(6)]
    TimedOut {
        /// What was waited for.
        #[n(0)]
        what: String,
        /// For how long, in seconds.
        #[n(1)]
        after_s: f64,
    },
    /// A newer command replaced it before it was done.
    #[error("replaced by a newer command")]
    #[n(7)]
    Superseded,
    /// A setpoint or goal is outside of the fence.
    #[error("outside the fence: {detail}")]
    #[n(8)]
    OutsideFence {
        /// Which limit, with value and limit.
        #[n(0)]
        detail: String,
    },
    /// Faster than allowed.
    #[error("{speed_m_s:.1} m/s is over the limit of {limit_m_s:.1} m/s")]
    #[n(9)]
    TooFast {
        /// Asked speed in metres per second.
        #[n(0)]
        speed_m_s: f64,
        /// The limit in metres per second.
        #[n(1)]
        limit_m_s: f64,
    },
    /// It would bring two vehicles too close.
    #[error("{distance_m:.1} m from vehicle {other}, under the limit of {limit_m:.1} m")]
    #[n(10)]
    TooClose {
        /// The other vehicle.
        #[n(0)]
        other: VehicleId,
        /// Predicted distance in metres.
        #[n(1)]
        distance_m: f64,
        /// The limit in metres.
        #[n(2)]
        limit_m: f64,
    },
    /// A number is not finite, a list is empty, a value is out of its range.
    #[error("invalid value: {detail}")]
    #[n(11)]
    InvalidValue {
        /// Which value and what would be right.
        #[n(0)]
        detail: String,
    },
    /// The swarm's common frame is not set yet, so that no position has a meaning.
    #[error("the swarm frame is not known yet")]
    #[n(12)]
    NoSwarmFrame,
    /// The vehicle has no usable position estimate.
    #[error("no position estimate")]
    #[n(13)]
    NoPosition,
    /// Not enough vehicles are in the air for it.
    #[error("{have} vehicles are available, {need} are needed")]
    #[n(14)]
    NotEnoughVehicles {
        /// Available.
        #[n(0)]
        have: u32,
        /// Needed.
        #[n(1)]
        need: u32,
    },
    /// The message was meant for an earlier incarnation.
    #[error("incarnation {got} is stale, {current} is running")]
    #[n(15)]
    StaleIncarnation {
        /// What the message carried.
        #[n(0)]
        got: Incarnation,
        /// What is running.
        #[n(1)]
        current: Incarnation,
    },
    /// Two vehicles with one system id are heard at one place, where what is sent reaches both: nothing is begun with them.
    #[error("two vehicles use system id {system_id}")]
    #[n(16)]
    DuplicateSystemId {
        /// The system id.
        #[n(0)]
        system_id: u8,
    },
    /// The plugin or actor that should do it is being restarted or has been given up.
    #[error("{what} is not running")]
    #[n(17)]
    NotRunning {
        /// Which part.
        #[n(0)]
        what: String,
    },
    /// The effect or operation is not permitted by the manifest or the configuration.
    #[error("not permitted: {detail}")]
    #[n(18)]
    NotPermitted {
        /// What and why.
        #[n(0)]
        detail: String,
    },
    /// What was asked cannot be done by this vehicle, model or payload at all.
    #[error("not supported: {detail}")]
    #[n(19)]
    NotSupported {
        /// What cannot be done, and by what.
        #[n(0)]
        detail: String,
    },
    /// No payload of that name is on the vehicle.
    #[error("vehicle {vehicle} has no payload \"{payload}\"")]
    #[n(20)]
    UnknownPayload {
        /// The vehicle.
        #[n(0)]
        vehicle: VehicleId,
        /// The name asked for.
        #[n(1)]
        payload: String,
    },
    /// Nothing with that number is tracked.
    #[error("there is no track {track}")]
    #[n(21)]
    UnknownTrack {
        /// The number asked for.
        #[n(0)]
        track: u64,
    },
    /// Red items of the preflight report that nobody has overridden.
    #[error("preflight: {}", items.join(", "))]
    #[n(22)]
    Preflight {
        /// Ids of the items.
        #[n(0)]
        items: Vec<String>,
    },
    /// Nothing of that name is known as a reference for a formation.
    #[error("there is no reference \"{name}\"")]
    #[n(23)]
    UnknownReference {
        /// The name asked for.
        #[n(0)]
        name: String,
    },
    /// A time cannot be kept, or a clock cannot be relied on.
    #[error("clock: {detail}")]
    #[n(24)]
    Clock {
        /// Which, and what would be right.
        #[n(0)]
        detail: String,
    },
    /// Another operator has control authority over the vehicle.
    #[error("{holder} has control authority over vehicle {vehicle}: ask for it")]
    #[n(25)]
    NoControlAuthority {
        /// The vehicle.
        #[n(0)]
        vehicle: VehicleId,
        /// What the other is called.
        #[n(1)]
        holder: String,
    },
    /// It did not leave this computer: no line to the vehicle took it.
    #[error("not sent: {detail}")]
    #[n(26)]
    NotSent {
        /// What happened instead, and what will be done.
        #[n(0)]
        detail: String,
    },
}

impl Refusal {
    /// A value that makes no sense: which, and what would be right.
    pub fn invalid(detail: impl Into<String>) -> Self {
        let detail = detail.into();
        Self::InvalidValue { detail }
    }

    /// Something that is not done, and why.
    pub fn not_permitted(detail: impl Into<String>) -> Self {
        let detail = detail.into();
        Self::NotPermitted { detail }
    }

    /// Something that this vehicle, payload or link cannot do.
    pub fn not_supported(detail: impl Into<String>) -> Self {
        let detail = detail.into();
        Self::NotSupported { detail }
    }

    /// What did not come within a time.
    pub fn timed_out(what: impl Into<String>, after_s: f64) -> Self {
        let what = what.into();
        Self::TimedOut { what, after_s }
    }

    /// A part of the program that is not there to answer.
    pub fn not_running(what: impl Into<String>) -> Self {
        let what = what.into();
        Self::NotRunning { what }
    }

    /// The machine-readable word for the reason, as in JSON.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::UnknownVehicle { .. } => "unknown_vehicle",
            Self::LinkLost { .. } => "link_lost",
            Self::WrongState { .. } => "wrong_state",
            Self::PilotInControl => "pilot_in_control",
            Self::NotReadyToArm { .. } => "not_ready_to_arm",
            Self::Autopilot { .. } => "autopilot",
            Self::TimedOut { .. } => "timed_out",
            Self::Superseded => "superseded",
            Self::OutsideFence { .. } => "outside_fence",
            Self::TooFast { .. } => "too_fast",
            Self::TooClose { .. } => "too_close",
            Self::InvalidValue { .. } => "invalid_value",
            Self::NoSwarmFrame => "no_swarm_frame",
            Self::NoPosition => "no_position",
            Self::NotEnoughVehicles { .. } => "not_enough_vehicles",
            Self::StaleIncarnation { .. } => "stale_incarnation",
            Self::DuplicateSystemId { .. } => "duplicate_system_id",
            Self::NoControlAuthority { .. } => "no_control_authority",
            Self::NotRunning { .. } => "not_running",
            Self::NotPermitted { .. } => "not_permitted",
            Self::NotSupported { .. } => "not_supported",
            Self::UnknownPayload { .. } => "unknown_payload",
            Self::UnknownTrack { .. } => "unknown_track",
            Self::UnknownReference { .. } => "unknown_reference",
            Self::Preflight { .. } => "preflight",
            Self::Clock { .. } => "clock",
            Self::NotSent { .. } => "not_sent",
        }
    }
}
