//! Carries the topics of all vehicles over one participant, on a thread of its own beside the simulation's.
//!
//! Must never do: let the simulation wait. What it publishes is queued, what comes for it lies ready; both are bounded, and what is
//! dropped is counted.

use crate::endpoints::{Endpoints, Way};
use crate::settings::DdsSettings;
use crate::{OpenError, failed};
use parking_lot::Mutex;
use rustdds::DomainParticipantBuilder;
use skein_sim::topics::{Asked, CarrierError, Published, TopicCarrier};
use std::collections::{BTreeMap, VecDeque};
use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

/// Above it, the ports of a domain reach into those that the system gives to anybody.
const LAST_DOMAIN_ID: u16 = 101;
/// Samples that wait to be written, of all vehicles: a second and more of a hundred of them.
const MOST_QUEUED: usize = 20_000;
/// What waits to be taken, of one vehicle: more than a second of setpoints. Beyond it the oldest makes way.
const MOST_WAITING: usize = 256;
/// Longest sleep.
const SLEEP: Duration = Duration::from_millis(20);

/// What the thread has to do.
enum Order {
    Enter(u64, Box<Endpoints>),
    Leave(u64),
    Publish(u64, Published),
}

#[derive(Default)]
struct Shared {
    orders: Mutex<VecDeque<Order>>,
    arrived: Mutex<BTreeMap<u64, VecDeque<Asked>>>,
    ends: AtomicBool,
    dropped: AtomicU64,
}

impl Shared {
    fn order(&self, order: Order) {
        let mut orders = self.orders.lock();
        if matches!(order, Order::Publish(..)) && orders.len() >= MOST_QUEUED {
            self.dropped.fetch_add(1, Ordering::Relaxed);
            return;
        }
        orders.push_back(order);
    }

    fn arrive(&self, vehicle: u64, asked: Asked) {
        let mut arrived = self.arrived.lock();
        let waiting = arrived.entry(vehicle).or_default();
        if waiting.len() >= MOST_WAITING {
            waiting.pop_front();
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
        waiting.push_back(asked);
    }
}

/// The topics of a simulation's vehicles on DDS. Ends when it is dropped.
pub struct DdsCarrier {
    settings: DdsSettings,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    // Last: what the thread holds goes before the participant does.
    way: Way,
}

impl std::fmt::Debug for DdsCarrier {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("DdsCarrier")
            .field("settings", &self.settings)
            .finish_non_exhaustive()
    }
}

impl DdsCarrier {
    /// Joins a domain on the loopback interface.
    ///
    /// # Errors
    /// When there is no such domain, or DDS cannot begin.
    pub fn open(settings: &DdsSettings) -> Result<Self, OpenError> {
        if settings.domain_id > LAST_DOMAIN_ID {
            return Err(OpenError::Domain(settings.domain_id));
        }
        let participant = DomainParticipantBuilder::new(settings.domain_id)
            .with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)])
            .build()
            .map_err(failed)?;
        let way = Way::new(participant)?;
        let shared = Arc::new(Shared::default());
        let of_thread = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("skein-sim dds".to_owned())
            .spawn(move || carry(&of_thread));
        Ok(Self {
            settings: settings.clone(),
            shared,
            thread: Some(thread.map_err(failed)?),
            way,
        })
    }

    /// Samples that were dropped or not taken by DDS, in either direction, since the start.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.shared.dropped.load(Ordering::Relaxed)
    }

    fn wake(&self) {
        if let Some(thread) = &self.thread {
            thread.thread().unpark();
        }
    }
}

impl TopicCarrier for DdsCarrier {
    fn enter(&self, vehicle: u64, system_id: u8) -> Result<(), CarrierError> {
        let namespace = self.settings.namespaces.of(system_id);
        let release = self.settings.release_of(system_id);
        let endpoints = Endpoints::new(&self.way, &namespace, release)?;
        self.shared.order(Order::Enter(vehicle, Box::new(endpoints)));
        self.wake();
        Ok(())
    }

    fn leave(&self, vehicle: u64) {
        self.shared.order(Order::Leave(vehicle));
        self.wake();
    }

    fn publish(&self, vehicle: u64, published: &Published) {
        self.shared.order(Order::Publish(vehicle, *published));
    }

    fn take(&self, vehicle: u64) -> Option<Asked> {
        self.shared.arrived.lock().get_mut(&vehicle)?.pop_front()
    }

    fn step_done(&self) {
        if !self.shared.orders.lock().is_empty() {
            self.wake();
        }
    }
}

impl Drop for DdsCarrier {
    fn drop(&mut self) {
        self.shared.ends.store(true, Ordering::Release);
        self.wake();
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the thread that carries topics panicked");
        }
    }
}

/// What the thread does.
fn carry(shared: &Shared) {
    let mut vehicles: BTreeMap<u64, Box<Endpoints>> = BTreeMap::new();
    while !shared.ends.load(Ordering::Acquire) {
        let orders = std::mem::take(&mut *shared.orders.lock());
        let idle = orders.is_empty();
        for order in orders {
            match order {
                Order::Enter(vehicle, endpoints) => {
                    vehicles.insert(vehicle, endpoints);
                }
                Order::Leave(vehicle) => {
                    vehicles.remove(&vehicle);
                    shared.arrived.lock().remove(&vehicle);
                }
                Order::Publish(vehicle, published) => {
                    let written = vehicles.get(&vehicle).is_none_or(|to| to.write(&published));
                    shared.dropped.fetch_add(u64::from(!written), Ordering::Relaxed);
                }
            }
        }
        for (vehicle, endpoints) in &mut vehicles {
            endpoints.read(|asked| shared.arrive(*vehicle, asked));
        }
        if idle {
            std::thread::park_timeout(SLEEP);
        }
    }
}
