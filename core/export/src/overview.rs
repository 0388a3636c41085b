//! What is in a recording, and which recordings are in a folder.
//!
//! Must never do: hold back a file because something is wrong with it.

use crate::told::{Kind, each};
use crate::{ExportError, origin};
use serde::Serialize;
use skein_domain::exchange::Severity;
use skein_recording::{ReadError, Recording, Topic};
use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;
use std::fs;
use std::path::{Path, PathBuf};

/// Folders below the folder that is looked into are looked into so far.
const DEPTH: u32 = 3;

/// What is in a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Overview {
    /// The file.
    pub file: PathBuf,
    /// In bytes.
    pub size_bytes: u64,
    /// Version of the format.
    pub format: u32,
    /// Version of the program that wrote it.
    pub version: String,
    /// The node's number, if it is in a swarm.
    pub node: Option<u64>,
    /// The node's name.
    pub name: String,
    /// The swarm's id; empty without a swarm.
    pub swarm: String,
    /// When it begins, in nanoseconds since 1970.
    pub begin_unix_ns: u64,
    /// The same (UTC), as text.
    pub begin: String,
    /// How long it is, in seconds.
    pub length_s: f64,
    /// Vehicles of which there is telemetry.
    pub vehicles: Vec<u16>,
    /// Topics by name.
    pub topics: Vec<TopicCount>,
    /// It ends with its summary.
    pub finished: bool,
    /// What was seen to be wrong with it.
    pub damage: Vec<String>,
    /// Events by severity; empty as long as they were not counted.
    pub events: BTreeMap<String, u64>,
}

/// A topic of a recording.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct TopicCount {
    /// Its name.
    pub topic: String,
    /// Its schema.
    pub schema: String,
    /// How messages are encoded.
    pub encoding: String,
    /// How many messages it has.
    pub messages: u64,
}

impl TopicCount {
    /// Messages a second, of a recording of this length.
    #[must_use]
    pub fn rate_hz(&self, length_s: f64) -> f64 {
        if length_s > 0.0 {
            self.messages as f64 / length_s
        } else {
            0.0
        }
    }
}

impl Overview {
    /// Of an open recording, without looking into it.
    #[must_use]
    pub fn of(recording: &Recording) -> Self {
        let header = recording.header();
        let (first, last) = recording.span();
        let mut topics: Vec<TopicCount> = recording
            .topics()
            .map(|(info, messages)| TopicCount {
                topic: info.name.to_string(),
                schema: info.schema.to_string(),
                encoding: info.encoding.to_string(),
                messages,
            })
            .collect();
        topics.sort();
        let vehicles: BTreeSet<u16> = recording
            .topics()
            .filter_map(|(info, _)| match origin::parse(&info.name)?.1 {
                Topic::Telemetry(vehicle) => Some(vehicle.0),
                _ => None,
            })
            .collect();
        let begin_unix_ns = header.base.unix_ns(first);
        Self {
            file: recording.path().to_owned(),
            size_bytes: recording.bytes(),
            format: header.format,
            version: header.version.clone(),
            node: header.node.map(|node| node.0),
            name: header.name.clone(),
            swarm: header.swarm.clone(),
            begin_unix_ns,
            begin: crate::utc::precise(begin_unix_ns),
            // A damaged file may end before it begins.
            length_s: last.seconds_since(first).max(0.0),
            vehicles: vehicles.into_iter().collect(),
            topics,
            finished: recording.is_finished(),
            damage: recording.damage().iter().map(ToString::to_string).collect(),
            events: BTreeMap::new(),
        }
    }

    /// The same with its events counted and its chunks that cannot be read.
    #[must_use]
    pub fn with_events(recording: &Recording) -> Self {
        let mut overview = Self::of(recording);
        for severity in [
            Severity::Info,
            Severity::Advisory,
            Severity::Warning,
            Severity::Critical,
        ] {
            overview.events.insert(word(severity), 0);
        }
        let counted = each(
            recording,
            |topic| *topic == Topic::Events,
            &mut |_| {},
            |told| {
                if let Kind::Event(event) = &told.kind {
                    *overview.events.entry(word(event.severity)).or_default() += 1;
                }
                Ok::<_, Infallible>(())
            },
        );
        let Ok(unread) = counted;
        if unread.messages > 0 {
            overview.events.insert("unreadable".into(), unread.messages);
        }
        overview.damage.extend(unread.damage.iter().map(ToString::to_string));
        overview
    }
}

/// The word for a severity, as JSON has it.
pub(crate) fn word(severity: Severity) -> String {
    format!("{severity:?}").to_lowercase()
}

/// The recordings of a folder and its folders, the oldest first, and the MCAP files that are none, with why.
///
/// # Errors
/// When the folder cannot be read.
pub fn list(folder: &Path) -> Result<(Vec<Overview>, Vec<ReadError>), ExportError> {
    let mut files = Vec::new();
    let failed = |error: std::io::Error| ExportError::Folder {
        path: folder.to_owned(),
        reason: error.to_string(),
    };
    for entry in fs::read_dir(folder).map_err(failed)? {
        find(&entry.map_err(failed)?.path(), DEPTH, &mut files);
    }
    files.sort();
    let (mut found, mut others) = (Vec::new(), Vec::new());
    for file in files {
        match Recording::open(&file) {
            Ok(recording) => found.push(Overview::of(&recording)),
            Err(error) => others.push(error),
        }
    }
    found.sort_by_key(|overview| overview.begin_unix_ns);
    Ok((found, others))
}

/// A folder that cannot be read is passed over: it was not asked for.
fn find(path: &Path, depth: u32, files: &mut Vec<PathBuf>) {
    // Links are not followed: they may lead in a circle.
    let Ok(kind) = fs::symlink_metadata(path).map(|metadata| metadata.file_type()) else {
        return;
    };
    if kind.is_dir() && depth > 0 {
        for entry in fs::read_dir(path).into_iter().flatten().flatten() {
            find(&entry.path(), depth - 1, files);
        }
    } else if kind.is_file() && path.extension().is_some_and(|ending| ending == "mcap") {
        files.push(path.to_owned());
    }
}
