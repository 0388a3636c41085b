//! Commands from node to node: each is delivered once, in the order in which its sender posted it, or its sender is told that it may not have been.
//!
//! Must never do: deliver a command twice or after a later one; hold on to more than its bounds; wait. Whoever calls it sends what is due.
//!
//! A node that starts again has another boot, and everything of its former one is dropped: an order from before a restart is not
//! carried out after it.

use crate::envelope::Boot;
use minicbor::{Decode, Encode};
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;
use thiserror::Error;

/// One command on its way.
#[derive(Debug, Clone, PartialEq, Eq, Encode, Decode)]
pub struct Parcel {
    /// The run of the sender it belongs to.
    #[n(0)]
    pub boot: Boot,
    /// The run of the receiver it is meant for, once that is known: a command for a node's earlier run is of no use to the next.
    #[n(1)]
    pub to_boot: Option<Boot>,
    /// Counts from 1 per sender's run and receiver.
    #[n(2)]
    pub number: u64,
    /// Nothing before this number will come any more.
    #[n(3)]
    pub oldest: u64,
    /// The command.
    #[cbor(n(4), with = "minicbor::bytes")]
    pub body: Vec<u8>,
    /// How long its sender will still wait for a receipt, in milliseconds: the receiver keeps it back no longer than that.
    #[n(5)]
    pub left_ms: u32,
}

/// The receiver's answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Encode, Decode)]
pub struct Receipt {
    /// The sender's run it answers.
    #[n(0)]
    pub boot: Boot,
    /// The receiver's run.
    #[n(1)]
    pub from_boot: Boot,
    /// All before this number have been delivered or given up.
    #[n(2)]
    pub next: u64,
}

/// Limits of a courier.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CourierSettings {
    /// An unanswered parcel is sent again after so long, in seconds; then after twice as long, and so on up to [`Self::again_at_most_s`].
    pub again_after_s: f64,
    /// The longest time between two tries, in seconds.
    pub again_at_most_s: f64,
    /// A command without a receipt is given up after so long, in seconds: an order that comes late does harm.
    pub give_up_after_s: f64,
    /// How many commands for one node may be under way.
    pub most_under_way: usize,
}

impl Default for CourierSettings {
    fn default() -> Self {
        Self {
            again_after_s: 0.1,
            again_at_most_s: 0.3,
            give_up_after_s: 3.0,
            most_under_way: 64,
        }
    }
}

/// Too many commands for one node are under way: it does not answer, or is asked too much.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("{under_way} commands for node {to} are under way already")]
pub struct Crowded {
    /// For whom.
    pub to: NodeId,
    /// How many.
    pub under_way: usize,
}

/// How a command ended, for its sender.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The receiver has it.
    Delivered,
    /// No receipt came in time. It may have arrived all the same.
    NotAnswered,
}

#[derive(Debug)]
struct UnderWay {
    body: Vec<u8>,
    posted: NodeTime,
    next_try: NodeTime,
    pause_s: f64,
}

/// What one node has sent to one other and not had a receipt for.
#[derive(Debug)]
pub struct Outbox {
    settings: CourierSettings,
    to: NodeId,
    boot: Boot,
    to_boot: Option<Boot>,
    last: u64,
    under_way: BTreeMap<u64, UnderWay>,
}

impl Outbox {
    /// An empty outbox for the node `to`.
    #[must_use]
    pub fn new(settings: CourierSettings, boot: Boot, to: NodeId) -> Self {
        Self {
            settings,
            to,
            boot,
            to_boot: None,
            last: 0,
            under_way: BTreeMap::new(),
        }
    }

    /// Takes a command in; it is due at once. Gives its number.
    ///
    /// # Errors
    ///
    /// As many as may be are under way.
    pub fn post(&mut self, now: NodeTime, body: Vec<u8>) -> Result<u64, Crowded> {
        let under_way = self.under_way.len();
        if under_way >= self.settings.most_under_way {
            return Err(Crowded { to: self.to, under_way });
        }
        self.last += 1;
        let command = UnderWay {
            body,
            posted: now,
            next_try: now,
            pause_s: self.settings.again_after_s,
        };
        self.under_way.insert(self.last, command);
        Ok(self.last)
    }

    /// The next parcel to send now, if one is due: the oldest of them.
    pub fn next(&mut self, now: NodeTime) -> Option<Parcel> {
        let oldest = self.oldest();
        let CourierSettings {
            again_at_most_s,
            give_up_after_s,
            ..
        } = self.settings;
        let (number, command) = self.under_way.iter_mut().find(|(_, command)| now >= command.next_try)?;
        command.next_try = now.plus_seconds(command.pause_s);
        command.pause_s = (command.pause_s * 2.0).min(again_at_most_s);
        let left_s = give_up_after_s - now.seconds_since(command.posted);
        Some(Parcel {
            boot: self.boot,
            to_boot: self.to_boot,
            number: *number,
            oldest,
            body: command.body.clone(),
            left_ms: (left_s * 1e3).max(0.0) as u32,
        })
    }

    /// Whether anything is due.
    #[must_use]
    pub fn is_due(&self, now: NodeTime) -> bool {
        self.under_way.values().any(|command| now >= command.next_try)
    }

    /// Takes a receipt in. Gives the numbers that ended, with how.
    pub fn receipt(&mut self, now: NodeTime, receipt: &Receipt) -> Vec<(u64, Outcome)> {
        if receipt.boot != self.boot {
            return Vec::new();
        }
        // First of all: the receiver does not carry out what has been given up, and says all the same that it is past it.
        let mut ended = self.expire(now);
        ended.extend(self.met(receipt.from_boot));
        ended.extend(self.drain_before(receipt.next, Outcome::Delivered));
        ended
    }

    /// The receiver is in this run now. What was under way for an earlier run ends.
    pub fn met(&mut self, to_boot: Boot) -> Vec<(u64, Outcome)> {
        let restarted = self.to_boot.replace(to_boot).is_some_and(|known| known != to_boot);
        if restarted {
            return self.drain_before(u64::MAX, Outcome::NotAnswered);
        }
        Vec::new()
    }

    /// Gives up what has waited too long.
    pub fn expire(&mut self, now: NodeTime) -> Vec<(u64, Outcome)> {
        let limit_s = self.settings.give_up_after_s;
        let first_kept = self
            .under_way
            .iter()
            .find(|(_, command)| now.seconds_since(command.posted) < limit_s)
            .map_or(u64::MAX, |(number, _)| *number);
        self.drain_before(first_kept, Outcome::NotAnswered)
    }

    fn drain_before(&mut self, number: u64, outcome: Outcome) -> Vec<(u64, Outcome)> {
        let kept = self.under_way.split_off(&number);
        let ended = std::mem::replace(&mut self.under_way, kept);
        ended.into_keys().map(|number| (number, outcome)).collect()
    }

    fn oldest(&self) -> u64 {
        self.under_way.keys().next().copied().unwrap_or(self.last + 1)
    }
}

/// What one node has received of one other.
#[derive(Debug)]
pub struct Inbox {
    boot: Boot,
    most_held: usize,
    from: Option<Boot>,
    /// Runs of the sender that have ended; newest last.
    former: Vec<Boot>,
    next: u64,
    held: BTreeMap<u64, Held>,
}

/// A command that waits for one before it.
#[derive(Debug)]
struct Held {
    body: Vec<u8>,
    until: NodeTime,
}

/// A sender's runs that are remembered as ended.
const FORMER_BOOTS: usize = 8;

impl Inbox {
    /// An inbox of a node in this run. It holds as many commands back as may be under way.
    #[must_use]
    pub fn new(settings: CourierSettings, boot: Boot) -> Self {
        Self {
            boot,
            most_held: settings.most_under_way,
            from: None,
            former: Vec::new(),
            next: 1,
            held: BTreeMap::new(),
        }
    }

    /// Takes a parcel in. Gives what can be delivered now, in order, and the receipt to send back; nothing for what comes from a run that
    /// has ended. What is not meant for this run is not delivered; its receipt says so.
    pub fn take(&mut self, now: NodeTime, parcel: Parcel) -> Option<(Vec<Vec<u8>>, Receipt)> {
        if self.former.contains(&parcel.boot) {
            return None;
        }
        if self.from != Some(parcel.boot) {
            self.begin(parcel.boot);
        }
        let mut deliverable = Vec::new();
        if parcel.to_boot.is_none_or(|to| to == self.boot) {
            self.give_up_before(parcel.oldest);
            let room = self.held.len() < self.most_held || parcel.number == self.next;
            if parcel.number >= self.next && room {
                let until = now.plus_seconds(f64::from(parcel.left_ms) * 1e-3);
                let body = parcel.body;
                self.held.insert(parcel.number, Held { body, until });
            }
            while let Some(held) = self.held.remove(&self.next) {
                // One that has waited for so long has been given up by its sender.
                if now <= held.until {
                    deliverable.push(held.body);
                }
                self.next = self.next.saturating_add(1);
            }
        }
        let receipt = Receipt {
            boot: parcel.boot,
            from_boot: self.boot,
            next: self.next,
        };
        Some((deliverable, receipt))
    }

    fn begin(&mut self, boot: Boot) {
        self.former.extend(self.from);
        if self.former.len() > FORMER_BOOTS {
            self.former.remove(0);
        }
        self.from = Some(boot);
        self.next = 1;
        self.held.clear();
    }

    /// What the sender has given up is not waited for, and not delivered if it is here: the sender has been told that it was not.
    fn give_up_before(&mut self, oldest: u64) {
        if oldest > self.next {
            self.held = self.held.split_off(&oldest);
            self.next = oldest;
        }
    }
}

#[cfg(test)]
mod tests;
