//! Where a replay is, and what is asked of it, as the API has both.
//!
//! Must never do: hold behaviour.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_domain::NodeTime;
use ts_rs::TS;

/// The slowest and the quickest pace.
pub const RATES: std::ops::RangeInclusive<f64> = 0.25..=20.0;

/// Where a replay is.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct ReplayState {
    /// Name of the recording's file.
    pub file: String,
    /// Name of the node that recorded it.
    pub node: String,
    /// When the recording begins, in seconds since 1970 by the clock of that node's computer.
    pub begun_unix_s: f64,
    /// The same moment on that node's clock.
    pub begin: NodeTime,
    /// How long the recording is, in seconds.
    pub duration_s: f64,
    /// How far into it what is shown now is, in seconds.
    pub position_s: f64,
    /// Recorded seconds that are shown in a second.
    pub rate: f64,
    /// It goes on.
    pub playing: bool,
    /// Grows whenever it goes to another moment: what was known of the vehicles before holds no more then.
    pub jumps: u64,
    /// It was ended. One that was not was being written when it was opened, or was cut off with its program.
    pub finished: bool,
    /// The recording has been gone through: the timeline is whole.
    pub indexed: bool,
}

/// What is asked of a replay. What is left out stays as it is.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReplayChange {
    /// Go to this moment, in seconds from the beginning of the recording; what is after its end is its end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[ts(optional)]
    #[schemars(range(min = 0.0, max = 1e9))]
    pub position_s: Option<f64>,
    /// Show so many recorded seconds in a second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[ts(optional)]
    #[schemars(range(min = 0.25, max = 20.0))]
    pub rate: Option<f64>,
    /// Go on, or stand still.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[ts(optional)]
    pub playing: Option<bool>,
}
