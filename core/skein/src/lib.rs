//! The program: from a configuration to a running node with its dashboard, and the commands a person starts it with.
//!
//! Must never do: fly anything by itself; the demo flight gives the same commands an operator would give.
#![forbid(unsafe_code)]

pub mod args;
pub mod bench;
pub mod doctor;
pub mod exit;
pub mod init;
pub mod logging;
pub mod manual;
pub mod plugin;
pub mod replay;
pub mod run;
pub mod simulate;
pub mod swarm;
pub mod vision;
