//! What the swarm sees: where its cameras look, and what is tracked.
//!
//! Must never do: hold behaviour.

use schemars::JsonSchema;
use serde::Serialize;
use skein_coordination::observing::ObserverProposal;
use skein_domain::payload::{CameraPose, TrackEstimate};
use skein_domain::{NodeTime, VehicleId};
use skein_runtime::AskedObserver;
use ts_rs::TS;

/// Where the cameras of all vehicles look, as far as that is known.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct CameraViewList {
    /// Now, on the node's clock.
    pub time: NodeTime,
    /// One for each camera of which it is known where it looks, by vehicle.
    pub views: Vec<CameraView>,
}

/// Where one camera is and looks.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct CameraView {
    /// The vehicle that carries it.
    pub vehicle: VehicleId,
    /// Its name on the vehicle.
    pub payload: String,
    /// Where it is and looks, in the swarm frame.
    pub pose: CameraPose,
    /// Width of its pictures in pixels.
    pub width_px: u32,
    /// Height of its pictures in pixels.
    pub height_px: u32,
    /// How this is known.
    pub known_from: ViewSource,
    /// Seconds since it was so.
    pub age_s: f64,
}

/// How it is known where a camera looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, TS, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ViewSource {
    /// Its last frame says so.
    Frame,
    /// From the angles of the vehicle's gimbal and the camera's field of view.
    Gimbal,
}

/// What is tracked.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct TrackList {
    /// Now, on the node's clock.
    pub time: NodeTime,
    /// The tracks: those that were told last, and those that the swarm made of what its sensors saw.
    pub tracks: Vec<TrackEstimate>,
}

/// Who could keep a track in view.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct ObserverList {
    /// The track.
    #[ts(type = "number")]
    pub track: u64,
    /// Vehicles whose model can observe, the best placed first; those that cannot be asked come last, with the reason.
    pub observers: Vec<ObserverProposal>,
}

/// Who was asked to keep a track in view.
#[derive(Debug, Clone, PartialEq, Serialize, TS, JsonSchema)]
pub struct AskedObserverList {
    /// The track.
    #[ts(type = "number")]
    pub track: u64,
    /// Each with its answer; some or all may be refusals.
    pub asked: Vec<AskedObserver>,
}
