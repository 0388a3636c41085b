//! The way out of one endpoint, shared by its links. It stays the same object over restarts of the endpoint: closed while the
//! endpoint is down, and no link holds the socket itself, so that the port can be bound again.
//!
//! Must never do: wait. What the socket or line does not take at once is dropped and counted.

use crate::metrics::EndpointMetrics;
use parking_lot::{Mutex, RwLock};
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use tokio::net::UdpSocket;
use tokio::sync::Notify;

/// Bytes that may wait for a TCP or serial line: under a second at 57600 baud.
const QUEUE_BYTES: usize = 4096;

/// Where frames go.
#[derive(Debug, Clone)]
pub enum Line {
    /// A bound UDP socket; each frame to its vehicle's address.
    Bound(Arc<UdpSocket>),
    /// A connected UDP socket.
    Connected(Arc<UdpSocket>),
    /// Bytes one behind the other.
    Queue(Arc<ByteQueue>),
}

/// The way out.
#[derive(Debug)]
pub struct Outlet {
    line: RwLock<Option<Line>>,
    metrics: Arc<EndpointMetrics>,
}

impl Outlet {
    /// A closed one.
    #[must_use]
    pub fn new(metrics: Arc<EndpointMetrics>) -> Self {
        Self {
            line: RwLock::new(None),
            metrics,
        }
    }

    /// Opens it until the guard is dropped.
    #[must_use]
    pub fn open(self: &Arc<Self>, line: Line) -> OutletGuard {
        *self.line.write() = Some(line);
        OutletGuard(Arc::clone(self))
    }

    /// Sends one frame, or counts why not. True if the socket or line took it.
    pub fn send(&self, to: Option<SocketAddr>, frame: &[u8]) -> bool {
        let sent = match (&*self.line.read(), to) {
            (Some(Line::Bound(socket)), Some(to)) => socket.try_send_to(frame, to),
            (Some(Line::Connected(socket)), _) => socket.try_send(frame),
            (Some(Line::Queue(queue)), _) => queue.push(frame),
            (Some(Line::Bound(_)), None) | (None, _) => Err(io::ErrorKind::NotConnected.into()),
        };
        match &sent {
            Ok(_) => self.metrics.sent(frame.len()),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => self.metrics.full(),
            Err(_) => self.metrics.failed(),
        }
        sent.is_ok()
    }
}

/// Closes the outlet when the endpoint's task ends, however it ends.
#[derive(Debug)]
pub struct OutletGuard(Arc<Outlet>);

impl Drop for OutletGuard {
    fn drop(&mut self) {
        *self.0.line.write() = None;
    }
}

/// Frames waiting for a TCP or serial line, as one run of bytes.
#[derive(Debug, Default)]
pub struct ByteQueue {
    bytes: Mutex<Vec<u8>>,
    filled: Notify,
}

impl ByteQueue {
    fn push(&self, frame: &[u8]) -> io::Result<usize> {
        let mut bytes = self.bytes.lock();
        if bytes.len() + frame.len() > QUEUE_BYTES {
            return Err(io::ErrorKind::WouldBlock.into());
        }
        bytes.extend_from_slice(frame);
        drop(bytes);
        self.filled.notify_one();
        Ok(frame.len())
    }

    /// Waits for bytes and takes all there are into `taken`, whose memory is used again.
    pub async fn take(&self, taken: &mut Vec<u8>) {
        taken.clear();
        loop {
            std::mem::swap(&mut *self.bytes.lock(), taken);
            if !taken.is_empty() {
                return;
            }
            self.filled.notified().await;
        }
    }
}
