//! What the radio tells when it happens.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Something happened.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum RadioEvent {
    /// The vehicle is about to leave the range of its link.
    RangeWarning {
        /// Distance to the ground station in metres.
        distance_m: f64,
        /// Distance at which the link is expected to fail, in metres.
        range_m: f64,
        /// Time until then as the vehicle flies now, in seconds; absent if it does not fly away.
        out_of_range_in_s: Option<f64>,
    },
    /// It is well within the range again.
    RangeRecovered {
        /// Distance to the ground station in metres.
        distance_m: f64,
        /// Distance at which the link is expected to fail, in metres.
        range_m: f64,
    },
}
