//! What a demonstration is asked for on the command line.
//!
//! Must never do: decide what is flown; the scenarios do.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// `skein demo`
#[derive(Debug, Clone, Args)]
pub struct DemoArguments {
    /// What is flown; each scenario has criteria of its own.
    #[arg(long, value_enum, default_value_t = Scenario::Tour, value_name = "NAME")]
    pub scenario: Scenario,
    /// How many vehicles fly [default: 6].
    #[arg(long, value_parser = clap::value_parser!(u8).range(2..=100))]
    pub vehicles: Option<u8>,
    /// The tour is laid out to be over within so many seconds [default: what the number of vehicles needs].
    #[arg(long, value_name = "S")]
    pub seconds: Option<u32>,
    /// No dashboard for people: fly, report, exit.
    #[arg(long)]
    pub headless: bool,
    /// Write the figures of the flight to this file, as JSON.
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// Faults in flight: `actors` kills a plugin, a vehicle actor and the coordinator; `plugins` ends a random plugin twice a second;
    /// `links` cuts the first of each vehicle's two links in turn (with `--link both`). The criteria stay the same.
    #[arg(long, value_enum, value_name = "WHAT", num_args = 0..=1, default_missing_value = "actors")]
    pub faults: Option<FaultPlan>,
    /// What the vehicles are flown over: `dds` is PX4's uXRCE-DDS agent, `both` is DDS first and MAVLink when that is silent.
    #[arg(long, value_enum, default_value_t = DemoLink::Mavlink, value_name = "LINK")]
    pub link: DemoLink,
    /// Vehicles and dashboard only: fly it yourself.
    #[arg(long)]
    pub manual: bool,
    /// Port of the dashboard on 127.0.0.1; 0 lets the system choose [default: 8080, or another one where that is taken].
    #[arg(long)]
    pub port: Option<u16>,
    /// Seed of wind and sensor noise.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// What kind of vehicles fly; the scenario `mixed` has its own.
    #[arg(long, value_enum, default_value_t = SimulatedKind::Quadrotor, value_name = "KIND")]
    pub airframe: SimulatedKind,
    /// Every vehicle is flown by this UAV model, and carries a radio only [default: a mixed swarm].
    #[arg(long, value_name = "PLUGIN")]
    pub model: Option<String>,
    /// Fly autopilots that are there already and heard on this address, such as `udp-listen://127.0.0.1:14540`, instead of simulated
    /// ones; may be given several times. They are judged by their own reports.
    #[arg(long, value_name = "ADDRESS", conflicts_with_all = ["link", "seed"])]
    pub listen: Vec<String>,
    /// The flight is recorded into this folder [default: `skein/flights` in the user's state folder, `~/.local/state`].
    #[arg(long, value_name = "DIR")]
    pub record: Option<PathBuf>,
    /// Another directory of plugins, beside `plugins` where this program is; may be given several times.
    #[arg(long, value_name = "DIR")]
    pub plugins: Vec<PathBuf>,
}

/// How many vehicles fly if nothing else is said.
const VEHICLES: u8 = 6;

impl DemoArguments {
    /// How many vehicles fly.
    #[must_use]
    pub fn count(&self) -> u8 {
        self.vehicles.unwrap_or(VEHICLES)
    }
}

/// What the demonstration flies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scenario {
    /// Take off, form up, follow a leader along a route and back, land each on its spot.
    Tour,
    /// Every shape, morphed in flight; anchored to the leader, a virtual leader's path, a moving reference and a place.
    Formations,
    /// The leader falls silent on its route: another leads; then the leader is replaced on purpose, at speed.
    LeaderLoss,
    /// Vehicles leave and join in flight, swap roles, and one is lost.
    JoinLeave,
    /// Vehicles with different limits, some of them camera carriers: nobody is left behind, nobody flies in a camera's view.
    Mixed,
    /// A fence and two no-fly zones: refused goals, ways around, stops at the boundary.
    Fence,
    /// The coordinator is taken away: the formation keeps its shape by its neighbours' states alone.
    NoCoordinator,
    /// An intruder is seen by cameras, tracked and observed from two sides; one who looks is relieved.
    Observe,
    /// Observation UAVs keep their cameras on the leader; their video is received all the while.
    ObserveVideo,
}

/// What fails in the demonstration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FaultPlan {
    /// A plugin, a vehicle actor and the coordinator, each once.
    Actors,
    /// A random plugin (UAV models and payloads, in both isolations) twice a second.
    Plugins,
    /// The first of each vehicle's two links, in turn.
    Links,
}

/// What the vehicles of the demonstration are flown over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DemoLink {
    /// MAVLink over UDP.
    Mavlink,
    /// The topics of PX4's uXRCE-DDS agent.
    Dds,
    /// DDS, and MAVLink when that is silent.
    Both,
}

/// A kind of simulated vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SimulatedKind {
    /// A usual quadrotor.
    Quadrotor,
    /// The one of PX4's own simulation in hardware: the air slows it down four times as strongly, and it is slow to tilt.
    Sih,
}

impl From<SimulatedKind> for skein_sim::Airframe {
    fn from(kind: SimulatedKind) -> Self {
        match kind {
            SimulatedKind::Quadrotor => Self::Quadrotor,
            SimulatedKind::Sih => Self::Sih,
        }
    }
}
