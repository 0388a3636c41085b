//! The program on several hosts, each a network namespace of this machine.

mod composed;
mod failover;
mod flights;
mod namespaces;
mod unicast;
mod upgrades;
mod video;
