//! Whether recordings are whole: every chunk can be read, every record of the audit follows on the one before, also from one file of a node to
//! the next, and nothing is missing in between.
//!
//! Must never do: end at the first fault while there is more to look at.

use crate::{Progress, origin};
use skein_domain::NodeTime;
use skein_recording::{AuditChain, AuditRecord, Damage, Message, RecorderState, Recording, Select, Topic};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Nothing recorded for so long while somebody is armed is a gap, in seconds.
const GAP_S: f64 = 1.0;
/// The same on the ground, where there is one picture a second.
const GAP_ON_GROUND_S: f64 = 2.5;
/// Who was armed less long ago than this is.
const STILL_ARMED_S: f64 = 0.5;
/// Of each kind no more findings than this are told one by one.
const TOLD: usize = 20;
/// So many messages lie between two reports of progress.
const REPORT_EVERY: u64 = 2_000;

/// One thing that is wrong with a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The file.
    pub file: PathBuf,
    /// Where, in seconds from its beginning, if at a place.
    pub at_s: Option<f64>,
    /// What.
    pub what: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(at_s) = self.at_s {
            write!(f, " at {at_s:.1} s")?;
        }
        write!(f, ": {}", self.what)
    }
}

/// What was looked at, and what is wrong.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Findings {
    /// Messages that were read.
    pub messages: u64,
    /// Records of the audit that follow on each other.
    pub audited: u64,
    /// What is wrong.
    pub findings: Vec<Finding>,
}

/// Of a vehicle's telemetry what is looked at here.
#[derive(serde::Deserialize)]
struct Armed {
    armed: bool,
}

/// The end of a node's chain in the files that were looked at so far.
struct End {
    file: PathBuf,
    hash: String,
}

/// Looks at all of these files.
#[must_use]
pub fn check(recordings: &[Recording], progress: Progress<'_>) -> Findings {
    let mut all = Findings::default();
    let mut order: Vec<&Recording> = recordings.iter().collect();
    // Of one node the older first, however they were named.
    order.sort_by_key(|recording| recording.header().base.unix_ns(recording.span().0));
    let mut ends: BTreeMap<String, End> = BTreeMap::new();
    let share = 1.0 / order.len().max(1) as f64;
    for (index, recording) in order.into_iter().enumerate() {
        let mut part = |of: f64| progress((index as f64 + of) * share);
        One::of(recording, &mut all).look(&mut ends, &mut part);
    }
    all
}

/// One file under check.
struct One<'a> {
    recording: &'a Recording,
    all: &'a mut Findings,
    begin: NodeTime,
    gaps: usize,
    /// When it was last recorded that somebody is armed.
    armed: Option<NodeTime>,
    /// Records of the audit by topic: where the chain stands, or that it is broken.
    chains: BTreeMap<String, Option<AuditChain>>,
    /// By topic how many messages the recorder had dropped since its node started: at the beginning of the file and last.
    dropped: BTreeMap<String, (u64, u64)>,
    /// By topic how many messages were read.
    read: BTreeMap<Arc<str>, u64>,
}

impl<'a> One<'a> {
    fn of(recording: &'a Recording, all: &'a mut Findings) -> Self {
        Self {
            recording,
            all,
            begin: recording.span().0,
            gaps: 0,
            armed: None,
            chains: BTreeMap::new(),
            dropped: BTreeMap::new(),
            read: BTreeMap::new(),
        }
    }

    fn found(&mut self, at: Option<NodeTime>, what: String) {
        self.all.findings.push(Finding {
            file: self.recording.path().to_owned(),
            at_s: at.map(|at| at.seconds_since(self.begin)),
            what,
        });
    }

    fn look(mut self, ends: &mut BTreeMap<String, End>, progress: Progress<'_>) {
        let recording = self.recording;
        for damage in recording.damage() {
            self.found(None, damage.to_string());
        }
        let (first, last) = recording.span();
        let length_s = last.seconds_since(first).max(1e-6);
        let (mut before, mut count, mut damaged) = (None::<NodeTime>, 0_u64, Vec::new());
        let select = Select {
            foreign: true,
            ..Select::default()
        };
        for message in recording.messages(select) {
            let message = match message {
                Ok(message) => message,
                Err(damage) => {
                    damaged.push((before, damage));
                    continue;
                }
            };
            if count.is_multiple_of(REPORT_EVERY) {
                progress(message.recorded.seconds_since(first) / length_s);
            }
            count += 1;
            self.gap(before, message.recorded);
            before = Some(message.recorded.max(before.unwrap_or_default()));
            *self.read.entry(message.name.clone()).or_default() += 1;
            self.look_at(&message, ends);
        }
        self.all.messages += count;
        // Where a chunk cannot be read, less is read than there is: that is told already.
        if damaged.is_empty() {
            self.compare_counts();
        }
        self.tell_damage(damaged);
        if self.gaps > TOLD {
            self.found(None, format!("{} more gaps", self.gaps - TOLD));
        }
        for (topic, (at_first, at_last)) in std::mem::take(&mut self.dropped) {
            let dropped = at_last.saturating_sub(at_first);
            if dropped > 0 {
                self.found(
                    None,
                    format!("{topic}: {dropped} messages were dropped, because the disk did not take them"),
                );
            }
        }
    }

    /// Whether the file's own counts are those of what is in it: other programs show them, and plan by them.
    fn compare_counts(&mut self) {
        let mut said: BTreeMap<Arc<str>, u64> = BTreeMap::new();
        for (info, count) in self.recording.topics() {
            let of_topic = said.entry(info.name.clone()).or_default();
            *of_topic = of_topic.saturating_add(count);
        }
        // MCAP lets a summary be without counts, and some programs write such.
        if said.values().all(|count| *count == 0) {
            return;
        }
        let read = std::mem::take(&mut self.read);
        let told = |name: &Arc<str>| read.get(name).copied().unwrap_or_default();
        let wrong: Vec<_> = said.iter().filter(|&(name, said)| told(name) != *said).collect();
        for (name, said) in wrong.iter().take(TOLD) {
            let what = format!("{name}: its summary says {said} messages, there are {}", told(name));
            self.found(None, what);
        }
        if wrong.len() > TOLD {
            self.found(None, format!("{} more topics are counted wrong", wrong.len() - TOLD));
        }
    }

    fn tell_damage(&mut self, damaged: Vec<(Option<NodeTime>, Damage)>) {
        let more = damaged.len().saturating_sub(TOLD);
        for (after, damage) in damaged.into_iter().take(TOLD) {
            self.found(Some(after.unwrap_or(self.begin)), damage.to_string());
        }
        if more > 0 {
            self.found(None, format!("{more} more chunks cannot be read"));
        }
    }

    fn gap(&mut self, before: Option<NodeTime>, now: NodeTime) {
        let Some(before) = before else {
            return;
        };
        let gap_s = now.seconds_since(before);
        let armed = self
            .armed
            .is_some_and(|armed| before.seconds_since(armed) < STILL_ARMED_S);
        if gap_s > if armed { GAP_S } else { GAP_ON_GROUND_S } {
            self.gaps += 1;
            if self.gaps <= TOLD {
                self.found(Some(before), format!("nothing was recorded for {gap_s:.1} s"));
            }
        }
    }

    fn look_at(&mut self, message: &Message, ends: &mut BTreeMap<String, End>) {
        match origin::parse(&message.name) {
            Some((node, Topic::Audit)) => {
                let node = node.map(str::to_owned);
                self.audit(message, node.as_deref(), ends);
            }
            Some((_, Topic::Telemetry(_))) if message.json::<Armed>().is_ok_and(|vehicle| vehicle.armed) => {
                self.armed = Some(message.recorded);
            }
            Some((_, Topic::Recorder)) => {
                if let Ok(state) = message.json::<RecorderState>() {
                    let first = (state.dropped, state.dropped);
                    self.dropped.entry(message.name.to_string()).or_insert(first).1 = state.dropped;
                }
            }
            _ => {}
        }
    }

    fn audit(&mut self, message: &Message, node: Option<&str>, ends: &mut BTreeMap<String, End>) {
        let key = node.map_or_else(
            || key(self.recording),
            |node| format!("{} {node}", self.recording.header().swarm),
        );
        let Ok(record) = message.json::<AuditRecord>() else {
            let told = self.chains.insert(message.name.to_string(), None);
            if told != Some(None) {
                self.found(Some(message.at), "a record of the audit cannot be read".to_owned());
            }
            return;
        };
        let chain = match self.chains.get(&*message.name) {
            Some(None) => None,
            Some(Some(chain)) => Some(chain.clone()),
            None => {
                self.follows_file(&record, &key, message.at, ends);
                Some(AuditChain::default())
            }
        };
        if let Some(chain) = chain {
            self.follow(chain, &record, message);
        }
        ends.insert(
            key,
            End {
                file: self.recording.path().to_owned(),
                hash: record.hash,
            },
        );
    }

    fn follow(&mut self, mut chain: AuditChain, record: &AuditRecord, message: &Message) {
        // In a file that was merged of several of one node the next one's begins here.
        if record.number == 0 && record.before == chain.last() {
            chain = AuditChain::after(&record.before);
        }
        let followed = chain.follow(record);
        let chain = match followed {
            Ok(()) => {
                self.all.audited += 1;
                Some(chain)
            }
            Err(broken) => {
                self.found(Some(message.at), broken.to_string());
                None
            }
        };
        self.chains.insert(message.name.to_string(), chain);
    }

    /// The first record of a file names the last one of the node's file before.
    fn follows_file(&mut self, record: &AuditRecord, key: &str, at: NodeTime, ends: &BTreeMap<String, End>) {
        let Some(end) = ends.get(key).filter(|end| end.file != self.recording.path()) else {
            return;
        };
        if end.hash != record.before {
            let what = format!(
                "its audit does not follow on that of {}: a file between them is missing, or the end of that one was cut off",
                name_of(&end.file)
            );
            self.found(Some(at), what);
        }
    }
}

fn name_of(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

/// Which node a recording is of.
fn key(recording: &Recording) -> String {
    let header = recording.header();
    match header.node {
        Some(node) => format!("{} {node}", header.swarm),
        None => format!("{} named {}", header.swarm, header.name),
    }
}
