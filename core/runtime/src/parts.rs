//! Where the parts of a node can be reached.
//!
//! Must never do: keep a part from being started again.

use crate::coordinator::CoordinatorMessage;
use crate::fleet::FleetMessage;
use arc_swap::ArcSwapOption;
use ractor::ActorRef;
use skein_link_dds::DdsLinkTable;
use skein_link_mavlink::LinkTable;
use skein_state::TrackingMessage;
use skein_upgrade::Ground;
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::{Arc, OnceLock};

/// Where the parts of the node can be reached; empty while one is being restarted.
#[derive(Default)]
pub struct Parts {
    /// The coordinator.
    pub coordinator: ArcSwapOption<ActorRef<CoordinatorMessage>>,
    /// The fleet.
    pub fleet: ArcSwapOption<ActorRef<FleetMessage>>,
    /// What makes tracks.
    pub tracking: ArcSwapOption<ActorRef<TrackingMessage>>,
    /// Links and counters of all endpoints.
    pub links: Arc<LinkTable>,
    /// Links to vehicles over DDS.
    pub dds_links: Arc<DdsLinkTable>,
    /// Local addresses of the endpoints that are bound, by name.
    pub bound: parking_lot::Mutex<BTreeMap<String, SocketAddr>>,
    /// What exchanges the program, where the node has a place to keep versions in.
    pub versions: OnceLock<Arc<Ground>>,
}
