//! What comes to a UDP port, taken for RTP with H.264: datagrams in, whole access units out. Pure; time is an argument.
//!
//! Must never do: panic, whatever comes, or keep more than its bounds: 65 datagrams of 9,216 bytes and an access unit of
//! 4 MiB, 4.6 MiB in all.

use super::assembly::{Assembly, Foreign, Picture};
use super::order::{Order, Packet, Placed};
use retina::rtp::PacketHeader;
use std::time::Duration;
use thiserror::Error;

/// A larger datagram is not taken: it fits no Ethernet frame, jumbo frames included.
pub(super) const MOST_DATAGRAM_BYTES: usize = 9_216;
/// Another sender, or another sequence of the same one, is believed when nothing came of the last one for so long.
const SILENCE: Duration = Duration::from_millis(500);
/// Payload types that are agreed on by the two ends: H.264 has no other.
const DYNAMIC_TYPES: std::ops::RangeInclusive<u8> = 96..=127;
/// The packet types of RTCP, where it comes to the same port (RFC 5761).
const RTCP_TYPES: std::ops::RangeInclusive<u8> = 192..=223;

/// What is wrong with what comes; what says more of the sender stands behind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Error)]
pub(crate) enum Lack {
    #[error("nothing comes")]
    Nothing,
    #[error("what comes is empty")]
    Empty,
    #[error("what comes are datagrams of more than {MOST_DATAGRAM_BYTES} bytes")]
    Oversized,
    #[error("what comes is no RTP")]
    NotRtp,
    #[error("what comes is RTP of payload type {0}; H.264 has one from 96 to 127")]
    PayloadType(u8),
    #[error("what comes is no H.264 as RFC 6184 packs it")]
    NotH264,
    #[error("H.264 comes, but no key picture (IDR) is whole: let the sender make one every second or two")]
    NoKeyPicture,
    #[error("what comes is H.265")]
    H265,
}

/// What came, counted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) datagrams: u64,
    pub(super) empty: u64,
    pub(super) oversized: u64,
    pub(super) not_rtp: u64,
    pub(super) other_type: u64,
    pub(super) not_h264: u64,
    /// Of a second sender while the first goes on.
    pub(super) other_sender: u64,
    /// Doubled, late, or with a number that fits to nothing.
    pub(super) late: u64,
    /// Packets that were given up.
    pub(super) lost: u64,
}

impl Counts {
    /// What was of no use since then, in words; none if there was nothing.
    pub(super) fn useless_since(&self, then: &Self) -> Option<String> {
        let differences = [
            (self.lost - then.lost, "packets lost"),
            (self.late - then.late, "late or doubled"),
            (self.other_sender - then.other_sender, "of another sender"),
            (self.not_h264 - then.not_h264, "no H.264"),
            (self.other_type - then.other_type, "of another payload type"),
            (self.not_rtp - then.not_rtp, "no RTP"),
            (self.oversized - then.oversized, "too large"),
            (self.empty - then.empty, "empty"),
        ];
        let told: Vec<String> = differences
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        let came = self.datagrams - then.datagrams;
        (!told.is_empty()).then(|| format!("of {came} datagrams: {}", told.join(", ")))
    }
}

/// Takes what comes to one port.
#[derive(Debug)]
pub(in crate::stream) struct Reception {
    parameter_sets: Vec<u8>,
    order: Order,
    assembly: Assembly,
    /// Who sends (its SSRC), and when its last packet came.
    sender: Option<(u32, Duration)>,
    counts: Counts,
    /// What has been wrong since the last picture.
    lack: Lack,
}

impl Reception {
    /// `parameter_sets` in Annex B's byte stream, for a sender that does not send them.
    pub(in crate::stream) fn new(parameter_sets: Vec<u8>) -> Self {
        Self {
            order: Order::default(),
            assembly: Assembly::new(&parameter_sets),
            sender: None,
            counts: Counts::default(),
            lack: Lack::Nothing,
            parameter_sets,
        }
    }

    /// What came so far.
    pub(super) fn counts(&self) -> Counts {
        Counts {
            lost: self.counts.lost + self.order.lost,
            ..self.counts
        }
    }

    /// What has been wrong since the last picture, or since this was asked.
    pub(in crate::stream) fn take_lack(&mut self) -> Lack {
        std::mem::replace(&mut self.lack, Lack::Nothing)
    }

    /// Takes a datagram that came at `now`, on any clock that only goes forward; what it completes is given.
    pub(in crate::stream) fn take(&mut self, now: Duration, datagram: &[u8]) -> Vec<Picture> {
        self.counts.datagrams += 1;
        let mut pictures = Vec::new();
        if let Err(lack) = self.judge(now, datagram, &mut pictures) {
            self.lack = self.lack.max(lack);
        }
        if !pictures.is_empty() {
            self.lack = Lack::Nothing;
        }
        pictures
    }

    fn judge(&mut self, now: Duration, datagram: &[u8], pictures: &mut Vec<Picture>) -> Result<(), Lack> {
        if datagram.is_empty() {
            self.counts.empty += 1;
            return Err(Lack::Empty);
        }
        if datagram.len() > MOST_DATAGRAM_BYTES {
            self.counts.oversized += 1;
            return Err(Lack::Oversized);
        }
        let Ok((header, range)) = PacketHeader::validate(datagram) else {
            self.counts.not_rtp += 1;
            return Err(Lack::NotRtp);
        };
        if datagram.get(1).is_some_and(|byte| RTCP_TYPES.contains(byte)) {
            return Ok(());
        }
        let payload_type = header.payload_type();
        if !DYNAMIC_TYPES.contains(&payload_type) {
            self.counts.other_type += 1;
            return Err(Lack::PayloadType(payload_type));
        }
        let payload = datagram.get(usize::from(range.start)..usize::from(range.end));
        let packet = Packet {
            timestamp: header.timestamp(),
            marker: header.mark(),
            payload: payload.unwrap_or_default().to_vec(),
        };
        self.sort_in(now, header.ssrc(), header.sequence_number(), packet);
        self.assemble(pictures)
    }

    fn sort_in(&mut self, now: Duration, ssrc: u32, sequence: u16, packet: Packet) {
        let after_silence = self.sender.is_none_or(|(_, last)| now.saturating_sub(last) >= SILENCE);
        if self.sender.is_some_and(|(known, _)| known != ssrc) {
            if !after_silence {
                // Two cameras that send to one port would make one stream of rubbish.
                self.counts.other_sender += 1;
                return;
            }
            self.counts.lost += self.order.lost;
            self.order = Order::default();
            self.assembly = Assembly::new(&self.parameter_sets);
        }
        self.sender = Some((ssrc, now));
        if self.order.put(sequence, packet, after_silence) != Placed::Kept {
            self.counts.late += 1;
        }
    }

    fn assemble(&mut self, pictures: &mut Vec<Picture>) -> Result<(), Lack> {
        let mut outcome = Err(Lack::NoKeyPicture);
        while let Some((packet, after_gap)) = self.order.pop() {
            if let Err(foreign) = self.assembly.put(&packet, after_gap, pictures) {
                self.counts.not_h264 += 1;
                outcome = Err(match foreign {
                    Foreign::H265 => Lack::H265,
                    Foreign::Unknown => Lack::NotH264,
                });
            }
        }
        outcome
    }

    /// Bytes that are kept, without the bookkeeping around them.
    #[cfg(test)]
    pub(super) fn kept_bytes(&self) -> usize {
        self.order.kept_bytes() + self.assembly.kept_bytes()
    }
}
