//! Recordings of several nodes as one, on the clock of the first.
//!
//! Topics of the first node keep their names; those of others stand below `/nodes/<node>`. A vehicle is one vehicle whoever tells of it:
//! `/vehicles/<id>` is told by the node that flies it, what others saw of it stands below their own names.
//!
//! Must never do: put two nodes' messages on one topic where they would contradict each other.

mod fliers;

use crate::rewrite::Rewriter;
use crate::{ExportError, Progress, Rewritten, origin};
use fliers::Fliers;
use skein_domain::VehicleId;
use skein_recording::{Merged, Message, Recording, Select, Topic};
use std::collections::BTreeMap;
use std::path::Path;

/// So many messages lie between two reports of progress.
const REPORT_EVERY: u64 = 2_000;

/// What came of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MergeReport {
    /// What was written.
    pub written: Rewritten,
    /// How each node is called in it, the first one's name first.
    pub nodes: Vec<String>,
    /// Nodes whose clock was only known by the time of day.
    pub unmeasured: Vec<String>,
}

/// Which node each recording is of.
struct Nodes {
    /// By recording.
    of: Vec<usize>,
    names: Vec<String>,
}

impl Nodes {
    fn of(recordings: &[Recording]) -> Self {
        let mut nodes = Self {
            of: Vec::new(),
            names: Vec::new(),
        };
        let mut known: BTreeMap<(String, Option<u64>, String), usize> = BTreeMap::new();
        for recording in recordings {
            let header = recording.header();
            let number = header.node.map(|node| node.0);
            // A node with a number may be renamed; one without has nothing but its name.
            let called = if number.is_some() {
                String::new()
            } else {
                header.name.clone()
            };
            let key = (header.swarm.clone(), number, called);
            let index = *known.entry(key).or_insert_with(|| {
                let wanted = number.map_or_else(|| in_topic(&header.name), |number| number.to_string());
                let name = free(&wanted, &nodes.names);
                nodes.names.push(name);
                nodes.names.len() - 1
            });
            nodes.of.push(index);
        }
        nodes
    }

    fn index(&self, recording: usize) -> usize {
        self.of.get(recording).copied().unwrap_or_default()
    }

    /// The name of a topic of one of them, as it stands in the file.
    fn topic(&self, node: usize, topic: &Topic) -> String {
        match self.names.get(node) {
            Some(name) if node > 0 => origin::of_node(name, topic),
            _ => topic.to_string(),
        }
    }
}

/// A name as one part of a topic's.
fn in_topic(name: &str) -> String {
    let part = |c: char| {
        if c.is_ascii_alphanumeric() || c == '-' || c == '_' {
            c
        } else {
            '-'
        }
    };
    let told: String = name.chars().map(part).take(40).collect();
    if told.is_empty() { "node".to_owned() } else { told }
}

/// Two nodes of different swarms may have one number.
fn free(wanted: &str, taken: &[String]) -> String {
    let mut name = wanted.to_owned();
    let mut number = 2;
    while taken.contains(&name) {
        name = format!("{wanted}-{number}");
        number += 1;
    }
    name
}

/// Writes these recordings as one, by measured offsets of their clocks where they were measured.
///
/// # Errors
/// When there is none, one was merged before, or the file cannot be made.
pub fn merge(recordings: &[Recording], out: &Path, progress: Progress<'_>) -> Result<MergeReport, ExportError> {
    let first = recordings.first().ok_or(ExportError::NoFile)?;
    if let Some(merged) = recordings.iter().find(|recording| origin::is_merged(recording)) {
        let path = merged.path().to_owned();
        return Err(ExportError::Merged { path });
    }
    let nodes = Nodes::of(recordings);
    let how = [
        ("nodes", nodes.names.join(" ")),
        ("files", recordings.len().to_string()),
    ];
    let mut writer = Rewriter::create(out, first.header(), "skein.merged", how)?;
    let mut fliers = Fliers::new(recordings, &nodes.of);
    // What a broken file says of itself may be any number.
    let counts = recordings.iter().flat_map(Recording::topics);
    let total = counts.fold(0_u64, |total, (_, count)| total.saturating_add(count));
    let (messages, mut unmeasured) = Merged::of(recordings, &Select::default());
    let mut damage = Vec::new();
    for (count, message) in (0_u64..).zip(messages) {
        if count.is_multiple_of(REPORT_EVERY) {
            progress(count as f64 / total.max(1) as f64);
        }
        match message {
            Ok((recording, message)) => {
                let node = nodes.index(recording);
                if let Some(name) = name(&message, node, &nodes, &mut fliers) {
                    writer.write(&name, message.recorded, message.at, &message.bytes)?;
                }
            }
            Err(damaged) => damage.push(damaged),
        }
    }
    unmeasured.sort();
    unmeasured.dedup();
    let messages = writer.finish()?;
    progress(1.0);
    Ok(MergeReport {
        written: Rewritten { messages, damage },
        nodes: nodes.names,
        unmeasured,
    })
}

/// Under which name a message goes into the file.
fn name(message: &Message, node: usize, nodes: &Nodes, fliers: &mut Fliers) -> Option<String> {
    let topic = message.topic.as_ref()?;
    if *topic == Topic::Fleet {
        fliers.see(node, message);
    }
    Some(match vehicle(topic) {
        Some(vehicle) if fliers.tells_of(node, vehicle) => topic.to_string(),
        // Of what others saw of a vehicle the first node's is no exception.
        Some(_) => origin::of_node(nodes.names.get(node)?, topic),
        None => nodes.topic(node, topic),
    })
}

fn vehicle(topic: &Topic) -> Option<VehicleId> {
    match topic {
        Topic::Telemetry(vehicle) | Topic::Setpoint(vehicle) | Topic::Location(vehicle) | Topic::Video(vehicle, _) => {
            Some(*vehicle)
        }
        _ => None,
    }
}
