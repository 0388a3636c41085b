//! TCP and serial lines: bytes both ways, and opened again when they break.

use super::hub::Hub;
use crate::address::EndpointAddress;
use crate::error::EndpointError;
use crate::event::EndpointEvent;
use crate::frame::StreamBuffer;
use crate::outlet::{ByteQueue, Line};
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Instant, sleep_until, timeout};
use tokio_serial::SerialPortBuilderExt;

/// First pause before another attempt; it doubles up to the setting.
const RETRY_FIRST_S: f64 = 0.25;
/// How long a connection attempt may take.
const CONNECT_MAX: Duration = Duration::from_secs(5);

/// Works the line for ever: opens it, moves bytes until it breaks, waits, opens it again.
pub async fn run(mut hub: Hub) -> EndpointError {
    let mut pause_s = RETRY_FIRST_S;
    let mut was_down = false;
    loop {
        let broke = match open(&hub.settings.address).await {
            Ok((stream, local_addr)) => {
                pause_s = RETRY_FIRST_S;
                was_down = false;
                hub.report(EndpointEvent::Bound {
                    endpoint: Arc::clone(&hub.slot.name),
                    local_addr,
                });
                work(&mut hub, stream).await
            }
            Err(error) => error,
        };
        // Once per outage, not once per attempt.
        if !std::mem::replace(&mut was_down, true) {
            let reason = format!("{}: {broke}", hub.settings.address);
            hub.report(EndpointEvent::Down {
                endpoint: Arc::clone(&hub.slot.name),
                reason,
            });
        }
        rest(&mut hub, pause_s).await;
        pause_s = (pause_s * 2.0).min(hub.settings.reconnect_max_s);
    }
}

/// Waits, while the links on this line still get their ticks: their loss must be noticed, their guards must act.
async fn rest(hub: &mut Hub, pause_s: f64) {
    let end = Instant::now() + Duration::from_secs_f64(pause_s);
    loop {
        let now = hub.now();
        let due_s = hub.tick(now).seconds_since(now).max(0.0);
        let wake = Instant::now() + Duration::from_secs_f64(due_s);
        sleep_until(wake.min(end)).await;
        if Instant::now() >= end {
            return;
        }
    }
}

/// Both kinds of line as one.
trait Duplex: AsyncRead + AsyncWrite + Send + Unpin {}
impl<T: AsyncRead + AsyncWrite + Send + Unpin> Duplex for T {}

async fn open(address: &EndpointAddress) -> io::Result<(Box<dyn Duplex>, Option<SocketAddr>)> {
    match address {
        EndpointAddress::TcpConnect(host_port) => {
            let connecting = timeout(CONNECT_MAX, TcpStream::connect(host_port.as_str()));
            let stream = connecting
                .await
                .map_err(|_| io::Error::from(io::ErrorKind::TimedOut))??;
            stream.set_nodelay(true)?;
            let local_addr = stream.local_addr().ok();
            Ok((Box::new(stream), local_addr))
        }
        EndpointAddress::Serial { path, baud } => {
            let port = tokio_serial::new(path, *baud)
                .open_native_async()
                .map_err(io::Error::from)?;
            Ok((Box::new(port), None))
        }
        EndpointAddress::UdpListen(_) | EndpointAddress::UdpConnect(_) => Err(io::ErrorKind::Unsupported.into()),
    }
}

/// Moves bytes until the line breaks; gives why it did.
async fn work(hub: &mut Hub, stream: Box<dyn Duplex>) -> io::Error {
    let (mut reader, mut writer) = tokio::io::split(stream);
    let queue = Arc::new(ByteQueue::default());
    let _open = hub.slot.outlet.open(Line::Queue(Arc::clone(&queue)));
    let writing = async move {
        let mut bytes = Vec::new();
        loop {
            queue.take(&mut bytes).await;
            if let Err(error) = writer.write_all(&bytes).await {
                return error;
            }
        }
    };
    tokio::pin!(writing);
    let mut buffer = StreamBuffer::default();
    let timer = sleep_until(Instant::now());
    tokio::pin!(timer);
    loop {
        let read = tokio::select! {
            biased;
            read = reader.read(buffer.space()) => Some(read),
            error = &mut writing => return error,
            () = &mut timer => None,
        };
        let now = hub.now();
        match read {
            Some(Ok(0)) => return io::ErrorKind::UnexpectedEof.into(),
            Some(Ok(count)) => {
                hub.counters.wake_ups += 1;
                hub.on_bytes(now, &mut buffer, count);
                hub.publish();
            }
            Some(Err(error)) if error.kind() == io::ErrorKind::Interrupted => {}
            Some(Err(error)) => return error,
            None => {}
        }
        hub.hello(now);
        let wait_s = hub.tick(now).seconds_since(now).max(0.0);
        timer.as_mut().reset(Instant::now() + Duration::from_secs_f64(wait_s));
    }
}
