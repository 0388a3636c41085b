//! Where the MAVLink messages that a payload wants to see wait for its next batch.
//!
//! Bound: a fixed number of messages; the oldest goes first. Must never do: block the link that fills it.

use parking_lot::Mutex;
use skein_domain::link::MessageTap;
use skein_domain::payload::MavlinkMessage;
use std::collections::{BTreeSet, VecDeque};

/// Messages kept: more than a device sends in a second.
const KEPT: usize = 256;

/// The queue.
pub struct Tap {
    wanted: BTreeSet<u32>,
    queue: Mutex<VecDeque<MavlinkMessage>>,
}

impl Tap {
    /// For messages with these ids.
    pub fn new(wanted: BTreeSet<u32>) -> Self {
        Self {
            wanted,
            queue: Mutex::default(),
        }
    }

    /// Which messages it is for.
    pub fn wanted(&self) -> &BTreeSet<u32> {
        &self.wanted
    }

    /// What arrived since last asked, oldest first.
    pub fn drain(&self) -> Vec<MavlinkMessage> {
        self.queue.lock().drain(..).collect()
    }
}

impl MessageTap for Tap {
    fn wants(&self, message_id: u32) -> bool {
        self.wanted.contains(&message_id)
    }

    fn take(&self, message: MavlinkMessage) {
        let mut queue = self.queue.lock();
        if queue.len() == KEPT {
            queue.pop_front();
        }
        queue.push_back(message);
    }
}
