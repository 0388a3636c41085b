//! How a participant is had that leaves multicast alone.
//!
//! RustDDS takes part in multicast wherever the interface can, and then tells others to send to its group instead of to itself: on a network that does
//! not carry multicast, all of that is lost. It has no setting for this, but goes without when it can't have the ports. So these are taken while
//! it starts, and only then.
//!
//! Must never do: keep the ports for longer than a start takes, or take them from a program that has them.

use crate::peer::multicast_ports;
use socket2::{Domain, Protocol, Socket, Type};
use std::io;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::time::{Duration, Instant};

/// Others that start on this host hold the ports for a moment each: so long it is tried.
const PATIENCE: Duration = Duration::from_secs(20);
const TRY_EVERY: Duration = Duration::from_millis(5);

/// While it lives, nobody on this host begins to use a domain's multicast. Whoever does already is not disturbed.
#[derive(Debug)]
pub(crate) struct Kept(#[expect(dead_code, reason = "held for what it keeps")] [Socket; 2]);

impl Kept {
    /// Keeps it; waits while another one does.
    ///
    /// # Errors
    /// A program has a port for itself alone, and keeps it.
    pub(crate) fn wait(domain_id: u16) -> io::Result<Self> {
        let began = Instant::now();
        loop {
            match multicast_ports(domain_id).map(keep) {
                [Ok(discovery), Ok(rest)] => return Ok(Self([discovery, rest])),
                [Err(error), _] | [_, Err(error)] if began.elapsed() > PATIENCE => return Err(error),
                _ => std::thread::sleep(TRY_EVERY),
            }
        }
    }
}

/// A port that others may have had before, but that nobody gets from now on.
fn keep(port: u16) -> io::Result<Socket> {
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
    socket.set_reuse_address(true)?;
    socket.bind(&SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, port).into())?;
    socket.set_reuse_address(false)?;
    Ok(socket)
}

#[cfg(test)]
mod tests {
    use super::Kept;
    use crate::peer::multicast_ports;
    use socket2::{Domain, Socket, Type};
    use std::net::{Ipv4Addr, SocketAddrV4};

    const DOMAIN: u16 = 78;

    /// As participants do.
    fn shared(port: u16) -> std::io::Result<Socket> {
        let socket = Socket::new(Domain::IPV4, Type::DGRAM, None)?;
        socket.set_reuse_address(true)?;
        socket.set_reuse_port(true)?;
        socket.bind(&SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, port).into())?;
        Ok(socket)
    }

    #[test]
    fn nobody_begins_while_it_is_kept_and_who_has_begun_goes_on() {
        let [discovery, rest] = multicast_ports(DOMAIN);
        let before = shared(discovery).unwrap();
        let kept = Kept::wait(DOMAIN).unwrap();
        assert!(shared(discovery).is_err() && shared(rest).is_err());
        drop(kept);
        assert!(shared(discovery).is_ok() && shared(rest).is_ok());
        drop(before);
    }
}
