//! The files of a bag.
//!
//! Must never do: count a message that is not in the file.

use crate::told::Told;
use crate::{ExportError, Exported, target};
use byteorder::LittleEndian;
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};
use skein_ros2_messages::interfaces::{Definitions, Field, Interface};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

/// What stands before a message in CDR, little end first.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];
/// Sequences and strings are a few hundred bytes at most.
const USUAL_BYTES: usize = 256;

struct Channel {
    id: u16,
    kind: String,
    count: u32,
}

pub(super) struct Bag {
    folder: PathBuf,
    path: PathBuf,
    file: String,
    writer: mcap::Writer<BufWriter<File>>,
    channels: BTreeMap<String, Channel>,
    /// Log times of the first and last message.
    span_ns: Option<(u64, u64)>,
}

impl Bag {
    pub fn create(folder: &Path) -> Result<Self, ExportError> {
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        let file = format!("{name}_0.mcap");
        let path = folder.join(&file);
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("skein ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            .compression_threads(0);
        let writer = options.create(target::file(&path)?);
        Ok(Self {
            folder: folder.to_owned(),
            writer: writer.map_err(|error| ExportError::write(&path, error))?,
            path,
            file,
            channels: BTreeMap::new(),
            span_ns: None,
        })
    }

    pub fn write<M: Interface + Field>(&mut self, topic: &str, told: &Told, message: &M) -> Result<(), ExportError> {
        let failed = |error: &dyn std::fmt::Display| ExportError::write(&self.path, error);
        let mut bytes = Vec::with_capacity(USUAL_BYTES);
        bytes.extend(ENCAPSULATION);
        let encoded = cdr_encoding::to_vec::<M, LittleEndian>(message).map_err(|error| failed(&error))?;
        bytes.extend(encoded);
        if !self.channels.contains_key(topic) {
            let channel = self.channel::<M>(topic)?;
            self.channels.insert(topic.to_owned(), channel);
        }
        let Some(channel) = self.channels.get_mut(topic) else {
            return Ok(());
        };
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.count,
            log_time: told.recorded_ns,
            publish_time: told.at_ns,
        };
        let written = self.writer.write_to_known_channel(&header, &bytes);
        written.map_err(|error| ExportError::write(&self.path, error))?;
        channel.count = channel.count.saturating_add(1);
        let (first, last) = self.span_ns.unwrap_or((u64::MAX, 0));
        self.span_ns = Some((first.min(told.recorded_ns), last.max(told.recorded_ns)));
        Ok(())
    }

    fn channel<M: Interface + Field>(&mut self, topic: &str) -> Result<Channel, ExportError> {
        let failed = |error: mcap::McapError| ExportError::write(&self.path, error);
        let kind = format!("{}/msg/{}", M::PACKAGE, M::NAME);
        let definition = Definitions::of::<M>();
        let schema = self.writer.add_schema(&kind, "ros2msg", definition.as_bytes());
        let metadata = BTreeMap::from([("offered_qos_profiles".to_owned(), String::new())]);
        let id = self
            .writer
            .add_channel(schema.map_err(failed)?, topic, "cdr", &metadata)
            .map_err(failed)?;
        Ok(Channel { id, kind, count: 0 })
    }

    pub fn finish(mut self) -> Result<Exported, ExportError> {
        let ended = self.writer.finish();
        ended.map_err(|error| ExportError::write(&self.path, error))?;
        let text = self.metadata();
        target::finish(&self.path, self.writer.into_inner())?;
        let path = self.folder.join("metadata.yaml");
        let mut file = target::file(&path)?;
        file.write_all(text.as_bytes())
            .map_err(|error| ExportError::write(&path, error))?;
        target::finish(&path, file)?;
        let counts = self.channels.into_iter();
        Ok(Exported {
            files: vec![path, self.path],
            counts: counts.map(|(topic, channel)| (topic, channel.count.into())).collect(),
            ..Exported::default()
        })
    }

    /// What `ros2 bag` reads first. Texts are written as JSON writes them, which is YAML too.
    fn metadata(&self) -> String {
        let (first, last) = self.span_ns.unwrap_or_default();
        let total: u64 = self.channels.values().map(|channel| u64::from(channel.count)).sum();
        let quoted = |text: &str| serde_json::Value::from(text).to_string();
        let topics: String = self
            .channels
            .iter()
            .map(|(topic, Channel { kind, count, .. })| {
                format!(
                    "    - topic_metadata:\n        name: {}\n        type: {kind}\n        serialization_format: cdr\n        \
                     offered_qos_profiles: []\n        type_description_hash: \"\"\n      message_count: {count}\n",
                    quoted(topic)
                )
            })
            .collect();
        let file = quoted(&self.file);
        let length = last.saturating_sub(first);
        format!(
            "rosbag2_bagfile_information:\n  version: 9\n  storage_identifier: mcap\n  duration:\n    nanoseconds: {length}\n  \
             starting_time:\n    nanoseconds_since_epoch: {first}\n  message_count: {total}\n  topics_with_message_count:{}{topics}  \
             compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - {file}\n  files:\n    - path: {file}\n      \
             starting_time:\n        nanoseconds_since_epoch: {first}\n      duration:\n        nanoseconds: {length}\n      \
             message_count: {total}\n  custom_data: ~\n  ros_distro: jazzy\n",
            if topics.is_empty() { " []\n" } else { "\n" }
        )
    }
}
