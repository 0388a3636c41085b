//! The messages of a recording, one after the other, a chunk at a time.
//!
//! Must never do: end at a damaged chunk while there are others.

use crate::chunk::Records;
use crate::damage::Damage;
use crate::reader::{ChunkAt, Recording, contents};
use crate::topic::Topic;
use mcap::records::Record;
use serde::de::DeserializeOwned;
use skein_domain::NodeTime;
use std::sync::Arc;

/// Whether messages of a topic are wanted.
type Wants = Arc<dyn Fn(&Topic) -> bool + Send + Sync>;

/// Which messages.
#[derive(Clone, Default)]
pub struct Select {
    /// Recorded at this moment or later.
    pub from: Option<NodeTime>,
    /// Recorded before this moment.
    pub until: Option<NodeTime>,
    /// On these topics; all if there is no such question.
    pub topics: Option<Wants>,
    /// Also those on topics of other programs.
    pub foreign: bool,
}

impl Select {
    /// All of a topic.
    #[must_use]
    pub fn only(wants: impl Fn(&Topic) -> bool + Send + Sync + 'static) -> Self {
        Self {
            topics: Some(Arc::new(wants)),
            ..Self::default()
        }
    }

    /// The same, from a moment on.
    #[must_use]
    pub fn from(self, from: NodeTime) -> Self {
        Self {
            from: Some(from),
            ..self
        }
    }

    /// The same, up to a moment.
    #[must_use]
    pub fn until(self, until: NodeTime) -> Self {
        Self {
            until: Some(until),
            ..self
        }
    }
}

/// One message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// The topic; `None` for one of another program.
    pub topic: Option<Topic>,
    /// Its name.
    pub name: Arc<str>,
    /// When it was recorded, on the node's clock.
    pub recorded: NodeTime,
    /// When what it tells of happened, on the node's clock.
    pub at: NodeTime,
    /// The message as it was encoded.
    pub bytes: Vec<u8>,
}

impl Message {
    /// One of ours.
    ///
    /// # Errors
    /// When it is none of these.
    pub fn json<T: DeserializeOwned>(&self) -> Result<T, serde_json::Error> {
        serde_json::from_slice(&self.bytes)
    }
}

impl Recording {
    /// Its messages in the order in which they were recorded. A damaged chunk is told once, and passed over.
    #[must_use]
    pub fn messages(&self, select: Select) -> Messages<'_> {
        Messages::new(self, select)
    }

    /// The last message on a topic, as far as it can be read.
    #[must_use]
    pub fn last(&self, topic: &Topic) -> Option<Message> {
        let wanted = topic.clone();
        let mut messages = Messages::new(self, Select::only(move |topic| *topic == wanted));
        let mut chunks: Vec<ChunkAt> = std::mem::take(&mut messages.chunks).collect();
        chunks.reverse();
        chunks.iter().find_map(|at| {
            // What is wrong with a chunk is told when it is read from the beginning.
            let _ = messages.read(at);
            std::mem::take(&mut messages.ready).next_back()
        })
    }
}

/// Goes through the messages.
pub struct Messages<'a> {
    recording: &'a Recording,
    select: Select,
    chunks: std::vec::IntoIter<ChunkAt>,
    ready: std::vec::IntoIter<Message>,
}

impl<'a> Messages<'a> {
    fn new(recording: &'a Recording, select: Select) -> Self {
        let base = recording.header().base;
        let from_ns = select.from.map_or(0, |at| base.unix_ns(at));
        let until_ns = select.until.map_or(u64::MAX, |at| base.unix_ns(at));
        let wanted = |chunk: &&ChunkAt| chunk.last_ns >= from_ns && chunk.first_ns < until_ns;
        let mut chunks: Vec<ChunkAt> = recording.chunks().iter().filter(wanted).copied().collect();
        chunks.sort_by_key(|chunk| (chunk.first_ns, chunk.offset));
        Self {
            recording,
            select,
            chunks: chunks.into_iter(),
            ready: Vec::new().into_iter(),
        }
    }

    fn read(&mut self, at: &ChunkAt) -> Result<(), Damage> {
        let body = self.recording.chunk(at)?;
        let (_, unpacked) = contents(&body)?;
        let base = self.recording.header().base;
        let (mut messages, mut damage) = (Vec::new(), None);
        for record in Records::of(&unpacked) {
            let (header, data) = match record {
                Ok(Record::Message { header, data }) => (header, data),
                Ok(_) => continue,
                Err(wrong) => {
                    damage = Some(wrong);
                    break;
                }
            };
            let Some(info) = self.recording.topic(header.channel_id) else {
                continue;
            };
            let recorded = base.node_time(header.log_time);
            let in_time = self.select.from.is_none_or(|from| recorded >= from)
                && self.select.until.is_none_or(|until| recorded < until);
            let wanted = match &info.topic {
                Some(topic) => self.select.topics.as_ref().is_none_or(|wants| wants(topic)),
                None => self.select.foreign,
            };
            if in_time && wanted {
                messages.push(Message {
                    topic: info.topic.clone(),
                    name: info.name.clone(),
                    recorded,
                    at: base.node_time(header.publish_time),
                    bytes: data.into_owned(),
                });
            }
        }
        messages.sort_by_key(|message| message.recorded);
        self.ready = messages.into_iter();
        damage.map_or(Ok(()), Err)
    }
}

impl Iterator for Messages<'_> {
    type Item = Result<Message, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(message) = self.ready.next() {
                return Some(Ok(message));
            }
            let at = self.chunks.next()?;
            if let Err(damage) = self.read(&at) {
                return Some(Err(damage));
            }
        }
    }
}
