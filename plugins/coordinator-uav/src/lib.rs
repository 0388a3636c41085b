//! A UAV model for a vehicle whose computer can host the coordinator of the swarm. It flies as `generic-uav` does, of which it holds one,
//! and says beside that whether it could take the coordinator over, and how gladly.
//!
//! Must never do: host or move the coordinator. It only says what its vehicle is good for; who takes over is decided elsewhere.
#![forbid(unsafe_code)]

mod model;
mod settings;

pub use model::CoordinatorUav;
pub use settings::Settings;

#[cfg(test)]
mod tests;
