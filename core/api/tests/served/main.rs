//! A real node without vehicles, served on a real loopback socket: what the API answers when all it has is itself.
//! Flights are tested in `tests/integration`.
#![allow(
    clippy::unwrap_used,
    reason = "what tests share may stop at the first surprise, as they do"
)]

mod http;
mod node;
mod raw;
mod safety;
mod stream;
mod trajectories;
