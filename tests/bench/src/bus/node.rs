//! One node of the bench: its end of the bus, its traffic, its thread.
//!
//! Must never do: spin. It sleeps until something arrives or is due.

use crate::error::BenchError;
use parking_lot::Mutex;
use skein_bus::bus::{Bus, BusSettings, Event, pump};
use skein_bus::envelope::{Boot, SwarmKey};
use skein_bus::latest::Key;
use skein_bus::transport::Transport;
use skein_domain::{NodeId, NodeTime};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

const BEACON_S: f64 = 0.1;
const VEHICLE_S: f64 = 0.2;
const SELDOM_S: f64 = 2.0;
/// It looks at least as often as the program does for what waits for the budget, or for an answer.
const LOOK_S: f64 = 0.01;
const BEACON: Key = Key(1);
const VEHICLE: Key = Key(2);
const INTENT: Key = Key(3);

/// What all nodes of one transport have counted.
#[derive(Debug, Default)]
pub(super) struct Counts {
    met: AtomicUsize,
    sent_bytes: AtomicU64,
    arrivals: AtomicU64,
    latencies_us: Mutex<Vec<u64>>,
    bulk_us: Mutex<Vec<u64>>,
}

/// What they counted in a window, or until its beginning.
#[derive(Debug, Default)]
pub(super) struct NodeCounts {
    pub sent_bytes: u64,
    pub arrivals: u64,
    /// Sorted.
    pub latencies_us: Vec<u64>,
    /// Sorted.
    pub bulk_us: Vec<u64>,
}

impl Counts {
    /// How many nodes know all others.
    pub fn met(&self) -> usize {
        self.met.load(Ordering::Acquire)
    }

    /// Begins a window.
    pub fn begin(&self) -> NodeCounts {
        self.latencies_us.lock().clear();
        self.bulk_us.lock().clear();
        NodeCounts {
            sent_bytes: self.sent_bytes.load(Ordering::Acquire),
            arrivals: self.arrivals.load(Ordering::Acquire),
            ..NodeCounts::default()
        }
    }

    /// Ends it.
    pub fn end(&self, before: &NodeCounts) -> NodeCounts {
        let sorted = |of: &Mutex<Vec<u64>>| {
            let mut values = std::mem::take(&mut *of.lock());
            values.sort_unstable();
            values
        };
        NodeCounts {
            sent_bytes: self.sent_bytes.load(Ordering::Acquire) - before.sent_bytes,
            arrivals: self.arrivals.load(Ordering::Acquire) - before.arrivals,
            latencies_us: sorted(&self.latencies_us),
            bulk_us: sorted(&self.bulk_us),
        }
    }
}

/// Ends its thread when dropped.
pub(super) struct Running {
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Running {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            let _ended = thread.join();
        }
    }
}

/// A node before its thread begins.
pub(super) struct Node {
    bus: Bus,
    transport: Box<dyn Transport>,
    others: Vec<NodeId>,
    begun: Instant,
    counts: Arc<Counts>,
    next: [NodeTime; 3],
    met: bool,
    sent_bytes: u64,
    arrivals: u64,
}

impl Node {
    pub fn new(
        transport: Box<dyn Transport>,
        key: &SwarmKey,
        all: &[NodeId],
        begun: Instant,
        counts: &Arc<Counts>,
    ) -> Self {
        let me = transport.node();
        let settings = BusSettings {
            // The same for all, so that they carry the same datagrams.
            datagram_bytes: transport.largest_bytes().min(1300),
            ..BusSettings::default()
        };
        // The nodes of a run of the bench are strangers to those of another by its swarm's name.
        let bus = Bus::new(settings, key.clone(), me, Boot(me.0 + 1), NodeTime(0));
        // Not all at the same moment.
        let first = NodeTime::from_seconds(me.0 as f64 * 0.013);
        Self {
            bus,
            transport,
            others: all.iter().copied().filter(|node| *node != me).collect(),
            begun,
            counts: Arc::clone(counts),
            next: [first; 3],
            met: false,
            sent_bytes: 0,
            arrivals: 0,
        }
    }

    /// Begins its thread.
    pub fn run(mut self) -> Result<Running, BenchError> {
        let ends = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&ends);
        let thread = std::thread::Builder::new().name(format!("node {}", self.bus.node()));
        let thread = thread.spawn(move || {
            let me = std::thread::current();
            self.transport.wake_on_arrival(Arc::new(move || me.unpark()));
            while !told.load(Ordering::Acquire) {
                let now = self.now();
                self.tell(now);
                let Ok(events) = pump(&mut self.bus, &mut self.transport, now) else {
                    return;
                };
                let now = self.now();
                for event in events {
                    self.happened(now, event);
                }
                self.count();
                let due_s = self.next.into_iter().min().map_or(0.0, |due| due.seconds_since(now));
                std::thread::park_timeout(Duration::from_secs_f64(due_s.clamp(0.0, LOOK_S)));
            }
        });
        Ok(Running {
            ends,
            thread: Some(thread.map_err(BenchError::system("a thread"))?),
        })
    }

    fn now(&self) -> NodeTime {
        NodeTime::from_seconds(self.begun.elapsed().as_secs_f64())
    }

    /// Its traffic: values begin with the moment at which they are told.
    fn tell(&mut self, now: NodeTime) {
        let periods_s = [BEACON_S, VEHICLE_S, SELDOM_S];
        let lengths = [(BEACON, 30), (VEHICLE, 82), (INTENT, 600)];
        for ((next, period_s), (key, length)) in self.next.iter_mut().zip(periods_s).zip(lengths) {
            if now < *next {
                continue;
            }
            *next = next.plus_seconds(period_s).max(now);
            let first = self.bus.node() == NodeId(1);
            if key == INTENT && !first {
                continue;
            }
            let mut value = now.0.to_be_bytes().to_vec();
            value.resize(length, 7);
            // They fit, and are three.
            let _told = self.bus.tell(now, key, value);
            if key == INTENT
                && let Some(other) = self.others.first()
            {
                let mut thing = now.0.to_be_bytes().to_vec();
                thing.resize(100_000, 5);
                let _sent = self.bus.send(now, *other, thing);
            }
        }
    }

    fn happened(&self, now: NodeTime, event: Event) {
        let since_us = |bytes: &[u8]| {
            let told = bytes.first_chunk().map_or(now.0, |bytes| u64::from_be_bytes(*bytes));
            now.0.saturating_sub(told)
        };
        match event {
            Event::State {
                key: VEHICLE, value, ..
            } => self.counts.latencies_us.lock().push(since_us(&value)),
            Event::Bulk { body, .. } => self.counts.bulk_us.lock().push(since_us(&body)),
            _ => {}
        }
    }

    fn count(&mut self) {
        if !self.met && self.others.iter().all(|node| self.bus.run_of(*node).is_some()) {
            self.met = true;
            self.counts.met.fetch_add(1, Ordering::AcqRel);
        }
        let sent_bytes = self.bus.sent().total_bytes();
        let arrivals = self
            .bus
            .received()
            .values()
            .map(|of| of.datagrams.iter().sum::<u64>())
            .sum();
        self.counts
            .sent_bytes
            .fetch_add(sent_bytes - self.sent_bytes, Ordering::AcqRel);
        self.counts
            .arrivals
            .fetch_add(arrivals - self.arrivals, Ordering::AcqRel);
        (self.sent_bytes, self.arrivals) = (sent_bytes, arrivals);
    }
}
