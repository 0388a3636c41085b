//! Where a vehicle's frames come from.
//!
//! Must never do: hold a socket.

use std::fmt;
use std::net::SocketAddr;
use std::sync::Arc;

/// Where a vehicle's frames come from: an endpoint, and behind a UDP socket the address they are answered to.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Source {
    /// Name of the endpoint.
    pub endpoint: Arc<str>,
    /// Remote address; `None` on TCP and serial lines.
    pub address: Option<SocketAddr>,
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.address {
            Some(address) => write!(f, "{} on {}", address, self.endpoint),
            None => write!(f, "{}", self.endpoint),
        }
    }
}
