//! The state as it is reported: the camera's, and what truly is in its last simulated picture where that is asked for.

use schemars::JsonSchema;
use serde::Serialize;
use skein_domain::NodeTime;
use skein_domain::payload::{CameraPose, CameraState};
use skein_sim_payloads::scene::Seen;

/// The state of a camera, and the truth about its last picture beside it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CameraReport {
    /// The state.
    #[serde(flatten)]
    pub camera: CameraState,
    /// What is in the last simulated picture; only with the setting `truth`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<PictureTruth>,
}

/// What is in one picture of a simulated scene.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PictureTruth {
    /// Number of the frame, as in its header.
    pub frame: u64,
    /// When it was taken, on the node's clock.
    pub time: NodeTime,
    /// Where the camera was and looked. The frame's header is off by its pose error.
    pub pose: CameraPose,
    /// What is in it: peers, then objects.
    pub seen: Vec<NamedSeen>,
}

/// One thing in a picture.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct NamedSeen {
    /// `vehicle 3` of the vehicle with this number; `bird 2` of the second of the objects that are set, which is a bird.
    pub name: String,
    /// What it truly is, and where.
    #[serde(flatten)]
    pub seen: Seen,
}
