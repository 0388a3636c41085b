//! From pictures and what detectors find in them to where things are: what moves, tracks in one camera's picture, bearings in the swarm frame, and tracks of the
//! swarm that several cameras and other sensors feed.
//!
//! | stage | type |
//! |---|---|
//! | pictures to what moves in them, with the camera's own motion taken out | [`MotionDetector`] |
//! | boxes of one picture to tracks of one camera | [`PictureTracker`] |
//! | a pixel of a camera whose place is known to a bearing | [`Lens`] |
//! | bearings and positions of all sensors to tracks of the swarm | [`SwarmTracker`] |
//! | what was found and what is there to figures | [`Scorer`] |
//!
//! Must never do: I/O, read a clock, spawn, draw random numbers. Time comes in as an argument, so that the same input gives the same output.
//! Numbers that are not finite, and covariances that are none, are refused where they come in; nothing panics on them.
#![forbid(unsafe_code)]

mod assignment;
mod bearing;
mod bounds;
mod classes;
mod fusion;
mod gray;
mod motion;
mod picture;
mod scoring;
mod turn;

pub use bearing::Lens;
pub use bounds::Bounds;
pub use classes::{ClassScores, UNKNOWN_CLASS};
pub use fusion::{
    Observation, OwnVehicle, RangeGuess, Sensor, Sighting, SwarmSettings, SwarmTrack, SwarmTracker, Unsound,
};
pub use gray::Gray;
pub use motion::{Motion, MotionDetector, Moving};
pub use picture::{Found, PictureSettings, PictureTrack, PictureTracker};
pub use scoring::{Scorer, Scores, ToldBox, TrueBox};
pub use turn::Turn;
