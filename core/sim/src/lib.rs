//! Simulated PX4 vehicles: real MAVLink frames over real sockets, a quadrotor that flies like one, and the truth for a referee.
//!
//! * [`Simulation`]: vehicles on their own thread, each with its own UDP ports. What a link meets.
//! * [`Faces`]: a vehicle is reached over MAVLink, by its autopilot's [`topics`], or both. Who carries topics is given to the simulation.
//! * [`vehicle::SimVehicle`]: one vehicle without sockets or clock: bytes in, time steps in, frames out. Runs faster than real time.
//! * [`PayloadPlan`]: what each vehicle carries: a gimbal, a camera, a telemetry radio, each spoken to over the vehicle's own links.
//! * [`Fault`]: what can go wrong with a vehicle while it flies. [`Mover`]: others that tell of themselves, or are told of.
//! * [`Airframe`]: kinds of vehicles, so that swarms can be mixed.
//! * [`TruthFrame`]: where every vehicle really is, and what its autopilot really did; for referees only, never for the swarm.
//!   [`truth_lines`]: the same as lines of JSON, for a referee over several simulations.
//!
//! Limits, where a real PX4 does more or otherwise:
//! * The estimator is the truth plus errors, not a filter: after the loss of satellites it drifts along one line, and a receiver that
//!   is wrong is refused by a fixed gate. Times and gate are EKF2's defaults. The height is never wrong: it comes from the barometer.
//! * The wind is estimated (and told) without being asked for by a parameter: `EKF2_DRAG_CTRL` is on, which is not PX4's default.
//! * Missions are waypoints and changes of speed; no other item, no fence, no rally point is taken. They are flown in the air only.
//! * A vehicle that falls or collides is not damaged: it can be armed again.
//! * A step of the clock moves all stamps at once; PX4's own clock does so only where time is simulated or a board is slept.
//!
//! Must never do: share code with the link that it is there to test, or let anything but its seed decide what happens in
//! [`vehicle`]. Nothing here listens on other interfaces than the loopback.
#![forbid(unsafe_code)]

pub mod airframe;
pub mod faces;
pub mod faults;
pub mod movers;
mod parameter_value;
pub mod settings;
pub mod simulation;
pub mod stalls;
pub mod topics;
pub mod truth;
pub mod truth_lines;
pub mod vehicle;
mod wind;
mod wire;

pub use airframe::Airframe;
pub use faces::{Face, Faces};
pub use faults::{Fault, Receiver};
pub use movers::{Mover, Report};
pub use settings::{
    BatterySettings, Impairment, NoiseSettings, PortPlan, Px4Ports, SimSettings, VehicleStart, WindSettings,
};
pub use simulation::{SimError, Simulation, VehiclePorts};
pub use skein_sim_payloads::{CameraSettings, GimbalOutput, GimbalSettings, PayloadPlan, RadioSettings};
pub use truth::{CameraTruth, GimbalTruth, ModeCause, ModeChange, MoverTruth, RadioTruth, TruthFrame, VehicleTruth};
