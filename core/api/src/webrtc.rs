//! Sessions of WebRTC that send video.
//!
//! One UDP socket serves all viewers, under the port of the web side where that is free. The node is ICE-lite: it answers under the address under
//! which the browser reached the page, and asks nobody for another one.
//!
//! Bound: [`MAX_SESSIONS`] sessions, one task each. Must never do: encode, or make a camera wait for a viewer.

mod session;

use crate::error::ApiError;
use parking_lot::Mutex;
use session::Packet;
pub(crate) use session::Session;
use std::collections::{BTreeMap, VecDeque};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::{Arc, Weak};
use tokio::net::UdpSocket;
use tokio::sync::{OnceCell, mpsc};

/// Sessions at once.
const MAX_SESSIONS: usize = 48;
/// Sessions that have ended are remembered, so many of them.
const MOST_REMEMBERED: usize = 256;
/// Datagrams that wait for one session; more are dropped, as on the way.
const MOST_WAITING: usize = 128;
/// No datagram of WebRTC is longer, in bytes.
const LONGEST_DATAGRAM: usize = 2_000;

/// Under which of its addresses the node was reached.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalAddress(pub(crate) SocketAddr);

/// All sessions, and the socket they share; made with the first.
#[derive(Debug, Default)]
pub(crate) struct WebRtc(OnceCell<Arc<Hub>>);

/// The sessions.
#[derive(Debug)]
pub(crate) struct Hub {
    socket: UdpSocket,
    port: u16,
    sessions: Mutex<BTreeMap<String, mpsc::Sender<Packet>>>,
    /// The last ones that have ended.
    ended: Mutex<VecDeque<String>>,
    /// Who speaks to which session.
    known: Mutex<BTreeMap<SocketAddr, String>>,
}

impl WebRtc {
    /// The sessions, if there ever was one.
    pub(crate) fn opened(&self) -> Option<&Arc<Hub>> {
        self.0.get()
    }

    /// The sessions, with a socket that is opened with the first.
    ///
    /// # Errors
    /// When there is no socket.
    pub(crate) async fn hub(&self, local: SocketAddr) -> Result<Arc<Hub>, ApiError> {
        let opened = self.0.get_or_try_init(|| open(local)).await;
        opened.cloned().map_err(|error| ApiError::NoSocket {
            reason: error.to_string(),
        })
    }
}

async fn open(local: SocketAddr) -> std::io::Result<Arc<Hub>> {
    let any: IpAddr = match local.ip() {
        // Reached on loopback it listens there alone, perhaps on purpose.
        loopback if loopback.is_loopback() => loopback,
        IpAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
        IpAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
    };
    let socket = match UdpSocket::bind((any, local.port())).await {
        Ok(socket) => socket,
        Err(_) => UdpSocket::bind((any, 0)).await?,
    };
    let hub = Arc::new(Hub {
        port: socket.local_addr()?.port(),
        socket,
        sessions: Mutex::default(),
        ended: Mutex::default(),
        known: Mutex::default(),
    });
    tokio::spawn(receive(Arc::downgrade(&hub)));
    Ok(hub)
}

/// Hands what arrives to its session, for as long as there is a hub.
async fn receive(hub: Weak<Hub>) {
    let mut buffer = vec![0; LONGEST_DATAGRAM];
    while let Some(hub) = hub.upgrade() {
        // Looked at every second whether anybody is left who holds the hub.
        let arrived = tokio::time::timeout(std::time::Duration::from_secs(1), hub.socket.recv_from(&mut buffer)).await;
        let Ok(Ok((len, from))) = arrived else { continue };
        let packet = Packet {
            from,
            bytes: buffer.get(..len).unwrap_or_default().into(),
        };
        let known = hub.known.lock().get(&from).cloned();
        let sessions = hub.sessions.lock();
        match known.and_then(|id| sessions.get(&id)) {
            // Full: as if it were lost on the way.
            Some(session) => drop(session.try_send(packet)),
            // A new address: the session whose secret it names takes it.
            None => sessions
                .values()
                .for_each(|session| drop(session.try_send(packet.clone()))),
        }
    }
}

impl Hub {
    /// Serves a session on a task of its own; gives its name.
    pub(crate) fn serve(
        self: &Arc<Self>,
        session: Session,
        permit: tokio::sync::OwnedSemaphorePermit,
    ) -> Result<String, ApiError> {
        let id = format!("{:032x}", rand::random::<u128>());
        let (sender, packets) = mpsc::channel(MOST_WAITING);
        {
            let mut sessions = self.sessions.lock();
            if sessions.len() >= MAX_SESSIONS {
                return Err(ApiError::TooManyStreams { limit: MAX_SESSIONS });
            }
            sessions.insert(id.clone(), sender);
        }
        let (hub, name) = (self.clone(), id.clone());
        tokio::spawn(async move {
            session.run(&hub, &name, packets).await;
            hub.forget(&name);
            drop(permit);
        });
        Ok(id)
    }

    /// Ends a session; whether there is or was one of this name. A browser that leaves closes its side first.
    pub(crate) fn end(&self, id: &str) -> bool {
        // Without its sender it ends.
        let ended = self.sessions.lock().remove(id).is_some();
        ended || self.ended.lock().iter().any(|name| name == id)
    }

    fn forget(&self, id: &str) {
        self.sessions.lock().remove(id);
        let mut ended = self.ended.lock();
        ended.push_back(id.to_owned());
        if ended.len() > MOST_REMEMBERED {
            ended.pop_front();
        }
        drop(ended);
        self.known.lock().retain(|_, session| session != id);
    }

    /// This address speaks to this session.
    fn learn(&self, from: SocketAddr, id: &str) {
        let mut known = self.known.lock();
        if known.get(&from).is_none_or(|session| session != id) {
            known.insert(from, id.to_owned());
        }
    }
}
