//! The web side of a node: REST, the telemetry stream, the OpenAPI document, metrics, the embedded dashboard, and the one place
//! where errors become HTTP.
//!
//! Must never do: decide anything about flight, or make the node wait. It reads snapshots and hands commands to the node's handle.
#![forbid(unsafe_code)]

pub mod generated;
pub mod protocol;
pub mod wire;
