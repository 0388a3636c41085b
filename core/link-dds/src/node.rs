//! All vehicles that are heard over one participant: found by the names of their topics, looked at, and read by one thread.
//!
//! Must never do: join DDS by itself; write to a vehicle that has not been admitted; end while it is held, but with its thread told.

mod vehicle;

use crate::event::EventSink;
use crate::link::DdsLink;
use crate::naming::{Direction, Namespace, TopicName};
use crate::raw::{Dds, DdsError, failed};
use crate::sources::Participant;
use parking_lot::Mutex;
use rustdds::{DomainParticipant, GUID, RTPSEntity};
use skein_domain::{Clock, NodeTime};
use skein_px4::LinkSettings;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;
use vehicle::{Around, DdsVehicle};

/// How often discovery is looked at, in seconds.
const SCAN_S: f64 = 0.2;
/// Longest sleep: setpoints are repeated and expire with no more delay than this.
const SLEEP: Duration = Duration::from_millis(10);
/// After each look the samples of so long are read together: at a thousand samples a second there is no wake-up for each.
const GATHER: Duration = Duration::from_millis(2);
/// Namespaces that are looked at, at most: strangers could announce any number.
const VEHICLES_MAX: usize = 256;

/// What a node is started with.
pub struct DdsArguments {
    /// The node's one participant.
    pub participant: DomainParticipant,
    /// The node's clock.
    pub clock: Arc<dyn Clock>,
    /// How links behave; the same settings as those over MAVLink.
    pub settings: LinkSettings,
    /// The links; survives a restart.
    pub links: Arc<DdsLinkTable>,
    /// Where events go.
    pub events: EventSink,
}

/// The links by namespace; outlives restarts of what reads.
#[derive(Debug, Default)]
pub struct DdsLinkTable {
    links: Mutex<BTreeMap<Namespace, Arc<DdsLink>>>,
}

impl DdsLinkTable {
    /// All links.
    #[must_use]
    pub fn links(&self) -> Vec<Arc<DdsLink>> {
        self.links.lock().values().cloned().collect()
    }

    fn get(&self, namespace: &Namespace) -> Option<Arc<DdsLink>> {
        self.links.lock().get(namespace).cloned()
    }

    fn put(&self, namespace: Namespace, link: Arc<DdsLink>) {
        self.links.lock().insert(namespace, link);
    }
}

/// Reads as long as it is held.
#[derive(Debug)]
pub struct DdsNode {
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl DdsNode {
    /// Begins to look for vehicles.
    ///
    /// # Errors
    /// If DDS or the system does not let it.
    pub fn start(arguments: DdsArguments) -> Result<Self, DdsError> {
        let ends = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&ends);
        let me = arguments.participant.guid().prefix;
        let mut worker = Worker {
            me: participant(&GUID {
                prefix: me,
                ..arguments.participant.guid()
            }),
            dds: Dds::new(arguments.participant)?,
            clock: arguments.clock,
            settings: arguments.settings,
            links: arguments.links,
            events: arguments.events,
            vehicles: BTreeMap::new(),
            next_scan: NodeTime::default(),
        };
        let thread = std::thread::Builder::new()
            .name("px4 over dds".to_owned())
            .spawn(move || {
                while !told.load(Ordering::Acquire) {
                    if worker.pass() {
                        std::thread::sleep(GATHER);
                    } else {
                        std::thread::park_timeout(SLEEP);
                    }
                }
            });
        Ok(Self {
            ends,
            thread: Some(thread.map_err(failed)?),
        })
    }

    /// Whether it still reads; if not, whoever holds it starts another one with the same table.
    #[must_use]
    pub fn goes_on(&self) -> bool {
        self.thread.as_ref().is_some_and(|thread| !thread.is_finished())
    }
}

impl Drop for DdsNode {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // It ended by a panic of DDS, or as it should: either way it is gone.
            let _gone = thread.join();
        }
    }
}

struct Worker {
    dds: Dds,
    me: Participant,
    clock: Arc<dyn Clock>,
    settings: LinkSettings,
    links: Arc<DdsLinkTable>,
    events: EventSink,
    vehicles: BTreeMap<Namespace, DdsVehicle>,
    next_scan: NodeTime,
}

impl Worker {
    /// Does everything that there is to do; true if there was something to read.
    fn pass(&mut self) -> bool {
        let now = self.clock.now();
        if now >= self.next_scan {
            self.next_scan = now.plus_seconds(SCAN_S);
            self.scan(now);
        }
        let Self {
            dds,
            settings,
            links,
            events,
            vehicles,
            ..
        } = self;
        let mut around = Around {
            now,
            dds,
            settings,
            links,
            events,
        };
        let (mut busy, mut anew) = (false, false);
        for vehicle in vehicles.values_mut() {
            let read = vehicle.read(&mut around);
            busy |= read.any;
            anew |= read.anew;
        }
        if anew {
            self.next_scan = now;
        }
        for link in self.links.links() {
            link.tick(now);
        }
        busy
    }

    fn scan(&mut self, now: NodeTime) {
        let Self {
            dds,
            settings,
            links,
            events,
            vehicles,
            me,
            ..
        } = self;
        let mut around = Around {
            now,
            dds,
            settings,
            links,
            events,
        };
        for vehicle in vehicles.values_mut() {
            vehicle.begin_look();
        }
        for found in dds.participant.discovered_readers() {
            let topic = &found.subscription_topic_data;
            let who = participant(&found.reader_proxy.remote_reader_guid);
            let Some(name) = TopicName::parse(topic.topic_name()).filter(|_| who != *me) else {
                continue;
            };
            if name.direction == Direction::In
                && let Some(vehicle) = vehicles.get_mut(&name.namespace)
            {
                vehicle.found_reader(&around, &name, who, topic.type_name(), &found.user_data);
            }
        }
        for found in dds.participant.discovered_writers() {
            let topic = &found.publication_topic_data;
            let who = participant(&found.writer_proxy.remote_writer_guid);
            let Some(name) = TopicName::parse(&topic.topic_name).filter(|_| who != *me) else {
                continue;
            };
            if let Some(vehicle) = entry(vehicles, &name, now) {
                match name.direction {
                    Direction::Out => vehicle.found_writer(&mut around, &name, who, &topic.type_name, &found.user_data),
                    Direction::In => {
                        vehicle.found_rival(&around, &name, found.writer_proxy.remote_writer_guid.to_bytes());
                    }
                }
            }
        }
        for vehicle in vehicles.values_mut() {
            vehicle.judge(&mut around);
        }
    }
}

/// The vehicle of a topic; of strangers' topics there may be any number.
fn entry<'a>(
    vehicles: &'a mut BTreeMap<Namespace, DdsVehicle>,
    name: &TopicName,
    now: NodeTime,
) -> Option<&'a mut DdsVehicle> {
    if !vehicles.contains_key(&name.namespace) && (name.direction == Direction::In || vehicles.len() >= VEHICLES_MAX) {
        return None;
    }
    let new = || DdsVehicle::new(name.namespace.clone(), now);
    Some(vehicles.entry(name.namespace.clone()).or_insert_with(new))
}

/// The part of an identity that all writers and readers of one participant share.
fn participant(guid: &GUID) -> Participant {
    let bytes = guid.to_bytes();
    let mut prefix = Participant::default();
    for (to, from) in prefix.iter_mut().zip(bytes) {
        *to = from;
    }
    prefix
}
