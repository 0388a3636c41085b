//! The node's event log: a bounded ring of the newest events and a broadcast of new ones. Writing never waits for a reader.
//!
//! Must never do: keep without bound, or drop an event without the reader being told how many.

use crate::event::{EventKind, EventRecord};
use parking_lot::Mutex;
use skein_domain::exchange::Severity;
use skein_domain::{NodeId, NodeTime, VehicleId};
use std::collections::{BTreeSet, VecDeque};
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
    /// Alerts among the kept ones that somebody has seen.
    acknowledged: BTreeSet<u64>,
}

impl Default for EventLog {
    fn default() -> Self {
        Self {
            ring: Mutex::new(Ring {
                next_seq: 1,
                events: VecDeque::new(),
                acknowledged: BTreeSet::new(),
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
        if ring.events.len() == KEPT
            && let Some(oldest) = ring.events.pop_front()
        {
            ring.acknowledged.remove(&oldest.seq);
        }
        ring.events.push_back(record.clone());
        // Sent under the lock, so that receivers see the order of the numbers. No receiver is no error.
        let _ = self.sender.send(record);
    }

    /// Marks alerts as seen, and says so to whoever reads the log. Returns how many were not before; no event tells of none, so that
    /// repeating it pushes nothing out of the log.
    pub fn acknowledge(&self, time: NodeTime, events: &[u64]) -> usize {
        let newly: Vec<u64> = {
            let mut guard = self.ring.lock();
            let Ring {
                events: kept,
                acknowledged,
                ..
            } = &mut *guard;
            let alerts = |seq: &u64| {
                let at = kept.binary_search_by_key(seq, |event| event.seq).ok()?;
                kept.get(at).filter(|event| event.severity >= Severity::Warning)
            };
            events
                .iter()
                .filter(|seq| alerts(seq).is_some() && acknowledged.insert(**seq))
                .copied()
                .collect()
        };
        let count = newly.len();
        if count > 0 {
            let text = format!("{count} {} acknowledged", if count == 1 { "alert" } else { "alerts" });
            self.record(
                time,
                None,
                Severity::Info,
                EventKind::Acknowledged { events: newly },
                text,
            );
        }
        count
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

#[cfg(test)]
mod tests {
    //! What is seen stays seen, and who says it again changes nothing.

    use super::*;

    fn log_of(severities: &[Severity]) -> EventLog {
        let log = EventLog::default();
        for severity in severities {
            log.record(NodeTime(0), None, *severity, EventKind::Notice, "something");
        }
        log
    }

    #[test]
    fn what_is_acknowledged_is_told_once_and_only_of_alerts() {
        let log = log_of(&[Severity::Info, Severity::Warning, Severity::Critical]);
        assert_eq!(log.acknowledge(NodeTime(1), &[1, 2, 3, 3, 77]), 2);
        assert_eq!(log.acknowledge(NodeTime(2), &[2, 3]), 0);
        let told = log.after(3);
        assert_eq!(told.len(), 1);
        assert_eq!(told[0].kind, EventKind::Acknowledged { events: vec![2, 3] });
    }

    #[test]
    fn marks_go_with_what_they_mark() {
        let log = log_of(&[Severity::Warning]);
        log.acknowledge(NodeTime(1), &[1]);
        for _ in 0..KEPT {
            log.record(NodeTime(2), None, Severity::Info, EventKind::Notice, "something");
        }
        assert!(log.ring.lock().acknowledged.is_empty());
        assert_eq!(log.acknowledge(NodeTime(3), &[1]), 0);
    }
}
