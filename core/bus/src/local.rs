//! The transport within one process: nodes of one host, and tests.
//!
//! Must never do: lose a datagram but by overflow; know what is in it.

use crate::arrivals::Arrivals;
use crate::transport::{Class, Datagram, SendError, To, Transport, Wake};
use parking_lot::Mutex;
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;
use std::sync::Arc;

/// As large as those of the other transports, so that what fits here fits there.
const LARGEST_BYTES: usize = 1400;

/// Where the nodes of one process meet.
#[derive(Debug, Clone, Default)]
pub struct Hub(Arc<Mutex<BTreeMap<NodeId, Arc<Arrivals>>>>);

/// One node's place at a [`Hub`]. It leaves when this is dropped.
#[derive(Debug)]
pub struct Local {
    node: NodeId,
    hub: Hub,
    arrivals: Arc<Arrivals>,
}

impl Hub {
    /// Gives a node its place. One that was there under this id gets nothing any more: it has been started again.
    #[must_use]
    pub fn join(&self, node: NodeId) -> Local {
        let arrivals = Arc::new(Arrivals::default());
        self.0.lock().insert(node, Arc::clone(&arrivals));
        let hub = self.clone();
        Local { node, hub, arrivals }
    }

    fn reached(&self, from: NodeId, to: To) -> Vec<Arc<Arrivals>> {
        let nodes = self.0.lock();
        match to {
            To::One(node) => nodes.get(&node).map(Arc::clone).into_iter().collect(),
            To::All => {
                let others = nodes.iter().filter(|(node, _)| **node != from);
                others.map(|(_, arrivals)| Arc::clone(arrivals)).collect()
            }
        }
    }
}

impl Transport for Local {
    fn node(&self) -> NodeId {
        self.node
    }

    fn largest_bytes(&self) -> usize {
        LARGEST_BYTES
    }

    fn send(&mut self, _now: NodeTime, to: To, class: Class, bytes: &[u8]) -> Result<(), SendError> {
        self.check_size(bytes)?;
        for arrivals in self.hub.reached(self.node, to) {
            arrivals.put(self.node, class, bytes.to_vec());
        }
        Ok(())
    }

    fn receive(&mut self, _now: NodeTime) -> Option<Datagram> {
        self.arrivals.next()
    }

    fn wake_on_arrival(&mut self, wake: Wake) {
        self.arrivals.wake_on(wake);
    }

    fn overflowed(&self) -> u64 {
        self.arrivals.overflowed()
    }
}

impl Drop for Local {
    fn drop(&mut self) {
        let mut nodes = self.hub.0.lock();
        if nodes
            .get(&self.node)
            .is_some_and(|there| Arc::ptr_eq(there, &self.arrivals))
        {
            nodes.remove(&self.node);
        }
    }
}

#[cfg(test)]
mod tests;
