//! One transport made of two: what is urgent goes over both, bulk over the first as long as it works.
//!
//! Must never do: fail while one of the two works; know what is in a datagram. The second copy of one is dropped by the seal, as any other that
//! was there before.

use crate::arrivals::Arrivals;
use crate::budget::Traffic;
use crate::transport::{Class, Datagram, SendError, To, Transport, Wake};
use parking_lot::Mutex;
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;
use std::sync::Arc;
use thiserror::Error;

/// A way that is down is tried again so often, in seconds.
const AGAIN_AFTER_S: f64 = 0.5;
/// A node of which nothing comes for so long over a way, in seconds, while it does over the other, is not reached over the first.
const SILENT_AFTER_S: f64 = 2.0;
/// Bulk that nobody has answered for so long, in seconds, goes over the other way. Each chunk is answered with a query's class.
const UNANSWERED_AFTER_S: f64 = 1.0;
/// After so long on the other way, in seconds, bulk tries the first one again.
const BACK_AFTER_S: f64 = 10.0;
/// More nodes than any swarm has; strangers make no more entries.
const MOST_NODES: usize = 512;

/// The two transports are of different nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("one transport is of node {0:?}, the other one of {1:?}")]
pub struct DifferentNodes(pub NodeId, pub NodeId);

/// How one of the two ways is.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Way {
    /// Whether its transport takes what is sent. That says nothing about whether anybody is reached.
    pub up: bool,
    /// Why it does not.
    pub down_because: Option<String>,
    /// What went over it.
    pub sent: Traffic,
    /// What came over it, second copies and strangers' included.
    pub received: Traffic,
    /// When something last came over it.
    pub last_came: Option<NodeTime>,
}

/// Both ways, the first one first: to be read anywhere while the transport is in use.
#[derive(Debug, Clone)]
pub struct Ways(Arc<Mutex<[Way; 2]>>);

impl Ways {
    /// How they are now.
    #[must_use]
    pub fn now(&self) -> [Way; 2] {
        self.0.lock().clone()
    }
}

/// What is known of how one node is reached.
#[derive(Debug, Default)]
struct Reached {
    came: [Option<NodeTime>; 2],
    /// When bulk went there that nothing has answered since.
    unanswered: Option<NodeTime>,
    /// Until then bulk goes over the other way than it would.
    other_until: Option<NodeTime>,
}

/// Two transports of one node as one.
pub struct Redundant<A, B> {
    first: A,
    second: B,
    ways: Ways,
    /// When a way that is down is tried again.
    again: [Option<NodeTime>; 2],
    reached: BTreeMap<NodeId, Reached>,
    arrivals: Arrivals,
}

impl<A, B> std::fmt::Debug for Redundant<A, B> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Redundant")
            .field("ways", &self.ways)
            .finish_non_exhaustive()
    }
}

impl<A: Transport, B: Transport> Redundant<A, B> {
    /// Of these two, of which bulk prefers the first.
    ///
    /// # Errors
    ///
    /// They are of different nodes.
    pub fn new(first: A, second: B) -> Result<Self, DifferentNodes> {
        if first.node() != second.node() {
            return Err(DifferentNodes(first.node(), second.node()));
        }
        let up = Way {
            up: true,
            ..Way::default()
        };
        Ok(Self {
            first,
            second,
            ways: Ways(Arc::new(Mutex::new([up.clone(), up]))),
            again: [None; 2],
            reached: BTreeMap::new(),
            arrivals: Arrivals::default(),
        })
    }

    /// How the two ways are, from now on.
    #[must_use]
    pub fn ways(&self) -> Ways {
        self.ways.clone()
    }

    /// Sends over one way, unless it is down and it is not yet time to try again.
    fn send_over(&mut self, place: usize, now: NodeTime, to: To, class: Class, bytes: &[u8]) -> Result<(), SendError> {
        let waits = self.again.get(place).copied().flatten();
        if waits.is_some_and(|again| now < again) {
            let why = self.way(place, |way| way.down_because.clone());
            return Err(SendError::Down(why.flatten().unwrap_or_default()));
        }
        let sent = if place == 0 {
            self.first.send(now, to, class, bytes)
        } else {
            self.second.send(now, to, class, bytes)
        };
        let again = sent.as_ref().err().map(|_| now.plus_seconds(AGAIN_AFTER_S));
        if let Some(place) = self.again.get_mut(place) {
            *place = again;
        }
        self.way(place, |way| {
            way.up = sent.is_ok();
            way.down_because = sent.as_ref().err().map(ToString::to_string);
            if sent.is_ok() {
                way.sent.count(now, class, bytes.len());
            }
        });
        sent
    }

    fn way<R>(&self, place: usize, with: impl FnOnce(&mut Way) -> R) -> Option<R> {
        self.ways.0.lock().get_mut(place).map(with)
    }

    /// Which way bulk for this node goes first.
    fn way_of_bulk(&mut self, now: NodeTime, to: NodeId) -> usize {
        let Some(reached) = self.known(to) else {
            return 0;
        };
        let heard = |came: Option<NodeTime>| came.is_some_and(|at| now.seconds_since(at) < SILENT_AFTER_S);
        let preferred = usize::from(reached.came.map(heard) == [false, true]);
        // Being heard says nothing about hearing: answers do.
        let turned = |until: Option<NodeTime>| until.is_some_and(|until| now < until);
        let since = *reached.unanswered.get_or_insert(now);
        if now.seconds_since(since) > UNANSWERED_AFTER_S {
            reached.unanswered = Some(now);
            reached.other_until = (!turned(reached.other_until)).then(|| now.plus_seconds(BACK_AFTER_S));
        }
        preferred ^ usize::from(turned(reached.other_until))
    }

    /// What is known of a node; none if they are too many.
    fn known(&mut self, node: NodeId) -> Option<&mut Reached> {
        if self.reached.len() >= MOST_NODES && !self.reached.contains_key(&node) {
            return None;
        }
        Some(self.reached.entry(node).or_default())
    }

    /// Takes over what has come, so that the most urgent of both is handed out first.
    fn gather(&mut self, now: NodeTime) {
        for place in 0..2 {
            loop {
                let came = if place == 0 {
                    self.first.receive(now)
                } else {
                    self.second.receive(now)
                };
                let Some(Datagram { from, class, bytes }) = came else {
                    break;
                };
                self.way(place, |way| {
                    way.received.count(now, class, bytes.len());
                    way.last_came = Some(now);
                });
                if let Some(reached) = self.known(from) {
                    if let Some(came) = reached.came.get_mut(place) {
                        *came = Some(now);
                    }
                    if class == Class::Query {
                        reached.unanswered = None;
                    }
                }
                self.arrivals.put(from, class, bytes);
            }
        }
    }
}

impl<A: Transport, B: Transport> Transport for Redundant<A, B> {
    fn node(&self) -> NodeId {
        self.first.node()
    }

    fn largest_bytes(&self) -> usize {
        self.first.largest_bytes().min(self.second.largest_bytes())
    }

    fn sends_to_each(&self) -> bool {
        self.first.sends_to_each() || self.second.sends_to_each()
    }

    fn send(&mut self, now: NodeTime, to: To, class: Class, bytes: &[u8]) -> Result<(), SendError> {
        self.check_size(bytes)?;
        match (class, to) {
            (Class::Video | Class::Bulk, To::One(node)) => {
                let place = self.way_of_bulk(now, node);
                self.send_over(place, now, to, class, bytes)
                    .or_else(|_| self.send_over(1 - place, now, to, class, bytes))
            }
            _ => {
                let first = self.send_over(0, now, to, class, bytes);
                let second = self.send_over(1, now, to, class, bytes);
                first.or(second)
            }
        }
    }

    fn receive(&mut self, now: NodeTime) -> Option<Datagram> {
        self.gather(now);
        self.arrivals.next()
    }

    fn due(&self) -> Option<NodeTime> {
        [self.first.due(), self.second.due()].into_iter().flatten().min()
    }

    fn wake_on_arrival(&mut self, wake: Wake) {
        self.first.wake_on_arrival(Arc::clone(&wake));
        self.second.wake_on_arrival(wake);
    }

    fn overflowed(&self) -> u64 {
        self.first.overflowed() + self.second.overflowed() + self.arrivals.overflowed()
    }
}

#[cfg(test)]
mod tests;
