//! Flights of a real PX4, replayed through the link: every frame is read as it was meant, and the link comes to the right
//! facts at the right times. Time is the recording's.

mod decoding;
mod flights;
mod log;
mod replay;
mod sockets;
