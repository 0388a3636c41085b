//! The node's one place in DDS: its participant, joined when something first needs it, and shared by all that do.
//!
//! Must never do: reach beyond loopback unless the settings say so; know what is said over it.
//!
//! A participant costs sockets, threads and announcements to everybody, so that a node has one: for the swarm's bus, for vehicles whose PX4 speaks
//! DDS, and for ROS 2.
#![deny(unsafe_code)]

mod announcement;
mod announcer;
mod interrupted;
mod multicast;
mod peer;
mod rounds;

pub use peer::{CALLED_PER_HOST, Peer};

use parking_lot::Mutex;
use rustdds::{DomainParticipant, DomainParticipantBuilder};
use std::net::{IpAddr, Ipv4Addr};
use thiserror::Error;

/// Above it, the ports of a domain reach into those that the system gives to anybody.
pub const LAST_DOMAIN_ID: u16 = 101;

/// Where a node is in DDS. The configuration has its like, which is read from a file: this crate knows of no file, nor of its words for what is
/// wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DdsSettings {
    /// The DDS domain, 101 at most: only participants of one domain hear each other. What `ROS_DOMAIN_ID` is elsewhere.
    pub domain_id: u16,
    /// Addresses of this host's interfaces whose networks are used; without peers, others are found there by multicast. With loopback alone, nobody beyond
    /// this host is.
    pub interfaces: Vec<IpAddr>,
    /// Whoever is told of this node by unicast. If there is any, multicast is left alone: nothing is expected from it, and nobody is told to use it.
    pub peers: Vec<Peer>,
}

impl Default for DdsSettings {
    /// Only this host.
    fn default() -> Self {
        Self {
            domain_id: 0,
            interfaces: vec![IpAddr::V4(Ipv4Addr::LOCALHOST)],
            peers: Vec::new(),
        }
    }
}

/// Why there is no participant.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum JoinError {
    /// There is no such domain.
    #[error("domain {0} is beyond the last one, {LAST_DOMAIN_ID}")]
    Domain(u16),
    /// No interface is named: DDS would take that for all.
    #[error("no interface is named")]
    NoInterface,
    /// A peer can't be one.
    #[error("{} is no address of one host", .0.address)]
    Peer(Peer),
    /// Multicast can't be left alone, because a program has a port of it for itself.
    #[error("a port of multicast of domain {domain_id} is taken: {reason}")]
    Multicast {
        /// The domain.
        domain_id: u16,
        /// What the system says.
        reason: String,
    },
    /// Peers can't be told of the participant.
    #[error("peers can't be told of this node: {0}")]
    Announcer(String),
    /// DDS could not begin.
    #[error("DDS did not start: {0}")]
    Start(String),
}

/// A new participant. Waits until its threads have started; with peers also while others on this host start.
///
/// # Errors
/// The settings name no domain, no interface or a peer that can't be one, or DDS can't begin.
pub fn join(settings: &DdsSettings) -> Result<DomainParticipant, JoinError> {
    if settings.domain_id > LAST_DOMAIN_ID {
        return Err(JoinError::Domain(settings.domain_id));
    }
    if settings.interfaces.is_empty() {
        return Err(JoinError::NoInterface);
    }
    if let Some(peer) = settings.peers.iter().find(|peer| !peer.can_be()) {
        return Err(JoinError::Peer(*peer));
    }
    if settings.peers.is_empty() {
        return build(settings);
    }
    let kept = multicast::Kept::wait(settings.domain_id).map_err(|error| JoinError::Multicast {
        domain_id: settings.domain_id,
        reason: error.to_string(),
    })?;
    let participant = build(settings)?;
    drop(kept);
    announcer::begin(&participant, settings).map_err(|error| JoinError::Announcer(error.to_string()))?;
    Ok(participant)
}

fn build(settings: &DdsSettings) -> Result<DomainParticipant, JoinError> {
    DomainParticipantBuilder::new(settings.domain_id)
        .with_only_networks(settings.interfaces.iter().copied())
        .build()
        .map_err(|error| JoinError::Start(error.to_string()))
}

/// A node's place in DDS, by default on this host alone; taken when it is first asked for.
pub struct Place {
    settings: DdsSettings,
    joined: Mutex<Option<DomainParticipant>>,
}

impl std::fmt::Debug for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Place")
            .field("settings", &self.settings)
            .finish_non_exhaustive()
    }
}

impl Default for Place {
    fn default() -> Self {
        Self::new(DdsSettings::default())
    }
}

impl Place {
    /// Not joined yet.
    #[must_use]
    pub fn new(settings: DdsSettings) -> Self {
        Self {
            settings,
            joined: Mutex::new(None),
        }
    }

    /// The node's participant: the same for everyone who asks. It ends with the last one that holds it and this place. Waits when it is first asked.
    ///
    /// # Errors
    /// As [`join`]; the next one who asks tries again.
    pub fn participant(&self) -> Result<DomainParticipant, JoinError> {
        let mut joined = self.joined.lock();
        if let Some(participant) = &*joined {
            return Ok(participant.clone());
        }
        let participant = join(&self.settings)?;
        *joined = Some(participant.clone());
        Ok(participant)
    }
}

#[cfg(test)]
mod tests {
    use super::{DdsSettings, JoinError, Peer, Place, join};
    use rustdds::RTPSEntity;
    use std::net::Ipv4Addr;

    #[test]
    fn what_can_not_be_is_said_before_anything_starts() {
        let with = |domain_id, interfaces| DdsSettings {
            domain_id,
            interfaces,
            peers: Vec::new(),
        };
        let here = DdsSettings::default().interfaces;
        let refused = |settings: &DdsSettings| join(settings).map(|_| ()).unwrap_err();
        assert_eq!(refused(&with(102, here)), JoinError::Domain(102));
        assert_eq!(refused(&with(1, Vec::new())), JoinError::NoInterface);
        let peer = Peer {
            address: Ipv4Addr::BROADCAST,
            port: None,
        };
        let peers = DdsSettings {
            peers: vec![peer],
            ..DdsSettings::default()
        };
        assert_eq!(refused(&peers), JoinError::Peer(peer));
    }

    #[test]
    fn everyone_who_asks_gets_the_same() {
        let place = Place::new(DdsSettings {
            domain_id: 77,
            ..DdsSettings::default()
        });
        let (one, other) = (place.participant().unwrap(), place.participant().unwrap());
        assert_eq!(one.guid(), other.guid());
    }
}
