//! The writers and readers of one vehicle, with the quality that PX4's agent gives them.
//!
//! Must never do: join DDS by itself; wait for a reader. Writers are best effort.

use crate::octets::{Octets, sample};
use crate::{OpenError, failed, shapes};
use rustdds::no_key::{DataWriter, SimpleDataReader};
use rustdds::policy::{Durability, History, Reliability};
use rustdds::{DomainParticipant, Publisher, QosPolicies, QosPolicyBuilder, Subscriber, Topic as DdsTopic, TopicKind};
use skein_link_dds::definitions::{Command, DEFINITIONS, Definition, Release, Topic};
use skein_link_dds::messages::Message;
use skein_link_dds::messages::incoming::{OffboardControlMode, TrajectorySetpoint, VehicleCommand};
use skein_link_dds::naming::{Direction, Namespace, TopicName, type_name};
use skein_sim::topics::{Asked, Published};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Wake, Waker};
use std::thread::Thread;
use std::time::{Duration, Instant};

/// Samples that wait to be sent or read, of one topic.
const WAITING: i32 = 16;
/// Samples of one topic that are read in one pass, at most: a flood must not hold up the other vehicles.
const AT_ONCE: usize = 64;
/// Readers are looked at so often though nothing was announced: under load RustDDS may drop a notice.
const LOOKS_EVERY: Duration = Duration::from_millis(100);

/// Something has arrived for a vehicle.
struct Notice {
    arrived: AtomicBool,
    thread: Thread,
}

impl Wake for Notice {
    fn wake(self: Arc<Self>) {
        self.arrived.store(true, Ordering::Release);
        self.thread.unpark();
    }
}

/// The way into DDS, the same for all vehicles.
pub(crate) struct Way {
    participant: DomainParticipant,
    publisher: Publisher,
    subscriber: Subscriber,
}

impl Way {
    pub fn new(participant: DomainParticipant) -> Result<Self, OpenError> {
        Ok(Self {
            publisher: participant.create_publisher(&outgoing()).map_err(failed)?,
            subscriber: participant.create_subscriber(&incoming()).map_err(failed)?,
            participant,
        })
    }

    fn topic(&self, name: &TopicName, message: &str, quality: &QosPolicies) -> Result<DdsTopic, OpenError> {
        let (name, kind) = (name.dds_name(), type_name(message));
        let made = self.participant.create_topic(name, kind, quality, TopicKind::NoKey);
        made.map_err(failed)
    }

    fn reader<M: Message + 'static>(
        &self,
        namespace: &Namespace,
        command: Command,
    ) -> Result<SimpleDataReader<M>, OpenError> {
        let name = TopicName {
            namespace: namespace.clone(),
            direction: Direction::In,
            base: command.base().to_owned(),
            version: 0,
        };
        let topic = self.topic(&name, M::NAME, &incoming())?;
        let made = self.subscriber.create_simple_datareader_no_key(&topic, None);
        made.map_err(failed)
    }
}

/// As PX4's agent offers its topics.
fn outgoing() -> QosPolicies {
    QosPolicyBuilder::new()
        .reliability(Reliability::BestEffort)
        .durability(Durability::TransientLocal)
        .history(History::KeepLast { depth: WAITING })
        .build()
}

/// As it reads.
fn incoming() -> QosPolicies {
    QosPolicyBuilder::new()
        .reliability(Reliability::BestEffort)
        .durability(Durability::Volatile)
        .history(History::KeepLast { depth: WAITING })
        .build()
}

struct Writing {
    definition: &'static Definition,
    writer: DataWriter<Octets>,
}

/// One vehicle's.
pub(crate) struct Endpoints {
    release: Release,
    writers: Vec<Writing>,
    modes: SimpleDataReader<OffboardControlMode>,
    setpoints: SimpleDataReader<TrajectorySetpoint>,
    commands: SimpleDataReader<VehicleCommand>,
    notice: Option<Arc<Notice>>,
    looked: Instant,
}

impl Endpoints {
    pub fn new(way: &Way, namespace: &Namespace, release: Release) -> Result<Self, OpenError> {
        let definitions = DEFINITIONS.iter().filter(|d| d.releases.contains(&release));
        let writing = |definition: &'static Definition| {
            let name = TopicName {
                namespace: namespace.clone(),
                direction: Direction::Out,
                base: definition.topic.base().to_owned(),
                version: definition.version,
            };
            let topic = way.topic(&name, definition.message, &outgoing())?;
            let writer = way.publisher.create_datawriter_no_key_cdr(&topic, None);
            let writer = writer.map_err(failed)?;
            Ok(Writing { definition, writer })
        };
        Ok(Self {
            release,
            writers: definitions.map(writing).collect::<Result<_, OpenError>>()?,
            modes: way.reader(namespace, Command::OffboardControlMode)?,
            setpoints: way.reader(namespace, Command::TrajectorySetpoint)?,
            commands: way.reader(namespace, Command::VehicleCommand)?,
            notice: None,
            looked: Instant::now(),
        })
    }

    /// Writes one sample; false if DDS did not take it.
    pub fn write(&self, published: &Published) -> bool {
        let Some((topic, record)) = shapes::outgoing(published, self.release) else {
            return true;
        };
        let writing = self.writers.iter().find(|w| of(w) == topic);
        writing.is_some_and(|Writing { definition, writer }| {
            writer.write(sample(definition.fields, &record), None).is_ok()
        })
    }

    /// Reads what has arrived. What is no message of its topic is passed over.
    pub fn read(&mut self, mut each: impl FnMut(Asked)) {
        let notice = self.notice.get_or_insert_with(|| {
            Arc::new(Notice {
                arrived: AtomicBool::new(true),
                thread: std::thread::current(),
            })
        });
        let arrived = notice.arrived.swap(false, Ordering::AcqRel);
        if !arrived && self.looked.elapsed() < LOOKS_EVERY {
            return;
        }
        self.looked = Instant::now();
        let waker = Waker::from(Arc::clone(notice));
        let more = [
            drain(&self.modes, &waker, |m| each(shapes::mode(m))),
            drain(&self.setpoints, &waker, |s| each(shapes::setpoint(s))),
            drain(&self.commands, &waker, |c| each(shapes::command(c))),
        ];
        if more.contains(&true) {
            waker.wake();
        }
    }
}

fn of(writing: &Writing) -> Topic {
    writing.definition.topic
}

/// Reads one topic; true if there may be more.
fn drain<M: Message + 'static>(reader: &SimpleDataReader<M>, waker: &Waker, mut each: impl FnMut(&M)) -> bool {
    // In this order nothing that comes meanwhile is missed: the waker is there before it is looked.
    reader.set_waker(Some(waker.clone()));
    reader.drain_read_notifications();
    for _ in 0..AT_ONCE {
        match reader.try_take_one() {
            Ok(Some(sample)) => each(&sample.into_value()),
            Ok(None) => return false,
            // A stranger's sample that is none.
            Err(_) => {}
        }
    }
    true
}
