//! What nodes of a swarm tell each other, by classes of traffic, over any transport that carries datagrams.
//!
//! Must never do: let one class wait for another; rest on a transport being ordered, reliable or free of doubles. What a class promises is kept here,
//! in code without I/O, so that it holds over every transport alike.
#![forbid(unsafe_code)]

pub mod courier;
