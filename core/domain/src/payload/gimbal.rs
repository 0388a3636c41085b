//! Gimbals: what they can be asked, and what they say of their state.

use crate::Geodetic;
use serde::{Deserialize, Serialize};

/// The frame of a gimbal's yaw. Roll and pitch are always about the horizon.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum GimbalYawFrame {
    /// Zero is the vehicle's nose: the gimbal turns with the vehicle.
    #[default]
    Vehicle,
    /// Zero is north: the gimbal keeps its direction when the vehicle turns.
    North,
}

/// What a gimbal can be asked.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "command", rename_all = "snake_case", deny_unknown_fields)]
pub enum GimbalCommand {
    /// Point to these angles and stay there, stabilised to the horizon.
    Angles {
        /// Pitch in radians about the horizon, upwards positive.
        pitch_rad: f64,
        /// Yaw in radians, clockwise from the zero of `yaw_frame`.
        yaw_rad: f64,
        /// What the yaw counts from.
        #[serde(default)]
        yaw_frame: GimbalYawFrame,
    },
    /// Turn at these rates until told otherwise.
    Rates {
        /// Upwards positive, in radians per second.
        pitch_rad_s: f64,
        /// Clockwise positive, in radians per second.
        yaw_rad_s: f64,
    },
    /// Keep pointing at a place on Earth while the vehicle moves.
    PointAt {
        /// The place.
        place: Geodetic,
    },
    /// Look ahead, level.
    Neutral,
    /// Take primary control of the gimbal from whoever has it.
    TakeControl,
    /// Give primary control back.
    ReleaseControl,
}

/// Who steers a gimbal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum GimbalOwner {
    /// Nobody says so, or the device knows no owners.
    #[default]
    Unknown,
    /// Nobody.
    Nobody,
    /// This node.
    Us,
    /// Another ground station or component.
    Other {
        /// Its system id.
        system_id: u8,
        /// Its component id.
        component_id: u8,
    },
}

/// What a gimbal is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum GimbalMode {
    /// Nothing was asked of it yet.
    #[default]
    Idle,
    /// Holds angles.
    Angles,
    /// Turns at rates.
    Rates,
    /// Keeps pointing at a place.
    PointAt,
}

/// The state of a gimbal.
#[derive(Debug, Clone, PartialEq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(default)]
pub struct GimbalState {
    /// It is heard.
    pub connected: bool,
    /// What it is doing.
    pub mode: GimbalMode,
    /// Who steers it.
    pub owner: GimbalOwner,
    /// Roll in radians about the horizon.
    pub roll_rad: f64,
    /// Pitch in radians about the horizon, upwards positive.
    pub pitch_rad: f64,
    /// Yaw in radians from the vehicle's nose, clockwise.
    pub yaw_vehicle_rad: f64,
    /// Yaw in radians from north, clockwise; absent while the vehicle's own is not known.
    pub yaw_north_rad: Option<f64>,
    /// Where it is to point: pitch and yaw as last asked for, yaw from north.
    pub wanted_pitch_rad: Option<f64>,
    /// See `wanted_pitch_rad`.
    pub wanted_yaw_north_rad: Option<f64>,
    /// The place it keeps pointing at.
    pub place: Option<Geodetic>,
    /// Lowest pitch it can reach, in radians.
    pub pitch_min_rad: Option<f64>,
    /// Highest pitch it can reach, in radians.
    pub pitch_max_rad: Option<f64>,
    /// What it is, in words.
    pub model: String,
    /// It looks elsewhere than it is wanted and comes no nearer, though it could reach it. Its fault says so too.
    pub not_following: bool,
    /// What is wrong with it; empty if nothing.
    pub fault: String,
}
