//! Where an endpoint listens or connects, as one line of text such as `udp-listen://127.0.0.1:14540`.
//!
//! Must never do: resolve names or open anything; it only says what is meant.

use std::fmt;
use std::net::SocketAddr;
use std::str::FromStr;

/// Baud rate of a serial line that names none (the usual one of telemetry radios).
pub const DEFAULT_BAUD: u32 = 57_600;

/// Where an endpoint listens or connects.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum EndpointAddress {
    /// Bind this UDP address and answer each vehicle where its frames come from: `udp-listen://127.0.0.1:14540`.
    UdpListen(SocketAddr),
    /// Talk to one UDP address from a port the system chooses: `udp-connect://192.168.4.1:14550`.
    UdpConnect(SocketAddr),
    /// Connect to a TCP server, host and port as text so that a name works too: `tcp://sitl.local:5760`.
    TcpConnect(String),
    /// Open a serial line: `serial:///dev/ttyACM0?baud=921600`.
    Serial {
        /// Path of the device.
        path: String,
        /// Baud rate.
        baud: u32,
    },
}

/// An address that cannot be understood.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is not an endpoint address: {reason}")]
pub struct AddressError {
    /// The text as given.
    pub text: String,
    /// What is wrong with it and what would be right.
    pub reason: String,
}

impl fmt::Display for EndpointAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UdpListen(address) => write!(f, "udp-listen://{address}"),
            Self::UdpConnect(address) => write!(f, "udp-connect://{address}"),
            Self::TcpConnect(address) => write!(f, "tcp://{address}"),
            Self::Serial { path, baud } => write!(f, "serial://{path}?baud={baud}"),
        }
    }
}

impl FromStr for EndpointAddress {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let wrong = |reason: &str| AddressError {
            text: text.to_owned(),
            reason: reason.to_owned(),
        };
        let Some((scheme, rest)) = text.split_once("://") else {
            return Err(wrong("expected udp-listen://, udp-connect://, tcp:// or serial://"));
        };
        let socket = || {
            rest.parse::<SocketAddr>()
                .map_err(|_| wrong("expected an IP address and a port, for example 127.0.0.1:14540"))
        };
        match scheme {
            "udp-listen" => Ok(Self::UdpListen(socket()?)),
            "udp-connect" => match socket()? {
                address if address.port() == 0 => Err(wrong("port 0 cannot be connected to")),
                address => Ok(Self::UdpConnect(address)),
            },
            "tcp" => match rest.rsplit_once(':') {
                Some((host, port)) if !host.is_empty() && port.parse::<u16>().is_ok_and(|port| port > 0) => {
                    Ok(Self::TcpConnect(rest.to_owned()))
                }
                _ => Err(wrong("expected host:port, for example 127.0.0.1:5760")),
            },
            "serial" => serial(rest).map_err(|reason| wrong(&reason)),
            _ => Err(wrong("expected udp-listen://, udp-connect://, tcp:// or serial://")),
        }
    }
}

/// The part behind `serial://`: a path, and a baud rate if it is not the usual one.
fn serial(rest: &str) -> Result<EndpointAddress, String> {
    let (path, query) = rest.split_once('?').unwrap_or((rest, ""));
    if path.is_empty() {
        return Err("expected the path of a device, for example /dev/ttyACM0".to_owned());
    }
    let baud = match query {
        "" => DEFAULT_BAUD,
        query => match query.strip_prefix("baud=").map(str::parse::<u32>) {
            Some(Ok(baud)) if baud > 0 => baud,
            _ => return Err("after the ? only baud=NUMBER is known".to_owned()),
        },
    };
    Ok(EndpointAddress::Serial {
        path: path.to_owned(),
        baud,
    })
}

#[cfg(test)]
mod tests;
