//! State: the newest value of each key replaces the one before, at its sender and at every receiver.
//!
//! Must never do: queue values; hand out a value that is older than one handed out before.
//!
//! What did not change is told again, soon at first and then now and then, so that a loss is made good and a node that joins comes to know it. A link too slow for all
//! carries each less often: the key that has waited longest goes first.

use crate::seal::Boot;
use minicbor::{Decode, Encode};
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;
use thiserror::Error;

/// Names one value of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Encode, Decode)]
#[cbor(transparent)]
pub struct Key(#[n(0)] pub u32);

/// One value on its way.
#[derive(Debug, Clone, PartialEq, Eq, Encode, Decode)]
pub struct Entry {
    /// Which.
    #[n(0)]
    pub key: Key,
    /// Counts from 1 per run of the sender, over all keys: one that is told again after it was given up is newer than before.
    #[n(1)]
    pub version: u64,
    /// The value.
    #[cbor(n(2), with = "minicbor::bytes")]
    pub value: Vec<u8>,
}

/// How often state is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StateSettings {
    /// Two tellings of one value are at least so far apart, in seconds.
    pub no_sooner_than_s: f64,
    /// A value that has changed is told again after so long, in seconds, for it may have been lost; then after twice as long, and so on.
    pub again_soon_s: f64,
    /// In the end a value that does not change is told again after so long, in seconds: who joins waits no longer for it.
    pub again_after_s: f64,
}

impl Default for StateSettings {
    fn default() -> Self {
        Self {
            no_sooner_than_s: 0.02,
            again_soon_s: 0.15,
            again_after_s: 1.0,
        }
    }
}

/// A value that can't be told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum StateError {
    /// It does not fit into one datagram.
    #[error("{bytes} bytes are more than the {most} of one value")]
    TooLarge {
        /// Its size.
        bytes: usize,
        /// The largest.
        most: usize,
    },
    /// The node tells too many already.
    #[error("a node tells no more than {MOST_KEYS} values")]
    TooMany,
}

/// How many values one node may tell; more of one sender are not taken in.
pub const MOST_KEYS: usize = 256;
/// What one entry costs beside its value at most: key, version, lengths.
pub const ENTRY_BYTES: usize = 20;

#[derive(Debug)]
struct Told {
    version: u64,
    value: Vec<u8>,
    /// When it was last told; none if never.
    last: Option<NodeTime>,
    due: NodeTime,
    /// How long after that it is told again.
    pause_s: f64,
}

/// What this node tells.
#[derive(Debug)]
pub struct Telling {
    settings: StateSettings,
    last: u64,
    values: BTreeMap<Key, Told>,
}

impl Telling {
    /// Nothing yet.
    #[must_use]
    pub fn new(settings: StateSettings) -> Self {
        Self {
            settings,
            last: 0,
            values: BTreeMap::new(),
        }
    }

    /// Sets a value. Setting it to what it is counts as a change: its receivers may judge its age.
    ///
    /// # Errors
    ///
    /// There are too many.
    pub fn set(&mut self, now: NodeTime, key: Key, value: Vec<u8>) -> Result<(), StateError> {
        if self.values.len() >= MOST_KEYS && !self.values.contains_key(&key) {
            return Err(StateError::TooMany);
        }
        let told = self.values.entry(key).or_insert(Told {
            version: 0,
            value: Vec::new(),
            last: None,
            due: now,
            pause_s: 0.0,
        });
        self.last += 1;
        told.version = self.last;
        told.value = value;
        told.pause_s = self.settings.again_soon_s;
        let soonest = told
            .last
            .map_or(now, |last| last.plus_seconds(self.settings.no_sooner_than_s));
        told.due = told.due.min(soonest.max(now));
        Ok(())
    }

    /// Tells a value no more.
    pub fn forget(&mut self, key: Key) {
        self.values.remove(&key);
    }

    /// When something is due next.
    #[must_use]
    pub fn wakes_at(&self) -> Option<NodeTime> {
        self.values.values().map(|told| told.due).min()
    }

    /// What is due, as much as fits into so many bytes, the longest due first. At least one if any is due.
    pub fn next(&mut self, now: NodeTime, room_bytes: usize) -> Vec<Entry> {
        let mut due: Vec<(NodeTime, Key)> = self
            .values
            .iter()
            .filter(|(_, told)| told.due <= now)
            .map(|(key, told)| (told.due, *key))
            .collect();
        due.sort_unstable();
        let mut entries = Vec::new();
        let mut bytes = 0;
        for (_, key) in due {
            let Some(told) = self.values.get_mut(&key) else {
                continue;
            };
            bytes += told.value.len() + ENTRY_BYTES;
            if bytes > room_bytes && !entries.is_empty() {
                break;
            }
            told.last = Some(now);
            told.due = now.plus_seconds(told.pause_s);
            told.pause_s = (told.pause_s * 2.0).min(self.settings.again_after_s);
            entries.push(Entry {
                key,
                version: told.version,
                value: told.value.clone(),
            });
        }
        entries
    }
}

/// What this node has been told.
#[derive(Debug, Default)]
pub struct Heard {
    of: BTreeMap<NodeId, (Boot, BTreeMap<Key, u64>)>,
}

impl Heard {
    /// Whether this is newer than what was handed out before. A value told again unchanged is not.
    pub fn is_new(&mut self, from: NodeId, boot: Boot, entry: &Entry) -> bool {
        let (known, versions) = self.of.entry(from).or_insert_with(|| (boot, BTreeMap::new()));
        if *known != boot {
            (*known, *versions) = (boot, BTreeMap::new());
        }
        if versions.len() >= MOST_KEYS && !versions.contains_key(&entry.key) {
            return false;
        }
        let version = versions.entry(entry.key).or_insert(0);
        let newer = entry.version > *version;
        *version = entry.version.max(*version);
        newer
    }
}

#[cfg(test)]
mod tests;
