//! What the camera tells when it happens.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Something happened.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum CameraEvent {
    /// A picture was taken.
    PictureTaken {
        /// Its number, from 1.
        picture: u32,
        /// The frame it is; absent if the camera keeps it.
        frame: Option<u64>,
    },
    /// Recording began.
    RecordingStarted,
    /// Recording ended.
    RecordingStopped {
        /// How long it was, in seconds.
        seconds: f64,
    },
}
