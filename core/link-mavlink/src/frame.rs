//! Finding MAVLink frames in bytes: whole ones in a datagram, or ones cut anywhere in a stream. MAVLink 2, and 1.
//!
//! A frame of a known message is only given out when its checksum is right. One of an unknown message cannot be checked; it
//! is skipped as a whole if what follows looks like the next frame, and byte by byte otherwise.
//!
//! Must never do: allocate per frame, panic on any input, or look into payloads.

use crate::metrics::EndpointCounters;
use mavlink::dialects::common::MavMessage;
use mavlink::{MAV_STX, MAV_STX_V2, MavlinkVersion, Message, calculate_crc};

/// Longest frame there is: MAVLink 2 with a full payload and a signature.
pub const MAX_FRAME_BYTES: usize = 280;
/// Longest payload there is.
const MAX_PAYLOAD_BYTES: usize = 255;
/// Longest datagram that is looked at as a whole.
pub const MAX_DATAGRAM_BYTES: usize = 2048;

const CHECKSUM_BYTES: usize = 2;
const SIGNATURE_BYTES: usize = 13;
const V1_HEADER_BYTES: usize = 6;
const V2_HEADER_BYTES: usize = 10;
const FLAG_SIGNED: u8 = 0x01;

/// What stands before a frame's payload.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameHeader {
    /// Protocol version of the frame.
    pub version: MavlinkVersion,
    /// Who sent it.
    pub system_id: u8,
    /// Which part of that system.
    pub component_id: u8,
    /// Counts the frames of one channel, modulo 256.
    pub sequence: u8,
    /// Which message.
    pub message_id: u32,
}

/// One frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Its header.
    pub header: FrameHeader,
    /// Its payload; in MAVLink 2 without trailing zeroes.
    pub payload: &'a [u8],
    /// Whether the message is known here, and so the checksum was right. An unknown message's could not be checked.
    pub known: bool,
}

/// What stands at the start of some bytes.
enum FrameStep<'a> {
    /// A frame of so many bytes.
    Frame(Frame<'a>, usize),
    /// The start of a frame that is not here whole.
    Partial,
    /// A frame by its form, with a wrong checksum.
    BadCrc,
    /// Nothing that a frame begins with.
    Stray,
}

/// What a known message's checksum is begun with.
pub(crate) fn checksum_extra(message_id: u32) -> Option<u8> {
    let extra = MavMessage::extra_crc(message_id);
    (extra != 0 || MavMessage::all_ids().contains(&message_id)).then_some(extra)
}

/// The number of bytes of a known message's payload, extensions included.
pub(crate) fn payload_len(message_id: u32) -> Option<usize> {
    let message = MavMessage::default_message_from_id(message_id)?;
    // The library says how many bytes are left without trailing zeroes only. How many it has written is seen by writing over
    // two different backgrounds.
    let (mut zeroes, mut ones) = ([0x00; MAX_PAYLOAD_BYTES], [0xFF; MAX_PAYLOAD_BYTES]);
    message.ser(MavlinkVersion::V2, &mut zeroes);
    message.ser(MavlinkVersion::V2, &mut ones);
    let written = zeroes.iter().zip(&ones).take_while(|(a, b)| a == b).count();
    Some(written)
}

/// Reads what stands before a payload: the header, and how many bytes the payload has.
fn header(version: MavlinkVersion, bytes: &[u8]) -> Option<(FrameHeader, usize)> {
    let (len, sequence, system_id, component_id, message_id) = match *bytes {
        [_, len, _, _, sequence, system_id, component_id, a, b, c] => {
            (len, sequence, system_id, component_id, u32::from_le_bytes([a, b, c, 0]))
        }
        [_, len, sequence, system_id, component_id, id] => (len, sequence, system_id, component_id, u32::from(id)),
        _ => return None,
    };
    let header = FrameHeader {
        version,
        system_id,
        component_id,
        sequence,
        message_id,
    };
    Some((header, usize::from(len)))
}

/// The first frame of `bytes`, if they begin with one.
fn step(bytes: &[u8]) -> FrameStep<'_> {
    let (version, header_len, flags) = match *bytes {
        [MAV_STX_V2, _, flags, ..] => (MavlinkVersion::V2, V2_HEADER_BYTES, flags),
        [MAV_STX, ..] => (MavlinkVersion::V1, V1_HEADER_BYTES, 0),
        [MAV_STX_V2, ..] => return FrameStep::Partial,
        _ => return FrameStep::Stray,
    };
    // Any other flag changes the layout (or means something we must understand): such a frame is not for us.
    if flags & !FLAG_SIGNED != 0 {
        return FrameStep::Stray;
    }
    let Some((header, payload_len)) = bytes.get(..header_len).and_then(|bytes| header(version, bytes)) else {
        return FrameStep::Partial;
    };
    let payload_end = header_len + payload_len;
    let signature = if flags & FLAG_SIGNED == 0 { 0 } else { SIGNATURE_BYTES };
    let frame_len = payload_end + CHECKSUM_BYTES + signature;
    if bytes.len() < frame_len {
        return FrameStep::Partial;
    }
    let checksum = bytes
        .get(payload_end..)
        .and_then(|behind| behind.first_chunk::<CHECKSUM_BYTES>());
    let (Some(payload), Some(checked), Some(checksum)) =
        (bytes.get(header_len..payload_end), bytes.get(1..payload_end), checksum)
    else {
        return FrameStep::Partial;
    };
    let extra = checksum_extra(header.message_id);
    let known = extra.is_some();
    if let Some(extra) = extra {
        if calculate_crc(checked, extra) != u16::from_le_bytes(*checksum) {
            return FrameStep::BadCrc;
        }
    } else if !matches!(bytes.get(frame_len), None | Some(&(MAV_STX | MAV_STX_V2))) {
        return FrameStep::Stray;
    }
    FrameStep::Frame(Frame { header, payload, known }, frame_len)
}

/// Calls `frame` for every frame in `bytes`, and counts. Gives the bytes used; the rest may be the start of a frame.
fn scan(
    bytes: &[u8],
    counters: &mut EndpointCounters,
    mut frame: impl FnMut(&mut EndpointCounters, &Frame<'_>),
) -> usize {
    let mut rest = bytes;
    // One damaged frame is one error, however many markers are tried inside of it.
    let mut damaged = false;
    while !rest.is_empty() {
        match step(rest) {
            FrameStep::Frame(found, len) => {
                damaged = false;
                counters.frames_in += 1;
                counters.unknown += u64::from(!found.known);
                frame(counters, &found);
                rest = rest.get(len..).unwrap_or_default();
            }
            FrameStep::Partial => break,
            step => {
                if matches!(step, FrameStep::BadCrc) && !damaged {
                    counters.bad_crc += 1;
                    damaged = true;
                }
                let behind = rest.get(1..).unwrap_or_default();
                let skipped = behind
                    .iter()
                    .position(|&b| b == MAV_STX || b == MAV_STX_V2)
                    .unwrap_or(behind.len());
                counters.stray_bytes += 1 + skipped as u64;
                rest = behind.get(skipped..).unwrap_or_default();
            }
        }
    }
    bytes.len() - rest.len()
}

/// Calls `frame` for every frame in one datagram. A frame that the datagram's end cuts is counted, and what may be whole
/// behind its start is still found.
pub fn each_in_datagram(
    datagram: &[u8],
    counters: &mut EndpointCounters,
    mut frame: impl FnMut(&mut EndpointCounters, &Frame<'_>),
) {
    let mut rest = datagram;
    let mut truncated = false;
    loop {
        let used = scan(rest, counters, &mut frame);
        rest = rest.get(used..).unwrap_or_default();
        if rest.is_empty() {
            break;
        }
        truncated = true;
        counters.stray_bytes += 1;
        rest = rest.get(1..).unwrap_or_default();
    }
    counters.truncated += u64::from(truncated);
}

/// Bytes of a stream (TCP, serial) until they make whole frames.
#[derive(Debug)]
pub struct StreamBuffer {
    bytes: Box<[u8]>,
    len: usize,
}

impl Default for StreamBuffer {
    fn default() -> Self {
        Self {
            bytes: vec![0; 4 * MAX_DATAGRAM_BYTES].into_boxed_slice(),
            len: 0,
        }
    }
}

impl StreamBuffer {
    /// Where to read more bytes into; never empty.
    pub fn space(&mut self) -> &mut [u8] {
        self.bytes.get_mut(self.len..).unwrap_or_default()
    }

    /// Takes in `count` bytes that were read into [`Self::space`] and calls `frame` for every frame that is whole now.
    pub fn advance(
        &mut self,
        count: usize,
        counters: &mut EndpointCounters,
        frame: impl FnMut(&mut EndpointCounters, &Frame<'_>),
    ) {
        self.len = (self.len + count).min(self.bytes.len());
        let used = scan(self.bytes.get(..self.len).unwrap_or_default(), counters, frame);
        // At most the start of one frame is left over, so there is always space.
        self.bytes.copy_within(used..self.len, 0);
        self.len -= used;
    }

    /// Forgets what is left of a connection that broke.
    pub fn clear(&mut self) {
        self.len = 0;
    }
}

#[cfg(test)]
mod tests;
