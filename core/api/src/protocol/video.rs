//! Live video: what is told of each stream, and what a viewer may say.
//!
//! Must never do: hold behaviour.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_domain::VehicleId;
use ts_rs::TS;

/// The cameras and how their video is.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct VideoStreamList {
    /// One for each camera, by vehicle.
    pub streams: Vec<VideoStreamView>,
}

/// How the video of a camera is, in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, TS, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum VideoStateWord {
    /// Pictures come.
    Live,
    /// None came yet; the camera has just begun.
    Starting,
    /// None come any more.
    Stalled,
    /// Pictures come, but none that a decoder can begin with.
    NoKeyPicture,
    /// None ever came.
    NoPictures,
    /// What comes cannot be used.
    Failed,
}

/// How the video of a camera is.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct VideoStreamView {
    /// The vehicle that carries it.
    pub vehicle: VehicleId,
    /// Its name on the vehicle.
    pub payload: String,
    /// How it is.
    pub state: VideoStateWord,
    /// What is wrong, in words; empty if nothing is.
    pub reason: String,
    /// The H.264 codec after RFC 6381, as `avc1.42c01f`; empty while it is not known.
    pub codec: String,
    /// Width in pixels; 0 while it is not known.
    pub width_px: u32,
    /// Height in pixels; 0 while it is not known.
    pub height_px: u32,
    /// Pictures per second that the camera gives.
    pub rate_hz: f64,
    /// Bytes per second of a camera that encodes; 0 of one that gives pixels.
    pub bytes_per_s: f64,
    /// Share of the pictures that were lost on their way here, 0 to 1.
    pub lost: f64,
    /// Seconds since the last picture came; none if none ever did.
    pub age_s: Option<f64>,
    /// How many look at it.
    pub viewers: u32,
}

/// What a viewer is told as text.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum VideoMessage {
    /// How the stream is; about once a second.
    State(VideoStreamView),
    /// The answer to a ping.
    Pong {
        /// The ping's number.
        id: u32,
        /// Now, in microseconds of the node's clock.
        #[ts(type = "number")]
        time_us: u64,
    },
    /// What the viewer said was not understood.
    Error {
        /// Why.
        reason: String,
    },
}

/// What a viewer may say.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, TS, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum VideoRequest {
    /// Asks for the node's clock.
    Ping {
        /// Comes back with the answer.
        id: u32,
    },
    /// Its decoder cannot go on without a key picture.
    Key,
    /// How long it takes from the camera's picture to the eyes, read from the clock in the picture, over the last seconds.
    Seen {
        /// Median in seconds.
        p50_s: f64,
        /// 99th percentile in seconds.
        p99_s: f64,
    },
}

/// A recording that was begun or ended.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct VideoRecordingAnswer {
    /// The file's name.
    pub file: String,
    /// How long it is so far, in seconds.
    pub seconds: f64,
}

/// What is and was recorded on this node.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct VideoRecordingList {
    /// The recordings, the newest first.
    pub recordings: Vec<VideoRecording>,
}

/// A video that is or was recorded.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct VideoRecording {
    /// The file's name. Beside it lies one with `.jsonl`: where the vehicle was and how its payloads stood, ten times a second.
    pub file: String,
    /// Its vehicle.
    pub vehicle: VehicleId,
    /// The camera's name there.
    pub payload: String,
    /// Its size in bytes.
    #[ts(type = "number")]
    pub bytes: u64,
    /// How long it is, in seconds, while it is being recorded; 0 after that.
    pub seconds: f64,
    /// It is being recorded.
    pub running: bool,
}
