//! A UAV model for any multirotor whose autopilot takes OFFBOARD setpoints: the vehicle's flight state machine.
//!
//! Events in, effects out ([`GenericUav`]). It turns an operator's commands and the task in the intent into requests to the autopilot
//! and a setpoint per control period.
//!
//! Must never do: I/O, read a clock, draw random numbers, emit a setpoint while a pilot is in control or the vehicle is idle, take off
//! after a refused arming.
#![forbid(unsafe_code)]

mod asking;
mod blend;
mod commands;
mod flight;
mod flying;
mod ground;
mod guidance;
mod keeping;
mod landing;
mod model;
mod modes;
mod plan;
mod settings;
mod steering;
mod tasks;
mod telling;
mod way;

pub use flight::Goal;
pub use model::GenericUav;
pub use settings::Settings;

#[cfg(test)]
mod tests;
