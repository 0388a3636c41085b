//! What the detector says of itself beside what it found.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_domain::payload::DetectorState;

/// The state of the detector.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct DetectorReport {
    /// What was found in the last picture that was looked at.
    #[serde(flatten)]
    pub found: DetectorState,
    /// Pictures that were looked at.
    pub looked: u64,
    /// Pictures that came while another one was looked at, and were not looked at.
    pub dropped: u64,
    /// What runs the model: `rten`, or `onnxruntime`.
    pub runtime: String,
    /// How long looking at a picture takes, in seconds: the mean of the last ones.
    pub takes_s: f64,
    /// Of that, what each part takes.
    pub stages: Stages,
    /// Why nothing can be found; empty if all is well.
    pub fault: String,
    /// What is wrong with the camera's pictures, if anything is.
    pub picture_fault: Option<PictureFault>,
}

/// How long the parts of looking at a picture take, in seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Stages {
    /// The picture made to fit the model, the model, and its boxes.
    pub model_s: f64,
    /// What moves.
    pub motion_s: f64,
    /// Tracks, and what they are taken for.
    pub tracks_s: f64,
}

impl Stages {
    /// Moves each by a share, 0..=1, towards those of another one.
    pub(crate) fn blend(&mut self, newer: &Self, share: f64) {
        for (mean_s, newer_s) in [
            (&mut self.model_s, newer.model_s),
            (&mut self.motion_s, newer.motion_s),
            (&mut self.tracks_s, newer.tracks_s),
        ] {
            *mean_s += share * (newer_s - *mean_s);
        }
    }
}

/// What can be wrong with the pictures of a camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PictureFault {
    /// None has come for some time.
    Missing,
    /// The same one comes again and again.
    Frozen,
    /// There is nothing in them.
    Black,
    /// They cannot be read: encoded, or damaged.
    Unreadable,
}
