//! The web side of a node: REST, the telemetry stream, the OpenAPI document, metrics, the embedded dashboard, and the one place
//! where errors become HTTP.
//!
//! Must never do: decide anything about flight, or make the node wait. It reads snapshots and hands commands to the node's handle.
#![forbid(unsafe_code)]

mod app;
mod assets;
mod audit;
mod body;
mod connections;
mod control;
mod elsewhere;
mod emergency;
mod endpoints;
mod error;
mod example;
mod examples;
mod fences;
mod files;
mod flights;
pub mod generated;
mod guard;
mod links;
mod logs;
mod metrics;
mod observed;
mod open_replays;
pub mod openapi;
mod operators;
mod parameters;
mod payloads;
mod picture;
mod preflight;
pub mod protocol;
mod references;
mod replay;
mod replays;
mod resume;
mod routes;
mod safety_view;
mod server;
mod settings;
mod stream;
mod supervision;
mod swarm;
mod trace;
mod trajectories;
mod upgrades;
mod video;
mod view;
mod webrtc;
pub mod wire;

pub use elsewhere::serve_others;
pub use error::ApiError;
pub use server::{replay_router, router, serve};
pub use settings::ApiSettings;
