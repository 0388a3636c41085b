//! Measures the whole program from outside: its own process against a load generator in another, beside a bare loop that receives,
//! parses and sends without any logic, in the same run on the same machine.
//!
//! Assignments of vehicles to slots are measured beside SciPy's ([`run_assignment_bench`]).
//!
//! The transports of the swarm's bus are measured beside each other in one process ([`run_bus_bench`]).
//!
//! Latencies through ROS 2 and DDS, beside rclpy programs, and what ROS 2 costs ([`run_ros2_bench`]).
//!
//! What it takes to relay live video, beside FFmpeg ([`run_video_bench`]).
//!
//! What a detector takes for a picture, part by part, beside FFmpeg and ONNX Runtime ([`run_vision_bench`]).
//!
//! A long recording opened and wound back and forth, beside reading it once ([`run_replay_bench`]).
//!
//! The cost of plugins' calls is measured from inside, in a program of their own ([`run_plugin_bench`]).
//!
//! Must never do: reach into the program measured. What counts is what leaves its sockets and what the system charges it.
#![forbid(unsafe_code)]

mod assignment;
mod bare;
mod bus;
mod error;
mod fleet;
mod flyer;
mod gaps;
mod generator;
mod plugin;
mod process;
mod program;
mod replay;
mod report;
mod ros2;
mod swarm;
mod video;
mod vision;
mod wire;

pub use assignment::{AssignmentBenchArgs, AssignmentBenchReport, AssignmentFigures, run_assignment_bench};
pub use bare::{BareLoopSettings, run_bare_loop};
pub use bus::{BusBenchArgs, BusBenchReport, TransportFigures, run_bus_bench};
pub use error::BenchError;
pub use fleet::{FleetBenchArgs, run_fleet_bench};
pub use generator::{LoadGeneratorSettings, run_load_generator};
pub use plugin::{CallFigures, PluginBenchArgs, PluginBenchReport, run_plugin_bench};
pub use process::Scheduling;
pub use program::VehicleLink;
pub use replay::{ReplayBenchArgs, ReplayBenchReport, run_replay_bench};
pub use report::{FleetBenchReport, Gaps, LoadFigures, SideFigures, Spread, WindowFigures};
pub use ros2::{CostFigures, Latency, Ros2BenchArgs, Ros2BenchReport, Shown, run_ros2_bench};
pub use swarm::{SwarmBenchArgs, SwarmBenchReport, run_swarm_bench};
pub use video::{VideoBenchArgs, VideoBenchReport, run_video_bench, run_video_viewer};
pub use vision::{VisionBenchArgs, VisionBenchReport, VisionFigures, run_vision_bench};
