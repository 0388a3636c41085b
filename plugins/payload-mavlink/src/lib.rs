//! How the plugin of a payload speaks MAVLink: messages in and out, and commands that are acknowledged and asked again.
//!
//! Must never do: I/O, read a clock, or believe an acknowledgement that answers somebody else.
#![forbid(unsafe_code)]

mod requests;
#[cfg(feature = "rig")]
pub mod rig;

pub use requests::{Outcome, Patience, Requests};

use mavlink::{MavlinkVersion, MessageData};
use skein_domain::payload::MavlinkMessage;
use skein_plugin_sdk::Effects;

/// Longest payload of a MAVLink message in bytes.
const LONGEST_PAYLOAD: usize = 255;

/// The message, if it is one of this kind and can be read.
#[must_use]
pub fn decode<M: MessageData>(message: &MavlinkMessage) -> Option<M> {
    if message.message_id != M::ID || message.payload.len() > LONGEST_PAYLOAD {
        return None;
    }
    M::deser(MavlinkVersion::V2, &message.payload).ok()
}

/// The payload of a message as it stands on the wire.
#[must_use]
pub fn encode<M: MessageData>(message: &M) -> Vec<u8> {
    let mut bytes = vec![0; LONGEST_PAYLOAD];
    let len = message.ser(MavlinkVersion::V2, &mut bytes);
    bytes.truncate(len);
    bytes
}

/// Sends a message to the vehicle's system.
pub fn send<M: MessageData>(message: &M, effects: &mut Effects) {
    effects.mavlink(M::ID, encode(message));
}

/// What a text field of fixed length says: up to its first zero, without blanks around it.
#[must_use]
pub fn text(field: &[u8]) -> String {
    let end = field.iter().position(|byte| *byte == 0).unwrap_or(field.len());
    let said = field.get(..end).unwrap_or_default();
    String::from_utf8_lossy(said).trim().to_owned()
}

#[cfg(test)]
mod tests;
