//! Whether flights are recorded, for whoever looks at a screen.
//!
//! Must never do: say that something is recorded which is not.

use schemars::JsonSchema;
use serde::Serialize;
use ts_rs::TS;

/// Whether flights are recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, TS, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RecorderWord {
    /// Nobody wants them to be.
    #[default]
    Off,
    /// They are.
    Recording,
    /// They should be, and are not: the disk is full, missing or silent. It is tried again and again.
    Interrupted,
}

/// What the recorder does.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, TS, JsonSchema)]
pub struct RecorderStatus {
    /// Whether flights are recorded.
    pub state: RecorderWord,
    /// The file that is written.
    pub file: Option<String>,
    /// Somebody was armed since it was begun.
    pub in_flight: bool,
    /// Why they are not recorded.
    pub why: Option<String>,
    /// The file of the last flight that has ended since the node started.
    pub last_flight: Option<String>,
}
