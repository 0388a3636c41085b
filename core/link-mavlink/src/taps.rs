//! Who else wants to see a vehicle's messages: payloads of it, each with the ids it wants.
//!
//! Must never do: keep a payload alive, copy a message nobody wants, or give one whose checksum was not right.

use crate::frame::Frame;
use skein_domain::link::MessageTap;
use skein_domain::payload::MavlinkMessage;
use std::fmt;
use std::sync::Weak;

/// The taps of one link.
#[derive(Default)]
pub(crate) struct Taps {
    taps: Vec<Weak<dyn MessageTap>>,
}

impl fmt::Debug for Taps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Taps").field("taps", &self.taps.len()).finish()
    }
}

impl Taps {
    /// One more; those whose payload is gone are forgotten.
    pub(crate) fn add(&mut self, tap: Weak<dyn MessageTap>) {
        self.forget_gone();
        self.taps.push(tap);
    }

    /// Gives a message to those that want it; true if there is one.
    pub(crate) fn give(&mut self, frame: &Frame<'_>) -> bool {
        if self.taps.is_empty() || !frame.known {
            return false;
        }
        let header = &frame.header;
        let (mut wanted, mut gone) = (false, false);
        for tap in &self.taps {
            let Some(tap) = tap.upgrade() else {
                gone = true;
                continue;
            };
            if tap.wants(header.message_id) {
                wanted = true;
                tap.take(MavlinkMessage {
                    system_id: header.system_id,
                    component_id: header.component_id,
                    message_id: header.message_id,
                    payload: frame.payload.to_vec(),
                });
            }
        }
        if gone {
            self.forget_gone();
        }
        wanted
    }

    fn forget_gone(&mut self) {
        self.taps.retain(|tap| tap.strong_count() > 0);
    }
}
