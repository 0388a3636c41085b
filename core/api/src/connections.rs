//! Who is connected, and who has to go when there is no room: whoever holds a connection without asking anything, longest first, of the
//! address that holds the most.
//!
//! Must never do: keep a new connection waiting, for it may be the operator's emergency stop; end one that is being answered for one that
//! has asked nothing yet.

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
/// Whoever takes longer to ask, or to take the answer, is slow and goes before those who are quick.
const SLOW: Duration = Duration::from_secs(5);

#[derive(Debug)]
struct Connection {
    address: IpAddr,
    /// Since when it has been as it is.
    since: Instant,
    /// How many requests are being answered on it.
    asked: usize,
    /// Ends it.
    _end: oneshot::Sender<()>,
}

impl Connection {
    /// In which order they go: first who asks nothing, then who is slow. The longest first. None: it stays.
    fn may_go(&self, now: Instant) -> Option<(bool, Instant)> {
        let busy = self.asked > 0;
        (!busy || now.duration_since(self.since) >= SLOW).then_some((busy, self.since))
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
        let may_go = self.open.iter().filter(|(_, open)| among(open));
        let (_, number) = may_go
            .filter_map(|(number, open)| Some((open.may_go(now)?, *number)))
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
            (open.asked, open.since) = (asked(open.asked), now);
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
