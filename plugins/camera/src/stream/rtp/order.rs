//! Puts RTP packets back into the order in which they were sent (RFC 3550). Pure.
//!
//! Must never do: keep more packets than its window has room for, or hide that one is missing.

use std::collections::BTreeMap;

/// So many packets may wait for one that is late.
pub(super) const WINDOW: usize = 64;
/// A packet is not waited for any longer when one comes that the sender stamped so much later: 0.1 s of the clock of H.264 (90 kHz).
const LATEST_TICKS: i32 = 9_000;
/// A sequence number further ahead is no loss, but another sequence (RFC 3550, A.1).
const MOST_AHEAD: u16 = 3_000;
/// A packet may be so far behind and still be one that is late.
const MOST_BEHIND: u16 = 100;

/// What of a packet matters once it is in its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Packet {
    pub(super) timestamp: u32,
    pub(super) marker: bool,
    pub(super) payload: Vec<u8>,
}

/// What became of a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Placed {
    /// It waits for its turn.
    Kept,
    /// It came twice, or after it was given up.
    Late,
    /// Its number fits to nothing; it is believed if the next one follows it.
    Stray,
}

/// The packets of one sender.
#[derive(Debug, Default)]
pub(super) struct Order {
    /// The number that is to be given next, counted on beyond 16 bits; none before the first packet.
    next: Option<u64>,
    waiting: BTreeMap<u64, Packet>,
    /// Nothing is known of what was sent before the next packet.
    cut: bool,
    /// What a stray packet's successor would have.
    after_stray: Option<u16>,
    /// Packets that were given up.
    pub(super) lost: u64,
}

impl Order {
    /// Puts a packet into its place. After a silence its number is believed, wherever it is: the sender may have begun anew.
    pub(super) fn put(&mut self, sequence: u16, packet: Packet, after_silence: bool) -> Placed {
        let Some(next) = self.next else {
            return self.begin_at(sequence, packet);
        };
        // The lower 16 bits are what a packet has.
        let ahead = sequence.wrapping_sub(next as u16);
        let is_behind = ahead > u16::MAX - MOST_BEHIND;
        let is_far = ahead > MOST_AHEAD && !is_behind;
        if ahead > 0 && after_silence || is_far && self.after_stray == Some(sequence) {
            return self.begin_at(sequence, packet);
        }
        if is_far {
            self.after_stray = Some(sequence.wrapping_add(1));
            return Placed::Stray;
        }
        let place = next + u64::from(ahead);
        if is_behind || self.waiting.contains_key(&place) {
            return Placed::Late;
        }
        self.waiting.insert(place, packet);
        Placed::Kept
    }

    fn begin_at(&mut self, sequence: u16, packet: Packet) -> Placed {
        let place = u64::from(sequence);
        self.waiting.clear();
        self.waiting.insert(place, packet);
        self.next = Some(place);
        self.after_stray = None;
        self.cut = true;
        Placed::Kept
    }

    /// The next packet, if it is there or not waited for any longer; and whether something is missing before it.
    pub(super) fn pop(&mut self) -> Option<(Packet, bool)> {
        let next = self.next?;
        let first = self.waiting.first_entry()?;
        let place = *first.key();
        if place != next {
            let stamp = first.get().timestamp;
            let newest = self.waiting.last_key_value().map_or(stamp, |(_, last)| last.timestamp);
            // Timestamps go round: the difference is what counts.
            let is_overdue = newest.wrapping_sub(stamp) as i32 > LATEST_TICKS;
            if self.waiting.len() <= WINDOW && !is_overdue {
                return None;
            }
        }
        let packet = self.waiting.remove(&place)?;
        let missing = place - next;
        self.lost += missing;
        self.next = Some(place + 1);
        let after_gap = std::mem::take(&mut self.cut) || missing > 0;
        Some((packet, after_gap))
    }

    /// Bytes that are kept.
    #[cfg(test)]
    pub(super) fn kept_bytes(&self) -> usize {
        self.waiting.values().map(|packet| packet.payload.len()).sum()
    }
}
