//! The swarm's datagrams over DDS: RTPS on UDP, peer to peer on a LAN, with the participants that ROS 2 knows.
//!
//! Must never do: rest on more of DDS than that it carries datagrams; join DDS by itself; wait for a slow reader. What
//! the classes of traffic promise is the bus's (`skein_bus`), and so is the seal: there is no DDS security underneath it.
//!
//! One best-effort topic per class for everybody, `skein/<swarm>/<class>`; whom a datagram is for stands in it ([`packet::Packet`]).
#![forbid(unsafe_code)]

use packet::Packet;
use reading::{Reader, Reading};
use rustdds::policy::{Durability, History, Reliability};
use rustdds::{DomainParticipant, QosPolicies, QosPolicyBuilder, Topic, TopicKind, no_key};
use skein_bus::arrivals::{Arrivals, MOST_WAITING};
use skein_bus::transport::{CLASSES, Class, Datagram, SendError, To, Transport, Wake};
use skein_domain::{NodeId, NodeTime};
use std::sync::Arc;
use thiserror::Error;

pub mod packet;
mod reading;

/// With the headers of RTPS it fits into one frame of Ethernet; RTPS would send more in fragments, of which each can get lost.
const LARGEST_BYTES: usize = 1300;
/// The type of the topics, as DDS writes names of IDL.
const TYPE: &str = "skein::bus::Datagram";
/// Why there is no transport.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum OpenError {
    /// The swarm's id can't be part of a topic's name.
    #[error("a swarm's id has letters, digits, - and _ only, and at least one of them: {0:?}")]
    SwarmId(String),
    /// DDS could not begin.
    #[error("DDS did not start: {0}")]
    Start(String),
}

type Writer = no_key::DataWriter<Packet>;

/// One node's transport over DDS. It ends when this is dropped.
///
/// Over the node's participant, with one thread that hands on what arrives.
pub struct Dds {
    node: NodeId,
    writers: Vec<(Class, Writer)>,
    // Before the participant: fields are dropped in this order.
    reading: Reading,
    arrivals: Arc<Arrivals>,
    _participant: DomainParticipant,
}

impl std::fmt::Debug for Dds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Dds").field("node", &self.node).finish_non_exhaustive()
    }
}

impl Dds {
    /// Joins the swarm of this id.
    ///
    /// # Errors
    ///
    /// The id is none, or DDS can't begin.
    pub fn open(swarm: &str, node: NodeId, participant: DomainParticipant) -> Result<Self, OpenError> {
        let allowed = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '_';
        if swarm.is_empty() || !swarm.chars().all(allowed) {
            return Err(OpenError::SwarmId(swarm.to_owned()));
        }
        let publisher = participant.create_publisher(&quality()).map_err(start)?;
        let subscriber = participant.create_subscriber(&quality()).map_err(start)?;
        let (mut writers, mut readers): (_, Vec<(Class, Reader)>) = (Vec::new(), Vec::new());
        for class in CLASSES {
            let topic = topic(&participant, swarm, class)?;
            let writer = publisher.create_datawriter_no_key_cdr(&topic, None).map_err(start)?;
            writers.push((class, writer));
            let reader = subscriber.create_simple_datareader_no_key(&topic, None);
            readers.push((class, reader.map_err(start)?));
        }
        let arrivals = Arc::new(Arrivals::default());
        let reading = Reading::begin(readers, node, Arc::clone(&arrivals)).map_err(start)?;
        Ok(Self {
            node,
            writers,
            reading,
            arrivals,
            _participant: participant,
        })
    }
}

impl Transport for Dds {
    fn node(&self) -> NodeId {
        self.node
    }

    fn largest_bytes(&self) -> usize {
        LARGEST_BYTES
    }

    fn send(&mut self, _now: NodeTime, to: To, class: Class, bytes: &[u8]) -> Result<(), SendError> {
        self.check_size(bytes)?;
        if !self.reading.goes_on() {
            return Err(SendError::Down("the thread that reads has ended".to_owned()));
        }
        let writer = self.writers.iter().find(|(of, _)| *of == class);
        let Some((_, writer)) = writer else {
            return Err(SendError::Down("no writer".to_owned()));
        };
        // A best-effort writer waits for nobody: the oldest of what is not sent yet makes way.
        let written = writer.write(Packet::new(self.node, to, bytes), None);
        written.map_err(|error| SendError::Down(error.to_string()))
    }

    fn receive(&mut self, _now: NodeTime) -> Option<Datagram> {
        self.arrivals.next()
    }

    fn wake_on_arrival(&mut self, wake: Wake) {
        self.arrivals.wake_on(wake);
    }

    fn overflowed(&self) -> u64 {
        self.arrivals.overflowed()
    }
}

/// Nothing is sent again, nothing kept for who comes later: the bus does that, and knows what is worth it.
fn quality() -> QosPolicies {
    QosPolicyBuilder::new()
        .reliability(Reliability::BestEffort)
        .durability(Durability::Volatile)
        // As many as wait to be fetched; a burst of a large swarm is no reason to lose any.
        .history(History::KeepLast {
            depth: i32::try_from(MOST_WAITING).unwrap_or(i32::MAX),
        })
        .build()
}

fn topic(participant: &DomainParticipant, swarm: &str, class: Class) -> Result<Topic, OpenError> {
    let class = match class {
        Class::Command => "command",
        Class::State => "state",
        Class::Query => "query",
        Class::Video => "video",
        Class::Bulk => "bulk",
    };
    let name = format!("skein/{swarm}/{class}");
    let topic = participant.create_topic(name, TYPE.to_owned(), &quality(), TopicKind::NoKey);
    topic.map_err(start)
}

fn start(reason: impl std::fmt::Display) -> OpenError {
    OpenError::Start(reason.to_string())
}
