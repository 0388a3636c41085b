//! One MAVLink 2 frame per datagram, as PX4 sends them.

use mavlink::dialects::common::MavMessage;
use mavlink::{MAV_STX_V2, MAVLinkV2MessageRaw, MavHeader, MavlinkVersion, Message, calculate_crc};

const HEADER_BYTES: usize = 10;
const CHECKSUM_BYTES: usize = 2;
/// A datagram longer than any frame.
pub(crate) const DATAGRAM_BYTES: usize = 512;
/// The component id of an autopilot.
pub(crate) const AUTOPILOT_COMPONENT: u8 = 1;

/// A frame whose checksum is right.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame<'a> {
    pub system_id: u8,
    pub component_id: u8,
    pub message_id: u32,
    payload: &'a [u8],
}

impl<'a> Frame<'a> {
    /// The frame that a datagram begins with.
    pub fn of(datagram: &'a [u8]) -> Option<Self> {
        let &[MAV_STX_V2, length, _, _, _, system_id, component_id, a, b, c] =
            datagram.first_chunk::<HEADER_BYTES>()?
        else {
            return None;
        };
        let end = HEADER_BYTES + usize::from(length);
        let payload = datagram.get(HEADER_BYTES..end)?;
        let sum = datagram
            .get(end..end + CHECKSUM_BYTES)?
            .first_chunk::<CHECKSUM_BYTES>()?;
        let message_id = u32::from_le_bytes([a, b, c, 0]);
        let computed = calculate_crc(datagram.get(1..end)?, MavMessage::extra_crc(message_id));
        (computed == u16::from_le_bytes(*sum)).then_some(Self {
            system_id,
            component_id,
            message_id,
            payload,
        })
    }

    /// Its message.
    pub fn message(&self) -> Option<MavMessage> {
        MavMessage::parse(MavlinkVersion::V2, self.message_id, self.payload).ok()
    }
}

/// Counts and encodes the frames of one sender.
#[derive(Debug, Clone)]
pub(crate) struct Encoder {
    header: MavHeader,
}

impl Encoder {
    /// A sender of this identity.
    pub fn new(system_id: u8, component_id: u8) -> Self {
        Self {
            header: MavHeader {
                system_id: u32::from(system_id),
                component_id,
                sequence: 0,
            },
        }
    }

    /// A message as a frame; hands its bytes to `send`.
    pub fn encode<R>(&mut self, message: &MavMessage, send: impl FnOnce(&[u8]) -> R) -> R {
        let mut raw = MAVLinkV2MessageRaw::new();
        raw.serialize_message(self.header, message);
        self.header.sequence = self.header.sequence.wrapping_add(1);
        send(raw.raw_bytes())
    }
}

#[cfg(test)]
mod tests;
