//! One vehicle in simulated time: it must do what was measured of a real PX4.

mod commands;
mod faults;
mod flight;
mod missions;
mod offboard;
mod payload_properties;
mod payloads;
mod properties;
mod protocol;
mod recorded;
mod rig;
mod topics;
