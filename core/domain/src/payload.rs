//! Payloads: what a gimbal, a camera, a radio or a detector can be asked, and what it says of its state. These are the standard
//! vocabularies: they cross the plugin boundary and the API as JSON, and a plugin may have one of its own instead.
//!
//! Must never do: anything but name things. No jammer, weapon or interception payload has a word here.

mod camera;
mod detector;
mod frame;
mod gimbal;
mod radio;
mod tracks;

pub use camera::{CameraCommand, CameraMode, CameraState, CameraStream};
pub use detector::{DetectorState, Finding};
pub use frame::{CameraPose, FrameHeader, PixelFormat};
pub use gimbal::{GimbalCommand, GimbalMode, GimbalOwner, GimbalState, GimbalYawFrame};
pub use radio::{RadioCommand, RadioState};
pub use tracks::{FIRST_FUSED_TRACK, Track, TrackEstimate, TrackSource, largest_error_m, symmetric, upper_triangle};

use crate::{PositionNed, VehicleId};
use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};

/// What a payload is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
#[cbor(index_only)]
pub enum PayloadKind {
    /// Points something.
    #[n(0)]
    Gimbal,
    /// Takes pictures or video.
    #[n(1)]
    Camera,
    /// Carries data between vehicles or to the ground.
    #[n(2)]
    Radio,
    /// Finds things in frames.
    #[n(3)]
    Detector,
}

/// A MAVLink message as it crosses to and from a plugin: its payload's bytes, without header, checksum and signature.
#[derive(Debug, Clone, PartialEq, Eq, Default, Encode, Decode)]
pub struct MavlinkMessage {
    /// Who sent it; ignored in what a plugin sends.
    #[n(0)]
    pub system_id: u8,
    /// Which component of it sent it; ignored in what a plugin sends.
    #[n(1)]
    pub component_id: u8,
    /// Message id, up to 24 bits.
    #[n(2)]
    pub message_id: u32,
    /// The payload, little-endian as on the wire; trailing zeros may be cut off.
    #[n(3)]
    #[cbor(with = "minicbor::bytes")]
    pub payload: Vec<u8>,
}

/// What is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Target {
    /// A place in the swarm frame.
    #[n(0)]
    Place {
        /// Where.
        #[n(0)]
        position: PositionNed,
    },
    /// Another vehicle of the swarm.
    #[n(1)]
    Vehicle {
        /// Which.
        #[n(0)]
        vehicle: VehicleId,
    },
    /// Something that is being tracked.
    #[n(2)]
    Track {
        /// The track's number.
        #[n(0)]
        #[schemars(range(max = 9_007_199_254_740_991_u64))]
        track: u64,
    },
}

/// Whether a vehicle can host the coordinator, and how gladly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
pub struct CoordinatorCapability {
    /// It can, as things stand.
    #[n(0)]
    pub capable: bool,
    /// The greatest takes over first.
    #[n(1)]
    pub priority: u8,
}
