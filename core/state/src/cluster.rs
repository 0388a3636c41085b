//! What a node shares with the other nodes of its swarm: what is told of vehicles, what is asked, who coordinates.
//!
//! Must never do: send anything.

pub mod report;
pub mod share;
