//! H.264 as RTP that somebody sends to a UDP port of ours: air units, encoders, other ground stations.
//!
//! Must never do: answer whoever sends, or give a picture that is not whole.

mod assembly;
mod order;
mod reception;

pub(crate) use reception::Lack;
pub(super) use reception::Reception;

use self::reception::{Counts, MOST_DATAGRAM_BYTES};
use super::{Coded, Outlet, StreamFault};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use skein_plugin_sdk::abi::LogLevel;
use skein_plugin_sdk::log::Logger;
use socket2::{Domain, Protocol, Socket, Type};
use std::io::ErrorKind;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

/// No whole picture for so long is told. It is listened on all the while.
const SILENT_AFTER: Duration = Duration::from_secs(5);
/// How often it is looked whether anybody still wants the stream.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// What was wrong with datagrams of a stream that comes is told no more often.
const COUNTS_EVERY: Duration = Duration::from_secs(60);
/// A key picture comes at one go, and is larger than what the system keeps by itself.
const SOCKET_BUFFER_BYTES: usize = 2 << 20;
const START_CODE: [u8; 4] = [0, 0, 0, 1];

/// Where RTP comes to.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RtpPort {
    /// Address and port; the address of a group is joined.
    pub(crate) listen: SocketAddr,
    /// Parameter sets in Annex B's byte stream, for a sender that does not send them.
    pub(crate) parameter_sets: Vec<u8>,
}

/// Reads parameter sets as SDP has them (`sprop-parameter-sets`): base64, with commas between. Or says which is none.
pub(crate) fn parameter_sets(text: &str) -> Result<Vec<u8>, String> {
    let mut sets = Vec::new();
    for one in text.split(',').map(str::trim).filter(|one| !one.is_empty()) {
        let set = STANDARD.decode(one).map_err(|error| format!("{one:?}: {error}"))?;
        match set.first().map(|header| header & 0x9f) {
            Some(7 | 8) => {}
            _ => return Err(format!("{one:?} is no SPS or PPS of H.264")),
        }
        sets.extend(START_CODE);
        sets.extend(set);
    }
    if sets.len() > assembly::MOST_HELD_BYTES {
        return Err(format!("more than {} bytes", assembly::MOST_HELD_BYTES));
    }
    Ok(sets)
}

/// Reads until nobody wants it any more.
pub(super) fn read(port: &RtpPort, logger: Option<&Logger>, outlet: &Outlet) -> Result<(), StreamFault> {
    let failed = |error: std::io::Error| StreamFault::Port {
        listen: port.listen,
        reason: error.to_string(),
    };
    let socket = open(port.listen).map_err(failed)?;
    receive(&socket, port, logger, outlet).map_err(failed)
}

fn open(listen: SocketAddr) -> std::io::Result<UdpSocket> {
    let socket = Socket::new(Domain::for_address(listen), Type::DGRAM, Some(Protocol::UDP))?;
    // The system gives what it permits; less costs pictures only when this computer is busy.
    let _ = socket.set_recv_buffer_size(SOCKET_BUFFER_BYTES);
    let is_group = listen.ip().is_multicast();
    if is_group {
        // Others of this computer may listen to the group too.
        socket.set_reuse_address(true)?;
    }
    socket.bind(&listen.into())?;
    match listen.ip() {
        IpAddr::V4(group) if is_group => socket.join_multicast_v4(&group, &Ipv4Addr::UNSPECIFIED)?,
        IpAddr::V6(group) if is_group => socket.join_multicast_v6(&group, 0)?,
        _ => {}
    }
    Ok(socket.into())
}

fn receive(socket: &UdpSocket, port: &RtpPort, logger: Option<&Logger>, outlet: &Outlet) -> std::io::Result<()> {
    socket.set_read_timeout(Some(LOOK_EVERY))?;
    let began = Instant::now();
    let mut last_picture = began;
    let mut reception = Reception::new(port.parameter_sets.clone());
    let mut journal = Journal::new(port.listen, began);
    // One byte more than is taken, so that what is too large is seen to be.
    let mut datagram = vec![0; MOST_DATAGRAM_BYTES + 1];
    while outlet.is_wanted() {
        match socket.recv(&mut datagram) {
            Ok(len) => {
                for picture in reception.take(began.elapsed(), datagram.get(..len).unwrap_or_default()) {
                    last_picture = Instant::now();
                    let coded = Coded {
                        left_out: picture.left_out,
                        ..Coded::at_once(picture.bytes)
                    };
                    if !outlet.give(Ok(coded)) {
                        return Ok(());
                    }
                }
            }
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
                ) => {}
            Err(error) => return Err(error),
        }
        if last_picture.elapsed() >= SILENT_AFTER {
            last_picture = Instant::now();
            outlet.give(Err(StreamFault::NoRtpPicture {
                listen: port.listen,
                within_s: SILENT_AFTER.as_secs(),
                lack: reception.take_lack(),
            }));
        }
        journal.tell(reception.counts(), logger);
    }
    Ok(())
}

/// Tells now and then what of a stream was of no use.
struct Journal {
    listen: SocketAddr,
    told_at: Instant,
    told: Counts,
}

impl Journal {
    fn new(listen: SocketAddr, now: Instant) -> Self {
        Self {
            listen,
            told_at: now,
            told: Counts::default(),
        }
    }

    fn tell(&mut self, counts: Counts, logger: Option<&Logger>) {
        if self.told_at.elapsed() < COUNTS_EVERY {
            return;
        }
        let useless = counts.useless_since(&self.told);
        if let (Some(useless), Some(logger)) = (useless, logger) {
            logger.log(LogLevel::WARN, &format!("{}: {useless}", self.listen));
        }
        self.told = counts;
        self.told_at = Instant::now();
    }
}

#[cfg(test)]
mod tests;
