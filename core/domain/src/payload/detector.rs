//! Detectors: what they say that they see.

use super::CameraPose;
use crate::NodeTime;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

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
    /// Standard deviation of the middle in pixels; 0 if the detector does not say.
    pub error_px: f64,
    /// Seconds since it was last found in a picture: 0 if it was found in this one, more if it is only thought to be there.
    pub coasted_s: f64,
    /// What else it may be: the score of each class, 0..=1. Empty if the detector knows but one.
    pub classes: BTreeMap<String, f64>,
}

impl Finding {
    /// Whether its numbers can be true.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let is_score = |score: &f64| (0.0..=1.0).contains(score);
        let is_length = |length: &f64| length.is_finite() && *length >= 0.0;
        is_score(&self.score)
            && self.classes.values().all(is_score)
            && self.center_x_px.is_finite()
            && self.center_y_px.is_finite()
            && [self.width_px, self.height_px, self.error_px, self.coasted_s]
                .iter()
                .all(is_length)
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
    /// Width of the picture in pixels; 0 if the detector does not say.
    #[serde(default)]
    pub width_px: u32,
    /// Height of the picture in pixels; 0 if the detector does not say.
    #[serde(default)]
    pub height_px: u32,
    /// Where the camera was and looked, as the picture's header said; without it nobody knows in which direction a finding is.
    #[serde(default)]
    pub pose: Option<CameraPose>,
    /// What is in it.
    pub findings: Vec<Finding>,
}
