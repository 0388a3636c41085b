//! UDP, listening or connected: batches of datagrams, read until there are no more.

use super::hub::Hub;
use crate::error::EndpointError;
use crate::event::EndpointEvent;
use crate::frame::MAX_DATAGRAM_BYTES;
use crate::outlet::{Line, OutletGuard};
use socket2::{Domain, Protocol, Socket, Type};
use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;
use tokio::net::UdpSocket;
use tokio::time::{Instant, sleep, sleep_until};

/// Datagrams read before others get their turn.
const BATCH_MAX: usize = 512;
/// The receive rate is measured over this time, in seconds.
const RATE_WINDOW_S: f64 = 0.25;

/// An open UDP port.
pub struct Port {
    socket: Arc<UdpSocket>,
    connected: bool,
    _open: OutletGuard,
}

impl Port {
    /// Binds an address.
    pub fn listen(hub: &mut Hub, address: SocketAddr) -> Result<Self, EndpointError> {
        let socket = bind(hub, address).map_err(|source| bind_error(hub, source))?;
        Ok(Self::open(hub, socket, false))
    }

    /// Binds any port and connects it.
    pub async fn connect(hub: &mut Hub, address: SocketAddr) -> Result<Self, EndpointError> {
        let any = match address {
            SocketAddr::V4(v4) if v4.ip().is_loopback() => SocketAddr::from((Ipv4Addr::LOCALHOST, 0)),
            SocketAddr::V4(_) => SocketAddr::from((Ipv4Addr::UNSPECIFIED, 0)),
            SocketAddr::V6(_) => SocketAddr::from((Ipv6Addr::UNSPECIFIED, 0)),
        };
        let socket = bind(hub, any).map_err(|source| bind_error(hub, source))?;
        socket
            .connect(address)
            .await
            .map_err(|source| bind_error(hub, source))?;
        Ok(Self::open(hub, socket, true))
    }

    fn open(hub: &mut Hub, socket: UdpSocket, connected: bool) -> Self {
        let socket = Arc::new(socket);
        let line = if connected {
            Line::Connected(Arc::clone(&socket))
        } else {
            Line::Bound(Arc::clone(&socket))
        };
        let open = hub.slot.outlet.open(line);
        let local_addr = socket.local_addr().ok();
        hub.report(EndpointEvent::Bound {
            endpoint: Arc::clone(&hub.slot.name),
            local_addr,
        });
        Self {
            socket,
            connected,
            _open: open,
        }
    }

    /// Works the port until the system gives up on it.
    pub async fn run(self, mut hub: Hub) -> EndpointError {
        let mut buffer = vec![0_u8; MAX_DATAGRAM_BYTES];
        let mut rate = ReceiveRate::default();
        let mut timer_due = hub.now();
        let timer = sleep_until(Instant::now());
        tokio::pin!(timer);
        loop {
            let readable = tokio::select! {
                biased;
                readable = self.socket.readable() => readable,
                () = &mut timer => Ok(()),
            };
            if let Err(source) = readable {
                return EndpointError::Ended {
                    name: hub.settings.name.clone(),
                    detail: source.to_string(),
                };
            }
            let now = hub.now();
            let received = self.drain(&mut hub, now, &mut buffer);
            if self.connected {
                hub.hello(now);
            }
            let due = hub.tick(now);
            if due != timer_due || timer.is_elapsed() {
                timer_due = due;
                timer
                    .as_mut()
                    .reset(Instant::now() + Duration::from_secs_f64(due.seconds_since(now).max(0.0)));
            }
            rate.add(now.as_seconds(), received);
            if received >= BATCH_MAX {
                tokio::task::yield_now().await;
            } else if received > 0 && rate.per_second > hub.settings.coalesce_above_hz {
                // More is coming anyway: let it come, rather than be woken by each datagram.
                sleep(Duration::from_secs_f64(hub.settings.coalesce_s.clamp(0.0, 0.02))).await;
            }
        }
    }

    /// Reads what is there; gives how many datagrams.
    fn drain(&self, hub: &mut Hub, now: skein_domain::NodeTime, buffer: &mut [u8]) -> usize {
        let mut received = 0;
        while received < BATCH_MAX {
            let read = if self.connected {
                self.socket.try_recv(buffer).map(|len| (len, None))
            } else {
                self.socket.try_recv_from(buffer).map(|(len, from)| (len, Some(from)))
            };
            match read {
                Ok((len, from)) => {
                    received += 1;
                    hub.on_datagram(now, buffer.get(..len).unwrap_or_default(), from);
                }
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
                // An ICMP "nobody there" for something sent earlier, and the like: it concerns one vehicle, not the port.
                Err(_) => {
                    received += 1;
                    hub.counters.receive_errors += 1;
                }
            }
        }
        if received > 0 {
            hub.counters.wake_ups += 1;
            hub.publish();
        }
        received
    }
}

/// Datagrams per second, measured in short windows.
#[derive(Default)]
struct ReceiveRate {
    since_s: f64,
    count: usize,
    per_second: f64,
}

impl ReceiveRate {
    fn add(&mut self, now_s: f64, received: usize) {
        self.count += received;
        let elapsed_s = now_s - self.since_s;
        if elapsed_s >= RATE_WINDOW_S {
            self.per_second = self.count as f64 / elapsed_s;
            (self.since_s, self.count) = (now_s, 0);
        }
    }
}

fn bind(hub: &Hub, address: SocketAddr) -> io::Result<UdpSocket> {
    let socket = Socket::new(Domain::for_address(address), Type::DGRAM, Some(Protocol::UDP))?;
    socket.set_nonblocking(true)?;
    // A wish: the system grants what it is configured to.
    let _ = socket.set_recv_buffer_size(hub.settings.receive_buffer_bytes);
    socket.bind(&address.into())?;
    UdpSocket::from_std(socket.into())
}

fn bind_error(hub: &Hub, source: io::Error) -> EndpointError {
    let (name, address) = (hub.settings.name.clone(), hub.settings.address.clone());
    if source.kind() == io::ErrorKind::AddrInUse {
        EndpointError::AddressInUse { name, address }
    } else {
        EndpointError::Bind { name, address, source }
    }
}
