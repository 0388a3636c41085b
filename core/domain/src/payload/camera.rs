//! Cameras: what they can be asked, and what they say of their state.

use serde::{Deserialize, Serialize};

/// What a camera can be asked.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
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
#[derive(Debug, Clone, PartialEq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
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
#[derive(Debug, Clone, PartialEq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
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
