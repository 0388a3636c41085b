//! Programs of others against ours: Python environments with the real MAVSDK, pymavlink, Cyclone DDS and ROS 2 from PyPI, and their
//! scripts run with a watch on what they report and on the time they take; programs out of Debian packages.
//!
//! Must never do: stand in for the program it is to be tested against. Without Python or the packages a test fails, and says
//! what is missing.
#![forbid(unsafe_code)]

mod debian;
mod peer;
mod python;
mod ros2;
mod script;

pub use debian::program_of;
pub use peer::{Peer, PeerReport};
pub use python::{CYCLONE, CYCLONE_ON_LOOPBACK, Environment, MAVSDK, python, python_of};
pub use ros2::Ros2;
pub use script::{Script, say};
