//! What a transport is: it carries datagrams between nodes, and promises nothing.
//!
//! Must never do: promise more than the poorest of them keeps. Datagrams may be lost, late, doubled, turned around, and made up by
//! strangers; what the swarm needs beyond that is kept above.

use minicbor::{Decode, Encode};
use skein_domain::{NodeId, NodeTime};
use std::sync::Arc;
use thiserror::Error;

/// The kinds of traffic, the most urgent first. A transport may treat them differently on the way; none of them may wait for a later one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Encode, Decode)]
#[cbor(index_only)]
pub enum Class {
    /// Orders and what belongs to them: few, small, each matters.
    #[n(0)]
    Command,
    /// What is so now: the newest replaces the one before.
    #[n(1)]
    State,
    /// Questions and answers.
    #[n(2)]
    Query,
    /// Live video: the newest is worth the most, and what comes late nothing.
    #[n(4)]
    Video,
    /// Pictures and logs.
    #[n(3)]
    Bulk,
}

/// All classes, the most urgent first.
pub const CLASSES: [Class; 5] = [Class::Command, Class::State, Class::Query, Class::Video, Class::Bulk];

/// Whom a datagram is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum To {
    /// One node.
    One(NodeId),
    /// Every other node that it reaches.
    All,
}

/// One datagram that arrived.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Datagram {
    /// The sender as the transport names it. Nothing proves it before the seal is open.
    pub from: NodeId,
    /// Its kind as the transport names it.
    pub class: Class,
    /// What was sent.
    pub bytes: Vec<u8>,
}

/// Why a datagram was not sent.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SendError {
    /// It is larger than this transport carries in one.
    #[error("{bytes} bytes are more than the {most} this transport carries in one datagram")]
    TooLarge {
        /// Its size.
        bytes: usize,
        /// The largest.
        most: usize,
    },
    /// The transport has ended or is broken.
    #[error("the transport is down: {0}")]
    Down(String),
}

/// Called from any thread when something has arrived; it must return at once.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// Carries datagrams between the nodes of one swarm. No call of it waits.
pub trait Transport: Send {
    /// Whose it is.
    fn node(&self) -> NodeId;

    /// The largest datagram it carries.
    fn largest_bytes(&self) -> usize;

    /// Whether what is for all is sent to each of them by itself, and uses the air as often.
    fn sends_to_each(&self) -> bool {
        false
    }

    /// Whether it carries so large a datagram.
    ///
    /// # Errors
    ///
    /// [`SendError::TooLarge`] if not.
    fn check_size(&self, bytes: &[u8]) -> Result<(), SendError> {
        let (bytes, most) = (bytes.len(), self.largest_bytes());
        if bytes > most {
            return Err(SendError::TooLarge { bytes, most });
        }
        Ok(())
    }

    /// Sends a datagram; that nobody is there is no error.
    ///
    /// # Errors
    ///
    /// It is too large, or the transport is down.
    fn send(&mut self, now: NodeTime, to: To, class: Class, bytes: &[u8]) -> Result<(), SendError>;

    /// The next datagram that has arrived, of the most urgent class that has one.
    fn receive(&mut self, now: NodeTime) -> Option<Datagram>;

    /// When it must be looked at again though nothing arrives; none if arrivals wake.
    fn due(&self) -> Option<NodeTime> {
        None
    }

    /// Whom to wake when something has arrived.
    fn wake_on_arrival(&mut self, wake: Wake);

    /// How many datagrams that had arrived were dropped because they were not fetched in time.
    fn overflowed(&self) -> u64;
}

impl<T: Transport + ?Sized> Transport for Box<T> {
    fn node(&self) -> NodeId {
        (**self).node()
    }

    fn largest_bytes(&self) -> usize {
        (**self).largest_bytes()
    }

    fn sends_to_each(&self) -> bool {
        (**self).sends_to_each()
    }

    fn send(&mut self, now: NodeTime, to: To, class: Class, bytes: &[u8]) -> Result<(), SendError> {
        (**self).send(now, to, class, bytes)
    }

    fn receive(&mut self, now: NodeTime) -> Option<Datagram> {
        (**self).receive(now)
    }

    fn due(&self) -> Option<NodeTime> {
        (**self).due()
    }

    fn wake_on_arrival(&mut self, wake: Wake) {
        (**self).wake_on_arrival(wake);
    }

    fn overflowed(&self) -> u64 {
        (**self).overflowed()
    }
}
