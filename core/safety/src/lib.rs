//! The gate that every setpoint, goal, command and payload message passes before a link sees it: fence, speed, separation, what a
//! payload may send, and whether a thing makes sense at all. Every refusal is a typed reason.
//!
//! Must never do: I/O, read a clock, spawn, draw random numbers, or let a number that is not finite through.
#![forbid(unsafe_code)]

pub mod avoidance;
pub mod control;
pub mod energy;
pub mod failsafe;
mod fence;
mod gate;
pub mod gnss;
mod half_space;
pub mod parameter;
mod payload;
pub mod preflight;
pub mod wind;

pub use failsafe::FailsafePolicy;
pub use fence::{Approach, Breach, Clearance, Excess, Fence, FenceError, FencePlanError, Fences, Wall, Zone};
pub use gate::{Gate, Limits, LimitsError, Steered, Steering};
pub use half_space::HalfSpace;
