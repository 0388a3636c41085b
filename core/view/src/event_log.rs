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

#[derive(Debug)]
struct Ring {
    next_seq: u64,
    events: VecDeque<Arc<EventRecord>>,
    /// Alerts among the kept ones that somebody has seen.
    acknowledged: BTreeSet<u64>,
}

impl Default for Ring {
    fn default() -> Self {
        Self {
            next_seq: 1,
            events: VecDeque::new(),
            acknowledged: BTreeSet::new(),
        }
    }
}

impl Ring {
    /// Keeps one; the oldest goes for it.
    fn add(&mut self, record: EventRecord) -> Arc<EventRecord> {
        self.next_seq = record.seq + 1;
        if self.events.len() == KEPT
            && let Some(oldest) = self.events.pop_front()
        {
            self.acknowledged.remove(&oldest.seq);
        }
        let record = Arc::new(record);
        self.events.push_back(record.clone());
        record
    }
}

impl Default for EventLog {
    fn default() -> Self {
        Self {
            ring: Mutex::default(),
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
        let seq = ring.next_seq;
        let record = ring.add(EventRecord { seq, ..record });
        // Sent under the lock, so that receivers see the order of the numbers. No receiver is no error.
        let _ = self.sender.send(record);
    }

    /// Holds these from now on, under their own numbers, instead of what it held: what had happened at another moment of a recording. Nobody is
    /// told of them.
    pub fn hold(&self, records: impl IntoIterator<Item = EventRecord>) {
        let mut ring = self.ring.lock();
        *ring = Ring::default();
        for record in records {
            ring.add(record);
        }
    }

    /// Tells what a recording tells, under its own number.
    pub fn tell_again(&self, record: EventRecord) {
        let mut ring = self.ring.lock();
        let record = ring.add(record);
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
    fn what_a_recording_tells_keeps_its_numbers_and_another_moment_replaces_it() {
        let log = log_of(&[Severity::Info; 3]);
        let of = |seq| EventRecord {
            seq,
            ..log.after(0)[0].as_ref().clone()
        };
        let (early, late) = ([of(40), of(42)], of(50));
        let numbers = || log.after(0).iter().map(|event| event.seq).collect::<Vec<_>>();
        let mut told = log.subscribe();
        log.hold(early.clone());
        assert_eq!(numbers(), [40, 42]);
        log.tell_again(late);
        assert_eq!(numbers(), [40, 42, 50]);
        assert_eq!(told.try_recv().map(|event| event.seq), Ok(50));
        log.hold(early);
        assert_eq!(numbers(), [40, 42]);
        assert!(told.try_recv().is_err());
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
