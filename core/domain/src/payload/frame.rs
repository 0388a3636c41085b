//! Frames of cameras: what is known of one beside its bytes.

use crate::{NodeTime, PositionNed};
use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};

/// How the bytes of a frame are to be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
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
    /// An H.264 access unit in Annex B's byte stream. All of them are passed on, in order; of the others the newest counts.
    #[n(3)]
    H264,
}

/// What is known of a frame beside its bytes. The bytes stay where they are: `id` names them.
#[derive(Debug, Clone, PartialEq, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
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
    /// The camera that took it, by its name on the vehicle: the host fills it in for who is shown the frame.
    #[n(9)]
    #[cbor(default)]
    #[serde(default)]
    pub camera: String,
}

/// Where a camera was and looked when it took a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
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
