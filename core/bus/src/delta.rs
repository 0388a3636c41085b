//! State told often, as differences to a value that its receivers have whole: the base.
//!
//! Must never do: let a receiver put a difference on another base than its sender did; hand out anything that was not told.
//!
//! A base is named by the version of its value, of which a run of a sender has one only. It is told whole several times, each time with a difference to it in the same
//! datagram, before a difference goes alone; so who lost one telling of it has it by another. Who lacks it still says so, and waits no longer than until the
//! next base, which is told beside the old one before it takes its place.

use crate::entry::{Entry, Key};
use minicbor::{Decode, Encode};
use skein_domain::NodeTime;
use std::collections::BTreeMap;

/// A value as a difference to a base.
#[derive(Debug, Clone, PartialEq, Eq, Encode, Decode)]
pub struct Change {
    /// Which value.
    #[n(0)]
    pub key: Key,
    /// Its version.
    #[n(1)]
    pub version: u64,
    /// How much older the base's version is.
    #[n(2)]
    pub back: u64,
    /// How long the value is, in bytes.
    #[n(3)]
    pub length: u32,
    /// What differs: see [`difference`].
    #[cbor(n(4), with = "minicbor::bytes")]
    pub differs: Vec<u8>,
}

/// Shorter values are told whole: what a datagram costs beside them is more than they are, and they never wait for a base.
pub const LEAST_BYTES: usize = 40;
/// Longer values are told whole: with their base they must fit into one datagram.
pub const MOST_BYTES: usize = 600;
/// A node tells no more keys than these as differences; a receiver keeps bases of so many of each node.
pub const MOST_KEYS: usize = 32;
/// A base is told whole so often before a difference to it goes alone: at 30 % loss 8 of 1,000 receivers lack it then.
const TOLD: u8 = 4;
/// After so long a new base takes its place, in seconds.
const LASTS_S: f64 = 5.0;
/// A base whose differences are more than three quarters of the value lasts only so long, in seconds.
const POOR_LASTS_S: f64 = 1.0;
/// So many changes in quick succession make a value one that is told often.
const OFTEN: u8 = 4;
/// What quick succession is, in seconds.
const QUICK_S: f64 = 0.5;
/// A value whose differences did not pay for their base is told whole for so long, in seconds.
const IN_VAIN_FOR_S: f64 = 30.0;
/// Bases of one key that a receiver keeps: the one in use and the one that follows.
const KEPT: usize = 2;

/// What differs between two values: the exclusive or, as runs. A byte tells how many bytes are the same (four bits) and how many follow that are not.
///
/// It needs no knowledge of what the bytes mean, never grows by more than a fifteenth, and finds what fields of fixed width have in common: the high bytes of
/// numbers that change slowly.
#[must_use]
pub fn difference(base: &[u8], value: &[u8]) -> Vec<u8> {
    let padded = base.iter().copied().chain(std::iter::repeat(0));
    let mut rest: Vec<u8> = value.iter().zip(padded).map(|(new, old)| new ^ old).collect();
    let length = rest.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    rest.truncate(length);
    let mut rest = &rest[..];
    let mut runs = Vec::new();
    while !rest.is_empty() {
        let same = rest.iter().take(15).take_while(|byte| **byte == 0).count();
        rest = rest.get(same..).unwrap_or(&[]);
        // One byte that is the same between others costs no more than a new run.
        let pairs = rest.iter().zip(rest.iter().skip(1).chain([&0]));
        let other = pairs
            .take(15)
            .take_while(|(byte, next)| **byte != 0 || **next != 0)
            .count();
        let (bytes, after) = rest.split_at_checked(other).unwrap_or((rest, &[]));
        runs.push((same as u8) << 4 | other as u8);
        runs.extend_from_slice(bytes);
        rest = after;
    }
    runs
}

/// The value that differs so from the base; none if it can't be.
#[must_use]
pub fn applied(base: &[u8], length: usize, mut differs: &[u8]) -> Option<Vec<u8>> {
    if length > MOST_BYTES {
        return None;
    }
    let mut value = base.to_vec();
    value.resize(length, 0);
    let mut at = 0;
    while let Some((run, after)) = differs.split_first() {
        at += usize::from(run >> 4);
        let (bytes, after) = after.split_at_checked(usize::from(run & 15))?;
        for byte in bytes {
            *value.get_mut(at)? ^= byte;
            at += 1;
        }
        differs = after;
    }
    Some(value)
}

#[derive(Debug)]
struct Base {
    version: u64,
    value: Vec<u8>,
    begun: NodeTime,
    told: u8,
    /// What differences to it have saved, in bytes.
    saved: usize,
    poor: bool,
}

/// How one value is told now.
#[derive(Debug, PartialEq, Eq)]
pub struct Piece {
    /// A base to tell whole. If its version is that of the value, it is the value.
    pub base: Option<Entry>,
    /// The value as a difference; otherwise it is to be told whole.
    pub change: Option<Change>,
}

impl Piece {
    const WHOLE: Self = Self {
        base: None,
        change: None,
    };

    /// Whether the value must be told whole beside.
    #[must_use]
    pub fn needs_whole(&self, version: u64) -> bool {
        self.change.is_none() && self.base.as_ref().is_none_or(|base| base.version != version)
    }
}

/// The bases of one key at its sender.
#[derive(Debug, Default)]
pub struct Basing {
    current: Option<Base>,
    coming: Option<Base>,
    often: u8,
    /// So many times the present base is told again: somebody lacks it.
    owed: u8,
    not_before: Option<NodeTime>,
}

impl Basing {
    /// Takes note that the value has changed, so long after it was last told.
    pub fn changed(&mut self, after_s: Option<f64>) {
        if after_s.is_some_and(|after_s| after_s <= QUICK_S) {
            self.often = self.often.saturating_add(1);
        } else {
            let not_before = self.not_before;
            *self = Self {
                not_before,
                ..Self::default()
            };
        }
    }

    /// Whether it changes often enough for bases.
    #[must_use]
    pub fn is_used(&self) -> bool {
        self.often >= OFTEN
    }

    /// What a telling takes at most beside the value itself, in bytes.
    #[must_use]
    pub fn beside_bytes(&self) -> usize {
        if self.is_used() { MOST_BYTES } else { 0 }
    }

    /// Somebody lacks the base.
    pub fn owe(&mut self) {
        self.owed = 2;
    }

    /// How to tell this value now.
    pub fn tell(&mut self, now: NodeTime, key: Key, version: u64, value: &[u8]) -> Piece {
        if self.often < OFTEN || !(LEAST_BYTES..=MOST_BYTES).contains(&value.len()) {
            return Piece::WHOLE;
        }
        self.renew(now, version, value);
        let (reference, told) = match (&mut self.coming, &mut self.current) {
            (Some(coming), _) => {
                coming.told += 1;
                (coming, true)
            }
            (None, Some(current)) => {
                let owed = self.owed > 0;
                self.owed = self.owed.saturating_sub(1);
                (current, owed)
            }
            (None, None) => return Piece::WHOLE,
        };
        let base = told.then(|| Entry {
            key,
            version: reference.version,
            value: reference.value.clone(),
        });
        if told && reference.version == version {
            return Piece { base, change: None };
        }
        let differs = difference(&reference.value, value);
        reference.poor = differs.len() * 4 > value.len() * 3;
        if differs.len() >= value.len() {
            return Piece { base, change: None };
        }
        if !told {
            reference.saved += value.len() - differs.len();
        }
        let change = Change {
            key,
            version,
            back: version.saturating_sub(reference.version),
            length: value.len() as u32,
            differs,
        };
        Piece {
            base,
            change: Some(change),
        }
    }

    /// Lets the base that comes take the place of the one that is, and a new one come.
    fn renew(&mut self, now: NodeTime, version: u64, value: &[u8]) {
        if self.coming.as_ref().is_some_and(|coming| coming.told >= TOLD) {
            self.current = self.coming.take();
        }
        let lasts = |base: &Base| now.seconds_since(base.begun) < if base.poor { POOR_LASTS_S } else { LASTS_S };
        let waits = self.not_before.is_some_and(|moment| now < moment);
        if waits || self.coming.is_some() || self.current.as_ref().is_some_and(lasts) {
            return;
        }
        if self
            .current
            .as_ref()
            .is_some_and(|base| base.saved < usize::from(TOLD) * value.len())
        {
            self.current = None;
            self.not_before = Some(now.plus_seconds(IN_VAIN_FOR_S));
            return;
        }
        self.coming = Some(Base {
            version,
            value: value.to_vec(),
            begun: now,
            told: 0,
            saved: 0,
            poor: false,
        });
    }
}

/// The bases that a receiver has of one run of a sender.
#[derive(Debug, Default)]
pub struct Bases(BTreeMap<Key, BTreeMap<u64, Vec<u8>>>);

impl Bases {
    /// Keeps a base: the newest ones of each key, of as many keys as there may be.
    pub fn keep(&mut self, base: &Entry) {
        if base.value.len() > MOST_BYTES {
            return;
        }
        let of_key = self.0.entry(base.key).or_default();
        of_key.insert(base.version, base.value.clone());
        if of_key.len() > KEPT {
            of_key.pop_first();
        }
        if self.0.len() > MOST_KEYS {
            let newest = |of: &BTreeMap<u64, Vec<u8>>| of.last_key_value().map_or(0, |(version, _)| *version);
            let oldest = self.0.iter().min_by_key(|(_, of)| newest(of)).map(|(key, _)| *key);
            oldest.map(|key| self.0.remove(&key));
        }
    }

    /// The value of a change; none without its base.
    #[must_use]
    pub fn value(&self, change: &Change) -> Option<Vec<u8>> {
        let base = self
            .0
            .get(&change.key)?
            .get(&change.version.checked_sub(change.back)?)?;
        applied(base, change.length as usize, &change.differs)
    }
}

#[cfg(test)]
mod tests;
