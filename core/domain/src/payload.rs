//! Payloads: what a gimbal, a camera, a radio or a detector can be asked, and what it says of its state. These are the standard
//! vocabularies: they cross the plugin boundary and the API as JSON, and a plugin may have one of its own instead.
//!
//! Must never do: anything but name things. No jammer, weapon or interception payload has a word here.

use crate::{Geodetic, NodeTime, PositionNed, VehicleId, VelocityNed};
use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};

/// What a payload is.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    Serialize,
    Deserialize,
    Encode,
    Decode,
    ts_rs::TS,
    schemars::JsonSchema
)]
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
        track: u64,
    },
}

/// Something tracked: where it is and where it goes, in the swarm frame.
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
#[serde(deny_unknown_fields)]
pub struct Track {
    /// Its number.
    #[n(0)]
    pub track: u64,
    /// Where it was at `time`.
    #[n(1)]
    pub position: PositionNed,
    /// Its velocity at `time`.
    #[n(2)]
    pub velocity: VelocityNed,
    /// When that was, on the node's clock.
    #[n(3)]
    pub time: NodeTime,
}

/// The frame of a gimbal's yaw. Roll and pitch are always about the horizon.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
#[serde(rename_all = "snake_case")]
pub enum GimbalYawFrame {
    /// Zero is the vehicle's nose: the gimbal turns with the vehicle.
    #[default]
    Vehicle,
    /// Zero is north: the gimbal keeps its direction when the vehicle turns.
    North,
}

/// What a gimbal can be asked.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
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
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
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
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
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
#[derive(
    Debug,
    Clone,
    PartialEq,
    Default,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
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
    /// What is wrong with it; empty if nothing.
    pub fault: String,
}

/// What a camera can be asked.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
#[serde(tag = "command", rename_all = "snake_case", deny_unknown_fields)]
pub enum CameraCommand {
    /// Take pictures.
    TakePictures {
        /// How many; 0 until told to stop.
        #[serde(default = "one")]
        count: u32,
        /// Time between two, in seconds.
        #[serde(default)]
        interval_s: f64,
    },
    /// Take no more pictures.
    StopPictures,
    /// Start recording.
    StartRecording,
    /// Stop recording.
    StopRecording,
    /// Zoom to a factor, 1 being the widest.
    Zoom {
        /// The factor.
        factor: f64,
    },
    /// Change the mode.
    SetMode {
        /// The mode.
        mode: CameraMode,
    },
    /// Start the stream with this number.
    StartStream {
        /// Its number, from 1.
        #[serde(default = "first_stream")]
        stream: u8,
    },
    /// Stop the stream with this number.
    StopStream {
        /// Its number, from 1.
        #[serde(default = "first_stream")]
        stream: u8,
    },
}

fn one() -> u32 {
    1
}

fn first_stream() -> u8 {
    1
}

/// The mode of a camera.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
#[serde(rename_all = "snake_case")]
pub enum CameraMode {
    /// Takes pictures.
    #[default]
    Picture,
    /// Records video.
    Video,
    /// Takes pictures for a survey.
    Survey,
}

/// The state of a camera.
#[derive(
    Debug,
    Clone,
    PartialEq,
    Default,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
#[serde(default)]
pub struct CameraState {
    /// It is heard, or its source delivers.
    pub connected: bool,
    /// Who made it.
    pub vendor: String,
    /// What it is.
    pub model: String,
    /// Mode.
    pub mode: CameraMode,
    /// Pictures are being taken at an interval.
    pub capturing: bool,
    /// Pictures taken so far.
    pub pictures: u32,
    /// It records.
    pub recording: bool,
    /// For how long, in seconds.
    pub recording_s: f64,
    /// Zoom factor, 1 being the widest.
    pub zoom: Option<f64>,
    /// Room left on its storage in mebibytes.
    pub storage_free_mib: Option<f64>,
    /// Size of its storage in mebibytes.
    pub storage_total_mib: Option<f64>,
    /// Width of its pictures in pixels.
    pub width_px: Option<u32>,
    /// Height of its pictures in pixels.
    pub height_px: Option<u32>,
    /// Horizontal field of view in radians at the present zoom.
    pub field_of_view_rad: Option<f64>,
    /// Frames it has given since it was started.
    pub frames: u64,
    /// Streams it offers.
    pub streams: Vec<CameraStream>,
    /// What is wrong with it; empty if nothing.
    pub fault: String,
}

/// One video stream of a camera.
#[derive(
    Debug,
    Clone,
    PartialEq,
    Default,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
#[serde(default)]
pub struct CameraStream {
    /// Its number, from 1.
    pub stream: u8,
    /// Name.
    pub name: String,
    /// Where it can be read.
    pub uri: String,
    /// It runs.
    pub running: bool,
    /// Frames per second.
    pub rate_hz: f64,
    /// Width in pixels.
    pub width_px: u32,
    /// Height in pixels.
    pub height_px: u32,
}

/// What a radio can be asked, where the device allows it.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
#[serde(tag = "command", rename_all = "snake_case", deny_unknown_fields)]
pub enum RadioCommand {
    /// Change the channel.
    SetChannel {
        /// Its number as the device counts.
        channel: u32,
    },
    /// Change the transmission power.
    SetPower {
        /// In decibels over a milliwatt.
        power_dbm: f64,
    },
}

/// The state of a radio link.
#[derive(
    Debug,
    Clone,
    PartialEq,
    Default,
    Serialize,
    Deserialize,
    ts_rs::TS,
    schemars::JsonSchema
)]
#[serde(default)]
pub struct RadioState {
    /// It is heard.
    pub connected: bool,
    /// What the figures come from: `radio_status`, `nl80211`.
    pub source: String,
    /// Signal strength here, in decibels over a milliwatt.
    pub rssi_dbm: Option<f64>,
    /// Signal strength at the far end, in decibels over a milliwatt.
    pub remote_rssi_dbm: Option<f64>,
    /// Noise here, in decibels over a milliwatt.
    pub noise_dbm: Option<f64>,
    /// Signal over noise in decibels, of the weaker end.
    pub snr_db: Option<f64>,
    /// Share of packets lost, 0..=1.
    pub loss: Option<f64>,
    /// Time a packet takes, in seconds.
    pub latency_s: Option<f64>,
    /// Data rate in bits per second.
    pub throughput_bit_s: Option<f64>,
    /// Channel.
    pub channel: Option<u32>,
    /// Transmission power in decibels over a milliwatt.
    pub power_dbm: Option<f64>,
    /// Distance to the ground station in metres.
    pub distance_m: Option<f64>,
    /// Distance at which the link is expected to fail, in metres, from how it fell off so far.
    pub range_m: Option<f64>,
    /// Time until the vehicle is out of range if it goes on as now, in seconds.
    pub out_of_range_in_s: Option<f64>,
    /// It is about to leave the range.
    pub warning: bool,
    /// What is wrong with it; empty if nothing.
    pub fault: String,
}

/// How the bytes of a frame are to be read. A number, so that a reader can name one it does not know.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    Serialize,
    Deserialize,
    Encode,
    Decode,
    ts_rs::TS,
    schemars::JsonSchema
)]
#[serde(rename_all = "snake_case")]
#[cbor(index_only)]
pub enum PixelFormat {
    /// One byte of brightness per pixel.
    #[default]
    #[n(0)]
    Gray8,
    /// Red, green, blue, one byte each.
    #[n(1)]
    Rgb8,
    /// A JPEG file.
    #[n(2)]
    Jpeg,
}

/// What is known of a frame beside its bytes. The bytes stay where they are: `id` names them.
#[derive(
    Debug,
    Clone,
    PartialEq,
    Default,
    Serialize,
    Deserialize,
    Encode,
    Decode,
    ts_rs::TS,
    schemars::JsonSchema
)]
pub struct FrameHeader {
    /// Names the bytes at the boundary they cross; the host's and only good there.
    #[n(0)]
    pub id: u64,
    /// Counts the frames of one source, from 1.
    #[n(1)]
    pub sequence: u64,
    /// When it was taken, on the node's clock.
    #[n(2)]
    pub time: NodeTime,
    /// Width in pixels.
    #[n(3)]
    pub width_px: u32,
    /// Height in pixels.
    #[n(4)]
    pub height_px: u32,
    /// Bytes per row; 0 where rows have no meaning.
    #[n(5)]
    pub stride_bytes: u32,
    /// How to read the bytes.
    #[n(6)]
    pub format: PixelFormat,
    /// Number of bytes.
    #[n(7)]
    pub len: u64,
    /// Where the camera was and looked, if known.
    #[n(8)]
    pub pose: Option<CameraPose>,
}

/// Where a camera was and looked when it took a frame.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Default,
    Serialize,
    Deserialize,
    Encode,
    Decode,
    ts_rs::TS,
    schemars::JsonSchema
)]
pub struct CameraPose {
    /// Position in the swarm frame.
    #[n(0)]
    pub position: PositionNed,
    /// Roll of the picture in radians.
    #[n(1)]
    pub roll_rad: f64,
    /// Pitch of the optical axis in radians, upwards positive.
    #[n(2)]
    pub pitch_rad: f64,
    /// Yaw of the optical axis in radians, clockwise from north.
    #[n(3)]
    pub yaw_rad: f64,
    /// Horizontal field of view in radians.
    #[n(4)]
    pub field_of_view_rad: f64,
}

/// Whether a vehicle can host the coordinator, and how gladly.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    Serialize,
    Deserialize,
    Encode,
    Decode,
    ts_rs::TS,
    schemars::JsonSchema
)]
pub struct CoordinatorCapability {
    /// It can, as things stand.
    #[n(0)]
    pub capable: bool,
    /// The greatest takes over first.
    #[n(1)]
    pub priority: u8,
}
