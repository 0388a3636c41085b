//! What is read of a node and its swarm: pictures of the fleet for screens, ROS 2 and metrics, the vehicles of one control period, events and
//! their log. The three types to know: [`FleetSnapshot`], [`PeerSnapshot`], [`EventLog`].
//!
//! Must never do: contain an actor, decide anything, or make a reader wait for a writer.
#![forbid(unsafe_code)]

mod audit;
mod event;
mod event_log;
mod fleet;
mod health;
mod peers;
mod receipts;
mod recorder;
mod swarm;
mod upgrade;

pub use audit::Audit;
pub use event::{EventKind, EventRecord};
pub use event_log::EventLog;
pub use fleet::{
    Avoidance, FleetSnapshot, FormationSnapshot, LeftVehicle, PayloadSnapshot, ResumeQuestion, UnadoptedVehicle,
    VehicleSnapshot,
};
pub use health::{ActorHealth, ActorStatus, PluginHealth, RestartRecord, Restored};
pub use peers::{PeerEntry, PeerSnapshot, airborne, kinematics};
pub use receipts::{CommandReceipt, ForeseenWay, FormationForecast, FormationReceipt};
pub use recorder::{RecorderStatus, RecorderWord};
pub use swarm::{LeaderStateKind, NodeRole, NodeSnapshot, SwarmSnapshot, TermSnapshot, WaySnapshot};
pub use upgrade::{
    ArchiveInfo, GoneBack, NodeUpgrade, NodeUpgradeState, NodeVersions, Rollout, RolloutEnd, RolloutKind,
    UpgradeRefusal, UpgradeReport, VersionLabel,
};
