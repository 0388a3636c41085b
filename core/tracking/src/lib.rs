//! Tracks of the swarm at run time: what its detectors find and what other sensors tell becomes tracks, and who was asked to keep one in view is relieved.
//!
//! * [`Tracking`]: the actor, which feeds [`skein_vision::SwarmTracker`].
//! * [`Detection`]: what another sensor tells over the API.
//! * [`candidates`]: who could keep something in view.
//!
//! Must never do: speak MAVLink or HTTP; command a vehicle but through what it was given for that.
#![forbid(unsafe_code)]

mod candidates;
mod carrying;
mod detections;
mod geolocation;
mod orders;
mod shown;
mod telling;
mod tracking;

pub use candidates::candidates;
pub use carrying::AskVehicle;
pub use detections::{Detected, DetectedBearing, Detection, sightings};
pub use tracking::{Tracking, TrackingArguments, TrackingState};
