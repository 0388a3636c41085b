//! Frames on their way out to one vehicle: encoded at once, one behind the other in one buffer that is used again.

use mavlink::{MAVLinkV2MessageRaw, MavHeader, MessageData};

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
        let mut raw = MAVLinkV2MessageRaw::new();
        raw.serialize_message_data(self.header, message);
        self.header.sequence = self.header.sequence.wrapping_add(1);
        self.bytes.extend_from_slice(raw.raw_bytes());
        self.ends.push(self.bytes.len());
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
