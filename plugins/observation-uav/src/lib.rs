//! A UAV model that keeps something in view: a place, another vehicle of the swarm, or a track. It flies as `generic-uav` does, of which
//! it holds one, and has gimbal, camera and radio of its vehicle work together.
//!
//! Must never do: fly by itself. Every setpoint is `generic-uav`'s; here it is only said where to be and where to look.
#![forbid(unsafe_code)]

mod camera;
mod commands;
mod gaze;
mod geometry;
mod model;
mod payloads;
mod report;
mod settings;
mod target;
mod watch;

pub use model::ObservationUav;
pub use report::{Activity, ObservationState};
pub use settings::{OnObserving, OnRadioWarning, Settings};

#[cfg(test)]
mod tests;
