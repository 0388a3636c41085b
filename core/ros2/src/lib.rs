//! The swarm as an ordinary citizen of ROS 2: each vehicle a node in a namespace of its own, with standard messages in the frames of REP-103 and
//! REP-105; commands as services; velocities that expire. Native: no ROS 2 needs to be installed. Names, types, qualities and rates are tabled
//! in `deploy/docs/src/ros2.md`.
//!
//! Must never do: make an actor of the node wait. It reads snapshots on a thread of its own and hands commands to the node's handle.
#![forbid(unsafe_code)]

mod adapter;
mod camera;
pub mod cmd_vel;
pub mod detections;
mod endpoints;
pub mod limit;
pub mod picture;
pub mod quality;
mod rate;
pub mod requests;
mod services;
mod stamp;
mod swarm;
mod tasks;
mod translate;
mod vehicle;

pub use adapter::{Running, start};
pub use skein_ros2_messages::{frames, interfaces, names};
use tasks::Tasks;

use thiserror::Error;

/// Why there is nothing to be seen in ROS 2.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Ros2Error {
    /// DDS could not begin.
    #[error("no place in DDS: {reason}")]
    Start {
        /// Why.
        reason: String,
    },
    /// A node, a topic or a service could not be made.
    #[error("{what}: {reason}")]
    Refused {
        /// Which.
        what: String,
        /// Why.
        reason: String,
    },
    /// The thread that speaks could not begin, or ended.
    #[error("the thread that speaks: {reason}")]
    Thread {
        /// Why.
        reason: String,
    },
}

impl Ros2Error {
    fn of(what: &str, reason: &(impl std::fmt::Display + ?Sized)) -> Self {
        Self::Refused {
            what: what.to_owned(),
            reason: reason.to_string(),
        }
    }
}
