//! Writes a recording. What was flushed can be read whatever happens afterwards: chunks go to the file whole, and a reader needs nothing that
//! comes after them.
//!
//! Must never do: go on with a file after a write to it failed; a new one is begun then.

use crate::encoded::Encoded;
use crate::header::{Header, METADATA};
use crate::topic::Topic;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, McapError, WriteOptions};
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;
use thiserror::Error;

/// Why a recording could not be written.
#[derive(Debug, Error)]
pub enum WriteError {
    /// The disk does not take it.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The library's own reason.
    #[error("{0}")]
    Format(McapError),
}

impl From<McapError> for WriteError {
    fn from(error: McapError) -> Self {
        match error {
            McapError::Io(source) => Self::Io(source),
            other => Self::Format(other),
        }
    }
}

impl WriteError {
    /// Whether the disk is full.
    #[must_use]
    pub fn is_full(&self) -> bool {
        let full = [io::ErrorKind::StorageFull, io::ErrorKind::QuotaExceeded];
        matches!(self, Self::Io(error) if full.contains(&error.kind()))
    }
}

#[derive(Debug, Clone, Copy)]
struct Channel {
    id: u16,
    written: u32,
}

/// A recording being written.
pub struct Writer {
    writer: mcap::Writer<BufWriter<File>>,
    file: File,
    header: Header,
    channels: HashMap<Topic, Channel>,
    newest_ns: u64,
}

impl Writer {
    /// Begins a file. It must not be there yet.
    ///
    /// # Errors
    /// When it is there, or the disk does not take it.
    pub fn create(path: &Path, header: Header) -> Result<Self, WriteError> {
        let file = File::options().write(true).create_new(true).open(path)?;
        // Whoever finishes or deletes recordings sees by this that it is being written.
        file.try_lock().map_err(io::Error::from)?;
        let options = WriteOptions::new()
            .profile("skein")
            .library(format!("skein {}", header.version))
            .compression(Some(Compression::Zstd))
            // A thread of its own is enough: the recorder's.
            .compression_threads(0)
            // Whoever flushes says where a chunk ends.
            .chunk_size(None)
            // A chunk is put together in memory and goes to the file at once, so that none is there by half.
            .disable_seeking(true);
        let mut writer = options.create(BufWriter::new(file.try_clone()?))?;
        writer.write_metadata(&Metadata {
            name: METADATA.to_owned(),
            metadata: header.to_map(),
        })?;
        writer.flush()?;
        Ok(Self {
            writer,
            file,
            header,
            channels: HashMap::new(),
            newest_ns: 0,
        })
    }

    /// What it says of itself.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Adds a message, recorded now.
    ///
    /// # Errors
    /// When the library does not take it.
    pub fn write(&mut self, message: &Encoded, recorded: skein_domain::NodeTime) -> Result<(), WriteError> {
        let base = self.header.base;
        // Readers go by this time: it never goes back within a file.
        self.newest_ns = self.newest_ns.max(base.unix_ns(recorded));
        let channel = match self.channels.get_mut(&message.topic) {
            Some(channel) => channel,
            None => {
                let id = self.channel(&message.topic)?;
                self.channels
                    .entry(message.topic.clone())
                    .or_insert(Channel { id, written: 0 })
            }
        };
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.written,
            log_time: self.newest_ns,
            publish_time: base.unix_ns(message.at),
        };
        channel.written = channel.written.wrapping_add(1);
        self.writer.write_to_known_channel(&header, &message.bytes)?;
        Ok(())
    }

    fn channel(&mut self, topic: &Topic) -> Result<u16, WriteError> {
        let schema = topic.schema();
        let id = self.writer.add_schema(&schema.name, &schema.encoding, &schema.data)?;
        let channel = self
            .writer
            .add_channel(id, &topic.to_string(), &schema.message_encoding, &BTreeMap::new())?;
        Ok(channel)
    }

    /// Ends the chunk: what was written until now is in the file.
    ///
    /// # Errors
    /// When the disk does not take it. Then the file is given up.
    pub fn flush(&mut self) -> Result<(), WriteError> {
        Ok(self.writer.flush()?)
    }

    /// Waits until the disk has it, so that it outlives a loss of power.
    ///
    /// # Errors
    /// When the disk does not take it.
    pub fn sync(&self) -> Result<(), WriteError> {
        Ok(self.file.sync_data()?)
    }

    /// How large the file is, in bytes.
    ///
    /// # Errors
    /// When the file cannot be asked.
    pub fn bytes(&self) -> Result<u64, WriteError> {
        Ok(self.file.metadata()?.len())
    }

    /// Ends the file with its summary, by which readers find their way at once.
    ///
    /// # Errors
    /// When the disk does not take it.
    pub fn finish(mut self) -> Result<(), WriteError> {
        self.writer.finish()?;
        self.file.sync_data()?;
        Ok(())
    }
}
