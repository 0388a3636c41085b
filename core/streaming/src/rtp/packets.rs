//! H.264 pictures as packets of RTP (RFC 3550), in single NAL units, STAP-A and FU-A (RFC 6184, packetization mode 1).
//!
//! Must never do: read a clock, or know of sockets.

use skein_domain::NodeTime;
use skein_video::EncodedFrame;
use str0m::unversioned::{H264Packetizer, Packetizer};

/// No packet is longer, in bytes, so that none is cut in two on the way: Ethernet and most tunnels carry it.
const LONGEST_BYTES: usize = 1_400;
const HEADER_BYTES: usize = 12;
/// Version 2 without padding, extension or other sources.
const VERSION: u8 = 2 << 6;
/// The first number without a fixed meaning, which players expect for H.264.
const PAYLOAD_TYPE: u8 = 96;
/// The last packet of a picture.
const MARKER: u8 = 0x80;

/// Makes the packets of one stream.
#[derive(Debug)]
pub(super) struct Packets {
    payloads: H264Packetizer,
    /// SSRC: by it a player tells streams apart.
    source: u32,
    sequence: u16,
}

impl Packets {
    pub(super) fn new(source: u32) -> Self {
        Self {
            payloads: H264Packetizer::default(),
            source,
            sequence: 0,
        }
    }

    /// The packets of the stream's next picture.
    pub(super) fn of(&mut self, frame: &EncodedFrame) -> Vec<Vec<u8>> {
        // It has an error for other codecs alone.
        let payloads = self.payloads.packetize(LONGEST_BYTES - HEADER_BYTES, &frame.bytes);
        let payloads = payloads.unwrap_or_default();
        let (last, timestamp) = (payloads.len().saturating_sub(1), timestamp(frame.taken));
        let packets = payloads.into_iter().enumerate();
        packets
            .map(|(at, payload)| {
                let marker = if at == last { MARKER } else { 0 };
                let mut packet = Vec::with_capacity(HEADER_BYTES + payload.len());
                packet.extend([VERSION, marker | PAYLOAD_TYPE]);
                packet.extend(self.sequence.to_be_bytes());
                packet.extend(timestamp.to_be_bytes());
                packet.extend(self.source.to_be_bytes());
                packet.extend(payload);
                self.sequence = self.sequence.wrapping_add(1);
                packet
            })
            .collect()
    }
}

/// A moment in units of 1/90,000 s, which wrap around as RTP has it.
fn timestamp(taken: NodeTime) -> u32 {
    // The moment is the camera's word: whatever it is, it fits.
    (u128::from(taken.0) * 9 / 100) as u32
}

#[cfg(test)]
mod tests;
