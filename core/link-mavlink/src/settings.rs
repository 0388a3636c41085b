//! What can be set about one endpoint and the links on it, each with a default that suits PX4.
//!
//! Must never do: read files; the configuration crate fills these in.

use crate::address::EndpointAddress;
use skein_px4::LinkSettings;
use std::net::{Ipv4Addr, SocketAddr};

/// One endpoint: a socket or serial line and how its links behave.
#[derive(Debug, Clone, PartialEq)]
pub struct EndpointSettings {
    /// Its name in logs, metrics and events; unique in the node. Links are kept over a restart by this name.
    pub name: String,
    /// Where it listens or connects.
    pub address: EndpointAddress,
    /// How the links on it behave.
    pub link: LinkSettings,
    /// Datagrams per second from which wake-ups are coalesced: the endpoint then sleeps for [`Self::coalesce_s`] after each
    /// batch instead of being woken by every datagram.
    pub coalesce_above_hz: f64,
    /// How long it sleeps then, in seconds. It delays what is received by at most this much, and nothing that is sent.
    pub coalesce_s: f64,
    /// Receive buffer asked of the system for UDP, in bytes; the system may grant less.
    pub receive_buffer_bytes: usize,
    /// Longest pause between two attempts to connect (TCP) or open (serial), in seconds.
    pub reconnect_max_s: f64,
}

impl Default for EndpointSettings {
    fn default() -> Self {
        Self {
            name: "px4".to_owned(),
            address: EndpointAddress::UdpListen(SocketAddr::from((Ipv4Addr::LOCALHOST, 14_540))),
            link: LinkSettings::default(),
            coalesce_above_hz: 1_500.0,
            coalesce_s: 0.004,
            receive_buffer_bytes: 4 << 20,
            reconnect_max_s: 5.0,
        }
    }
}

impl EndpointSettings {
    /// Settings with this name and address, the rest as usual.
    #[must_use]
    pub fn new(name: impl Into<String>, address: EndpointAddress) -> Self {
        Self {
            name: name.into(),
            address,
            ..Self::default()
        }
    }
}
