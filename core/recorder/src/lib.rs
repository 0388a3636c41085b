//! The black box: records a node's flights into files, and shows the same live to Foxglove. The three types to know: [`Recorder`] (the actor),
//! `Encoder` (what is said of what is taken), `Tapes` (the files, and what is done when the disk does not take them).
//!
//! Must never do: make a setpoint wait. What comes is taken off a bounded queue by a thread of its own; what does not fit is counted.
#![forbid(unsafe_code)]

mod disk;
mod encoder;
mod finishing;
mod flights;
mod folder;
mod live;
pub mod logs;
mod recorder;
mod tapes;
mod thread;

pub use recorder::{Recorder, adapter, ended};

#[cfg(test)]
mod tests;
