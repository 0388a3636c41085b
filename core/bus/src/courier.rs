//! Commands from node to node: each is delivered once, in the order in which its sender posted it, or its sender is told that it may not have been.
//!
//! Must never do: deliver a command twice or after a later one; hold on to more than its bounds; wait. Whoever calls it sends what is due.
//!
//! A node that starts again has another session, and everything of its former one is dropped: an order from before a restart is not
//! carried out after it.

use minicbor::{Decode, Encode};
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;
use thiserror::Error;

/// One run of a node, drawn at random when it starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Encode, Decode)]
#[cbor(transparent)]
pub struct Session(#[n(0)] pub u64);

/// One command on its way.
#[derive(Debug, Clone, PartialEq, Eq, Encode, Decode)]
pub struct Parcel {
    /// The run of the sender it belongs to.
    #[n(0)]
    pub session: Session,
    /// The run of the receiver it is meant for, once that is known: a command for a node's earlier run is of no use to the next.
    #[n(1)]
    pub to_session: Option<Session>,
    /// Counts from 1 per sender's run and receiver.
    #[n(2)]
    pub number: u64,
    /// Nothing before this number will come any more.
    #[n(3)]
    pub oldest: u64,
    /// The command.
    #[cbor(n(4), with = "minicbor::bytes")]
    pub body: Vec<u8>,
}

/// The receiver's answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Encode, Decode)]
pub struct Receipt {
    /// The sender's run it answers.
    #[n(0)]
    pub session: Session,
    /// The receiver's run.
    #[n(1)]
    pub from_session: Session,
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
            again_at_most_s: 0.5,
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
    session: Session,
    to_session: Option<Session>,
    last: u64,
    under_way: BTreeMap<u64, UnderWay>,
}

impl Outbox {
    /// An empty outbox for the node `to`.
    #[must_use]
    pub fn new(settings: CourierSettings, session: Session, to: NodeId) -> Self {
        Self {
            settings,
            to,
            session,
            to_session: None,
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

    /// The parcels to send now.
    pub fn due(&mut self, now: NodeTime) -> Vec<Parcel> {
        let oldest = self.oldest();
        let at_most_s = self.settings.again_at_most_s;
        let mut parcels = Vec::new();
        for (number, command) in &mut self.under_way {
            if now < command.next_try {
                continue;
            }
            command.next_try = now.plus_seconds(command.pause_s);
            command.pause_s = (command.pause_s * 2.0).min(at_most_s);
            parcels.push(Parcel {
                session: self.session,
                to_session: self.to_session,
                number: *number,
                oldest,
                body: command.body.clone(),
            });
        }
        parcels
    }

    /// Takes a receipt in. Gives the numbers that ended, with how.
    pub fn receipt(&mut self, receipt: &Receipt) -> Vec<(u64, Outcome)> {
        if receipt.session != self.session {
            return Vec::new();
        }
        let restarted = self.to_session.replace(receipt.from_session).is_some_and(|known| known != receipt.from_session);
        if restarted {
            // What was under way was for the run that has ended.
            return self.drain_before(u64::MAX, Outcome::NotAnswered);
        }
        self.drain_before(receipt.next, Outcome::Delivered)
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
    session: Session,
    most_held: usize,
    from: Option<Session>,
    /// Runs of the sender that have ended; newest last.
    former: Vec<Session>,
    next: u64,
    held: BTreeMap<u64, Vec<u8>>,
}

/// A sender's runs that are remembered as ended.
const FORMER_SESSIONS: usize = 8;

impl Inbox {
    /// An inbox of a node in this run. It holds as many commands back as may be under way.
    #[must_use]
    pub fn new(settings: CourierSettings, session: Session) -> Self {
        Self {
            session,
            most_held: settings.most_under_way,
            from: None,
            former: Vec::new(),
            next: 1,
            held: BTreeMap::new(),
        }
    }

    /// Takes a parcel in. Gives what can be delivered now, in order, and the receipt to send back; nothing for what is not meant for
    /// this run or comes from a run that has ended.
    pub fn take(&mut self, parcel: Parcel) -> Option<(Vec<Vec<u8>>, Receipt)> {
        if self.former.contains(&parcel.session) {
            return None;
        }
        if self.from != Some(parcel.session) {
            self.begin(parcel.session);
        }
        let mut deliverable = Vec::new();
        let meant = parcel.to_session.is_none_or(|to| to == self.session);
        if meant {
            self.give_up_before(parcel.oldest, &mut deliverable);
            if parcel.number >= self.next && self.held.len() < self.most_held {
                self.held.insert(parcel.number, parcel.body);
            }
            while let Some(body) = self.held.remove(&self.next) {
                deliverable.push(body);
                self.next += 1;
            }
        }
        let receipt = Receipt {
            session: parcel.session,
            from_session: self.session,
            next: self.next,
        };
        Some((deliverable, receipt))
    }

    fn begin(&mut self, session: Session) {
        self.former.extend(self.from);
        if self.former.len() > FORMER_SESSIONS {
            self.former.remove(0);
        }
        self.from = Some(session);
        self.next = 1;
        self.held.clear();
    }

    /// What the sender has given up is not waited for; what is held of it and before is delivered in order.
    fn give_up_before(&mut self, oldest: u64, deliverable: &mut Vec<Vec<u8>>) {
        if oldest <= self.next {
            return;
        }
        let kept = self.held.split_off(&oldest);
        deliverable.extend(std::mem::replace(&mut self.held, kept).into_values());
        self.next = oldest;
    }
}

#[cfg(test)]
mod tests;
