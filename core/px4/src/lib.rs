//! How PX4 behaves, whatever carries its messages: which commands in which order and what must follow, the OFFBOARD stream, modes, the local
//! origin, the emergency stop, one vehicle over a pair of links. The three types to know: [`offboard::OffboardControl`],
//! [`commands::Commands`], [`PairedLink`].
//!
//! Must never do: I/O, read a clock, or know how a message is framed. MAVLink's numbers are here as PX4's own: they are the same over DDS.
#![forbid(unsafe_code)]

pub mod acknowledgement;
pub mod commands;
pub mod emergency;
pub mod events;
pub mod local_origin;
pub mod mode_watch;
pub mod modes;
pub mod offboard;
mod paired;
pub mod plan;
mod send_rate;
pub mod setpoints;
mod settings;
pub mod status_text;

pub use paired::PairedLink;
pub use send_rate::SendRate;
pub use settings::{LinkSettings, MessageRates};

/// Component id of an autopilot.
pub const AUTOPILOT_COMPONENT: u8 = 1;
