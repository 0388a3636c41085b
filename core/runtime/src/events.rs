//! The node's event log: a bounded ring of the newest events and a broadcast of new ones. Writing never waits for a reader.

use crate::snapshot::{EventKind, EventRecord};
use parking_lot::Mutex;
use skein_domain::exchange::Severity;
use skein_domain::{NodeId, NodeTime, VehicleId};
use std::collections::VecDeque;
use std::sync::Arc;
use tokio::sync::broadcast;

/// Events kept for readers that come later. At a busy 20 events a second it spans more than a minute and a half.
const KEPT: usize = 2_000;

/// The event log.
#[derive(Debug)]
pub struct EventLog {
    ring: Mutex<Ring>,
    sender: broadcast::Sender<Arc<EventRecord>>,
}

#[derive(Debug, Default)]
struct Ring {
    next_seq: u64,
    events: VecDeque<Arc<EventRecord>>,
}

impl Default for EventLog {
    fn default() -> Self {
        Self {
            ring: Mutex::new(Ring {
                next_seq: 1,
                events: VecDeque::new(),
            }),
            sender: broadcast::channel(KEPT).0,
        }
    }
}

impl EventLog {
    /// Records an event, also in the structured log.
    pub fn record(
        &self,
        time: NodeTime,
        vehicle: Option<VehicleId>,
        severity: Severity,
        kind: EventKind,
        text: impl Into<String>,
    ) {
        let text = text.into();
        let id = vehicle.map(|v| v.0);
        match severity {
            Severity::Info => tracing::info!(target: "skein::event", vehicle = id, at_s = time.as_seconds(), "{text}"),
            Severity::Advisory => {
                tracing::info!(target: "skein::event", vehicle = id, at_s = time.as_seconds(), advisory = true, "{text}");
            }
            Severity::Warning => {
                tracing::warn!(target: "skein::event", vehicle = id, at_s = time.as_seconds(), "{text}")
            }
            Severity::Critical => {
                tracing::error!(target: "skein::event", vehicle = id, at_s = time.as_seconds(), "{text}");
            }
        }
        self.keep(EventRecord {
            seq: 0,
            time,
            node: None,
            vehicle,
            severity,
            kind,
            text,
        });
    }

    /// Records what another node of the swarm told, by this node's clock. That node has logged it.
    pub fn relay(&self, node: NodeId, record: EventRecord) {
        self.keep(EventRecord {
            node: Some(node),
            ..record
        });
    }

    fn keep(&self, record: EventRecord) {
        let mut ring = self.ring.lock();
        let record = Arc::new(EventRecord {
            seq: ring.next_seq,
            ..record
        });
        ring.next_seq += 1;
        if ring.events.len() == KEPT {
            ring.events.pop_front();
        }
        ring.events.push_back(record.clone());
        // Sent under the lock, so that receivers see the order of the numbers. No receiver is no error.
        let _ = self.sender.send(record);
    }

    /// New events from now on. A reader that falls more than the kept number behind is told how many it missed.
    #[must_use]
    pub fn subscribe(&self) -> broadcast::Receiver<Arc<EventRecord>> {
        self.sender.subscribe()
    }

    /// Kept events with a greater sequence number.
    #[must_use]
    pub fn after(&self, seq: u64) -> Vec<Arc<EventRecord>> {
        self.ring
            .lock()
            .events
            .iter()
            .filter(|e| e.seq > seq)
            .cloned()
            .collect()
    }
}
