//! A simulated radio around a transport: places, path loss, shared airtime, loss, delay, jitter, doubles, links that are worse one way, and parts.
//!
//! Must never do: read a clock or draw chance that is not of its seed. The same seed and the same calls give the same datagrams.
//!
//! Each datagram of a node goes into the air once, at the air's rate; each node that is reached draws its own fate. It is then handed to
//! the transport underneath for that node alone, when its time has come.

use crate::transport::{Class, Datagram, SendError, To, Transport, Wake};
use parking_lot::Mutex;
use skein_domain::{NodeId, NodeTime, PositionNed};
use std::collections::BTreeMap;
use std::sync::Arc;

mod channel;

pub use channel::{AirSettings, AirUse, Link};

use channel::RadioChannel;

/// The air that all radios of a simulation share.
#[derive(Debug, Clone)]
pub struct Air(Arc<Mutex<RadioChannel>>);

impl Air {
    /// Nobody in it yet.
    #[must_use]
    pub fn new(settings: AirSettings, seed: u64) -> Self {
        Self(Arc::new(Mutex::new(RadioChannel::new(settings, seed))))
    }

    /// Puts a node somewhere, or moves it. Who has a radio but no place is at the origin.
    pub fn place(&self, node: NodeId, at: PositionNed) {
        self.0.lock().place(node, at);
    }

    /// Changes the air from now on.
    pub fn set(&self, settings: AirSettings) {
        self.0.lock().settings = settings;
    }

    /// Makes a link worse, in one direction.
    pub fn set_link(&self, from: NodeId, to: NodeId, link: Link) {
        self.0.lock().links.insert((from, to), link);
    }

    /// Divides the swarm: only those of one part hear each other; who is in none hears nobody.
    pub fn divide(&self, parts: &[&[NodeId]]) {
        let numbered = parts.iter().enumerate();
        let parts = numbered.flat_map(|(part, nodes)| nodes.iter().map(move |node| (*node, part)));
        self.0.lock().parts = Some(parts.collect());
    }

    /// Undoes all that was done to links and parts.
    pub fn mend(&self) {
        let mut channel = self.0.lock();
        channel.parts = None;
        channel.links.clear();
    }

    /// What it was used for so far.
    #[must_use]
    pub fn used(&self) -> AirUse {
        self.0.lock().used
    }

    /// A node's radio, over what really carries its datagrams.
    pub fn radio<T: Transport>(&self, inner: T) -> Radio<T> {
        self.0.lock().join(inner.node());
        Radio {
            inner,
            air: self.clone(),
            flying: BTreeMap::new(),
            last: 0,
        }
    }
}

/// One node's radio.
#[derive(Debug)]
pub struct Radio<T> {
    inner: T,
    air: Air,
    /// By the time of their arrival.
    flying: BTreeMap<(NodeTime, u64), (NodeId, Class, Vec<u8>)>,
    last: u64,
}

impl<T: Transport> Radio<T> {
    /// Hands on what has arrived by now.
    fn release(&mut self, now: NodeTime) -> Result<(), SendError> {
        let later = self.flying.split_off(&(now.plus_seconds(1e-6), 0));
        for (to, class, bytes) in std::mem::replace(&mut self.flying, later).into_values() {
            self.inner.send(now, To::One(to), class, &bytes)?;
        }
        Ok(())
    }
}

impl<T: Transport> Transport for Radio<T> {
    fn node(&self) -> NodeId {
        self.inner.node()
    }

    fn largest_bytes(&self) -> usize {
        self.inner.largest_bytes()
    }

    fn sends_to_each(&self) -> bool {
        self.inner.sends_to_each()
    }

    fn send(&mut self, now: NodeTime, to: To, class: Class, bytes: &[u8]) -> Result<(), SendError> {
        self.check_size(bytes)?;
        let arrivals = self.air.0.lock().sent(now, self.node(), to, bytes.len());
        for (node, at) in arrivals {
            self.last += 1;
            self.flying.insert((at, self.last), (node, class, bytes.to_vec()));
        }
        self.release(now)
    }

    fn receive(&mut self, now: NodeTime) -> Option<Datagram> {
        // A transport that is down says so when something is sent.
        let _released = self.release(now);
        self.inner.receive(now)
    }

    fn due(&self) -> Option<NodeTime> {
        let own = self.flying.keys().next().map(|(at, _)| *at);
        [own, self.inner.due()].into_iter().flatten().min()
    }

    fn wake_on_arrival(&mut self, wake: Wake) {
        self.inner.wake_on_arrival(wake);
    }

    fn overflowed(&self) -> u64 {
        self.inner.overflowed()
    }
}

#[cfg(test)]
mod tests;
