//! What the swarm's bus costs over each of its transports, on this host: the same traffic of the same nodes, one transport after the other in one run, beside bare UDP.
//!
//! Must never do: judge. Times hang on the machine; the ratios to bare UDP in the same run say more.
//!
//! Each node has a thread of its own that sleeps until something arrives or is due, as in the program. All are in one process, so that they have one
//! clock and the system charges them together.

use crate::error::BenchError;
use node::{Counts, Node};
use serde::Serialize;
use skein_bus::envelope::SwarmKey;
use skein_bus::local::Hub;
use skein_bus::transport::Transport;
use skein_bus_dds::Dds;
use skein_bus_zenoh::{Zenoh, ZenohSettings};
use skein_dds::DdsSettings;
use skein_domain::NodeId;
use std::fmt;
use std::net::{TcpListener, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::{Duration, Instant};

mod bare_udp;
mod node;

/// Until all nodes know each other.
const PATIENCE: Duration = Duration::from_secs(30);
/// Of the DDS domains, one that nobody is likely to use.
const DDS_DOMAIN: u16 = 97;
/// RustDDS finds no more participants of one host.
const MOST_NODES: u16 = 12;

/// What to run.
#[derive(Debug, Clone, Copy)]
pub struct BusBenchArgs {
    /// How many nodes: two to twelve.
    pub nodes: u16,
    /// For how long each transport is measured, in seconds.
    pub seconds: u32,
}

/// What one transport takes.
#[derive(Debug, Clone, Serialize)]
pub struct TransportFigures {
    /// Which.
    pub transport: &'static str,
    /// Until all nodes had proven themselves to all, in seconds.
    pub met_s: f64,
    /// What each node gives to its transport, in bytes per second.
    pub node_bytes_per_s: f64,
    /// What went over the loopback interface of this machine for each node, in bytes per second; of others' traffic too. None where the system does not tell.
    pub wire_bytes_per_s: Option<f64>,
    /// Processor time of all nodes together, as a share of one core.
    pub cpu_share: f64,
    /// That, for each datagram that arrived, in microseconds.
    pub cpu_us_per_arrival: f64,
    /// From telling a vehicle's state to its being known to another node, in microseconds: the median.
    pub p50_us: f64,
    /// And what one in a hundred takes longer than.
    pub p99_us: f64,
    /// How many states that is of.
    pub states: usize,
    /// 100 kB from node to node, in seconds: the median.
    pub bulk_s: Option<f64>,
    /// Processor time as a multiple of bare UDP's.
    pub cpu_ratio: f64,
    /// Median latency as a multiple of bare UDP's.
    pub p50_ratio: f64,
}

/// All transports, beside each other.
#[derive(Debug, Clone, Serialize)]
pub struct BusBenchReport {
    /// How many nodes.
    pub nodes: u16,
    /// For how long each was measured, in seconds.
    pub seconds: u32,
    /// In the order in which they ran. The second one is bare UDP.
    pub transports: Vec<TransportFigures>,
}

impl fmt::Display for BusBenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} nodes: beacon 10 Hz, vehicle 5 Hz, intent of 600 bytes and 100 kB of bulk every two seconds; {} s each",
            self.nodes, self.seconds
        )?;
        writeln!(
            f,
            "transport    met after  each sends  on lo, each      CPU  per arrival   p50        p99        bulk    CPU  p50 (bare UDP = 1)"
        )?;
        for of in &self.transports {
            let wire = of
                .wire_bytes_per_s
                .map_or("?".to_owned(), |bytes| format!("{:.1}", bytes / 1e3));
            let bulk = of.bulk_s.map_or("-".to_owned(), |took_s| format!("{took_s:.2} s"));
            writeln!(
                f,
                "{:<11}  {:6.2} s  {:5.1} kB/s  {wire:>6} kB/s  {:5.1} %  {:5.0} us  {:7.0} us {:7.0} us  {bulk:>7}  {:4.1} {:4.1}",
                of.transport,
                of.met_s,
                of.node_bytes_per_s / 1e3,
                of.cpu_share * 100.0,
                of.cpu_us_per_arrival,
                of.p50_us,
                of.p99_us,
                of.cpu_ratio,
                of.p50_ratio
            )?;
        }
        Ok(())
    }
}

type Opened = Vec<Box<dyn Transport>>;

/// Runs the same traffic over all transports.
///
/// # Errors
///
/// The number of nodes makes no sense, a transport does not open, or its nodes do not find each other.
pub fn run_bus_bench(args: &BusBenchArgs) -> Result<BusBenchReport, BenchError> {
    if !(2..=MOST_NODES).contains(&args.nodes) {
        return Err(BenchError::Argument(format!(
            "two to {MOST_NODES} nodes, not {}",
            args.nodes
        )));
    }
    let nodes: Vec<NodeId> = (1..=u64::from(args.nodes)).map(NodeId).collect();
    let hub = Hub::default();
    let local: Opened = nodes
        .iter()
        .map(|node| Box::new(hub.join(*node)) as Box<dyn Transport>)
        .collect();
    let mut transports = vec![
        measured("in-process", local, args)?,
        measured("bare UDP", bare_udp::open(&nodes)?, args)?,
        measured("Zenoh UDP", zenoh("udp", &nodes)?, args)?,
        measured("Zenoh TCP", zenoh("tcp", &nodes)?, args)?,
        measured("DDS", dds(&nodes)?, args)?,
    ];
    if let Some((cpu, p50_us)) = transports.get(1).map(|bare| (bare.cpu_share, bare.p50_us)) {
        for of in &mut transports {
            of.cpu_ratio = of.cpu_share / cpu;
            of.p50_ratio = of.p50_us / p50_us;
        }
    }
    Ok(BusBenchReport {
        nodes: args.nodes,
        seconds: args.seconds,
        transports,
    })
}

fn zenoh(protocol: &str, nodes: &[NodeId]) -> Result<Opened, BenchError> {
    let mut known: Vec<String> = Vec::new();
    let mut opened: Opened = Vec::new();
    for node in nodes {
        let listen = format!("{protocol}/127.0.0.1:{}", free_port()?);
        let settings = ZenohSettings {
            listen: vec![listen.clone()],
            connect: known.clone(),
            ..ZenohSettings::default()
        };
        known.push(listen);
        let transport = Zenoh::open(&swarm(), *node, &settings);
        opened.push(Box::new(transport.map_err(|e| BenchError::Program(e.to_string()))?));
    }
    Ok(opened)
}

fn dds(nodes: &[NodeId]) -> Result<Opened, BenchError> {
    let settings = DdsSettings {
        domain_id: DDS_DOMAIN,
        ..DdsSettings::default()
    };
    let open = |node: &NodeId| -> Result<Box<dyn Transport>, BenchError> {
        let participant = skein_dds::join(&settings).map_err(|e| BenchError::Program(e.to_string()))?;
        let transport = Dds::open(&swarm(), *node, participant);
        Ok(Box::new(transport.map_err(|e| BenchError::Program(e.to_string()))?))
    };
    nodes.iter().map(open).collect()
}

/// A swarm that no other run of the bench is.
fn swarm() -> String {
    format!("bench-{}", std::process::id())
}

/// A port that is free for TCP and UDP, and outside of those that the system gives to whoever connects.
fn free_port() -> Result<u16, BenchError> {
    let begin = 20_000 + (std::process::id() % 10_000) as u16;
    let free = |port: &u16| {
        let here = ("127.0.0.1", *port);
        TcpListener::bind(here).is_ok() && UdpSocket::bind(here).is_ok()
    };
    // Each call goes on behind the last one.
    static CALLS: AtomicU8 = AtomicU8::new(0);
    let begin = begin + u16::from(CALLS.fetch_add(1, Ordering::Relaxed)) * 8;
    let found = (begin..begin + 8).find(free);
    found.ok_or_else(|| BenchError::Program("no free port".to_owned()))
}

fn measured(name: &'static str, transports: Opened, args: &BusBenchArgs) -> Result<TransportFigures, BenchError> {
    let key = SwarmKey::derive("bench", b"a secret of thirty-two bytes ...")
        .map_err(|e| BenchError::Program(e.to_string()))?;
    let counts = Arc::new(Counts::default());
    let begun = Instant::now();
    let all: Vec<NodeId> = transports.iter().map(|transport| transport.node()).collect();
    let running: Vec<node::Running> = transports
        .into_iter()
        .map(|transport| Node::new(transport, &key, &all, begun, &counts).run())
        .collect::<Result<_, _>>()?;
    while counts.met() < all.len() {
        if begun.elapsed() > PATIENCE {
            return Err(BenchError::Program(format!(
                "the nodes did not find each other over {name}"
            )));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let met_s = begun.elapsed().as_secs_f64();
    // What joining takes is not measured.
    std::thread::sleep(Duration::from_secs(2));
    let (cpu_s, wire, since) = (cpu_s()?, loopback_bytes(), Instant::now());
    let before = counts.begin();
    std::thread::sleep(Duration::from_secs(u64::from(args.seconds)));
    let took_s = since.elapsed().as_secs_f64();
    let seen = counts.end(&before);
    let (cpu_s, wire_after) = (self::cpu_s()? - cpu_s, loopback_bytes());
    drop(running);
    let nodes = f64::from(args.nodes);
    let wire_bytes = wire
        .zip(wire_after)
        .map(|(before, after)| after.saturating_sub(before) as f64);
    Ok(TransportFigures {
        transport: name,
        met_s,
        node_bytes_per_s: seen.sent_bytes as f64 / took_s / nodes,
        wire_bytes_per_s: wire_bytes.map(|bytes| bytes / took_s / nodes),
        cpu_share: cpu_s / took_s,
        cpu_us_per_arrival: cpu_s * 1e6 / seen.arrivals.max(1) as f64,
        p50_us: quantile(&seen.latencies_us, 0.5).unwrap_or(f64::NAN),
        p99_us: quantile(&seen.latencies_us, 0.99).unwrap_or(f64::NAN),
        states: seen.latencies_us.len(),
        bulk_s: quantile(&seen.bulk_us, 0.5).map(|us| us * 1e-6),
        cpu_ratio: f64::NAN,
        p50_ratio: f64::NAN,
    })
}

/// Of sorted values.
fn quantile(sorted: &[u64], share: f64) -> Option<f64> {
    let place = (sorted.len() as f64 * share) as usize;
    sorted
        .get(place.min(sorted.len().saturating_sub(1)))
        .map(|value| *value as f64)
}

/// Processor time of this process, all threads, in seconds.
fn cpu_s() -> Result<f64, BenchError> {
    use nix::sys::resource::{UsageWho, getrusage};
    let usage = getrusage(UsageWho::RUSAGE_SELF).map_err(BenchError::system("getrusage"))?;
    let seconds = |time: nix::sys::time::TimeVal| time.tv_sec() as f64 + time.tv_usec() as f64 * 1e-6;
    Ok(seconds(usage.user_time()) + seconds(usage.system_time()))
}

/// What has gone over the loopback interface so far; none where the system does not tell.
fn loopback_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/net/dev").ok()?;
    let line = text.lines().find_map(|line| line.trim_start().strip_prefix("lo:"))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests;
