//! Every link of the node by system id, shared by all endpoints; it outlives their restarts.

use crate::link::Px4Link;
use crate::metrics::EndpointMetrics;
use std::sync::Arc;

/// All links of the node and all endpoints' counters.
#[derive(Debug, Default)]
pub struct LinkTable {}

impl LinkTable {
    /// An empty table.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The link of a system id, if a vehicle with it has been heard.
    #[must_use]
    pub fn link(&self, _system_id: u8) -> Option<Arc<Px4Link>> {
        None
    }

    /// All links by ascending system id.
    #[must_use]
    pub fn links(&self) -> Vec<Arc<Px4Link>> {
        Vec::new()
    }

    /// Name and counters of every endpoint that was ever started.
    #[must_use]
    pub fn metrics(&self) -> Vec<(Arc<str>, Arc<EndpointMetrics>)> {
        Vec::new()
    }
}
