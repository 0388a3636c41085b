//! Detectors: what they say that they see.

use crate::NodeTime;
use serde::{Deserialize, Serialize};

/// Something found in a picture. Pixels count from the picture's left upper corner.
#[derive(Debug, Clone, PartialEq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(default)]
pub struct Finding {
    /// What it is taken for, for example `uav`.
    pub class: String,
    /// How sure that is, 0..=1.
    pub score: f64,
    /// Middle of the box around it, in pixels from the left.
    pub center_x_px: f64,
    /// Middle of the box around it, in pixels from the top.
    pub center_y_px: f64,
    /// Width of the box in pixels.
    pub width_px: f64,
    /// Height of the box in pixels.
    pub height_px: f64,
    /// Names the same thing in later pictures; empty if it is not followed from one to the next.
    pub id: String,
}

impl Finding {
    /// Whether its numbers can be true.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let sides = [self.center_x_px, self.center_y_px, self.width_px, self.height_px];
        (0.0..=1.0).contains(&self.score)
            && sides.iter().all(|px| px.is_finite())
            && self.width_px >= 0.0
            && self.height_px >= 0.0
    }
}

/// The state of a detector: what it found in the last picture that it has looked at. A detector may say more beside it.
#[derive(Debug, Clone, PartialEq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct DetectorState {
    /// The vehicle's camera whose picture it was; empty if it has but one.
    #[serde(default)]
    pub camera: String,
    /// When the picture was taken, on the node's clock.
    pub time: NodeTime,
    /// What is in it.
    pub findings: Vec<Finding>,
}
