//! A payload's own line to its device: a UDP socket or a serial line, kept open by a task of its own.
//!
//! Bound: so many packets each way; what comes in beyond that drops the oldest, what goes out is dropped itself. Must never do: make
//! the payload's actor wait.

use parking_lot::Mutex;
use skein_state::TransportAddress;
use std::collections::VecDeque;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::UdpSocket;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio_serial::SerialPortBuilderExt;

/// Packets kept for the next batch.
const INBOX: usize = 256;
/// Packets waiting to be sent.
const OUTBOX: usize = 64;
/// A line that could not be opened, or broke, is tried again after this time.
const RETRY: Duration = Duration::from_secs(2);

/// An open line, or one that is being opened.
pub struct Transport {
    shared: Arc<Shared>,
    outbox: mpsc::Sender<Vec<u8>>,
    task: JoinHandle<()>,
}

#[derive(Default)]
struct Shared {
    inbox: Mutex<VecDeque<Vec<u8>>>,
    fault: Mutex<String>,
}

impl Drop for Transport {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Transport {
    /// Begins to open the line.
    pub fn open(address: TransportAddress) -> Self {
        let shared = Arc::new(Shared::default());
        let (outbox, packets) = mpsc::channel(OUTBOX);
        let task = tokio::spawn(keep_open(address, shared.clone(), packets));
        Self { shared, outbox, task }
    }

    /// What arrived since last asked, oldest first.
    pub fn drain(&self) -> Vec<Vec<u8>> {
        self.shared.inbox.lock().drain(..).collect()
    }

    /// Sends bytes; tells whether there was room for them.
    pub fn send(&self, bytes: Vec<u8>) -> bool {
        self.outbox.try_send(bytes).is_ok()
    }

    /// Why it does not work; empty if it does.
    pub fn fault(&self) -> String {
        self.shared.fault.lock().clone()
    }
}

async fn keep_open(address: TransportAddress, shared: Arc<Shared>, mut packets: mpsc::Receiver<Vec<u8>>) {
    loop {
        let ended = match &address {
            TransportAddress::Udp(peer) => udp(*peer, &shared, &mut packets).await,
            TransportAddress::Serial { path, baud } => serial(path, *baud, &shared, &mut packets).await,
        };
        match ended {
            Ok(()) => return,
            Err(error) => *shared.fault.lock() = format!("{address:?}: {error}"),
        }
        tokio::time::sleep(RETRY).await;
        // What waited for a line that was not there is stale.
        while packets.try_recv().is_ok() {}
    }
}

async fn udp(peer: SocketAddr, shared: &Shared, packets: &mut mpsc::Receiver<Vec<u8>>) -> std::io::Result<()> {
    let any: SocketAddr = if peer.is_ipv4() {
        SocketAddr::from(([0, 0, 0, 0], 0))
    } else {
        SocketAddr::from(([0u16; 8], 0))
    };
    let socket = UdpSocket::bind(any).await?;
    // From now on datagrams of others are not even seen.
    socket.connect(peer).await?;
    shared.fault.lock().clear();
    let mut buffer = vec![0; 2_048];
    loop {
        tokio::select! {
            received = socket.recv(&mut buffer) => match received {
                Ok(len) => shared.take(buffer.get(..len).unwrap_or_default()),
                // Nobody listens there yet: the device may come up later.
                Err(error) if error.kind() == std::io::ErrorKind::ConnectionRefused => {}
                Err(error) => return Err(error),
            },
            packet = packets.recv() => match packet {
                None => return Ok(()),
                // A refused packet is lost like any other; the plugin's own retries are for that.
                Some(bytes) => { let _ = socket.send(&bytes).await; }
            },
        }
    }
}

async fn serial(path: &str, baud: u32, shared: &Shared, packets: &mut mpsc::Receiver<Vec<u8>>) -> std::io::Result<()> {
    let mut line = tokio_serial::new(path, baud).open_native_async()?;
    shared.fault.lock().clear();
    let mut buffer = vec![0; 1_024];
    loop {
        tokio::select! {
            received = line.read(&mut buffer) => match received? {
                0 => return Err(std::io::ErrorKind::UnexpectedEof.into()),
                len => shared.take(buffer.get(..len).unwrap_or_default()),
            },
            packet = packets.recv() => match packet {
                None => return Ok(()),
                Some(bytes) => line.write_all(&bytes).await?,
            },
        }
    }
}

impl Shared {
    fn take(&self, bytes: &[u8]) {
        let mut inbox = self.inbox.lock();
        if inbox.len() == INBOX {
            inbox.pop_front();
        }
        inbox.push_back(bytes.to_vec());
    }
}

#[cfg(test)]
mod tests;
