//! Several nodes as one swarm: what each tells the others over the bus, what it takes from them, who coordinates. The three types to know:
//! [`Swarm`] (the actor), [`SwarmSetup`] (its key and transport), [`CarryOut`] (what does the things that others ask for).
//!
//! Must never do: fly anything, or believe a node that is not of the swarm.
#![forbid(unsafe_code)]

mod actor;
mod asks;
mod operator_state;
mod orders;
mod parts;
mod store;
mod tracks;

pub use actor::{CarryOut, OpenTransport, OpenedTransport, Swarm, SwarmArguments, SwarmSetup};
