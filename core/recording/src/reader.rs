//! Opens a recording: by its summary where it has one, else by going through it, as is needed where the program ended while it was written.
//!
//! Must never do: hold the whole file, or take a file of something else for an empty recording.

mod opening;

use crate::chunk::{self, Records};
use crate::damage::{Damage, ReadError};
use crate::header::Header;
use crate::topic::Topic;
use mcap::records::{ChunkHeader, Record};
use skein_domain::NodeTime;
use std::collections::BTreeMap;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A record of the file is read into memory up to this length, in bytes: chunks of other programs are a few megabytes.
const LARGEST_RECORD: u64 = 256 << 20;

/// A topic of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TopicInfo {
    /// Its name.
    pub name: Arc<str>,
    /// Which one it is; `None` for one of another program.
    pub topic: Option<Topic>,
    /// Name of its schema.
    pub schema: Arc<str>,
    /// How messages are encoded: `json` or `protobuf`.
    pub encoding: Arc<str>,
}

/// A chunk of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ChunkAt {
    /// Where its record begins.
    pub offset: u64,
    /// How long the record is, with its head.
    pub length: u64,
    /// Log time of its first message.
    pub first_ns: u64,
    /// Of its last one.
    pub last_ns: u64,
}

/// An open recording.
#[derive(Debug)]
pub struct Recording {
    path: PathBuf,
    file: File,
    bytes: u64,
    header: Header,
    topics: BTreeMap<u16, TopicInfo>,
    counts: BTreeMap<u16, u64>,
    chunks: Vec<ChunkAt>,
    damage: Vec<Damage>,
}

impl Recording {
    /// Opens one of ours, finished or not.
    ///
    /// # Errors
    /// When it is none, or nothing of it can be read. Damage inside of it is no error: see [`Self::damage`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        opening::open(path, &mut |_| {})
    }

    /// The same, telling the share of the file that was gone through, 0 to 1. One that was finished is not gone through.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_telling(path: &Path, progress: &mut dyn FnMut(f64)) -> Result<Self, ReadError> {
        opening::open(path, progress)
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// How large it is, in bytes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// What it says of itself.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Its topics, with the number of messages on each.
    pub fn topics(&self) -> impl Iterator<Item = (&TopicInfo, u64)> {
        let count = |id| self.counts.get(id).copied().unwrap_or_default();
        self.topics.iter().map(move |(id, info)| (info, count(id)))
    }

    /// When it begins and ends, on the node's clock.
    #[must_use]
    pub fn span(&self) -> (NodeTime, NodeTime) {
        let first = self.chunks.iter().map(|chunk| chunk.first_ns).min();
        let last = self.chunks.iter().map(|chunk| chunk.last_ns).max();
        let base = &self.header.base;
        let at = |ns: Option<u64>| ns.map_or(base.node, |ns| base.node_time(ns));
        (at(first), at(last))
    }

    /// What was found to be wrong when it was opened: that it was not finished, most of all. Chunks are looked into when they are read.
    #[must_use]
    pub fn damage(&self) -> &[Damage] {
        &self.damage
    }

    /// Whether it was finished: it ends with its summary.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.damage.is_empty()
    }

    pub(crate) fn chunks(&self) -> &[ChunkAt] {
        &self.chunks
    }

    pub(crate) fn topic(&self, channel: u16) -> Option<&TopicInfo> {
        self.topics.get(&channel)
    }

    /// A chunk as it lies in the file, without the head of its record.
    pub(crate) fn chunk(&self, at: &ChunkAt) -> Result<Vec<u8>, Damage> {
        let body = at.length.saturating_sub(chunk::HEAD as u64);
        body_at(&self.file, at.offset + chunk::HEAD as u64, body)
    }
}

/// Bytes of a file.
fn body_at(file: &File, offset: u64, length: u64) -> Result<Vec<u8>, Damage> {
    if length > LARGEST_RECORD {
        return Err(Damage::TooLarge { bytes: length });
    }
    let mut bytes = vec![0; usize::try_from(length).unwrap_or_default()];
    file.read_exact_at(&mut bytes, offset)
        .map_err(|error| match error.kind() {
            std::io::ErrorKind::UnexpectedEof => Damage::Cut,
            _ => Damage::Io(error.to_string()),
        })?;
    Ok(bytes)
}

/// What a chunk holds, unpacked.
pub(crate) fn contents(body: &[u8]) -> Result<(ChunkHeader, std::borrow::Cow<'_, [u8]>), Damage> {
    if !crate::lengths::fit(mcap::records::op::CHUNK, body) {
        return Err(Damage::Record);
    }
    let record = mcap::parse_record(mcap::records::op::CHUNK, body).map_err(|_| Damage::Record)?;
    let Record::Chunk { header, data } = record else {
        return Err(Damage::Record);
    };
    let packed: &[u8] = match data {
        std::borrow::Cow::Borrowed(packed) => packed,
        std::borrow::Cow::Owned(_) => return Err(Damage::Record),
    };
    let unpacked = chunk::unpacked(&header, packed)?;
    Ok((header, unpacked))
}

/// All records of a chunk that can be read; what is wrong with the rest.
pub(crate) fn each_record(body: &[u8], mut take: impl FnMut(Record<'_>)) -> Result<(), Damage> {
    let (_, unpacked) = contents(body)?;
    for record in Records::of(&unpacked) {
        take(record?);
    }
    Ok(())
}
