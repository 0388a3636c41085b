//! How a recording is opened.
//!
//! Must never do: refuse a file that was cut off; believe a summary that does not fit to the file.

use super::{ChunkAt, Recording, TopicInfo, body_at, each_record};
use crate::chunk::{self, HEAD, Records};
use crate::damage::{Damage, ReadError};
use crate::header::{FORMAT, Header, METADATA};
use crate::topic::Topic;
use mcap::records::{Channel, Record, SchemaHeader, op};
use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::sync::Arc;

/// The last record and the magic after it.
const FOOTER: u64 = HEAD as u64 + 20;
const MAGIC: u64 = mcap::MAGIC.len() as u64;
/// A summary is never larger than this: an hour of a hundred vehicles has three megabytes.
const LARGEST_SUMMARY: u64 = 256 << 20;
/// Enough of a chunk to know its times: two of them, a size, a checksum.
const CHUNK_TIMES: u64 = 16;

/// What was found of a file so far.
#[derive(Default)]
struct Found {
    header: Option<Header>,
    format_seen: Option<u32>,
    library: String,
    schemas: BTreeMap<u16, Arc<str>>,
    topics: BTreeMap<u16, TopicInfo>,
    counts: BTreeMap<u16, u64>,
    chunks: Vec<ChunkAt>,
    damage: Vec<Damage>,
}

pub(super) fn open(path: &Path, progress: &mut dyn FnMut(f64)) -> Result<Recording, ReadError> {
    let failed = |why| ReadError::Io {
        path: path.to_owned(),
        why,
    };
    let file = File::open(path).map_err(failed)?;
    let metadata = file.metadata().map_err(failed)?;
    if metadata.is_dir() {
        return Err(failed(io::ErrorKind::IsADirectory.into()));
    }
    let bytes = metadata.len();
    let mut magic = [0; MAGIC as usize];
    let begins = file.read_exact_at(&mut magic, 0);
    if begins.is_err() || magic != mcap::MAGIC {
        return Err(ReadError::NotMcap { path: path.to_owned() });
    }
    let mut found = Found::default();
    let summarised = found.by_summary(&file, bytes).is_some();
    if !summarised {
        let library = std::mem::take(&mut found.library);
        found = Found {
            library,
            ..Found::default()
        };
        found.by_scan(&file, bytes, progress);
    }
    found.into_recording(path, file, bytes)
}

impl Found {
    fn into_recording(self, path: &Path, file: File, bytes: u64) -> Result<Recording, ReadError> {
        let path = path.to_owned();
        let Some(header) = self.header else {
            return Err(match self.format_seen {
                Some(format) if format > FORMAT => ReadError::Later { path, format },
                _ if self.chunks.is_empty() => ReadError::Empty { path },
                _ => {
                    let library = self.library;
                    ReadError::NotOurs { path, library }
                }
            });
        };
        if self.chunks.is_empty() {
            return Err(ReadError::Empty { path });
        }
        Ok(Recording {
            path,
            file,
            bytes,
            header,
            topics: self.topics,
            counts: self.counts,
            chunks: self.chunks,
            damage: self.damage,
        })
    }

    /// `None` if there is none that fits to the file.
    fn by_summary(&mut self, file: &File, bytes: u64) -> Option<()> {
        let footer_at = bytes.checked_sub(FOOTER + MAGIC)?;
        let end = body_at(file, footer_at, FOOTER + MAGIC).ok()?;
        let (record, magic) = end.split_at_checked(FOOTER as usize)?;
        if magic != mcap::MAGIC {
            return None;
        }
        let Some(Ok(Record::Footer(footer))) = Records::of(record).next() else {
            return None;
        };
        let start = footer.summary_start;
        let length = footer_at.checked_sub(start).filter(|_| start > 0)?;
        if length > LARGEST_SUMMARY {
            return None;
        }
        let summary = body_at(file, start, length).ok()?;
        let mut metadata = Vec::new();
        for record in Records::of(&summary) {
            match record.ok()? {
                Record::Schema { header, .. } => self.schema(&header),
                Record::Channel(channel) => self.channel(channel),
                Record::Statistics(statistics) => self.counts = statistics.channel_message_counts,
                Record::ChunkIndex(index) => {
                    let end = index.chunk_start_offset.checked_add(index.chunk_length)?;
                    if end > start {
                        return None;
                    }
                    self.chunks.push(ChunkAt {
                        offset: index.chunk_start_offset,
                        length: index.chunk_length,
                        first_ns: index.message_start_time,
                        last_ns: index.message_end_time,
                    });
                }
                Record::MetadataIndex(index) => metadata.push((index.offset, index.length)),
                _ => {}
            }
        }
        self.library(file);
        for (offset, length) in metadata {
            let record = body_at(file, offset, length.min(1 << 20)).ok()?;
            if let Some(Ok(Record::Metadata(metadata))) = Records::of(&record).next() {
                self.metadata(&metadata);
            }
        }
        Some(())
    }

    /// Who wrote it.
    fn library(&mut self, file: &File) {
        let head = body_at(file, MAGIC, HEAD as u64).ok();
        let record = head.as_deref().and_then(chunk::head).and_then(|(opcode, length)| {
            let header = opcode == op::HEADER && length < 1 << 16;
            header.then(|| body_at(file, MAGIC, HEAD as u64 + length).ok())?
        });
        if let Some(Some(Ok(Record::Header(header)))) = record.as_deref().map(|bytes| Records::of(bytes).next()) {
            self.library = header.library;
        }
    }

    /// Goes through the file from its beginning to where it ends.
    fn by_scan(&mut self, file: &File, bytes: u64, progress: &mut dyn FnMut(f64)) {
        self.library(file);
        let mut at = MAGIC;
        loop {
            let Ok(head) = body_at(file, at, HEAD as u64) else {
                return self.damage.push(Damage::Cut);
            };
            let Some((opcode, length)) = chunk::head(&head) else {
                return self.damage.push(Damage::Record);
            };
            let Some(next) = at
                .checked_add(HEAD as u64)
                .and_then(|begin| begin.checked_add(length))
                .filter(|next| *next <= bytes)
            else {
                return self.damage.push(Damage::Cut);
            };
            match opcode {
                op::CHUNK => self.scanned_chunk(file, at, length),
                op::DATA_END | op::FOOTER => return self.damage.push(Damage::Cut),
                // What else there may be at the top: schemas, channels, metadata, and indexes of messages, which are passed over.
                op::SCHEMA | op::CHANNEL | op::METADATA if length < 1 << 20 => {
                    let record = body_at(file, at, HEAD as u64 + length).ok();
                    if let Some(Some(Ok(record))) = record.as_deref().map(|bytes| Records::of(bytes).next()) {
                        self.record(record);
                    }
                }
                op::HEADER..=op::DATA_END | 0x80.. => {}
                0 | 0x10..0x80 => return self.damage.push(Damage::Record),
            }
            at = next;
            progress(at as f64 / bytes as f64);
        }
    }

    /// A chunk is looked into: topics are told in it.
    fn scanned_chunk(&mut self, file: &File, at: u64, length: u64) {
        let length = HEAD as u64 + length;
        let Ok(body) = body_at(file, at + HEAD as u64, length - HEAD as u64) else {
            return;
        };
        let mut times = None::<(u64, u64)>;
        let read = each_record(&body, |record| {
            if let Record::Message { header, .. } = &record {
                let (first, last) = times.unwrap_or((u64::MAX, 0));
                times = Some((first.min(header.log_time), last.max(header.log_time)));
                *self.counts.entry(header.channel_id).or_default() += 1;
            }
            self.record(record);
        });
        // A damaged one stays in the list, with the times that its header says: whoever reads there is told.
        if read.is_err() {
            times = times.or_else(|| told_times(&body));
        }
        if let Some((first_ns, last_ns)) = times {
            self.chunks.push(ChunkAt {
                offset: at,
                length,
                first_ns,
                last_ns,
            });
        }
    }

    fn record(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, .. } => self.schema(&header),
            Record::Channel(channel) => self.channel(channel),
            Record::Metadata(metadata) => self.metadata(&metadata),
            _ => {}
        }
    }

    fn schema(&mut self, header: &SchemaHeader) {
        self.schemas.insert(header.id, header.name.as_str().into());
    }

    fn channel(&mut self, channel: Channel) {
        let schema = self.schemas.get(&channel.schema_id).cloned();
        let info = TopicInfo {
            topic: Topic::parse(&channel.topic),
            name: channel.topic.into(),
            schema: schema.unwrap_or_else(|| "".into()),
            encoding: channel.message_encoding.into(),
        };
        self.topics.insert(channel.id, info);
    }

    fn metadata(&mut self, metadata: &mcap::records::Metadata) {
        if metadata.name != METADATA {
            return;
        }
        self.format_seen = metadata.metadata.get("format").and_then(|format| format.parse().ok());
        self.header = Header::from_map(&metadata.metadata).filter(|header| header.format <= FORMAT);
    }
}

fn told_times(body: &[u8]) -> Option<(u64, u64)> {
    let (times, _) = body.split_first_chunk::<{ CHUNK_TIMES as usize }>()?;
    let (first, last) = times.split_first_chunk::<8>()?;
    let last = last.first_chunk::<8>()?;
    Some((u64::from_le_bytes(*first), u64::from_le_bytes(*last)))
}
