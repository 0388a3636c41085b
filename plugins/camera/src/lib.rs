//! A camera as a payload: MAVLink's camera protocol v2, and frames from a simulated scene, a folder of pictures or a video file.
//!
//! Must never do: read a clock, decode on the thread of a call, or leave a command without its end.
#![forbid(unsafe_code)]

mod camera;
mod capture;
mod clock_strip;
mod decoding;
mod feed;
mod occurrence;
mod remote;
mod settings;
mod stream;
mod synthetic;
mod truth;

pub use camera::Camera;
pub use occurrence::CameraEvent;
pub use settings::{Settings, Source};
pub use truth::{CameraReport, NamedSeen, PictureTruth};

#[cfg(test)]
mod tests;
