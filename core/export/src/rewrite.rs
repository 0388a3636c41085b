//! A recording that is made of messages of others: parts, and several as one.
//!
//! Must never do: change what a message says. Only its topic's name and the times of the record around it may be others.

use crate::{ExportError, origin, target};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions};
use skein_domain::NodeTime;
use skein_recording::{Damage, Header, METADATA, Topic};
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// What was written.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rewritten {
    /// Messages.
    pub messages: u64,
    /// What of the originals could not be read.
    pub damage: Vec<Damage>,
}

pub(crate) struct Rewriter {
    path: PathBuf,
    writer: mcap::Writer<BufWriter<File>>,
    header: Header,
    channels: HashMap<String, (u16, u32)>,
    newest_ns: u64,
    messages: u64,
}

/// The metadata by which a reader knows the file as one of ours.
fn metadata(header: &Header) -> Metadata {
    Metadata {
        name: METADATA.to_owned(),
        metadata: header.to_map(),
    }
}

fn of_pairs<const N: usize>(name: &str, pairs: [(&str, String); N]) -> Metadata {
    Metadata {
        name: name.to_owned(),
        metadata: pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect(),
    }
}

impl Rewriter {
    /// Begins a file that says of itself what this header says, and how it came about.
    pub fn create<const N: usize>(
        path: &Path,
        header: &Header,
        made: &str,
        how: [(&str, String); N],
    ) -> Result<Self, ExportError> {
        let options = WriteOptions::new()
            .profile("skein")
            .library(concat!("skein ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            .compression_threads(0);
        let failed = |error: mcap::McapError| ExportError::write(path, error);
        let mut writer = options.create(target::file(path)?).map_err(failed)?;
        writer.write_metadata(&metadata(header)).map_err(failed)?;
        writer.write_metadata(&of_pairs(made, how)).map_err(failed)?;
        Ok(Self {
            path: path.to_owned(),
            writer,
            header: header.clone(),
            channels: HashMap::new(),
            newest_ns: 0,
            messages: 0,
        })
    }

    /// Adds a message under a name that begins as those of a node or not.
    pub fn write(&mut self, name: &str, recorded: NodeTime, at: NodeTime, bytes: &[u8]) -> Result<(), ExportError> {
        let (id, written) = match self.channels.get(name) {
            Some(channel) => *channel,
            None => (self.channel(name)?, 0),
        };
        let base = self.header.base;
        self.newest_ns = self.newest_ns.max(base.unix_ns(recorded));
        let header = MessageHeader {
            channel_id: id,
            sequence: written,
            log_time: self.newest_ns,
            publish_time: base.unix_ns(at),
        };
        let written_now = self.writer.write_to_known_channel(&header, bytes);
        written_now.map_err(|error| ExportError::write(&self.path, error))?;
        self.channels.insert(name.to_owned(), (id, written.wrapping_add(1)));
        self.messages += 1;
        Ok(())
    }

    fn channel(&mut self, name: &str) -> Result<u16, ExportError> {
        let topic: Option<Topic> = origin::parse(name).map(|(_, topic)| topic);
        let failed = |error: mcap::McapError| ExportError::write(&self.path, error);
        let (schema, encoding) = match topic.map(|topic| topic.schema()) {
            Some(schema) => {
                let id = self.writer.add_schema(&schema.name, &schema.encoding, &schema.data);
                (id.map_err(failed)?, schema.message_encoding)
            }
            None => (0, "json".into()),
        };
        self.writer
            .add_channel(schema, name, &encoding, &BTreeMap::new())
            .map_err(failed)
    }

    /// Ends the file.
    pub fn finish(mut self) -> Result<u64, ExportError> {
        let ended = self.writer.finish();
        ended.map_err(|error| ExportError::write(&self.path, error))?;
        target::finish(&self.path, self.writer.into_inner())?;
        Ok(self.messages)
    }
}
