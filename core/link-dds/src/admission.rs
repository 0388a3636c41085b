//! Whether a vehicle's messages are those that Skein knows: asked once, before anything of it is believed.
//!
//! Must never do: let a vehicle through of which a message does not fit; change its mind about one that is flown.
//!
//! Without I/O: what discovery and readers give comes in, a verdict comes out.

use crate::cdr::{CdrError, Encoding};
use crate::definitions::{self, Command, Definition, Need, Release, SampleError, Topic};
use crate::naming::{Direction, TopicName, type_name};
use crate::sample::{Implausible, Sample};
use crate::type_hash;
use std::collections::BTreeMap;
use thiserror::Error;

/// So many good samples of a needed topic in a row are enough.
const GOOD_SAMPLES: u8 = 3;
/// So many samples in a row that cannot be true are not a glitch.
const BAD_SAMPLES: u8 = 3;

/// Why a vehicle is refused: which message does not fit, and in what.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Mismatch {
    /// The type on the topic is another one.
    #[error("{topic} carries {found} where {expected} is expected")]
    TypeName {
        /// The topic.
        topic: String,
        /// The type that there should be.
        expected: String,
        /// The type that there is.
        found: String,
    },
    /// The message has a version that is not known.
    #[error("{topic} has version {version} of {message}; known are {known}")]
    Version {
        /// The topic.
        topic: String,
        /// The message.
        message: &'static str,
        /// Its version.
        version: u32,
        /// Versions that are known, with their releases.
        known: String,
    },
    /// The hash of the type is not that of any definition.
    #[error("{topic} carries {message} with fields of its own (type hash {found})")]
    TypeHash {
        /// The topic.
        topic: String,
        /// The message.
        message: &'static str,
        /// The hash.
        found: String,
    },
    /// Samples have a length that no definition has.
    #[error("{topic} has samples of {got} octets; {message} has {known}")]
    Size {
        /// The topic.
        topic: String,
        /// The message.
        message: &'static str,
        /// Octets of a sample.
        got: usize,
        /// Octets of the definitions, with their releases.
        known: String,
    },
    /// Samples are not plain CDR.
    #[error("{topic} is encoded as 0x{encoding:04x}, which is not plain CDR")]
    Encoding {
        /// The topic.
        topic: String,
        /// The number of the encoding.
        encoding: u16,
    },
    /// Samples have the right length, but what is in them cannot be true.
    #[error("{topic}: {reason}; its fields are not those of {message} as it is known")]
    Content {
        /// The topic.
        topic: String,
        /// The message.
        message: &'static str,
        /// What cannot be.
        reason: String,
    },
}

/// Where the check stands.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// Not seen enough yet.
    Open,
    /// All fits.
    Admitted {
        /// MAVLink system id of the vehicle.
        system_id: u8,
        /// Releases that all definitions in use have in common; none if it is a mixture, which is flown nevertheless.
        releases: Vec<Release>,
    },
    /// Something does not fit.
    Refused(Mismatch),
}

#[derive(Debug, Default)]
struct SeenMessage {
    version: u32,
    definition: Option<&'static Definition>,
    good: u8,
    bad: u8,
}

/// The check of one vehicle.
#[derive(Debug, Default)]
pub struct Admission {
    topics: BTreeMap<Topic, SeenMessage>,
    /// Topics that are there in versions that are not known. Another program may offer a known one beside them.
    unknown: BTreeMap<Topic, Mismatch>,
    /// The same for topics that Skein writes.
    unread: BTreeMap<Command, Mismatch>,
    commands: Vec<Command>,
    system_id: Option<u8>,
    refused: Option<Mismatch>,
    admitted: bool,
}

impl Admission {
    /// Discovery has found a writer or reader of the vehicle. True if the topic is one that Skein uses, and fits by what is known so far.
    ///
    /// After the vehicle is admitted, one that does not fit is left alone, which is the caller's to tell.
    pub fn on_endpoint(&mut self, name: &TopicName, found_type: &str, user_data: &[u8]) -> Result<bool, Mismatch> {
        let judged = match name.direction {
            Direction::Out => self.on_writer(name, found_type, user_data),
            Direction::In => self.on_reader(name, found_type, user_data),
        };
        match &judged {
            Err(Mismatch::Version { .. }) | Ok(_) => {}
            Err(mismatch) if !self.admitted => {
                self.refused.get_or_insert_with(|| mismatch.clone());
            }
            Err(_) => {}
        }
        judged
    }

    fn on_writer(&mut self, name: &TopicName, found_type: &str, user_data: &[u8]) -> Result<bool, Mismatch> {
        let Some(topic) = Topic::of(&name.base) else {
            return Ok(false);
        };
        check_type(name, topic.message(), found_type)?;
        let known: Vec<_> = definitions::of(topic, name.version).collect();
        if known.is_empty() {
            let mismatch = Mismatch::Version {
                topic: name.to_string(),
                message: topic.message(),
                version: name.version,
                known: versions(topic),
            };
            self.unknown.insert(topic, mismatch.clone());
            return Err(mismatch);
        }
        if self.topics.get(&topic).is_some_and(|seen| seen.version != name.version) {
            // Translated by another program: one of them is enough.
            return Ok(false);
        }
        let hash = type_hash::announced(user_data);
        let by_hash = known
            .iter()
            .find(|d| hash.as_ref().is_some_and(|hash| d.type_hash() == *hash));
        if let (Some(found), None) = (hash, by_hash) {
            let topic_name = name.to_string();
            return Err(Mismatch::TypeHash {
                topic: topic_name,
                message: topic.message(),
                found,
            });
        }
        let seen = self.topics.entry(topic).or_default();
        seen.version = name.version;
        seen.definition = seen.definition.or(by_hash.copied());
        Ok(true)
    }

    fn on_reader(&mut self, name: &TopicName, found_type: &str, user_data: &[u8]) -> Result<bool, Mismatch> {
        let Some(command) = Command::of(&name.base) else {
            return Ok(false);
        };
        check_type(name, command.message(), found_type)?;
        if name.version != 0 {
            let mismatch = Mismatch::Version {
                topic: name.to_string(),
                message: command.message(),
                version: name.version,
                known: "0".to_owned(),
            };
            self.unread.insert(command, mismatch.clone());
            return Err(mismatch);
        }
        if let Some(found) = type_hash::announced(user_data)
            && found != type_hash::of_px4(command.message(), command.fields())
        {
            let topic = name.to_string();
            return Err(Mismatch::TypeHash {
                topic,
                message: command.message(),
                found,
            });
        }
        if !self.commands.contains(&command) {
            self.commands.push(command);
        }
        Ok(true)
    }

    /// A sample of the vehicle. `Some` if it can be used, which is before the verdict not yet for anything but that.
    pub fn on_sample(&mut self, name: &TopicName, encoding: Encoding, bytes: &[u8]) -> Option<Sample> {
        // Not announced, or in another version than the one that is read.
        let topic = Topic::of(&name.base).filter(|_| self.uses(name))?;
        let read = self.read(topic, name, encoding, bytes);
        let seen = self.topics.get_mut(&topic)?;
        match read {
            Ok(sample) => {
                seen.good = seen.good.saturating_add(1);
                seen.bad = 0;
                if let Sample::Status(status) = sample {
                    self.system_id = Some(status.system_id);
                }
                Some(sample)
            }
            Err(mismatch) => {
                seen.bad = seen.bad.saturating_add(1);
                let definite = matches!(mismatch, Mismatch::Size { .. } | Mismatch::Encoding { .. });
                if !self.admitted && (definite || seen.bad >= BAD_SAMPLES) {
                    self.refused.get_or_insert(mismatch);
                }
                None
            }
        }
    }

    fn read(&mut self, topic: Topic, name: &TopicName, encoding: Encoding, bytes: &[u8]) -> Result<Sample, Mismatch> {
        let (topic_name, message) = (name.to_string(), topic.message());
        if let Encoding::Other(encoding) = encoding {
            return Err(Mismatch::Encoding {
                topic: topic_name,
                encoding,
            });
        }
        let wrong_size = || Mismatch::Size {
            topic: name.to_string(),
            message,
            got: bytes.len(),
            known: sizes(topic, name.version),
        };
        let settled = self.topics.get(&topic).and_then(|seen| seen.definition);
        let definition = settled.or_else(|| definitions::by_size(topic, name.version, bytes.len()));
        let definition = definition.ok_or_else(wrong_size)?;
        let content = |reason: String| Mismatch::Content {
            topic: topic_name,
            message,
            reason,
        };
        let sample = definition.read(encoding, bytes).map_err(|error| match error {
            SampleError::Cdr(CdrError::Size { .. }) => wrong_size(),
            SampleError::Cdr(error) => content(error.to_string()),
            SampleError::Implausible(Implausible { field, value }) => content(format!("{field} is {value}")),
        })?;
        let seen = self.topics.entry(topic).or_default();
        seen.definition = Some(definition);
        Ok(sample)
    }

    /// Whether the vehicle is read by this topic in this version.
    #[must_use]
    pub fn uses(&self, name: &TopicName) -> bool {
        let seen = Topic::of(&name.base).and_then(|topic| self.topics.get(&topic));
        seen.is_some_and(|seen| seen.version == name.version)
    }

    /// Where it stands.
    pub fn verdict(&mut self) -> Verdict {
        if let Some(mismatch) = &self.refused {
            return Verdict::Refused(mismatch.clone());
        }
        let unknown = self.unknown.iter().find(|(topic, _)| !self.topics.contains_key(topic));
        let unread = self.unread.iter().find(|(command, _)| !self.commands.contains(command));
        if let Some(mismatch) = unknown
            .map(|(_, m)| m)
            .or(unread.map(|(_, m)| m))
            .filter(|_| !self.admitted)
        {
            return Verdict::Refused(mismatch.clone());
        }
        match self.system_id {
            Some(system_id) if self.waits_for().is_empty() => {
                self.admitted = true;
                let releases = self.releases();
                Verdict::Admitted { system_id, releases }
            }
            _ => Verdict::Open,
        }
    }

    /// Topics that have to be there, or be heard, before the vehicle can be admitted.
    #[must_use]
    pub fn waits_for(&self) -> Vec<&'static str> {
        let missing = Topic::ALL
            .into_iter()
            .filter(|topic| match (topic.need(), self.topics.get(topic)) {
                (Need::Optional, _) => false,
                (Need::Seen, seen) => seen.is_none_or(|seen| seen.good < GOOD_SAMPLES),
            });
        let unread = Command::ALL
            .into_iter()
            .filter(|command| !self.commands.contains(command));
        missing.map(Topic::base).chain(unread.map(Command::base)).collect()
    }

    /// The releases that all topics in use have in common; of one that was not heard yet its version alone tells.
    fn releases(&self) -> Vec<Release> {
        let fits = |release: &Release| {
            self.topics.iter().all(|(topic, seen)| match seen.definition {
                Some(definition) => definition.releases.contains(release),
                None => definitions::of(*topic, seen.version).any(|d| d.releases.contains(release)),
            })
        };
        Release::ALL.into_iter().filter(fits).collect()
    }
}

fn check_type(name: &TopicName, message: &str, found: &str) -> Result<(), Mismatch> {
    let expected = type_name(message);
    if found == expected {
        return Ok(());
    }
    Err(Mismatch::TypeName {
        topic: name.to_string(),
        expected,
        found: found.to_owned(),
    })
}

/// Versions of a topic that are known, for people.
fn versions(topic: Topic) -> String {
    let known = definitions::DEFINITIONS.iter().filter(|d| d.topic == topic);
    let words = known.map(|d| format!("{} (PX4 {})", d.version, releases(d)));
    words.collect::<Vec<_>>().join(", ")
}

/// Sizes of a topic's samples, for people.
fn sizes(topic: Topic, version: u32) -> String {
    let words = definitions::of(topic, version).map(|d| format!("{} (PX4 {})", d.size_bytes(), releases(d)));
    words.collect::<Vec<_>>().join(" or ")
}

fn releases(definition: &Definition) -> String {
    let words: Vec<_> = definition.releases.iter().map(ToString::to_string).collect();
    words.join(", ")
}

#[cfg(test)]
mod tests;
