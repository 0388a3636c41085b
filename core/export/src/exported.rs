//! What was written of a recording in another format.
//!
//! Must never do: leave out silently what could not be read.

use crate::told::Unread;
use skein_recording::Damage;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// What was written.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Exported {
    /// The files.
    pub files: Vec<PathBuf>,
    /// How much of each kind: rows of a table, points of a vehicle's track, messages of a topic, frames of a vehicle.
    pub counts: BTreeMap<String, u64>,
    /// Messages that are not what their topic says.
    pub unreadable: u64,
    /// Parts of the recording that could not be read.
    pub damage: Vec<Damage>,
}

impl Exported {
    pub(crate) fn count(&mut self, of: &str) {
        match self.counts.get_mut(of) {
            Some(count) => *count += 1,
            None => {
                self.counts.insert(of.to_owned(), 1);
            }
        }
    }

    pub(crate) fn without(mut self, unread: Unread) -> Self {
        self.unreadable += unread.messages;
        self.damage.extend(unread.damage);
        self
    }
}
