//! One node's end of the swarm bus: all classes of traffic, sealed, over datagrams that promise nothing.
//!
//! Must never do: I/O, read a clock, wait. What arrives is given to [`Bus::take`]; what is to be sent comes from [`Bus::next`], the most urgent
//! first and within the budget.

use crate::budget::{Budget, BudgetSettings, Traffic};
use crate::bulk::{BulkError, BulkSettings, Have, Receiving, Sending};
use crate::courier::{CourierSettings, Crowded, Inbox, Outbox, Outcome, Receipt};
use crate::envelope::{Boot, ENVELOPE_BYTES, Refused, SecureEnvelope, SwarmKey};
use crate::latest::{ENTRY_BYTES, Heard, Key, StateError, StateSettings, Telling};
use crate::links::{Link, LinkSettings, Links, Rates};
use crate::query::{Asking, QueryAnswer, QuerySettings, TooManyOpen};
use crate::transport::{Class, SendError, To, Transport};
use crate::video::{Pushed, VideoPicture, VideoReceiving, VideoSending};
use crate::wire::FRAME_BYTES;
use skein_domain::{NodeId, NodeTime};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use thiserror::Error;

mod incoming;
mod outgoing;

/// Limits of all classes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BusSettings {
    /// The largest datagram of the transport, in bytes.
    pub datagram_bytes: usize,
    /// Of state.
    pub state: StateSettings,
    /// Of commands.
    pub courier: CourierSettings,
    /// Of questions.
    pub query: QuerySettings,
    /// Of bulk.
    pub bulk: BulkSettings,
    /// Of all that is sent, at most.
    pub budget: BudgetSettings,
    /// The transport sends what is for all to each by itself: it counts as often.
    pub sends_to_each: bool,
    /// How links are measured, and the rate with them.
    pub links: LinkSettings,
}

impl Default for BusSettings {
    fn default() -> Self {
        Self {
            datagram_bytes: 1400,
            state: StateSettings::default(),
            courier: CourierSettings::default(),
            query: QuerySettings::default(),
            bulk: BulkSettings::default(),
            budget: BudgetSettings::default(),
            sends_to_each: false,
            links: LinkSettings::default(),
        }
    }
}

/// Something that does not fit into one datagram, though its class has no chunks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("{bytes} bytes are more than the {most} that fit into one datagram")]
pub struct TooLarge {
    /// Its size.
    pub bytes: usize,
    /// The largest.
    pub most: usize,
}

/// Why a command is not posted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum PostError {
    /// It is too large.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// Too many are under way.
    #[error(transparent)]
    Crowded(#[from] Crowded),
}

/// Why a question is not asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum AskError {
    /// It is too large.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// Too many are open.
    #[error(transparent)]
    TooMany(#[from] TooManyOpen),
}

/// Where an answer goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Ticket {
    /// Who asks.
    pub from: NodeId,
    /// The asker's number of the question.
    pub id: u64,
}

/// What has happened on the bus.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event {
    /// A node is there, in a run that was not known before.
    Joined {
        /// Which.
        node: NodeId,
        /// Its run.
        boot: Boot,
    },
    /// A value of another node is now so.
    State {
        /// Whose.
        from: NodeId,
        /// Which.
        key: Key,
        /// The value.
        value: Vec<u8>,
    },
    /// A command of another node: the next of it.
    Command {
        /// Whose.
        from: NodeId,
        /// The command.
        body: Vec<u8>,
    },
    /// A command of this node has ended.
    CommandEnded {
        /// For whom it was.
        to: NodeId,
        /// Its number.
        number: u64,
        /// How.
        outcome: Outcome,
    },
    /// Another node asks something; it may do so more than once.
    Asked {
        /// Where the answer goes.
        ticket: Ticket,
        /// The question.
        body: Vec<u8>,
    },
    /// The answer to a question of this node.
    Answered {
        /// The question's number.
        id: u64,
        /// Who answers.
        from: NodeId,
        /// The answer.
        body: Vec<u8>,
    },
    /// There was no answer before the deadline.
    Unanswered {
        /// The question's number.
        id: u64,
        /// Who was asked.
        to: NodeId,
    },
    /// Something large has come whole.
    Bulk {
        /// Of whom.
        from: NodeId,
        /// The thing.
        body: Vec<u8>,
    },
    /// A picture of a video has come whole.
    Video {
        /// Of whom.
        from: NodeId,
        /// The picture.
        picture: VideoPicture,
    },
    /// A receiver of this node's video cannot go on without a key picture.
    VideoKeyWanted {
        /// Who.
        by: NodeId,
        /// Its number of the stream.
        stream: u32,
    },
    /// Something large of this node has ended.
    BulkEnded {
        /// For whom it was.
        to: NodeId,
        /// Its number.
        id: u64,
        /// Whether it is there whole.
        whole: bool,
    },
}

/// A datagram to be sent now.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outgoing {
    /// For whom.
    pub to: To,
    /// Its class.
    pub class: Class,
    /// Sealed.
    pub bytes: Vec<u8>,
}

/// Answers and receipts that wait to be sent; of more the oldest is dropped, which its asker makes good.
const MOST_REPLIES: usize = 1024;

/// The share of what may be sent that goes to values which have not changed of late: who joins learns them from that, gradually.
const RESTING_SHARE: f64 = 0.25;
/// The share of what bulk may send that video may: pictures and logs go on beside it.
const VIDEO_SHARE: f64 = 0.85;
/// Video may be sent at once for so long, in seconds: a key picture is not to wait for its last parts.
const VIDEO_BURST_S: f64 = 0.03;
/// No burst is longer than what may be sent in this time, in seconds, but for a few datagrams.
const LONGEST_BURST_S: f64 = 0.5;

/// One node's end of the bus.
#[derive(Debug)]
pub struct Bus {
    settings: BusSettings,
    me: NodeId,
    boot: Boot,
    seal: SecureEnvelope,
    telling: Telling,
    heard: Heard,
    outboxes: BTreeMap<NodeId, Outbox>,
    inboxes: BTreeMap<NodeId, Inbox>,
    asking: Asking,
    sending: Sending,
    receiving: Receiving,
    budget: Budget,
    /// Of bulk alone, within the other one.
    bulk_budget: Budget,
    /// Of video alone, within the other one.
    video_budget: Budget,
    /// Of values that have not changed of late, within the other one.
    resting_budget: Budget,
    video_sending: VideoSending,
    video_receiving: VideoReceiving,
    links: Links,
    /// Challenges and proofs, sealed already.
    proofs: VecDeque<(NodeId, Vec<u8>)>,
    receipts: BTreeMap<NodeId, Receipt>,
    answers: VecDeque<(NodeId, QueryAnswer)>,
    haves: VecDeque<(NodeId, Have)>,
    /// Of whom this node lacks bases, and of which keys.
    lacking: BTreeMap<NodeId, BTreeSet<Key>>,
    sent: Traffic,
    received: BTreeMap<NodeId, Traffic>,
    not_understood: u64,
}

impl Bus {
    /// For a run of the node `me`; `boot` must be drawn at random.
    #[must_use]
    pub fn new(settings: BusSettings, key: SwarmKey, me: NodeId, boot: Boot, now: NodeTime) -> Self {
        let mut budget = settings.budget;
        // Bulk leaves half of the burst to the others; a datagram of it must fit into the other half.
        // On a slow link a long burst is a long wait for everybody else.
        let long_bytes = budget.bytes_per_s * LONGEST_BURST_S;
        budget.burst_bytes = budget
            .burst_bytes
            .min(long_bytes)
            .max(4.0 * settings.datagram_bytes as f64);
        // Short bursts: a datagram of bulk is long on the air, and others wait for it.
        let bulk_budget = BudgetSettings {
            burst_bytes: 2.0 * settings.datagram_bytes as f64,
            ..budget
        };
        let video_bytes_per_s = budget.bytes_per_s * VIDEO_SHARE;
        let video_budget = BudgetSettings {
            bytes_per_s: video_bytes_per_s,
            burst_bytes: (video_bytes_per_s * VIDEO_BURST_S).max(bulk_budget.burst_bytes),
        };
        let resting_budget = BudgetSettings {
            bytes_per_s: budget.bytes_per_s * RESTING_SHARE,
            ..bulk_budget
        };
        Self {
            settings,
            me,
            boot,
            seal: SecureEnvelope::new(key, me, boot),
            telling: Telling::new(settings.state),
            heard: Heard::default(),
            outboxes: BTreeMap::new(),
            inboxes: BTreeMap::new(),
            asking: Asking::new(settings.query),
            sending: Sending::new(settings.bulk),
            receiving: Receiving::new(settings.bulk),
            budget: Budget::new(budget, now),
            bulk_budget: Budget::new(bulk_budget, now),
            video_budget: Budget::new(video_budget, now),
            resting_budget: Budget::new(resting_budget, now),
            video_sending: VideoSending::default(),
            video_receiving: VideoReceiving::default(),
            links: Links::new(settings.links, budget.bytes_per_s, now),
            proofs: VecDeque::new(),
            receipts: BTreeMap::new(),
            answers: VecDeque::new(),
            haves: VecDeque::new(),
            lacking: BTreeMap::new(),
            sent: Traffic::default(),
            received: BTreeMap::new(),
            not_understood: 0,
        }
    }

    /// Whose end this is.
    #[must_use]
    pub fn node(&self) -> NodeId {
        self.me
    }

    /// Its run.
    #[must_use]
    pub fn boot(&self) -> Boot {
        self.boot
    }

    /// Sets a value that all others are to know.
    ///
    /// # Errors
    ///
    /// It does not fit into one datagram, or there are too many.
    pub fn tell(&mut self, now: NodeTime, key: Key, value: Vec<u8>) -> Result<(), StateError> {
        let (bytes, most) = (value.len(), self.body_bytes().saturating_sub(ENTRY_BYTES));
        if bytes > most {
            return Err(StateError::TooLarge { bytes, most });
        }
        self.telling.set(now, key, value)
    }

    /// Tells a value no more. The others keep what they were told last.
    pub fn tell_no_more(&mut self, key: Key) {
        self.telling.forget(key);
    }

    /// Posts a command; gives its number. It ends with [`Event::CommandEnded`].
    ///
    /// # Errors
    ///
    /// It does not fit into one datagram, or too many for this node are under way.
    pub fn post(&mut self, now: NodeTime, to: NodeId, body: Vec<u8>) -> Result<u64, PostError> {
        self.fits(&body)?;
        let (settings, boot) = (self.settings.courier, self.boot);
        let known = self.seal.run_of(to);
        let outbox = self.outboxes.entry(to).or_insert_with(|| {
            let mut outbox = Outbox::new(settings, boot, to);
            if let Some(run) = known {
                outbox.met(run);
            }
            outbox
        });
        Ok(outbox.post(now, body)?)
    }

    /// Asks something; gives the question's number. It ends with [`Event::Answered`] or [`Event::Unanswered`].
    ///
    /// # Errors
    ///
    /// It does not fit into one datagram, or too many are open.
    pub fn ask(&mut self, now: NodeTime, to: NodeId, body: Vec<u8>, within_s: f64) -> Result<u64, AskError> {
        self.fits(&body)?;
        Ok(self.asking.ask(now, to, body, within_s)?)
    }

    /// Answers a question.
    ///
    /// # Errors
    ///
    /// It does not fit into one datagram.
    pub fn answer(&mut self, ticket: Ticket, body: Vec<u8>) -> Result<(), TooLarge> {
        self.fits(&body)?;
        let answer = QueryAnswer { id: ticket.id, body };
        push_bounded(&mut self.answers, (ticket.from, answer));
        Ok(())
    }

    /// Sends something large; gives its number. It ends with [`Event::BulkEnded`].
    ///
    /// # Errors
    ///
    /// It is larger than is sent in one piece, or too many are under way.
    pub fn send(&mut self, now: NodeTime, to: NodeId, body: Vec<u8>) -> Result<u64, BulkError> {
        let chunk_bytes = self.body_bytes();
        self.sending.send(now, to, body, chunk_bytes)
    }

    /// Sends a picture of a video that another node asked for under its number of the stream.
    pub fn send_video(&mut self, now: NodeTime, to: NodeId, stream: u32, key: bool, body: &[u8]) -> Pushed {
        let (chunk_bytes, rate) = (self.body_bytes(), self.video_budget.bytes_per_s());
        self.video_sending
            .push(now, (to, stream), (key, body), chunk_bytes, rate)
    }

    /// That node does not want it any more.
    pub fn end_video(&mut self, to: NodeId, stream: u32) {
        self.video_sending.end(to, stream);
    }

    /// A video of another node is wanted: its pictures come as [`Event::Video`].
    pub fn expect_video(&mut self, from: NodeId, stream: u32) {
        self.video_receiving.expect(from, stream);
    }

    /// It is not wanted any more.
    pub fn forget_video(&mut self, from: NodeId, stream: u32) {
        self.video_receiving.forget(from, stream);
    }

    /// A decoder of it needs a key picture.
    pub fn want_video_key(&mut self, from: NodeId, stream: u32) {
        self.video_receiving.want_key(from, stream);
    }

    /// How the links to the others are.
    pub fn links(&self) -> impl Iterator<Item = (NodeId, Link)> {
        self.links.known()
    }

    /// What is sent per second at present, at most: as much as may be, or as the links bear.
    #[must_use]
    pub fn rates(&self) -> Rates {
        self.links.rates()
    }

    /// Changes what may be sent per second at most.
    pub fn set_bytes_per_s(&mut self, now: NodeTime, bytes_per_s: f64) {
        self.links.set_most_bytes_per_s(bytes_per_s);
        self.bulk_budget.set_bytes_per_s(now, bytes_per_s);
        self.video_budget.set_bytes_per_s(now, bytes_per_s * VIDEO_SHARE);
        self.resting_budget.set_bytes_per_s(now, bytes_per_s * RESTING_SHARE);
        self.budget.set_bytes_per_s(now, bytes_per_s);
    }

    /// What this node has sent.
    #[must_use]
    pub fn sent(&self) -> &Traffic {
        &self.sent
    }

    /// What this node has received of each other one and taken in.
    #[must_use]
    pub fn received(&self) -> &BTreeMap<NodeId, Traffic> {
        &self.received
    }

    /// What was not taken in.
    #[must_use]
    pub fn refused(&self) -> Refused {
        self.seal.refused()
    }

    /// What was of the swarm but not understood: of a later version of this program.
    #[must_use]
    pub fn not_understood(&self) -> u64 {
        self.not_understood
    }

    /// The run of a node that has proven to be going on.
    #[must_use]
    pub fn run_of(&self, node: NodeId) -> Option<Boot> {
        self.seal.run_of(node)
    }

    /// The largest body of a command, question or answer.
    #[must_use]
    pub fn body_bytes(&self) -> usize {
        self.settings
            .datagram_bytes
            .saturating_sub(ENVELOPE_BYTES + FRAME_BYTES)
    }

    fn fits(&self, body: &[u8]) -> Result<(), TooLarge> {
        let (bytes, most) = (body.len(), self.body_bytes());
        if bytes > most {
            return Err(TooLarge { bytes, most });
        }
        Ok(())
    }
}

/// Takes in what has arrived and sends what is due. Gives what has happened.
///
/// # Errors
///
/// The transport is down. What was to be sent is lost, as on the way.
pub fn pump(bus: &mut Bus, transport: &mut dyn Transport, now: NodeTime) -> Result<Vec<Event>, SendError> {
    let mut events = Vec::new();
    while let Some(datagram) = transport.receive(now) {
        events.extend(bus.take(now, &datagram.bytes));
    }
    events.extend(bus.expire(now));
    while let Some(Outgoing { to, class, bytes }) = bus.next(now) {
        transport.send(now, to, class, &bytes)?;
    }
    Ok(events)
}

fn push_bounded<T>(queue: &mut VecDeque<T>, item: T) {
    queue.push_back(item);
    if queue.len() > MOST_REPLIES {
        queue.pop_front();
    }
}

#[cfg(test)]
mod tests;
