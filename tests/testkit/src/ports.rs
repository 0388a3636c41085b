//! Ports that nobody uses.
//!
//! Must never do: hand out a fixed port. Where the code under test can bind port 0 and tell which it got, that is better still:
//! between asking here and binding there, another process may take the port.

use std::net::{Ipv4Addr, TcpListener, UdpSocket};

/// A UDP port that was free a moment ago on loopback.
///
/// # Panics
/// If the system has no free port.
#[must_use]
pub fn free_udp_port() -> u16 {
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("a free UDP port");
    socket.local_addr().expect("a bound socket has an address").port()
}

/// A TCP port that was free a moment ago on loopback.
///
/// # Panics
/// If the system has no free port.
#[must_use]
pub fn free_tcp_port() -> u16 {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a free TCP port");
    listener.local_addr().expect("a bound socket has an address").port()
}
