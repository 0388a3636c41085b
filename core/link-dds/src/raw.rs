//! What RustDDS carries: samples as they came, so that judging and reading them is ours; and what we write.
//!
//! Must never do: read a sample; join DDS by itself. The participant is the node's, one for everything.

use crate::cdr::Encoding;
use crate::definitions::Command;
use crate::messages::incoming::{OffboardControlMode, TrajectorySetpoint, VehicleCommand};
use crate::naming::{Direction, Namespace, TopicName, type_name};
use rustdds::no_key::{DataWriter, Decode, DefaultDecoder, DeserializerAdapter, SimpleDataReader};
use rustdds::policy::{Durability, History, Reliability};
use rustdds::{
    DomainParticipant, Publisher, QosPolicies, QosPolicyBuilder, RepresentationIdentifier as Id, Subscriber, Topic,
    TopicKind,
};
use std::convert::Infallible;
use thiserror::Error;

/// Longest sample that is kept whole; no message of the table is as long. Of a longer one the length alone is of interest.
const LONGEST_BYTES: usize = 1024;
/// Samples that wait to be read, of one topic.
const WAITING: i32 = 32;

/// DDS could not make a topic, reader or writer.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("DDS: {0}")]
pub struct DdsError(String);

pub(crate) fn failed(error: impl std::fmt::Display) -> DdsError {
    DdsError(error.to_string())
}

/// A sample as it came.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Raw {
    /// How it is encoded.
    pub encoding: Encoding,
    /// Its octets, no more of them than say that it is too long.
    pub bytes: Vec<u8>,
}

/// Hands samples on unread.
#[derive(Debug)]
pub struct Unread;

/// Does that.
#[derive(Debug, Clone)]
pub struct Copies;

/// All that RustDDS has a name for: what is none of ours is named, not passed over.
const ENCODINGS: [Id; 15] = [
    Id::CDR_BE,
    Id::CDR_LE,
    Id::PL_CDR_BE,
    Id::PL_CDR_LE,
    Id::CDR2_BE,
    Id::CDR2_LE,
    Id::PL_CDR2_BE,
    Id::PL_CDR2_LE,
    Id::D_CDR_BE,
    Id::D_CDR_LE,
    Id::XML,
    Id::XCDR2_BE,
    Id::XCDR2_LE,
    Id::D_CDR2_BE,
    Id::D_CDR2_LE,
];

impl DeserializerAdapter<Raw> for Unread {
    type Error = Infallible;
    type Decoded = Raw;

    fn supported_encodings() -> &'static [Id] {
        &ENCODINGS
    }

    fn transform_decoded(decoded: Raw) -> Raw {
        decoded
    }
}

impl DefaultDecoder<Raw> for Unread {
    type Decoder = Copies;
    const DECODER: Copies = Copies;
}

impl Decode<'_, Raw> for Copies {
    type Error = Infallible;

    fn decode_bytes(self, bytes: &[u8], encoding: Id) -> Result<Raw, Infallible> {
        let kept = bytes.get(..LONGEST_BYTES).unwrap_or(bytes);
        Ok(Raw {
            encoding: Encoding::of(u16::from_be_bytes(encoding.to_bytes())),
            bytes: kept.to_vec(),
        })
    }
}

/// Reads one topic.
pub type Reader = SimpleDataReader<Raw, Unread>;

/// Best effort and volatile. PX4's agent offers its topics as best effort and transient local, which is more, and reads as best effort. A
/// writer of this kind waits for no reader; what PX4 keeps for late readers is not sent again on best effort.
#[must_use]
pub fn quality() -> QosPolicies {
    QosPolicyBuilder::new()
        .reliability(Reliability::BestEffort)
        .durability(Durability::Volatile)
        .history(History::KeepLast { depth: WAITING })
        .build()
}

/// The way into DDS.
pub(crate) struct Dds {
    pub participant: DomainParticipant,
    publisher: Publisher,
    subscriber: Subscriber,
}

impl Dds {
    pub fn new(participant: DomainParticipant) -> Result<Self, DdsError> {
        Ok(Self {
            publisher: participant.create_publisher(&quality()).map_err(failed)?,
            subscriber: participant.create_subscriber(&quality()).map_err(failed)?,
            participant,
        })
    }

    fn topic(&self, name: &TopicName, message: &str) -> Result<Topic, DdsError> {
        let made = self
            .participant
            .create_topic(name.dds_name(), type_name(message), &quality(), TopicKind::NoKey);
        made.map_err(failed)
    }

    pub fn reader(&self, name: &TopicName, message: &str) -> Result<Reader, DdsError> {
        let topic = self.topic(name, message)?;
        let made = self
            .subscriber
            .create_simple_datareader_no_key::<Raw, Unread>(&topic, None);
        made.map_err(failed)
    }

    pub fn writers(&self, namespace: &Namespace) -> Result<Writers, DdsError> {
        let topic = |command: Command| {
            let name = TopicName {
                namespace: namespace.clone(),
                direction: Direction::In,
                base: command.base().to_owned(),
                version: 0,
            };
            self.topic(&name, command.message())
        };
        let (commands, modes) = (topic(Command::VehicleCommand)?, topic(Command::OffboardControlMode)?);
        let setpoints = topic(Command::TrajectorySetpoint)?;
        let to = &self.publisher;
        Ok(Writers {
            commands: to.create_datawriter_no_key_cdr(&commands, None).map_err(failed)?,
            modes: to.create_datawriter_no_key_cdr(&modes, None).map_err(failed)?,
            setpoints: to.create_datawriter_no_key_cdr(&setpoints, None).map_err(failed)?,
        })
    }
}

/// Writes what one vehicle is sent.
pub(crate) struct Writers {
    pub commands: DataWriter<VehicleCommand>,
    pub modes: DataWriter<OffboardControlMode>,
    pub setpoints: DataWriter<TrajectorySetpoint>,
}
