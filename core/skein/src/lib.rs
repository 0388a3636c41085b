//! The program: from a configuration to a running node with its dashboard, and the commands a person starts it with.
//! [`build`] is what the binary and the tests share.
//!
//! Must never do: fly anything by itself; the demo flight gives the same commands an operator would give.
#![forbid(unsafe_code)]

pub mod args;
pub mod bench;
pub mod build;
pub mod demo;
pub mod doctor;
pub mod exit;
mod gateway;
pub mod logging;
pub mod plugin;
pub mod replay;
mod ros2;
pub mod run;
pub mod simulate;
pub mod swarm;

pub use build::{BuildError, Running, build, build_in};
