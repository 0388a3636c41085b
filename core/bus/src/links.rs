//! How the links are: round trips, offsets of clocks, and how long datagrams wait on their way; and how fast to send because of that.
//!
//! Must never do: need clocks that agree; take loss for a sign of a full link, which on a radio it is not.
//!
//! Every node tells now and then when it did so by its own clock and how much it has sent, and for each of those it hears their latest such moment, how long ago it
//! came, and how much later than the quickest of late. So each learns of every other the round trip and the clock's offset (as NTP does), and
//! how full the way to it is (as LEDBAT does), and what is lost on the way from it. A way that has become longer looks like one that is full, until the quicker one is forgotten.

use crate::envelope::Boot;
use minicbor::{Decode, Encode};
use skein_domain::{NodeId, NodeTime};
use std::collections::{BTreeMap, VecDeque};

/// What one node tells of one that it hears.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Encode, Decode)]
pub struct Echo {
    /// Of whom.
    #[n(0)]
    pub node: NodeId,
    /// That one's run.
    #[n(1)]
    pub boot: Boot,
    /// That one's clock when it told.
    #[n(2)]
    pub told: NodeTime,
    /// How long ago it came, in microseconds.
    #[n(3)]
    pub held_us: u64,
    /// How much longer it was on its way than the quickest of late, in microseconds.
    #[n(4)]
    pub queued_us: u64,
}

/// What a node tells of its links.
#[derive(Debug, Clone, PartialEq, Eq, Encode, Decode)]
pub struct Report {
    /// The teller's clock.
    #[n(0)]
    pub told: NodeTime,
    /// Those it hears; in turn, if they are too many for one datagram.
    #[n(1)]
    pub echoes: Vec<Echo>,
    /// How many datagrams the teller's run had sent to all before this one; older programs do not tell.
    #[n(2)]
    pub sent_to_all: Option<u64>,
}

/// When links are measured, and how fast a node may send because of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkSettings {
    /// A report is told this often, in seconds; with more than [`MANY`] nodes less often, so that what is told in all grows no faster than their number.
    pub every_s: f64,
    /// Datagrams that wait longer than this on their way mean that the link is full, in seconds: bulk is slowed down.
    pub full_after_s: f64,
    /// Those that wait longer than this mean that it is overfull, in seconds: everything is slowed down.
    pub overfull_after_s: f64,
    /// Nothing is ever slowed down below this, in bytes per second of what is for all, as often as it is sent; with more than [`MANY`] nodes
    /// this is what that many have together.
    pub least_bytes_per_s: f64,
}

impl Default for LinkSettings {
    fn default() -> Self {
        Self {
            every_s: 0.5,
            full_after_s: 0.08,
            overfull_after_s: 0.2,
            least_bytes_per_s: 1000.0,
        }
    }
}

/// With more nodes reports become rarer.
pub const MANY: usize = 10;
/// What one echo takes at most, in bytes.
pub const ECHO_BYTES: usize = 48;
/// What the count of datagrams takes at most, in bytes.
const COUNT_BYTES: usize = 9;
/// What was lost is counted over so long, in seconds.
const LOSS_OVER_S: f64 = 10.0;
/// For so long the quickest way is remembered, in seconds: twice over, so that there is always a full span. A full way is empty again before, because everybody
/// sends less; one that is still as long then has become longer.
const QUICKEST_OVER_S: f64 = 10.0;
/// Of so many round trips the shortest one's offset counts: it is the least disturbed (NTP's clock filter).
const FILTERED: usize = 8;
/// A word about a full link counts for so long, in seconds.
const FULL_FOR_S: f64 = 2.0;
/// What a full link makes of the rate of bulk, and what one that is not makes of it in the same time.
const SLOWER: f64 = 0.7;
const FASTER: f64 = 1.05;
/// What an overfull link leaves of what was used, and how the limit grows again when it is not.
const LESS: f64 = 0.85;
const MORE: f64 = 1.1;
/// How much more may at least be sent on each of several ways than on one for all: what the places of a vehicle and signs of life take. Whose radio bears less must be told so.
const OWN_WAY: f64 = 5.0;

/// How the link to one node is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    /// The latest round trip, in seconds.
    pub round_trip_s: f64,
    /// The other's clock less this one's, in seconds.
    pub offset_s: f64,
    /// How far off that may be: half of the round trip it was measured with, in seconds.
    pub offset_error_s: f64,
    /// How much longer than the quickest of late datagrams are on their way to it, in seconds.
    pub queued_s: f64,
    /// Share of what it sent to all that did not come here in any way, 0..=1, over the last ten seconds; none if it does not tell what it sends.
    pub loss: Option<f64>,
    /// When this was learned.
    pub at: NodeTime,
}

#[derive(Debug)]
struct Peer {
    boot: Boot,
    /// Its latest word: its clock, ours.
    latest: (NodeTime, NodeTime),
    queued_us: i128,
    /// The quickest way of this span and of the one before, in microseconds of two clocks that do not agree.
    quickest: [Option<i128>; 2],
    span_begun: NodeTime,
    round_trips: VecDeque<(f64, f64)>,
    /// Datagrams to all that came.
    came_for_all: u64,
    /// When a report came, what had been sent to all by then, what had come of it.
    counts: VecDeque<(NodeTime, u64, u64)>,
    link: Option<Link>,
}

/// How fast a node sends at most, in bytes per second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// Of all classes together.
    pub all_bytes_per_s: f64,
    /// Of bulk.
    pub bulk_bytes_per_s: f64,
}

impl Rates {
    fn both(bytes_per_s: f64) -> Self {
        Self {
            all_bytes_per_s: bytes_per_s,
            bulk_bytes_per_s: bytes_per_s,
        }
    }
}

/// The links of one node, and its rate.
#[derive(Debug)]
pub struct Links {
    settings: LinkSettings,
    most_bytes_per_s: f64,
    rates: Rates,
    peers: BTreeMap<NodeId, Peer>,
    due: NodeTime,
    adapted: NodeTime,
    /// Whose echo comes first in the next report.
    turn: NodeId,
}

impl Links {
    /// Nothing known yet; it may be sent as fast as at most.
    #[must_use]
    pub fn new(settings: LinkSettings, most_bytes_per_s: f64, now: NodeTime) -> Self {
        Self {
            settings,
            most_bytes_per_s,
            rates: Rates::both(most_bytes_per_s),
            peers: BTreeMap::new(),
            due: now,
            adapted: now,
            turn: NodeId(0),
        }
    }

    /// What is known of the links.
    pub fn known(&self) -> impl Iterator<Item = (NodeId, Link)> {
        self.peers.iter().filter_map(|(node, peer)| Some((*node, peer.link?)))
    }

    /// How fast to send now.
    #[must_use]
    pub fn rates(&self) -> Rates {
        self.rates
    }

    /// Sets how fast it may be sent at most.
    pub fn set_most_bytes_per_s(&mut self, bytes_per_s: f64) {
        self.most_bytes_per_s = bytes_per_s;
        self.rates = Rates::both(bytes_per_s);
    }

    /// How many times as many nodes there are as are many; one if they are fewer.
    fn crowd(&self) -> f64 {
        (self.peers.len() as f64 / MANY as f64).max(1.0)
    }

    /// The report to tell now, if it is due, with as many echoes as fit into so many bytes. `sent_to_all` is how many datagrams this run has
    /// sent to all.
    pub fn report(&mut self, now: NodeTime, room_bytes: usize, sent_to_all: u64) -> Option<Report> {
        if now < self.due {
            return None;
        }
        self.due = now.plus_seconds(self.settings.every_s * self.crowd());
        let most = (room_bytes.saturating_sub(COUNT_BYTES) / ECHO_BYTES).max(1);
        let from_turn = self.peers.range(self.turn..).chain(self.peers.range(..self.turn));
        let mut echoes = from_turn.map(|(node, peer)| Echo {
            node: *node,
            boot: peer.boot,
            told: peer.latest.0,
            held_us: now.0.saturating_sub(peer.latest.1.0),
            queued_us: u64::try_from(peer.queued_us).unwrap_or(0),
        });
        let told: Vec<Echo> = echoes.by_ref().take(most).collect();
        let next = echoes.next().map(|echo| echo.node);
        self.turn = next.unwrap_or_default();
        Some(Report {
            told: now,
            echoes: told,
            sent_to_all: Some(sent_to_all),
        })
    }

    /// Counts a datagram that a node sent to all. Before its first report none is.
    pub fn count_for_all(&mut self, from: NodeId, boot: Boot) {
        if let Some(peer) = self.peers.get_mut(&from).filter(|peer| peer.boot == boot) {
            peer.came_for_all += 1;
        }
    }

    /// Takes another node's report in. Call [`Self::adapt`] after it.
    pub fn take(&mut self, now: NodeTime, me: (NodeId, Boot), from: NodeId, boot: Boot, report: &Report) {
        let peer = self.peers.entry(from).or_insert_with(|| Peer::new(boot, now));
        if peer.boot != boot {
            *peer = Peer::new(boot, now);
        }
        peer.came(now, report.told);
        let of_me = report.echoes.iter().find(|echo| (echo.node, echo.boot) == me);
        if let Some(echo) = of_me {
            peer.echoed(now, report.told, echo);
        }
        if let Some(sent) = report.sent_to_all {
            peer.counted(now, sent);
        }
    }

    /// Slower while the ways are full, bulk first, faster again when they are not. `used_bytes_per_s` is what is sent at present, and what is
    /// for all is sent `copies` times.
    pub fn adapt(&mut self, now: NodeTime, used_bytes_per_s: f64, copies: usize) {
        if now.seconds_since(self.adapted) < self.settings.every_s {
            return;
        }
        self.adapted = now;
        let queue_s = self.middle_wait_s(now);
        let most = self.most_bytes_per_s;
        // Who is sent to by itself has a way of its own, on which there is more room than on one that all share.
        let ways = if copies > 1 { OWN_WAY * copies as f64 } else { 1.0 };
        let least = (self.settings.least_bytes_per_s * ways / self.crowd()).min(most);
        let Rates {
            all_bytes_per_s: all,
            bulk_bytes_per_s: bulk,
        } = self.rates;
        let all = if queue_s > self.settings.overfull_after_s {
            all.min(used_bytes_per_s) * LESS
        } else {
            all * MORE
        };
        let full = queue_s > self.settings.full_after_s;
        let bulk = bulk * if full { SLOWER } else { FASTER };
        self.rates = Rates {
            all_bytes_per_s: all.max(least).min(most),
            bulk_bytes_per_s: bulk.max(least).min(most),
        };
    }

    /// How long datagrams wait on the middle one of the ways, in seconds: a single bad link must not slow the others down. Whom nobody echoes has no sign that
    /// its ways are full; were it kept as slow as it was then, it might never be heard again.
    fn middle_wait_s(&self, now: NodeTime) -> f64 {
        let links = self.peers.values().filter_map(|peer| peer.link);
        let recent = links.filter(|link| now.seconds_since(link.at) <= FULL_FOR_S);
        let mut queued: Vec<f64> = recent.map(|link| link.queued_s).collect();
        queued.sort_by(f64::total_cmp);
        queued.get(queued.len() / 2).copied().unwrap_or(0.0)
    }
}

impl Peer {
    fn new(boot: Boot, now: NodeTime) -> Self {
        Self {
            boot,
            latest: (NodeTime(0), now),
            queued_us: 0,
            quickest: [None; 2],
            span_begun: now,
            round_trips: VecDeque::new(),
            came_for_all: 0,
            counts: VecDeque::new(),
            link: None,
        }
    }

    fn came(&mut self, now: NodeTime, told: NodeTime) {
        let way_us = i128::from(now.0) - i128::from(told.0);
        if now.seconds_since(self.span_begun) > QUICKEST_OVER_S {
            self.span_begun = now;
            self.quickest = [None, self.quickest[0]];
        }
        self.quickest[0] = Some(self.quickest[0].map_or(way_us, |quickest| quickest.min(way_us)));
        let quickest_us = self.quickest.into_iter().flatten().min().unwrap_or(way_us);
        // One that was overtaken says nothing about now.
        if told >= self.latest.0 {
            self.latest = (told, now);
            self.queued_us = way_us - quickest_us;
        }
    }

    fn echoed(&mut self, now: NodeTime, told: NodeTime, echo: &Echo) {
        let held_s = echo.held_us as f64 * 1e-6;
        let round_trip_s = now.seconds_since(echo.told) - held_s;
        if round_trip_s < 0.0 {
            return;
        }
        let offset_s = (told.seconds_since(echo.told) - held_s + told.seconds_since(now)) / 2.0;
        self.round_trips.push_back((round_trip_s, offset_s));
        if self.round_trips.len() > FILTERED {
            self.round_trips.pop_front();
        }
        let shortest = self.round_trips.iter().min_by(|a, b| a.0.total_cmp(&b.0));
        let (shortest_s, offset_s) = shortest.copied().unwrap_or((round_trip_s, offset_s));
        self.link = Some(Link {
            round_trip_s,
            offset_s,
            offset_error_s: shortest_s / 2.0,
            queued_s: echo.queued_us as f64 * 1e-6,
            loss: self.loss(),
            at: now,
        });
    }

    /// Another report says how much was sent by then.
    fn counted(&mut self, now: NodeTime, sent: u64) {
        // One that was overtaken says nothing new.
        if self.counts.back().is_some_and(|(_, before, _)| sent <= *before) {
            return;
        }
        self.counts.push_back((now, sent, self.came_for_all));
        while self.counts.len() > 2
            && self
                .counts
                .get(1)
                .is_some_and(|(at, ..)| now.seconds_since(*at) > LOSS_OVER_S)
        {
            self.counts.pop_front();
        }
        let loss = self.loss();
        if let Some(link) = &mut self.link {
            link.loss = loss;
        }
    }

    /// Share lost between the first and the last count that are kept. What overtook a report makes it off by a datagram or two.
    fn loss(&self) -> Option<f64> {
        let ((_, sent_before, came_before), (_, sent, came)) = (self.counts.front()?, self.counts.back()?);
        let sent = sent.checked_sub(*sent_before).filter(|sent| *sent > 0)?;
        Some((1.0 - came.saturating_sub(*came_before) as f64 / sent as f64).max(0.0))
    }
}

#[cfg(test)]
mod tests;
