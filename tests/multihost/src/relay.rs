//! What is between the hosts: a switch for Ethernet frames that treats each direction between two hosts as it is told to.
//!
//! The far end of every host's `air` is a TAP device of this process. So loss, delay, jitter, doubles, overtaking, one-way links and
//! partitions are all made in one place, drawn from one seed, and alike for unicast and multicast; the kernel's own means (which here has
//! no netem) would be three, two of them without a seed. The rate of a host is the kernel's: see [`crate::net::Network::limit_rate`].
//!
//! Must never do: look into a frame further than to which host and port it is addressed.

mod fate;

pub use fate::Quality;

use anyhow::{Context, Result, anyhow};
use fate::Way;
use parking_lot::Mutex;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::io::unix::AsyncFd;
use tokio::sync::{mpsc, oneshot};
use tokio::time::{Instant, sleep, sleep_until};
use tun_rs::{DeviceBuilder, Layer, SyncDevice};

/// Largest frame.
const FRAME_BYTES: usize = 9000;
/// Frames under way at once; beyond it they are lost, as in any queue.
const UNDER_WAY: usize = 20_000;
/// First octets of the hosts' addresses; the last one is the host's number. Locally administered.
const MAC: [u8; 5] = [0x02, 0x53, 0x4b, 0x00, 0x00];

type Ways = Arc<Mutex<BTreeMap<(u8, u8), Way>>>;
/// UDP ports from and to which nothing passes.
type Closed = Arc<Mutex<BTreeSet<u16>>>;
type Device = Arc<AsyncFd<SyncDevice>>;
/// When, in which order of those of the same moment, to whom, what.
type UnderWay = Reverse<(Instant, u64, u8, Vec<u8>)>;

/// The air between the hosts, on a thread of its own.
#[derive(Debug)]
pub struct Relay {
    ways: Ways,
    closed: Closed,
    hosts: u8,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Relay {
    /// Makes the devices of so many hosts and begins to relay.
    ///
    /// # Errors
    /// When devices cannot be made.
    pub fn start(hosts: u8, seed: u64) -> Result<Self> {
        let pairs = (1..=hosts).flat_map(|from| (1..=hosts).map(move |to| (from, to)));
        let ways = pairs.filter(|(from, to)| from != to);
        let ways: Ways = Arc::new(Mutex::new(
            ways.map(|(from, to)| ((from, to), Way::new(seed, from, to))).collect(),
        ));
        let (stop, stopped) = oneshot::channel();
        let (ready, is_ready) = std::sync::mpsc::channel();
        let closed = Closed::default();
        let (shared, also_closed) = (ways.clone(), closed.clone());
        let thread = std::thread::Builder::new()
            .name("relay".to_owned())
            .spawn(move || serve(hosts, shared, also_closed, &ready, stopped))?;
        is_ready.recv().map_err(|_| anyhow!("the relay's thread has ended"))??;
        Ok(Self {
            ways,
            closed,
            hosts,
            stop: Some(stop),
            thread: Some(thread),
        })
    }

    /// Name of a host's device before it is moved into its namespace.
    #[must_use]
    pub fn device(host: u8) -> String {
        format!("skmh-air{host}")
    }

    /// A host's hardware address.
    #[must_use]
    pub fn mac_text(host: u8) -> String {
        let octets = MAC.iter().chain([&host]).map(|octet| format!("{octet:02x}"));
        octets.collect::<Vec<_>>().join(":")
    }

    /// All directions between all hosts are like this from now on. Cuts stay.
    pub fn everywhere(&self, quality: Quality) {
        self.ways.lock().values_mut().for_each(|way| way.quality = quality);
    }

    /// Nothing more passes from the one host to the other, or it does again; the other direction stays as it is.
    pub fn cut(&self, from: u8, to: u8, cut: bool) {
        if let Some(way) = self.ways.lock().get_mut(&(from, to)) {
            way.cut = cut;
        }
    }

    /// These hosts on the one side, all others on the other; nothing passes between the two.
    pub fn part(&self, one_side: &[u8]) {
        for ((from, to), way) in self.ways.lock().iter_mut() {
            way.cut = one_side.contains(from) != one_side.contains(to);
        }
    }

    /// No link is cut any more.
    pub fn join(&self) {
        self.part(&[]);
    }

    /// Nothing from or to this UDP port passes any more, between any hosts: what speaks over it has failed, and nothing else.
    pub fn close_port(&self, port: u16) {
        self.closed.lock().insert(port);
    }

    /// All ports are open again.
    pub fn open_ports(&self) {
        self.closed.lock().clear();
    }

    /// How many hosts there are.
    #[must_use]
    pub fn hosts(&self) -> u8 {
        self.hosts
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        if let Some(stop) = self.stop.take() {
            let _ = stop.send(());
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// The thread: makes the devices, says so, relays until it is stopped.
fn serve(
    hosts: u8,
    ways: Ways,
    closed: Closed,
    ready: &std::sync::mpsc::Sender<Result<()>>,
    stopped: oneshot::Receiver<()>,
) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let runtime = match runtime {
        Ok(runtime) => runtime,
        Err(error) => {
            let _ = ready.send(Err(error.into()));
            return;
        }
    };
    runtime.block_on(async {
        let devices: Result<BTreeMap<u8, Device>> = (1..=hosts).map(|host| Ok((host, open(host)?))).collect();
        let devices = match devices {
            Ok(devices) => devices,
            Err(error) => {
                let _ = ready.send(Err(error));
                return;
            }
        };
        let (send, receive) = mpsc::channel(UNDER_WAY);
        for (host, device) in &devices {
            let (ways, closed) = (ways.clone(), closed.clone());
            tokio::spawn(read(*host, hosts, device.clone(), ways, closed, send.clone()));
        }
        let _ = ready.send(Ok(()));
        tokio::select! {
            () = deliver(devices, receive) => {}
            _ = stopped => {}
        }
    });
}

#[expect(
    deprecated,
    reason = "what takes its place is unsafe; a SyncDevice has one descriptor as long as it lives"
)]
fn open(host: u8) -> Result<Device> {
    let name = Relay::device(host);
    let builder = DeviceBuilder::new().name(name.clone()).layer(Layer::L2).enable(false);
    let device = builder.build_sync().context(name)?;
    device.set_nonblocking(true)?;
    Ok(Arc::new(AsyncFd::new(device)?))
}

/// Takes the frames of one host and decides when they arrive where.
async fn read(host: u8, hosts: u8, device: Device, ways: Ways, closed: Closed, send: mpsc::Sender<UnderWay>) {
    let mut buffer = vec![0; FRAME_BYTES];
    let mut count = 0;
    loop {
        let Ok(mut guard) = device.readable().await else { return };
        let length = match guard.try_io(|device| device.get_ref().recv(&mut buffer)) {
            Ok(Ok(length)) => length,
            // while it is moved and not up yet
            Ok(Err(_)) => {
                sleep(Duration::from_millis(20)).await;
                continue;
            }
            Err(_would_block) => continue,
        };
        let frame = buffer.get(..length).unwrap_or_default();
        if udp_ports(frame).is_some_and(|ports| ports.iter().any(|port| closed.lock().contains(port))) {
            continue;
        }
        let now = Instant::now();
        for to in (1..=hosts).filter(|to| *to != host && is_for(frame, *to)) {
            let arrivals: Vec<f64> = match ways.lock().get_mut(&(host, to)) {
                Some(way) => way.arrivals_s().collect(),
                None => Vec::new(),
            };
            for after_s in arrivals {
                count += 1;
                let due = now + Duration::from_secs_f64(after_s);
                let _ = send.try_send(Reverse((due, count, to, frame.to_vec())));
            }
        }
    }
}

/// Whether a frame is for this host: to its own address, or to a group.
fn is_for(frame: &[u8], host: u8) -> bool {
    match frame.get(..6) {
        Some([first, ..]) if first & 1 == 1 => true,
        Some([rest @ .., last]) => rest == MAC && *last == host,
        _ => false,
    }
}

/// From and to which UDP port a frame goes, if it is the beginning of a datagram over IPv4.
fn udp_ports(frame: &[u8]) -> Option<[u16; 2]> {
    let packet = frame.get(14..)?;
    let is_udp = frame.get(12..14)? == [0x08, 0x00] && *packet.get(9)? == 17;
    let continues = u16::from_be_bytes([*packet.get(6)?, *packet.get(7)?]) & 0x1fff != 0;
    if !is_udp || continues {
        return None;
    }
    let header = usize::from(packet.first()? & 0x0f) * 4;
    match packet.get(header..header + 4)? {
        [a, b, c, d] => Some([u16::from_be_bytes([*a, *b]), u16::from_be_bytes([*c, *d])]),
        _ => None,
    }
}

/// Hands frames over when they are due.
async fn deliver(devices: BTreeMap<u8, Device>, mut receive: mpsc::Receiver<UnderWay>) {
    let mut waiting: BinaryHeap<UnderWay> = BinaryHeap::new();
    loop {
        let next = waiting.peek().map(|Reverse((due, ..))| *due);
        let due = async {
            match next {
                Some(due) => sleep_until(due).await,
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            frame = receive.recv() => match frame {
                Some(frame) if waiting.len() < UNDER_WAY => waiting.push(frame),
                Some(_) => {}
                None => return,
            },
            () = due => {}
        }
        while waiting.peek().is_some_and(|Reverse((due, ..))| *due <= Instant::now()) {
            let Some(Reverse((_, _, to, frame))) = waiting.pop() else {
                break;
            };
            if let Some(device) = devices.get(&to) {
                // a device that is down, or whose queue is full, loses it
                let _ = device.get_ref().send(&frame);
            }
        }
    }
}

#[cfg(test)]
mod tests;
