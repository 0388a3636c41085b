//! Frames: what can be found in a datagram, and how ours are written. Malformed input is skipped, never an error.
//!
//! Commands are read field by field: the generated types know only the commands of the dialect, and an autopilot must
//! answer "unsupported" to the others too.

use mavlink::dialects::common::{COMMAND_ACK_DATA, MavMessage};
use mavlink::{MAV_STX, MAV_STX_V2, MavHeader, MavlinkVersion, Message, MessageData, calculate_crc};

/// Who sent a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Sender {
    /// System id.
    pub system_id: u8,
    /// Component id.
    pub component_id: u8,
}

/// A received message.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Incoming {
    /// HEARTBEAT; all that matters is the sender's type.
    Heartbeat { vehicle_type: u8 },
    /// COMMAND_LONG, COMMAND_INT or SET_MODE.
    Command(CommandRequest),
    /// Any other.
    Other(Box<MavMessage>),
}

/// A command, from COMMAND_LONG or COMMAND_INT.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CommandRequest {
    /// Number of the command.
    pub command: u16,
    /// Addressed system; 0 = any.
    pub target_system: u8,
    /// Addressed component; 0 = any.
    pub target_component: u8,
    /// Parameters 1 to 4.
    pub param: [f32; 4],
    /// Parameters 5 and 6: as sent, or in degrees when it came as COMMAND_INT with a global frame.
    pub x: f64,
    /// See `x`.
    pub y: f64,
    /// Parameter 7. Altitudes are above mean sea level whatever the frame says: PX4 does not look at it.
    pub z: f64,
}

/// Finds the frames in a datagram (or any run of bytes) and gives every readable message to `each`.
pub(crate) fn read_frames(mut bytes: &[u8], mut each: impl FnMut(Sender, Incoming)) {
    while let Some(start) = bytes.iter().position(|b| matches!(*b, MAV_STX | MAV_STX_V2)) {
        bytes = bytes.get(start..).unwrap_or_default();
        let used = match read_frame(bytes) {
            Some((used, sender, message)) => {
                if let Some(message) = message {
                    each(sender, message);
                }
                used
            }
            // Not a frame after all: a start marker inside the rest may be the real one.
            None => 1,
        };
        bytes = bytes.get(used..).unwrap_or_default();
    }
}

/// Reads the frame at the start of `bytes`; `None` if there is no whole frame with a correct checksum.
fn read_frame(bytes: &[u8]) -> Option<(usize, Sender, Option<Incoming>)> {
    let length = usize::from(*bytes.get(1)?);
    let (version, header, id, sender_at, trailer) = if *bytes.first()? == MAV_STX_V2 {
        let flags = *bytes.get(2)?;
        if flags & !1 != 0 {
            return None;
        }
        let id = u32::from_le_bytes([*bytes.get(7)?, *bytes.get(8)?, *bytes.get(9)?, 0]);
        (MavlinkVersion::V2, 10, id, 5, if flags & 1 == 1 { 13 } else { 0 })
    } else {
        (MavlinkVersion::V1, 6, u32::from(*bytes.get(5)?), 3, 0)
    };
    let payload = bytes.get(header..header + length)?;
    let crc = bytes.get(header + length..header + length + 2)?;
    let computed = calculate_crc(bytes.get(1..header + length)?, MavMessage::extra_crc(id));
    if crc != computed.to_le_bytes() {
        return None;
    }
    let sender = Sender {
        system_id: *bytes.get(sender_at)?,
        component_id: *bytes.get(sender_at + 1)?,
    };
    Some((header + length + 2 + trailer, sender, decode(version, id, payload)))
}

/// Decodes a payload; `None` for a message this autopilot does not know.
fn decode(version: MavlinkVersion, id: u32, payload: &[u8]) -> Option<Incoming> {
    let fields = Fields(payload);
    match id {
        0 => Some(Incoming::Heartbeat {
            vehicle_type: fields.byte(4),
        }),
        11 => Some(Incoming::Command(set_mode(&fields))),
        75 => Some(Incoming::Command(command_int(&fields))),
        76 => Some(Incoming::Command(command_long(&fields))),
        _ => MavMessage::parse(version, id, payload)
            .ok()
            .map(|m| Incoming::Other(Box::new(m))),
    }
}

fn command_long(fields: &Fields<'_>) -> CommandRequest {
    CommandRequest {
        command: fields.word(28),
        target_system: fields.byte(30),
        target_component: fields.byte(31),
        param: [fields.float(0), fields.float(4), fields.float(8), fields.float(12)],
        x: f64::from(fields.float(16)),
        y: f64::from(fields.float(20)),
        z: f64::from(fields.float(24)),
    }
}

/// SET_MODE is answered like the command that has taken its place.
fn set_mode(fields: &Fields<'_>) -> CommandRequest {
    let (main, sub) = (fields.byte(2), fields.byte(3));
    CommandRequest {
        command: 176,
        target_system: fields.byte(4),
        target_component: 0,
        param: [f32::from(fields.byte(5)), f32::from(main), f32::from(sub), 0.0],
        x: 0.0,
        y: 0.0,
        z: 0.0,
    }
}

fn command_int(fields: &Fields<'_>) -> CommandRequest {
    let frame = fields.byte(32);
    // Global frames carry degrees times ten million; the smallest integer stands for "not given".
    let coordinate = |at: usize| {
        let raw = fields.integer(at);
        if raw == i32::MIN || raw == i32::MAX {
            f64::NAN
        } else if matches!(frame, 0 | 3 | 5 | 6 | 10 | 11) {
            f64::from(raw) * 1e-7
        } else {
            f64::from(raw) * 1e-4
        }
    };
    CommandRequest {
        command: fields.word(28),
        target_system: fields.byte(30),
        target_component: fields.byte(31),
        param: [fields.float(0), fields.float(4), fields.float(8), fields.float(12)],
        x: coordinate(16),
        y: coordinate(20),
        z: f64::from(fields.float(24)),
    }
}

/// Little-endian fields of a payload; bytes past its end count as zero, as MAVLink 2 cuts them off.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn byte(&self, at: usize) -> u8 {
        self.0.get(at).copied().unwrap_or(0)
    }

    fn word(&self, at: usize) -> u16 {
        u16::from_le_bytes([self.byte(at), self.byte(at + 1)])
    }

    fn bytes4(&self, at: usize) -> [u8; 4] {
        [self.byte(at), self.byte(at + 1), self.byte(at + 2), self.byte(at + 3)]
    }

    fn float(&self, at: usize) -> f32 {
        f32::from_le_bytes(self.bytes4(at))
    }

    fn integer(&self, at: usize) -> i32 {
        i32::from_le_bytes(self.bytes4(at))
    }
}

/// COMMAND_ACK with any command number, known to the dialect or not.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Acknowledgement {
    /// Number of the command.
    pub command: u16,
    /// MAV_RESULT.
    pub result: u8,
    /// Who asked.
    pub to: Sender,
}

impl MessageData for Acknowledgement {
    type Message = MavMessage;
    const ID: u32 = COMMAND_ACK_DATA::ID;
    const NAME: &'static str = COMMAND_ACK_DATA::NAME;
    const EXTRA_CRC: u8 = COMMAND_ACK_DATA::EXTRA_CRC;
    const ENCODED_LEN: usize = COMMAND_ACK_DATA::ENCODED_LEN;

    fn ser(&self, _version: MavlinkVersion, payload: &mut [u8]) -> usize {
        let [low, high] = self.command.to_le_bytes();
        let fields = [
            low,
            high,
            self.result,
            0,
            0,
            0,
            0,
            0,
            self.to.system_id,
            self.to.component_id,
        ];
        for (to, from) in payload.iter_mut().zip(fields) {
            *to = from;
        }
        fields.iter().rposition(|b| *b != 0).map_or(1, |last| last + 1)
    }

    fn deser(version: MavlinkVersion, payload: &[u8]) -> Result<Self, mavlink::error::ParserError> {
        let ack = COMMAND_ACK_DATA::deser(version, payload)?;
        let to = Sender {
            system_id: ack.target_system,
            component_id: ack.target_component,
        };
        Ok(Self {
            command: ack.command as u16,
            result: ack.result as u8,
            to,
        })
    }
}

/// Appends one MAVLink 2 frame to `out`.
pub(crate) fn write_frame<M: MessageData>(out: &mut Vec<u8>, header: MavHeader, message: &M) {
    let mut raw = mavlink::MAVLinkV2MessageRaw::new();
    raw.serialize_message_data(header, message);
    out.extend_from_slice(raw.raw_bytes());
}

#[cfg(test)]
mod tests;
