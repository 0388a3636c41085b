//! The model against a tiny autopilot in simulated time.

mod autopilot;
mod commands;
mod drag;
mod flights;
mod keeping;
mod pilot;
mod properties;
pub(crate) mod rig;
mod snapshots;
mod steering;
mod take_off;
mod tasks;
