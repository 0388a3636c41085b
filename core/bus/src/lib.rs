//! What nodes of a swarm tell each other, by classes of traffic, over any transport that carries datagrams.
//!
//! Must never do: let one class wait for a less urgent one; rest on a transport being ordered, reliable, private or free of doubles. What a class
//! promises is kept here, in code without I/O, so that it holds over every transport alike.
//!
//! [`Bus`] is one node's end; [`pump`] joins it to a [`transport::Transport`].
#![forbid(unsafe_code)]

pub mod arrivals;
pub mod budget;
pub mod bulk;
pub mod bus;
#[cfg(any(test, feature = "conformance"))]
pub mod conformance;
pub mod courier;
pub mod delta;
mod entry;
pub mod envelope;
pub mod latest;
pub mod links;
pub mod local;
pub mod query;
pub mod radio;
pub mod redundant;
pub mod transport;
pub mod video;
pub mod wire;

pub use bus::{Bus, BusSettings, Event, Outgoing, Ticket, pump};
