//! Who is connected, and who has to go when there is no room: of the address that holds the most, who has never asked anything, or has nothing
//! to ask now. The longest first.
//!
//! Must never do: keep a new connection waiting, for it may be the operator's emergency stop; end one that is being answered, unless that
//! takes long, for one that has asked nothing yet.

use parking_lot::Mutex;
use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::oneshot;

/// Connections at once. Streams of events are not among them once they are open; they have a bound of their own.
const CONNECTIONS_MAX: usize = 256;
/// Of one address at most, so that one computer leaves room for the others.
const OF_ONE_ADDRESS_MAX: usize = 192;
/// A request that is not answered within this time, because its body does not come or for another reason, may be broken off for others.
const SLOW: Duration = Duration::from_secs(5);

#[derive(Debug)]
struct Connection {
    address: IpAddr,
    /// Since when it has been as it is.
    since: Instant,
    /// How many requests are being answered on it.
    asked: usize,
    /// Whether anything was ever asked on it: a page that is open has.
    is_known: bool,
    /// Ends it.
    _end: oneshot::Sender<()>,
}

/// In which order they go; who is being answered and is not slow stays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Rank {
    First,
    Then,
    Slow,
}

impl Connection {
    /// Newcomers go before those who are known as long as they are the most: else whoever has come just now would go for the next.
    fn rank(&self, now: Instant, newcomers_first: bool) -> Option<Rank> {
        match self.asked {
            0 if self.is_known == newcomers_first => Some(Rank::Then),
            0 => Some(Rank::First),
            _ => (now.duration_since(self.since) >= SLOW).then_some(Rank::Slow),
        }
    }
}

#[derive(Debug, Default)]
struct Inner {
    next: u64,
    open: BTreeMap<u64, Connection>,
}

/// All connections of the server.
#[derive(Debug, Clone, Default)]
pub struct Connections(Arc<Mutex<Inner>>);

/// One of them. It is forgotten when this is dropped.
#[derive(Debug)]
pub struct Admitted {
    connections: Connections,
    number: u64,
}

/// A request that is being answered.
#[derive(Debug)]
pub struct Asked {
    connections: Connections,
    number: u64,
}

impl Connections {
    /// Takes a new connection in; gives what is told when it has to go. None if there is no room and nobody who could go: it is to be closed.
    pub fn admit(&self, now: Instant, address: IpAddr) -> Option<(Admitted, oneshot::Receiver<()>)> {
        let mut inner = self.0.lock();
        let of_it = inner.open.values().filter(|open| open.address == address).count();
        if of_it >= OF_ONE_ADDRESS_MAX {
            inner.dismiss(now, |open| open.address == address)?;
        } else if inner.open.len() >= CONNECTIONS_MAX {
            let most = inner.largest()?;
            let one_of_it = inner.dismiss(now, |open| open.address == most);
            one_of_it.or_else(|| inner.dismiss(now, |_| true))?;
        }
        let (end, ended) = oneshot::channel();
        let number = inner.next;
        inner.next += 1;
        let connection = Connection {
            address,
            since: now,
            asked: 0,
            is_known: false,
            _end: end,
        };
        inner.open.insert(number, connection);
        let admitted = Admitted {
            connections: self.clone(),
            number,
        };
        Some((admitted, ended))
    }
}

impl Inner {
    /// The address that holds the most.
    fn largest(&self) -> Option<IpAddr> {
        let mut counts: BTreeMap<IpAddr, usize> = BTreeMap::new();
        for open in self.open.values() {
            *counts.entry(open.address).or_default() += 1;
        }
        counts
            .into_iter()
            .max_by_key(|(_, count)| *count)
            .map(|(address, _)| address)
    }

    /// Ends the one of these that is to go first.
    fn dismiss(&mut self, now: Instant, among: impl Fn(&Connection) -> bool) -> Option<()> {
        let those = || self.open.iter().filter(|(_, open)| among(open));
        let newcomers = those().filter(|(_, open)| !open.is_known).count();
        let newcomers_first = 2 * newcomers > those().count();
        let (_, _, number) = those()
            .filter_map(|(number, open)| Some((open.rank(now, newcomers_first)?, open.since, *number)))
            .min()?;
        // Dropping it tells the connection's task.
        self.open.remove(&number).map(|_| ())
    }
}

impl Admitted {
    /// A request has come on it.
    #[must_use]
    pub fn asked(&self, now: Instant) -> Asked {
        self.connections.change(self.number, now, |asked| asked + 1);
        Asked {
            connections: self.connections.clone(),
            number: self.number,
        }
    }
}

impl Connections {
    fn change(&self, number: u64, now: Instant, asked: impl FnOnce(usize) -> usize) {
        if let Some(open) = self.0.lock().open.get_mut(&number) {
            (open.asked, open.since, open.is_known) = (asked(open.asked), now, true);
        }
    }
}

impl Drop for Asked {
    fn drop(&mut self) {
        self.connections
            .change(self.number, Instant::now(), |asked| asked.saturating_sub(1));
    }
}

impl Drop for Admitted {
    fn drop(&mut self) {
        self.connections.0.lock().open.remove(&self.number);
    }
}

#[cfg(test)]
mod tests;
