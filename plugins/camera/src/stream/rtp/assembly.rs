//! Puts H.264 together from RTP payloads in their order (RFC 6184, non-interleaved): access units in Annex B's byte stream. Pure.
//!
//! Must never do: give an access unit in which anything is missing, or one that refers to a picture that was left out.

use std::ops::Range;
use thiserror::Error;

use super::order::Packet;

/// A larger access unit is not taken: the node takes none.
pub(super) const MOST_UNIT_BYTES: usize = 4 << 20;
/// So many bytes of parameter sets are kept for the next key picture.
pub(super) const MOST_HELD_BYTES: usize = 16 << 10;
const START_CODE: [u8; 4] = [0, 0, 0, 1];

const IDR_SLICE: u8 = 5;
const SEQUENCE_PARAMETER_SET: u8 = 7;
const PICTURE_PARAMETER_SET: u8 = 8;
const DELIMITER: u8 = 9;
const STAP_A: u8 = 24;
const FU_A: u8 = 28;

fn kind(header: u8) -> u8 {
    header & 0x1f
}

/// A payload that cannot be H.264 as it is taken here.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub(super) enum Foreign {
    #[error("H.265")]
    H265,
    #[error("no H.264 as RFC 6184 packs it")]
    Unknown,
}

/// Whether a payload that begins so can be H.264.
fn foreign(header: u8, rest: &[u8]) -> Result<(), Foreign> {
    match kind(header) {
        // Headers of H.265 have two bytes, of which the second is usually 1. H.264 has no kind 0, and nobody makes its data partitions (2, 4).
        0 | 2 | 4 if header & 0x80 == 0 && rest.first() == Some(&1) => Err(Foreign::H265),
        // The highest bit is set where a gateway knows of damage.
        1..=STAP_A | FU_A if header & 0x80 == 0 => Ok(()),
        _ => Err(Foreign::Unknown),
    }
}

/// An access unit, and how many were left out before it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::stream) struct Picture {
    pub(in crate::stream) bytes: Vec<u8>,
    pub(super) left_out: u64,
}

/// The access unit that is being put together.
#[derive(Debug, Default)]
struct Unit {
    timestamp: u32,
    bytes: Vec<u8>,
    /// Kind of its first NAL unit.
    first: Option<u8>,
    /// Where its parameter sets stand.
    sets: Vec<Range<usize>>,
    has_sequence_set: bool,
    has_slice: bool,
    is_key: bool,
    /// Where the NAL unit begins whose fragments are coming.
    fragments_from: Option<usize>,
    is_damaged: bool,
}

impl Unit {
    fn begin_nal(&mut self, header: u8, rest: &[u8]) -> usize {
        let start = self.bytes.len();
        self.first.get_or_insert(kind(header));
        self.append(&START_CODE);
        self.append(&[header]);
        self.append(rest);
        start
    }

    fn append(&mut self, bytes: &[u8]) {
        if self.bytes.len() + bytes.len() > MOST_UNIT_BYTES {
            self.damage();
        }
        if !self.is_damaged {
            self.bytes.extend_from_slice(bytes);
        }
    }

    /// What comes after it is not kept, but what parameter sets came before it can still be used.
    fn damage(&mut self) {
        self.is_damaged = true;
        self.fragments_from = None;
    }

    fn end_nal(&mut self, start: usize) {
        let Some(header) = self.bytes.get(start + START_CODE.len()).filter(|_| !self.is_damaged) else {
            return;
        };
        match kind(*header) {
            // The other partitions of a slice (3, 4) are of no use without the first.
            1 | 2 => self.has_slice = true,
            IDR_SLICE => (self.has_slice, self.is_key) = (true, true),
            SEQUENCE_PARAMETER_SET => {
                self.has_sequence_set = true;
                self.sets.push(start..self.bytes.len());
            }
            PICTURE_PARAMETER_SET => self.sets.push(start..self.bytes.len()),
            _ => {}
        }
    }

    fn whole_nal(&mut self, nal: &[u8]) {
        let Some((header, rest)) = nal.split_first() else {
            return self.damage();
        };
        if self.fragments_from.is_some() {
            // The rest of the one before is missing, though no number is.
            self.damage();
        }
        let start = self.begin_nal(*header, rest);
        self.end_nal(start);
    }

    fn aggregate(&mut self, mut rest: &[u8]) {
        while !rest.is_empty() {
            let nal = rest.split_first_chunk().and_then(|(len, after)| {
                let len = usize::from(u16::from_be_bytes(*len));
                after.split_at_checked(len)
            });
            let Some((nal, after)) = nal else {
                return self.damage();
            };
            self.whole_nal(nal);
            rest = after;
        }
    }

    fn fragment(&mut self, indicator: u8, rest: &[u8]) {
        let Some((fragment_header, rest)) = rest.split_first() else {
            return self.damage();
        };
        let (starts, ends) = (fragment_header & 0x80 != 0, fragment_header & 0x40 != 0);
        let start = match (starts, self.fragments_from) {
            (true, None) => self.begin_nal(indicator & 0xe0 | kind(*fragment_header), rest),
            (false, Some(start)) => {
                self.append(rest);
                start
            }
            _ => return self.damage(),
        };
        self.fragments_from = (!ends && !self.is_damaged).then_some(start);
        if ends {
            self.end_nal(start);
        }
    }
}

/// Puts access units together.
#[derive(Debug)]
pub(super) struct Assembly {
    unit: Option<Unit>,
    /// Something is missing before what comes next.
    after_gap: bool,
    /// What comes refers to pictures that were left out, until a key picture comes.
    waits_for_key: bool,
    /// Key pictures of this sender begin with something before their first slice. Believed until one is seen that does not.
    keys_are_led: bool,
    /// Parameter sets that came with nothing that was given, or were configured: they go before the next picture that is.
    held: Vec<u8>,
    left_out: u64,
    has_begun: bool,
}

impl Assembly {
    /// `parameter_sets` in Annex B's byte stream, for a sender that does not send them.
    pub(super) fn new(parameter_sets: &[u8]) -> Self {
        Self {
            unit: None,
            after_gap: true,
            waits_for_key: true,
            // Who configures parameter sets says so.
            keys_are_led: parameter_sets.is_empty(),
            held: parameter_sets.to_vec(),
            left_out: 0,
            has_begun: false,
        }
    }

    /// Takes the next packet; what it completes goes to `out`.
    pub(super) fn put(&mut self, packet: &Packet, after_gap: bool, out: &mut Vec<Picture>) -> Result<(), Foreign> {
        self.after_gap |= after_gap;
        if after_gap {
            self.waits_for_key = true;
            if let Some(unit) = &mut self.unit {
                unit.damage();
            }
        }
        // Padding alone keeps a way open, and says nothing.
        let Some((header, rest)) = packet.payload.split_first() else {
            return Ok(());
        };
        let is_other = |unit: &Unit| unit.timestamp != packet.timestamp;
        if self.unit.as_ref().is_some_and(is_other) {
            self.end(out);
        }
        let is_proven = !std::mem::take(&mut self.after_gap) || self.is_beginning(*header, rest);
        let unit = self.unit.get_or_insert_with(|| Unit {
            timestamp: packet.timestamp,
            is_damaged: !is_proven,
            ..Unit::default()
        });
        let outcome = foreign(*header, rest);
        match kind(*header) {
            _ if outcome.is_err() => unit.damage(),
            STAP_A => unit.aggregate(rest),
            FU_A => unit.fragment(*header, rest),
            _ => unit.whole_nal(&packet.payload),
        }
        if packet.marker {
            self.end(out);
        }
        outcome
    }

    /// Whether a payload is the first one of its access unit, although nobody knows what was before it.
    fn is_beginning(&self, header: u8, rest: &[u8]) -> bool {
        let (header_kind, data) = match (kind(header), rest) {
            (STAP_A, [_, _, first, data @ ..]) => (kind(*first), data),
            (FU_A, [fragment, data @ ..]) if fragment & 0x80 != 0 => (kind(*fragment), data),
            (STAP_A | FU_A, _) => return false,
            (alone, data) => (alone, data),
        };
        // A slice begins with the number of its first macroblock; 0 is a bit that is set.
        let is_first_slice = data.first().is_some_and(|byte| byte & 0x80 != 0);
        match header_kind {
            SEQUENCE_PARAMETER_SET | DELIMITER => true,
            IDR_SLICE => is_first_slice && !self.keys_are_led,
            _ => false,
        }
    }

    fn end(&mut self, out: &mut Vec<Picture>) {
        let Some(unit) = self.unit.take() else {
            return;
        };
        let is_whole = !unit.is_damaged && unit.fragments_from.is_none();
        if is_whole && unit.is_key {
            self.keys_are_led = unit.first != Some(IDR_SLICE);
        }
        if is_whole && unit.has_slice && (unit.is_key || !self.waits_for_key) {
            let mut bytes = std::mem::take(&mut self.held);
            if unit.has_sequence_set {
                bytes.clear();
            }
            bytes.extend_from_slice(&unit.bytes);
            self.waits_for_key = false;
            self.has_begun = true;
            let left_out = std::mem::take(&mut self.left_out);
            return out.push(Picture { bytes, left_out });
        }
        self.hold(&unit);
        self.waits_for_key |= !is_whole;
        // Before the first one nothing is missed, and parameter sets alone are no picture.
        let is_missed = self.has_begun && (unit.has_slice || !is_whole);
        self.left_out += u64::from(is_missed);
    }

    /// Keeps the parameter sets of a unit that is not given.
    fn hold(&mut self, unit: &Unit) {
        if unit.has_sequence_set {
            self.held.clear();
        }
        for set in unit.sets.iter().filter_map(|range| unit.bytes.get(range.clone())) {
            if self.held.len() + set.len() > MOST_HELD_BYTES {
                self.held.clear();
                return;
            }
            self.held.extend_from_slice(set);
        }
    }

    /// Bytes that are kept.
    #[cfg(test)]
    pub(super) fn kept_bytes(&self) -> usize {
        self.held.len() + self.unit.as_ref().map_or(0, |unit| unit.bytes.len())
    }
}
