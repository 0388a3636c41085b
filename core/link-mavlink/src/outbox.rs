//! Frames on their way out to one vehicle: encoded at once, one behind the other in one buffer that is used again.

use crate::frame::{checksum_extra, payload_len};
use mavlink::{MAV_STX_V2, MAVLinkV2MessageRaw, MavHeader, MessageData, calculate_crc};
use skein_domain::Refusal;

/// Encoded frames that wait to be sent. MAVLink 2 always: PX4 answers in it from the first such frame on.
#[derive(Debug, Default)]
pub struct Outbox {
    header: MavHeader,
    bytes: Vec<u8>,
    ends: Vec<usize>,
}

impl Outbox {
    /// An empty one for frames from this system and component.
    #[must_use]
    pub fn new(own_system_id: u8, own_component_id: u8) -> Self {
        let header = MavHeader {
            system_id: u32::from(own_system_id),
            component_id: own_component_id,
            sequence: 0,
        };
        Self {
            header,
            bytes: Vec::new(),
            ends: Vec::new(),
        }
    }

    /// Encodes a message behind those that wait.
    pub fn push<D: MessageData>(&mut self, message: &D) {
        let mut sender = self.header;
        self.push_from(&mut sender, message);
        self.header = sender;
    }

    /// The same as a message of another sender, who counts its own frames.
    pub fn push_from<D: MessageData>(&mut self, sender: &mut MavHeader, message: &D) {
        let mut raw = MAVLinkV2MessageRaw::new();
        raw.serialize_message_data(*sender, message);
        sender.sequence = sender.sequence.wrapping_add(1);
        self.bytes.extend_from_slice(raw.raw_bytes());
        self.ends.push(self.bytes.len());
    }

    /// Frames a payload that is encoded already, behind those that wait.
    ///
    /// # Errors
    /// If the message is not known here, so that its checksum cannot be made, or the payload is longer than the message.
    pub fn push_payload(&mut self, message_id: u32, payload: &[u8]) -> Result<(), Refusal> {
        let mut sender = self.header;
        self.push_payload_from(&mut sender, message_id, payload)?;
        self.header = sender;
        Ok(())
    }

    /// The same as a message of another sender, who counts its own frames.
    ///
    /// # Errors
    /// As [`Self::push_payload`].
    pub fn push_payload_from(
        &mut self,
        sender: &mut MavHeader,
        message_id: u32,
        payload: &[u8],
    ) -> Result<(), Refusal> {
        let (Some(extra), Some(longest)) = (checksum_extra(message_id), payload_len(message_id)) else {
            return Err(Refusal::not_supported(format!(
                "message {message_id} is not known to the link"
            )));
        };
        if payload.len() > longest {
            let len = payload.len();
            return Err(Refusal::invalid(format!(
                "message {message_id} has {longest} bytes at most, not {len}"
            )));
        }
        // MAVLink 2 sends no trailing zeroes, but one byte at least.
        let len = payload.iter().rposition(|byte| *byte != 0).map_or(1, |last| last + 1);
        let MavHeader {
            system_id,
            component_id,
            sequence,
        } = *sender;
        let [a, b, c, _] = message_id.to_le_bytes();
        let start = self.bytes.len();
        self.bytes.extend([
            MAV_STX_V2,
            len as u8,
            0,
            0,
            sequence,
            system_id as u8,
            component_id,
            a,
            b,
            c,
        ]);
        let sent = payload.iter().copied().chain(std::iter::once(0)).take(len);
        self.bytes.extend(sent);
        let checked = self.bytes.get(start + 1..).unwrap_or_default();
        let checksum = calculate_crc(checked, extra);
        self.bytes.extend(checksum.to_le_bytes());
        self.ends.push(self.bytes.len());
        sender.sequence = sequence.wrapping_add(1);
        Ok(())
    }

    /// Whether nothing waits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Calls `send` for each frame in order, and is empty then.
    pub fn drain(&mut self, mut send: impl FnMut(&[u8])) {
        let mut start = 0;
        for &end in &self.ends {
            if let Some(frame) = self.bytes.get(start..end) {
                send(frame);
            }
            start = end;
        }
        self.ends.clear();
        self.bytes.clear();
    }
}

#[cfg(test)]
mod tests;
