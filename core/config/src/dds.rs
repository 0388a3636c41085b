//! `[dds]`: where this node is in DDS, and over which links a vehicle is flown.
//!
//! Must never do: join DDS.

use serde::{Deserialize, Serialize};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::str::FromStr;
use thiserror::Error;

/// `[dds]`
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DdsSettings {
    /// DDS domain: what `ROS_DOMAIN_ID` is elsewhere.
    pub domain_id: u16,
    /// Addresses of this computer's interfaces whose networks are used.
    pub interfaces: Vec<IpAddr>,
    /// Who is told of this node by unicast; with any, multicast is left alone.
    pub peers: Vec<DdsPeer>,
}

impl Default for DdsSettings {
    fn default() -> Self {
        Self {
            domain_id: 0,
            interfaces: vec![IpAddr::V4(Ipv4Addr::LOCALHOST)],
            peers: Vec::new(),
        }
    }
}

/// A host, `10.0.0.8`, or one participant on it, `10.0.0.8:7412`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct DdsPeer {
    /// Its address.
    pub address: Ipv4Addr,
    /// The port on which one participant hears of others.
    pub port: Option<u16>,
}

/// Why something is no peer.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum DdsPeerError {
    /// Neither an address nor one with a port.
    #[error("{0:?} is no IPv4 address, with or without a port: \"10.0.0.7\" or \"10.0.0.8:7412\"")]
    NoAddress(String),
    /// An address of IPv6.
    #[error("{0:?} is an IPv6 address: DDS speaks IPv4 here")]
    Ipv6(String),
    /// An address that stands for all or several hosts, or for none.
    #[error("{0:?} is not the address of one host")]
    NotOneHost(String),
    /// Nobody hears at port zero.
    #[error("{0:?} has port 0, at which nobody listens")]
    PortZero(String),
}

impl FromStr for DdsPeer {
    type Err = DdsPeerError;

    fn from_str(text: &str) -> Result<Self, DdsPeerError> {
        let no_address = || DdsPeerError::NoAddress(text.into());
        let host = text.trim_start_matches('[').split([']', '%', '/']).next();
        if host.is_some_and(|host| host.parse::<Ipv6Addr>().is_ok()) {
            return Err(DdsPeerError::Ipv6(text.into()));
        }
        let (address, port) = match text.split_once(':') {
            Some((address, port)) => (address, Some(port.parse().map_err(|_| no_address())?)),
            None => (text, None),
        };
        let address: Ipv4Addr = address.parse().map_err(|_| no_address())?;
        if address.is_unspecified() || address.is_multicast() || address.is_broadcast() {
            return Err(DdsPeerError::NotOneHost(text.into()));
        }
        if port == Some(0) {
            return Err(DdsPeerError::PortZero(text.into()));
        }
        Ok(Self { address, port })
    }
}

impl std::fmt::Display for DdsPeer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.port {
            Some(port) => write!(f, "{}:{port}", self.address),
            None => self.address.fmt(f),
        }
    }
}

impl TryFrom<String> for DdsPeer {
    type Error = DdsPeerError;

    fn try_from(text: String) -> Result<Self, DdsPeerError> {
        text.parse()
    }
}

impl From<DdsPeer> for String {
    fn from(peer: DdsPeer) -> Self {
        peer.to_string()
    }
}

/// What carries commands and setpoints to a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LinkKind {
    /// MAVLink over an endpoint.
    Mavlink,
    /// DDS, through PX4's uXRCE-DDS agent.
    Dds,
}

impl std::fmt::Display for LinkKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Mavlink => "MAVLink",
            Self::Dds => "DDS",
        })
    }
}

#[cfg(test)]
mod tests;
