//! Bulk: things larger than a datagram, in chunks, whole or not at all.
//!
//! Must never do: have more of one under way than a window; keep more of a sender's than its bounds; hand out a part.
//!
//! The receiver tells which chunk it misses first and which of the window behind it it has; the sender sends only what is not known to be
//! there, again after a while.

use minicbor::{Decode, Encode};
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;
use thiserror::Error;

mod receiving;

pub use receiving::Receiving;

/// A part of something on its way.
#[derive(Debug, Clone, PartialEq, Eq, Encode, Decode)]
pub struct Chunk {
    /// Of what; counts from 1 per run of the sender.
    #[n(0)]
    pub id: u64,
    /// Which part, from 0.
    #[n(1)]
    pub index: u32,
    /// How many parts there are; all but the last are as large as the first.
    #[n(2)]
    pub of: u32,
    /// The part.
    #[cbor(n(3), with = "minicbor::bytes")]
    pub part: Vec<u8>,
}

/// What of it is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Encode, Decode)]
pub struct Have {
    /// Of what.
    #[n(0)]
    pub id: u64,
    /// The first part that is missing; as many as there are once it is whole.
    #[n(1)]
    pub missing: u32,
    /// Of the parts after that one, the next one in the lowest bit: those that are there.
    #[n(2)]
    pub after: u64,
    /// The receiver does not take it: too large, or too many at once.
    #[n(3)]
    pub refused: bool,
}

/// Limits of bulk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BulkSettings {
    /// A chunk that is not known to be there is sent again after so long, in seconds: longer than a round trip.
    pub again_after_s: f64,
    /// What makes no progress for so long is given up, in seconds.
    pub give_up_after_s: f64,
    /// The largest thing, in bytes.
    pub most_bytes: usize,
    /// How many may be under way to or from one node.
    pub most_at_once: usize,
}

impl Default for BulkSettings {
    fn default() -> Self {
        Self {
            again_after_s: 1.0,
            give_up_after_s: 15.0,
            most_bytes: 16 << 20,
            most_at_once: 4,
        }
    }
}

/// Why something is not sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum BulkError {
    /// It is too large.
    #[error("{bytes} bytes are more than the {most} that are sent in one piece")]
    TooLarge {
        /// Its size.
        bytes: usize,
        /// The largest.
        most: usize,
    },
    /// Too many are under way to this node.
    #[error("{at_once} are under way to node {to} already")]
    TooMany {
        /// To whom.
        to: NodeId,
        /// How many.
        at_once: usize,
    },
}

/// Parts behind the first missing one that may be under way.
const WINDOW: u32 = 64;

#[derive(Debug)]
struct Sent {
    to: NodeId,
    body: Vec<u8>,
    chunk_bytes: usize,
    missing: u32,
    after: u64,
    /// When those of the window were last sent.
    sent: BTreeMap<u32, NodeTime>,
    progress: NodeTime,
}

impl Sent {
    fn parts(&self) -> u32 {
        u32::try_from(self.body.len().div_ceil(self.chunk_bytes).max(1)).unwrap_or(u32::MAX)
    }

    fn has(&self, index: u32) -> bool {
        index < self.missing
            || (index > self.missing
                && index - self.missing <= WINDOW
                && self.after >> (index - self.missing - 1) & 1 == 1)
    }

    /// The part to send now, if one is due.
    fn due(&self, now: NodeTime, again_after_s: f64) -> Option<u32> {
        let is_due = |index: &u32| {
            let sent = self.sent.get(index);
            !self.has(*index) && sent.is_none_or(|at| at.plus_seconds(again_after_s) <= now)
        };
        let mut window = self.missing..self.parts().min(self.missing.saturating_add(WINDOW));
        window.find(is_due)
    }

    fn part(&self, index: u32) -> Vec<u8> {
        let parts = self.body.chunks(self.chunk_bytes);
        parts
            .skip(index as usize)
            .map(<[u8]>::to_vec)
            .next()
            .unwrap_or_default()
    }
}

/// What one node sends.
#[derive(Debug)]
pub struct Sending {
    settings: BulkSettings,
    last: u64,
    under_way: BTreeMap<u64, Sent>,
}

impl Sending {
    /// Nothing yet.
    #[must_use]
    pub fn new(settings: BulkSettings) -> Self {
        Self {
            settings,
            last: 0,
            under_way: BTreeMap::new(),
        }
    }

    /// Begins to send something in chunks of so many bytes; gives its number.
    ///
    /// # Errors
    ///
    /// It is too large, or too many are under way.
    pub fn send(&mut self, now: NodeTime, to: NodeId, body: Vec<u8>, chunk_bytes: usize) -> Result<u64, BulkError> {
        let (bytes, most) = (body.len(), self.settings.most_bytes);
        if bytes > most {
            return Err(BulkError::TooLarge { bytes, most });
        }
        let at_once = self.under_way.values().filter(|sent| sent.to == to).count();
        if at_once >= self.settings.most_at_once {
            return Err(BulkError::TooMany { to, at_once });
        }
        self.last += 1;
        let sent = Sent {
            to,
            body,
            chunk_bytes: chunk_bytes.max(1),
            missing: 0,
            after: 0,
            sent: BTreeMap::new(),
            progress: now,
        };
        self.under_way.insert(self.last, sent);
        Ok(self.last)
    }

    /// The next chunk to send now: of the oldest that has one due.
    pub fn next(&mut self, now: NodeTime) -> Option<(NodeId, Chunk)> {
        let again_after_s = self.settings.again_after_s;
        for (id, sent) in &mut self.under_way {
            let Some(index) = sent.due(now, again_after_s) else {
                continue;
            };
            sent.sent.insert(index, now);
            let chunk = Chunk {
                id: *id,
                index,
                of: sent.parts(),
                part: sent.part(index),
            };
            return Some((sent.to, chunk));
        }
        None
    }

    /// Takes in what a receiver has. Gives the number that ended, and whether it is there whole.
    pub fn have(&mut self, now: NodeTime, from: NodeId, have: &Have) -> Option<(u64, bool)> {
        let sent = self.under_way.get_mut(&have.id).filter(|sent| sent.to == from)?;
        if have.refused {
            self.under_way.remove(&have.id);
            return Some((have.id, false));
        }
        // An older word than one before is of no use.
        if have.missing < sent.missing || have.missing > sent.parts() {
            return None;
        }
        let after = if have.missing == sent.missing {
            sent.after | have.after
        } else {
            have.after
        };
        if (have.missing, after) != (sent.missing, sent.after) {
            sent.progress = now;
        }
        (sent.missing, sent.after) = (have.missing, after);
        sent.sent = sent.sent.split_off(&have.missing);
        if have.missing == sent.parts() {
            self.under_way.remove(&have.id);
            return Some((have.id, true));
        }
        None
    }

    /// Gives up what makes no progress.
    pub fn expire(&mut self, now: NodeTime) -> Vec<(u64, NodeId)> {
        let limit_s = self.settings.give_up_after_s;
        self.end(|sent| now.seconds_since(sent.progress) >= limit_s)
    }

    /// Gives up what was for an earlier run of this node.
    pub fn restarted(&mut self, to: NodeId) -> Vec<(u64, NodeId)> {
        self.end(|sent| sent.to == to && sent.missing > 0)
    }

    fn end(&mut self, ends: impl Fn(&Sent) -> bool) -> Vec<(u64, NodeId)> {
        let mut ended = Vec::new();
        self.under_way.retain(|id, sent| {
            let kept = !ends(sent);
            if !kept {
                ended.push((*id, sent.to));
            }
            kept
        });
        ended
    }
}

#[cfg(test)]
mod tests;
