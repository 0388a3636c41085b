//! Flights of a real PX4, replayed through the link: every frame is read as it was meant, and the link comes to the right
//! facts at the right times. Time is the recording's.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod decoding;
mod drag;
mod flights;
mod log;
mod replay;
mod rest;
mod simulated;
mod sockets;
