//! Whom a vehicle obeys at this moment, and what it does when there is nobody.
//!
//! Must never do: decide how a vehicle holds or returns; that is its failsafe policy's. Say that a silent holder is obeyed without saying since when it is silent.

use crate::{LeaderMonitor, Leadership, Term};
use serde::{Deserialize, Serialize};
use skein_domain::NodeTime;

/// What a vehicle does that no coordinator reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reaction {
    /// It goes on with the last intent.
    #[default]
    Keep,
    /// It holds its position.
    Hold,
    /// It returns to where it started.
    Return,
}

/// When a vehicle reacts to having no coordinator, and how.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Unled {
    /// How long the last intent goes on, in seconds since the holder's last new pulse. Longer than a succession takes.
    pub after_s: f64,
    /// What is done then.
    pub reaction: Reaction,
}

impl Default for Unled {
    /// The last intent goes on: it can be flown without a coordinator, and a vehicle that stops in a formation is in the others' way.
    fn default() -> Self {
        Self {
            after_s: 5.0,
            reaction: Reaction::Keep,
        }
    }
}

/// Whom a node obeys, as it is to be shown and as a vehicle acts on it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum LeaderState {
    /// Nobody yet.
    Nobody,
    /// The holder of this term, of whom there are new pulses.
    Led {
        /// Its term.
        term: Term,
    },
    /// The holder of this term, who is silent. Its last intent goes on; a successor is awaited.
    Awaiting {
        /// Its term.
        term: Term,
        /// For how long, in seconds.
        silent_s: f64,
    },
    /// The holder of this term has been silent for so long that the configured reaction is due.
    Unled {
        /// Its term.
        term: Term,
        /// For how long, in seconds.
        silent_s: f64,
        /// What to do.
        reaction: Reaction,
    },
}

impl LeaderMonitor {
    /// Whom this node obeys now, and what it is to do if that one is gone. A node that coordinates is led by itself.
    #[must_use]
    pub fn leader_state(&self, now: NodeTime, leadership: &Leadership, unled: &Unled) -> LeaderState {
        let Some(term) = leadership.obeyed() else {
            return LeaderState::Nobody;
        };
        // Before the first look at a stored term it has been silent since the monitor began.
        let silent_s = self.silent_s(now).unwrap_or_else(|| self.watched_s(now));
        if leadership.acting().is_some() || silent_s <= self.lost_after_s() {
            LeaderState::Led { term }
        } else if silent_s <= unled.after_s {
            LeaderState::Awaiting { term, silent_s }
        } else {
            let reaction = unled.reaction;
            LeaderState::Unled {
                term,
                silent_s,
                reaction,
            }
        }
    }
}

#[cfg(test)]
mod tests;
