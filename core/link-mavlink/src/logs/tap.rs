//! What an autopilot says of its logs, kept until it is taken.
//!
//! Must never do: keep more than [`MOST`] messages: what is beyond that is asked for again.

use mavlink::dialects::common::{LOG_DATA_DATA, LOG_ENTRY_DATA};
use mavlink::{MavlinkVersion, MessageData};
use parking_lot::Mutex;
use skein_domain::link::MessageTap;
use skein_domain::payload::MavlinkMessage;
use std::collections::VecDeque;

/// Two windows of a transfer.
const MOST: usize = 2_048;

/// Something that was heard.
#[derive(Debug, Clone)]
pub enum Heard {
    /// A log that there is.
    Entry(LOG_ENTRY_DATA),
    /// A piece of one.
    Data(LOG_DATA_DATA),
}

/// Hears it.
#[derive(Debug, Default)]
pub struct Tap(Mutex<VecDeque<Heard>>);

impl Tap {
    /// What was heard since the last call.
    pub fn take(&self) -> VecDeque<Heard> {
        std::mem::take(&mut *self.0.lock())
    }
}

impl MessageTap for Tap {
    fn wants(&self, message_id: u32) -> bool {
        [LOG_ENTRY_DATA::ID, LOG_DATA_DATA::ID].contains(&message_id)
    }

    fn take(&self, message: MavlinkMessage) {
        let (version, payload) = (MavlinkVersion::V2, &message.payload);
        let heard = match message.message_id {
            LOG_ENTRY_DATA::ID => LOG_ENTRY_DATA::deser(version, payload).ok().map(Heard::Entry),
            LOG_DATA_DATA::ID => LOG_DATA_DATA::deser(version, payload).ok().map(Heard::Data),
            _ => None,
        };
        let mut kept = self.0.lock();
        if kept.len() < MOST {
            kept.extend(heard);
        }
    }
}
