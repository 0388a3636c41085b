//! State: the newest value of each key replaces the one before, at its sender and at every receiver.
//!
//! Must never do: queue values; hand out a value that is older than one handed out before.
//!
//! What did not change is told again, soon at first and then now and then, so that a loss is made good and a node that joins comes to know it. A link too slow for all
//! carries each less often: small values go first, then the key that has waited longest.

use crate::delta::{self, Bases, Basing, Change};
pub use crate::entry::{Entry, Key};
use crate::envelope::Boot;
use minicbor::{Decode, Encode};
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;
use thiserror::Error;

/// What is told in one datagram.
#[derive(Debug, Clone, PartialEq, Eq, Default, Encode, Decode)]
pub struct News {
    /// Whole values.
    #[n(0)]
    pub wholes: Vec<Entry>,
    /// Whole values that are to be kept as bases.
    #[n(1)]
    pub bases: Vec<Entry>,
    /// Values as differences to bases, maybe to those in this datagram.
    #[n(2)]
    pub changes: Vec<Change>,
    /// How much of it has not changed of late: for its sender.
    #[cbor(skip)]
    pub resting_bytes: usize,
}

impl News {
    /// Whether there is nothing in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.wholes.is_empty() && self.bases.is_empty() && self.changes.is_empty()
    }
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
    /// Whether values that change often are told as differences.
    pub differences: bool,
}

impl Default for StateSettings {
    fn default() -> Self {
        Self {
            no_sooner_than_s: 0.02,
            again_soon_s: 0.15,
            again_after_s: 1.0,
            differences: true,
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
/// Values of so many bytes at most go before others: they cost little, and on a slow link a sign of life must not wait for what is large.
const SMALL_BYTES: usize = 40;
/// What one entry costs beside its value at most: key, version, lengths.
pub const ENTRY_BYTES: usize = 20;

#[derive(Debug)]
struct ToldEntry {
    version: u64,
    value: Vec<u8>,
    /// When it was last told; none if never.
    last: Option<NodeTime>,
    due: NodeTime,
    /// How long after that it is told again.
    pause_s: f64,
    basing: Basing,
}

/// What this node tells.
#[derive(Debug)]
pub struct Telling {
    settings: StateSettings,
    last: u64,
    values: BTreeMap<Key, ToldEntry>,
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
        let told = self.values.entry(key).or_insert(ToldEntry {
            version: 0,
            value: Vec::new(),
            last: None,
            due: now,
            pause_s: 0.0,
            basing: Basing::default(),
        });
        told.basing.changed(told.last.map(|last| now.seconds_since(last)));
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

    /// Somebody lacks the base of a value.
    pub fn owe(&mut self, key: Key) {
        if let Some(told) = self.values.get_mut(&key) {
            told.basing.owe();
        }
    }

    /// Somebody has joined, who lacks all bases. Nothing becomes due by that: each is told with its value, when that is.
    pub fn owe_all(&mut self) {
        for told in self.values.values_mut() {
            told.basing.owe();
        }
    }

    /// What is due of what is small and has changed of late, as much as fits into so many bytes.
    pub fn next_small(&mut self, now: NodeTime, room_bytes: usize) -> News {
        let mut news = News::default();
        let mut bytes = 0;
        for (key, told) in &mut self.values {
            if told.due > now || !told.is_small() || told.rests(&self.settings) {
                continue;
            }
            if bytes + told.value.len() + ENTRY_BYTES > room_bytes {
                break;
            }
            bytes += told.tell(now, *key, false, &mut news);
            told.told(now, &self.settings);
        }
        news
    }

    /// What is due, as much as fits into so many bytes: what is small first, then the longest due. At least one if any is due, but what has not changed of late only if
    /// `resting` may be told.
    pub fn next(&mut self, now: NodeTime, room_bytes: usize, resting: bool) -> News {
        let mut due: Vec<(bool, NodeTime, Key)> = self
            .values
            .iter()
            .filter(|(_, told)| told.due <= now && (resting || !told.rests(&self.settings)))
            .map(|(key, told)| (!told.is_small(), told.due, *key))
            .collect();
        due.sort_unstable();
        let based = self.values.iter().filter(|(_, told)| told.basing.is_used());
        let based: Vec<Key> = based.map(|(key, _)| *key).take(delta::MOST_KEYS).collect();
        let mut news = News::default();
        let mut bytes = 0;
        for (_, _, key) in due {
            let Some(told) = self.values.get_mut(&key) else {
                continue;
            };
            let alone_bytes = told.value.len() + ENTRY_BYTES;
            let with_base_bytes = alone_bytes + told.basing.beside_bytes() + 2 * ENTRY_BYTES;
            // What has not changed for a while is told whole: for who lost it, and who joins.
            let may = self.settings.differences && !told.rests(&self.settings) && based.binary_search(&key).is_ok();
            let with_base = may && with_base_bytes <= room_bytes;
            let most_bytes = if with_base { with_base_bytes } else { alone_bytes };
            if bytes + most_bytes > room_bytes && !news.is_empty() {
                break;
            }
            let rests = told.rests(&self.settings);
            let told_bytes = told.tell(now, key, with_base, &mut news);
            bytes += told_bytes;
            news.resting_bytes += if rests { told_bytes } else { 0 };
            told.told(now, &self.settings);
        }
        news
    }
}

impl ToldEntry {
    /// Whether it has not changed for a while.
    fn rests(&self, settings: &StateSettings) -> bool {
        self.pause_s > 2.0 * settings.again_soon_s
    }

    fn is_small(&self) -> bool {
        self.value.len() <= SMALL_BYTES
    }

    /// It was told now: when it is told again.
    fn told(&mut self, now: NodeTime, settings: &StateSettings) {
        self.last = Some(now);
        self.due = now.plus_seconds(self.pause_s);
        self.pause_s = (self.pause_s * 2.0).min(settings.again_after_s);
    }

    /// Adds this value to the news; gives how many bytes it takes at most.
    fn tell(&mut self, now: NodeTime, key: Key, as_difference: bool, news: &mut News) -> usize {
        let piece = as_difference.then(|| self.basing.tell(now, key, self.version, &self.value));
        let whole = piece.as_ref().is_none_or(|piece| piece.needs_whole(self.version));
        let (base, change) = piece.map_or((None, None), |piece| (piece.base, piece.change));
        let mut bytes = base.as_ref().map_or(0, |base| base.value.len() + ENTRY_BYTES);
        bytes += change.as_ref().map_or(0, |change| change.differs.len() + ENTRY_BYTES);
        news.bases.extend(base);
        news.changes.extend(change);
        if whole {
            bytes += self.value.len() + ENTRY_BYTES;
            news.wholes.push(Entry {
                key,
                version: self.version,
                value: self.value.clone(),
            });
        }
        bytes
    }
}

/// What is known of one run of a node.
#[derive(Debug)]
struct Known {
    boot: Boot,
    versions: BTreeMap<Key, u64>,
    bases: Bases,
}

/// What this node has been told.
#[derive(Debug, Default)]
pub struct Heard {
    of: BTreeMap<NodeId, Known>,
}

/// What news make known.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Learned {
    /// Values newer than those before, the newest of each key.
    pub values: BTreeMap<Key, Vec<u8>>,
    /// Keys of which there is something newer, but not its base.
    pub lacking: Vec<Key>,
}

impl Heard {
    /// Takes news in. A value told again unchanged is not new.
    pub fn take(&mut self, from: NodeId, boot: Boot, news: News) -> Learned {
        let new = || Known {
            boot,
            versions: BTreeMap::new(),
            bases: Bases::default(),
        };
        let known = self.of.entry(from).or_insert_with(new);
        if known.boot != boot {
            *known = new();
        }
        let mut learned = Learned::default();
        for base in &news.bases {
            known.bases.keep(base);
        }
        for Entry { key, version, value } in news.bases.into_iter().chain(news.wholes) {
            if known.is_new(key, version) {
                learned.values.insert(key, value);
            }
        }
        for change in news.changes {
            let before = known.versions.get(&change.key).copied().unwrap_or(0);
            if change.version <= before {
                continue;
            }
            match known.bases.value(&change) {
                Some(value) if known.is_new(change.key, change.version) => {
                    learned.values.insert(change.key, value);
                }
                Some(_) => {}
                None => learned.lacking.push(change.key),
            }
        }
        learned
    }
}

impl Known {
    /// Whether this is newer than what was handed out before.
    fn is_new(&mut self, key: Key, version: u64) -> bool {
        if self.versions.len() >= MOST_KEYS && !self.versions.contains_key(&key) {
            return false;
        }
        let before = self.versions.entry(key).or_insert(0);
        let newer = version > *before;
        *before = version.max(*before);
        newer
    }
}

#[cfg(test)]
mod tests;
