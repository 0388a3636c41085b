//! The link against simulated PX4 vehicles: in simulated time without sockets, and over real sockets and lines.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod emergency;
mod endpoints;
mod flying;
mod line_quality;
mod lines;
mod navigation;
mod net;
mod parameters;
mod payloads;
mod puppet;
mod rig;
mod routes;
mod sightings;
