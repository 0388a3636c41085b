//! The actors of a node and the one handle to them. One file per actor; SEMANTICS.md states order, bounds, deadlines and what
//! stopping means.
//!
//! Must never do: speak MAVLink, HTTP or the plugin ABI by itself.
#![forbid(unsafe_code)]

mod arming;
mod clock;
mod control_loop;
mod coordinator;
mod dds_links;
mod fleet;
mod handle;
mod listening;
mod node;
mod observer;
mod parts;
mod payload;
mod plugin_life;
mod resume;
mod surroundings;
mod vehicle;
mod wiring;

pub use clock::TokioClock;
pub use handle::{
    AskedObserver, ControlAction, ControlReceipt, EmergencyKey, Fault, FenceAnswer, FormationSlots, InstanceUpgrade,
    LONGEST_TRACK_NAME, NodeHandle, ObserveRequest, ParameterReceipt, PluginInfo, PluginRefusal, PreflightAnswer,
    Targets, UpgradeReceipt,
};
pub use node::{Adapter, AdapterStart, Node, NodeError};
pub use skein_plugin_host::Frame;
pub use skein_state::SeenCounts;
pub use skein_state::video::{Quality, Rendition, Viewer};
pub use skein_streaming::{CameraStreams, CameraVideo, RecordedVideo};
pub use skein_tracking::{Detected, DetectedBearing, Detection};
pub use wiring::{WiringError, catalog};
