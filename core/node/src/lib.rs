//! From a configuration to a running node with dashboard, API and ROS 2: what `skein run`, the demonstration and the tests start. The three
//! things to know: [`build`], [`Running`], [`BuildError`].
//!
//! Must never do: fly anything by itself, or print by itself.
#![forbid(unsafe_code)]

mod build;
mod gateway;
mod process;
mod ros2;
mod swarm;

pub use build::{BuildError, Running, build, build_in};
pub use process::{flights_of_user, plugins_beside_program, stop_asked, tell};
pub use swarm::{SwarmError, setup};
