//! Real ROS 2 meets the swarm, as it is on PyPI, and Cyclone DDS beside it. Each test stands in a file with what it judges by.

mod cyclone;
mod definitions;
mod flight;
mod graph;
mod payloads;
mod recorder;
mod restart;
mod rig;
