//! What every tier of tests needs, in one place:
//!
//! | for | use |
//! |---|---|
//! | the program and the plugins under test, built once per run | [`skein_binary`], [`plugins_dir`] |
//! | a library that a fixture of a tier builds | [`example_library`] |
//! | a file of the repository | [`repository`] |
//! | the longest time without a setpoint that a flight in real time is allowed | [`LONGEST_GAP_S`] |
//! | waiting for something without sleeping | [`eventually`] with [`patience`] |
//! | a port that nobody uses | [`free_udp_port`], [`free_tcp_port`] |
//! | a child process that cannot outlive its test | [`Process`] |
//! | the browser's end of WebRTC | `Peer`, with the feature `webrtc` |
//! | a whole node with simulated vehicles in the test's own process | `Swarm`, with the feature `swarm` |
//! | several nodes of one swarm, each with a vehicle | `Flock`, with the feature `swarm` |
//!
//! Must never do: stand in for our own code. What runs in a test is what ships; vehicles are `skein-sim`'s, over real sockets.
//! Everything here panics when it cannot do its work: a test that cannot be set up has failed.
#![forbid(unsafe_code)]

mod artefacts;
#[cfg(feature = "swarm")]
mod flock;
mod gap;
mod patience;
mod ports;
mod process;
#[cfg(feature = "swarm")]
mod swarm;
#[cfg(feature = "webrtc")]
mod webrtc;

pub use artefacts::{example_library, plugins_dir, repository, skein_binary};
#[cfg(feature = "swarm")]
pub use flock::{Flock, Member, vehicles};
pub use gap::LONGEST_GAP_S;
pub use patience::{eventually, patience};
pub use ports::{free_tcp_port, free_udp_port};
pub use process::Process;
#[cfg(feature = "swarm")]
pub use swarm::Swarm;
#[cfg(feature = "webrtc")]
pub use webrtc::Peer;
