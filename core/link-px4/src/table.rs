//! Every link of the node by system id, shared by all endpoints; it outlives their restarts. Decides when a system id that is
//! heard from a second place means a vehicle that moved, and when it means two vehicles.

use crate::decode::Heartbeat;
use crate::event::EndpointEvent;
use crate::link::{Px4Link, Route, Ticked};
use crate::metrics::EndpointMetrics;
use crate::outlet::Outlet;
use crate::settings::LinkSettings;
use parking_lot::Mutex;
use skein_domain::{NodeTime, Refusal};
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::Arc;
use tokio::sync::Semaphore;

/// A vehicle that is silent at its place for this long while it is heard elsewhere has moved, in seconds.
const MOVED_AFTER_S: f64 = 0.5;
/// Two places are two vehicles when the first is still heard this long after the second came up, in seconds.
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
    duplicate: bool,
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
            duplicate: false,
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
        let heard = entry.link.last_heard();
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
        if rival.frames < 2 {
            return None;
        }
        let silent_s = now.seconds_since(heard);
        if silent_s > if entry.duplicate { clear_s } else { MOVED_AFTER_S } {
            let from = entry.link.source();
            let to = rival.route.source();
            entry.link.reroute(rival.route.clone());
            entry.rival = None;
            if std::mem::take(&mut entry.duplicate) {
                entry.link.refuse_all(now, None);
                return Some(EndpointEvent::DuplicateCleared {
                    system_id,
                    remaining: to,
                });
            }
            return Some(EndpointEvent::Moved { system_id, from, to });
        }
        if !entry.duplicate && heard.seconds_since(rival.first) > BOTH_AFTER_S {
            entry.duplicate = true;
            let (first, second) = (entry.link.source(), rival.route.source());
            entry
                .link
                .refuse_all(now, Some(Refusal::DuplicateSystemId { system_id }));
            return Some(EndpointEvent::Duplicate {
                system_id,
                first,
                second,
            });
        }
        None
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
        if !ticked.lost && !ticked.refuses && !interleaved {
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
        if entry.duplicate && !rival && !interleaved {
            entry.duplicate = false;
            entry.rival = None;
            link.refuse_all(now, None);
            return Some(EndpointEvent::DuplicateCleared {
                system_id,
                remaining: link.source(),
            });
        }
        if !entry.duplicate && interleaved {
            entry.duplicate = true;
            link.refuse_all(now, Some(Refusal::DuplicateSystemId { system_id }));
            return Some(EndpointEvent::Duplicate {
                system_id,
                first: link.source(),
                second: link.source(),
            });
        }
        None
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
