//! A detector as a payload: UAVs, birds, aeroplanes and helicopters in the pictures of a camera, found by a model in ONNX and by what moves, and followed
//! from picture to picture.
//!
//! Must never do: look at a picture on the thread of a call, let pictures wait (the newest is looked at, the others are counted), or trust what a model
//! gives.
#![forbid(unsafe_code)]

mod classifier;
mod detector;
mod eye;
mod fault;
mod joining;
mod model;
mod net;
mod picture;
mod report;
mod settings;
mod worker;

pub use detector::{Detector, NoCommand};
pub use report::{DetectorReport, PictureFault};
pub use settings::{Model, Settings};

#[cfg(test)]
mod tests;
