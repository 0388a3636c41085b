//! When the announcer calls whom: often at first, seldom later, and never many at once.
//!
//! Must never do: look at a clock, or draw anything.

use crate::peer::{CALLED_OFTEN, CALLED_PER_HOST, Peer};
use std::collections::VecDeque;
use std::net::SocketAddrV4;
use std::time::Duration;

/// The first round is put off by a drawn share of this, so that nodes that start at once do not all call at once.
const PUT_OFF: Duration = Duration::from_millis(500);
/// Between the first rounds, in which everybody is called.
const AT_FIRST: [Duration; 3] = [Duration::from_secs(1), Duration::from_secs(2), Duration::from_secs(4)];
/// Between two rounds later on; up to a fifth more, drawn.
const LATER: Duration = Duration::from_secs(5);
/// Everybody is called in one of so many later rounds; in the others, the first participants of each host.
const EVERYBODY_EACH: u32 = 12;
/// Between two calls of a round.
const PACE: Duration = Duration::from_millis(2);

/// Whom to call next, and when. Times are since the start.
#[derive(Debug)]
pub(crate) struct Rounds {
    often: Vec<SocketAddrV4>,
    all: Vec<SocketAddrV4>,
    /// Still to be called in this round.
    waiting: VecDeque<SocketAddrV4>,
    later: Duration,
    next_round: Duration,
    next_call: Duration,
    done: u32,
}

impl Rounds {
    /// Rounds to these peers but not to those excepted; `drawn` is between zero and one.
    pub(crate) fn new(peers: &[Peer], domain_id: u16, drawn: f64, excepted: impl Fn(&SocketAddrV4) -> bool) -> Self {
        let places = |most: u16| {
            let places = peers.iter().flat_map(|peer| peer.places(domain_id, most));
            let mut places: Vec<SocketAddrV4> = places.filter(|place| !excepted(place)).collect();
            // The lower a port, the likelier there is somebody.
            places.sort_by_key(|place| (place.port(), *place.ip()));
            places.dedup();
            places
        };
        let drawn = drawn.clamp(0.0, 1.0);
        Self {
            often: places(CALLED_OFTEN),
            all: places(CALLED_PER_HOST),
            waiting: VecDeque::new(),
            later: LATER + LATER.mul_f64(0.2 * drawn),
            next_round: PUT_OFF.mul_f64(drawn),
            next_call: Duration::ZERO,
            done: 0,
        }
    }

    /// Whom to call now, if anybody.
    pub(crate) fn call(&mut self, now: Duration) -> Option<SocketAddrV4> {
        if self.waiting.is_empty() && now >= self.next_round {
            self.begin(now);
        }
        if now < self.next_call {
            return None;
        }
        let called = self.waiting.pop_front()?;
        self.next_call = now + PACE;
        Some(called)
    }

    /// When somebody is to be called next.
    pub(crate) fn next(&self) -> Duration {
        match self.waiting.is_empty() {
            true => self.next_round,
            false => self.next_call,
        }
    }

    fn begin(&mut self, now: Duration) {
        let at_first = usize::try_from(self.done).ok().and_then(|done| AT_FIRST.get(done));
        let later = self.done.saturating_sub(3);
        let everybody = at_first.is_some() || later.is_multiple_of(EVERYBODY_EACH);
        self.waiting = match everybody {
            true => self.all.iter().copied().collect(),
            false => self.often.iter().copied().collect(),
        };
        self.next_round = now + at_first.copied().unwrap_or(self.later);
        self.done = self.done.saturating_add(1);
    }
}

#[cfg(test)]
mod tests;
