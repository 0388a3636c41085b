//! The actors of a node and the one handle to them. One file per actor; SEMANTICS.md states order, bounds, deadlines and what
//! stopping means.
//!
//! Must never do: speak MAVLink, HTTP or the plugin ABI by itself.
#![forbid(unsafe_code)]

mod anchor;
mod board;
mod by_hand;
mod clock;
pub mod coordination;
mod coordinator;
mod dds_links;
mod emergency;
mod events;
mod fences;
mod fleet;
mod handle;
mod listening;
mod neighbours;
mod node;
mod observer;
mod overrun;
mod own_tracks;
mod paired;
mod payload;
mod plugin_life;
mod plugins;
mod preflight;
mod pulse;
mod references;
pub mod restart;
mod resume;
mod returns;
pub mod snapshot;
pub mod steering;
mod swarm;
mod vehicle;
mod ways;
mod whole_file;
mod wiring;

pub use anchor::AnchorKeeper;
pub use board::{PeerEntry, PeerSnapshot};
pub use clock::TokioClock;
pub use emergency::EmergencyKey;
pub use fences::FenceAnswer;
pub use handle::{
    CommandReceipt, ControlAction, ControlReceipt, Fault, ForeseenWay, FormationForecast, FormationReceipt,
    FormationSlots, NodeHandle, ParameterReceipt, Targets,
};
pub use node::{Adapter, AdapterStart, Node, NodeError};
pub use plugins::{InstanceUpgrade, PluginInfo, PluginRefusal, UpgradeReceipt};
pub use preflight::PreflightAnswer;
pub use references::{ReferenceReport, ReferenceSnapshot, References};
pub use skein_plugin_host::Frame;
pub use snapshot::{
    EventKind, EventRecord, FleetSnapshot, LeftVehicle, PayloadSnapshot, PluginHealth, RestartRecord, Restored,
    ResumeQuestion, VehicleSnapshot,
};
pub use swarm::asks::{ApiAnswer, ApiRequest, ApiServer};
pub use swarm::{
    AllegianceKind, NodeRole, NodeSnapshot, OpenTransport, OpenedTransport, SwarmSetup, SwarmSnapshot, TermSnapshot,
    WaySnapshot,
};
pub use wiring::{WiringError, catalog};
