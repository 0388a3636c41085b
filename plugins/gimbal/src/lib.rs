//! A gimbal as a payload: angles, rates and places to point at, over MAVLink's gimbal protocol v2 or SIYI's own.
//!
//! Must never do: I/O, read a clock, fight another owner of the gimbal, or leave a command without its end.
#![forbid(unsafe_code)]

mod aim;
mod attitude;
mod device;
mod following;
mod gimbal;
mod manager;
mod orders;
mod settings;
mod siyi;

pub use gimbal::Gimbal;
pub use settings::{Backend, Settings};

#[cfg(test)]
mod tests;
