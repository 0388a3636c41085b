//! Every link of the node by system id, shared by all endpoints; it outlives their restarts. Decides when a system id that is
//! heard from a second place means a vehicle that moved, and when it means another sender.
//!
//! Must never do: leave the place of a vehicle that is still heard there, or that of one in flight for a place that spoke beside it.

use crate::decode::Heartbeat;
use crate::event::EndpointEvent;
use crate::link::{Contest, Px4Link, Route, Ticked};
use crate::metrics::EndpointMetrics;
use crate::outlet::Outlet;
use parking_lot::Mutex;
use skein_domain::NodeTime;
use skein_px4::LinkSettings;
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::Arc;
use tokio::sync::Semaphore;

/// A vehicle that is silent at its place for this long while it is heard elsewhere has moved, in seconds.
const MOVED_AFTER_S: f64 = 0.5;
/// Two places are two senders when the first is still heard this long after the second came up, in seconds.
const BOTH_AFTER_S: f64 = 0.3;
/// A system id that comes up at most this long before another at the same place goes silent is that vehicle's new one, in
/// seconds.
const CHANGED_WITHIN_S: f64 = 3.0;

/// One endpoint as the table knows it, over all its restarts.
#[derive(Debug, Clone)]
pub(crate) struct Slot {
    pub name: Arc<str>,
    pub number: usize,
    pub metrics: Arc<EndpointMetrics>,
    pub outlet: Arc<Outlet>,
    /// Held by the running task, so that the next one binds only when the port is free.
    pub lease: Arc<Semaphore>,
}

/// A second place at which a system id is heard.
#[derive(Debug)]
struct Rival {
    route: Route,
    first: NodeTime,
    last: NodeTime,
    frames: u32,
}

#[derive(Debug)]
struct Entry {
    link: Arc<Px4Link>,
    discovered: NodeTime,
    rival: Option<Rival>,
    contest: Contest,
    /// Where it was heard before it moved. Heard there again beside the new place, it has not moved: the new place is another sender's.
    former: Option<Route>,
}

#[derive(Debug, Default)]
struct Inner {
    slots: Vec<Slot>,
    entries: BTreeMap<u8, Entry>,
}

/// All links of the node and all endpoints' counters.
#[derive(Debug, Default)]
pub struct LinkTable {
    inner: Mutex<Inner>,
}

impl LinkTable {
    /// An empty table.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The link of a system id, if a vehicle with it has been heard.
    #[must_use]
    pub fn link(&self, system_id: u8) -> Option<Arc<Px4Link>> {
        self.inner
            .lock()
            .entries
            .get(&system_id)
            .map(|entry| Arc::clone(&entry.link))
    }

    /// All links by ascending system id.
    #[must_use]
    pub fn links(&self) -> Vec<Arc<Px4Link>> {
        self.inner
            .lock()
            .entries
            .values()
            .map(|entry| Arc::clone(&entry.link))
            .collect()
    }

    /// Name and counters of every endpoint that was ever started.
    #[must_use]
    pub fn metrics(&self) -> Vec<(Arc<str>, Arc<EndpointMetrics>)> {
        let inner = self.inner.lock();
        inner
            .slots
            .iter()
            .map(|slot| (Arc::clone(&slot.name), Arc::clone(&slot.metrics)))
            .collect()
    }

    /// The slot of an endpoint, made at its first start.
    pub(crate) fn slot(&self, name: &str) -> Slot {
        let mut inner = self.inner.lock();
        if let Some(slot) = inner.slots.iter().find(|slot| &*slot.name == name) {
            return slot.clone();
        }
        let metrics = Arc::new(EndpointMetrics::default());
        let slot = Slot {
            name: Arc::from(name),
            number: inner.slots.len(),
            outlet: Arc::new(Outlet::new(Arc::clone(&metrics))),
            metrics,
            lease: Arc::new(Semaphore::new(1)),
        };
        inner.slots.push(slot.clone());
        slot
    }

    /// Links heard at endpoint `number`.
    pub(crate) fn links_at(&self, number: usize) -> Vec<Arc<Px4Link>> {
        self.links()
            .into_iter()
            .filter(|link| link.route().number == number)
            .collect()
    }

    /// A vehicle's heartbeat from a system id that the asking endpoint does not know yet. Gives its link, and an event if it is
    /// new to the node.
    pub(crate) fn discover(
        &self,
        now: NodeTime,
        system_id: u8,
        heartbeat: &Heartbeat,
        slot: &Slot,
        address: Option<SocketAddr>,
        settings: &Arc<LinkSettings>,
    ) -> (Arc<Px4Link>, Option<EndpointEvent>) {
        let mut inner = self.inner.lock();
        if let Some(entry) = inner.entries.get(&system_id) {
            return (Arc::clone(&entry.link), None);
        }
        let route = slot.route(address);
        let source = route.source();
        let link = Arc::new(Px4Link::new(Arc::clone(settings), system_id, heartbeat, route, now));
        let entry = Entry {
            link: Arc::clone(&link),
            discovered: now,
            rival: None,
            contest: Contest::Nobody,
            former: None,
        };
        inner.entries.insert(system_id, entry);
        let event = EndpointEvent::Discovered {
            link: Arc::clone(&link),
            system_id,
            autopilot: heartbeat.autopilot,
            vehicle_type: heartbeat.vehicle_type,
            source,
        };
        (link, Some(event))
    }

    /// A frame of an autopilot came from another place than its vehicle's.
    pub(crate) fn on_foreign(
        &self,
        now: NodeTime,
        system_id: u8,
        slot: &Slot,
        address: Option<SocketAddr>,
        clear_s: f64,
    ) -> Option<EndpointEvent> {
        let mut inner = self.inner.lock();
        let entry = inner.entries.get_mut(&system_id)?;
        let rival = match &mut entry.rival {
            Some(rival) if rival.route.is(slot.number, address) => rival,
            // A third place: the two that are known are enough of a trouble while they last.
            Some(rival) if now.seconds_since(rival.last) < BOTH_AFTER_S => return None,
            place => place.insert(Rival {
                route: slot.route(address),
                first: now,
                last: now,
                frames: 0,
            }),
        };
        rival.last = now;
        rival.frames += 1;
        let (first, frames) = (rival.first, rival.frames);
        if frames < 2 {
            return None;
        }
        if entry.link.silent_s(now) > entry.moves_after_s(clear_s) {
            return Some(entry.moved(now, system_id));
        }
        if entry.link.last_heard().seconds_since(first) <= BOTH_AFTER_S {
            return None;
        }
        entry.both_speak(now, system_id)
    }

    /// Looks after what a link's tick found.
    pub(crate) fn on_ticked(
        &self,
        now: NodeTime,
        link: &Arc<Px4Link>,
        system_id: u8,
        ticked: &Ticked,
        clear_s: f64,
    ) -> Option<EndpointEvent> {
        let interleaved = ticked.interleaved.is_some_and(|at| now.seconds_since(at) <= clear_s);
        if !ticked.lost && !ticked.contested && !interleaved {
            return None;
        }
        let mut inner = self.inner.lock();
        if ticked.lost
            && let Some(event) = inner.changed_id(system_id, link)
        {
            return Some(event);
        }
        let entry = inner.entries.get_mut(&system_id)?;
        let rival = entry
            .rival
            .as_ref()
            .is_some_and(|rival| now.seconds_since(rival.last) <= clear_s);
        let source = link.source();
        match (entry.contest, interleaved, rival) {
            (Contest::Nobody | Contest::Elsewhere, true, _) => {
                entry.contest(now, Contest::Here);
                Some(EndpointEvent::Duplicate {
                    system_id,
                    first: source.clone(),
                    second: source,
                })
            }
            (Contest::Here, false, true) => {
                entry.contest(now, Contest::Elsewhere);
                None
            }
            (Contest::Here | Contest::Elsewhere, false, false) => {
                entry.rival = None;
                entry.contest(now, Contest::Nobody);
                Some(EndpointEvent::DuplicateCleared {
                    system_id,
                    remaining: source,
                })
            }
            _ => None,
        }
    }
}

impl Entry {
    /// How long the vehicle must be silent before a rival is taken for it, in seconds. One in flight is not left to a sender that spoke beside
    /// it: whoever forges frames would only have to wait for a gap.
    fn moves_after_s(&self, clear_s: f64) -> f64 {
        match (self.contest, self.link.is_armed()) {
            (Contest::Nobody, _) => MOVED_AFTER_S,
            (_, false) => clear_s,
            (_, true) => f64::INFINITY,
        }
    }

    fn contest(&mut self, now: NodeTime, contest: Contest) {
        self.contest = contest;
        self.link.contest(now, contest);
    }

    /// The vehicle is at its rival's place from now on.
    fn moved(&mut self, now: NodeTime, system_id: u8) -> EndpointEvent {
        let from = self.link.source();
        self.former = Some(self.link.route());
        if let Some(rival) = self.rival.take() {
            self.link.reroute(rival.route);
        }
        let to = self.link.source();
        if self.contest != Contest::Nobody {
            self.contest(now, Contest::Nobody);
            return EndpointEvent::DuplicateCleared {
                system_id,
                remaining: to,
            };
        }
        EndpointEvent::Moved { system_id, from, to }
    }

    /// Both places speak. The vehicle is where it was heard first.
    fn both_speak(&mut self, now: NodeTime, system_id: u8) -> Option<EndpointEvent> {
        let rival = self.rival.as_mut()?;
        let at_rivals = |former: &mut Route| former.is(rival.route.number, rival.route.address);
        if let Some(former) = self.former.take_if(at_rivals) {
            rival.route = self.link.route();
            self.link.reroute(former);
        } else if self.contest != Contest::Nobody {
            return None;
        }
        let second = rival.route.source();
        self.contest(now, Contest::Elsewhere);
        Some(EndpointEvent::Duplicate {
            system_id,
            first: self.link.source(),
            second,
        })
    }
}

impl Slot {
    fn route(&self, address: Option<SocketAddr>) -> Route {
        Route {
            endpoint: Arc::clone(&self.name),
            number: self.number,
            outlet: Arc::clone(&self.outlet),
            address,
        }
    }
}

impl Inner {
    /// Whether the vehicle of `system_id`, which has just gone silent, goes on under another id at the same place.
    fn changed_id(&self, system_id: u8, link: &Px4Link) -> Option<EndpointEvent> {
        let (route, heard) = (link.route(), link.last_heard());
        let (to, _) = self.entries.iter().find(|(id, entry)| {
            **id != system_id
                && entry.discovered.seconds_since(heard) > -CHANGED_WITHIN_S
                && entry.link.route().is(route.number, route.address)
                && entry.link.last_heard() > heard
        })?;
        Some(EndpointEvent::SystemIdChanged {
            from: system_id,
            to: *to,
            source: route.source(),
        })
    }
}

#[cfg(test)]
mod tests;
