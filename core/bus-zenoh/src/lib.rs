//! The swarm's datagrams over Zenoh: peer to peer on a LAN, through routers and over TLS or QUIC beyond it.
//!
//! Must never do: rest on more of Zenoh than that it carries datagrams; listen beyond loopback unless the settings say so; wait for a slow
//! link. What the classes of traffic promise is the bus's (`skein_bus`), and so is the seal: Zenoh's TLS comes on top of it.
//!
//! One key per receiver, class and sender: `skein/<swarm>/<receiver or "all">/<class>/<sender>`. A node subscribes to what is for it and for all.
#![forbid(unsafe_code)]

use hearing::Hearing;
use skein_bus::arrivals::Arrivals;
use skein_bus::transport::{CLASSES, Class, Datagram, SendError, To, Transport, Wake};
pub use skein_config::ZenohSettings;
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;
use std::sync::{Arc, mpsc};
use std::time::Duration;
use thiserror::Error;
use zenoh::Wait;
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::sample::Sample;

mod hearing;

/// With its key and Zenoh's headers it fits into one frame of Ethernet. Zenoh carries more, in fragments, of which each can get lost.
const LARGEST_BYTES: usize = 1300;
/// Publishers that are kept for receivers; of more all are made anew.
const MOST_PUBLISHERS: usize = 2048;

/// The environment variable with which a process must begin whose links go over TCP or TLS. Zenoh closes the socket of who vanished as TCP's "linger" says: whichever of its threads
/// does so stands still for up to ten seconds. By default one thread sends to all, and then none does.
pub const RUNTIMES: (&str, &str) = (
    "ZENOH_RUNTIME",
    "(tx: (worker_threads: 8), rx: (worker_threads: 8), net: (worker_threads: 4), acc: (worker_threads: 2))",
);
/// Who has not been heard of for so long, in milliseconds, is gone: its session ends, with what is queued for it.
const LEASE_MS: u64 = 3000;
/// How long is waited for a session that is closed.
const CLOSES_WITHIN: Duration = Duration::from_secs(1);

/// Why there is no transport.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum OpenError {
    /// The swarm's id can't be part of a key.
    #[error("a swarm's id has letters, digits, - and _ only, and at least one of them: {0:?}")]
    SwarmId(String),
    /// Zenoh does not take this setting.
    #[error("Zenoh refuses the setting {key}: {reason}")]
    Setting {
        /// Which.
        key: String,
        /// Zenoh's words.
        reason: String,
    },
    /// Zenoh could not begin.
    #[error("Zenoh did not start: {0}")]
    Start(String),
}

/// One node's transport over Zenoh. It ends when this is dropped.
///
/// Zenoh's threads are its own. [`Zenoh::open`] waits for it to start: call it where that is allowed, and within a tokio runtime only in one of
/// several threads, as Zenoh demands.
#[derive(Debug)]
pub struct Zenoh {
    node: NodeId,
    swarm: String,
    session: zenoh::Session,
    publishers: BTreeMap<(Option<NodeId>, Class), Publisher<'static>>,
    hearing: Hearing,
    arrivals: Arc<Arrivals>,
}

impl Drop for Zenoh {
    /// `Session::close` blocks for ever while a TCP peer does not read, as one that has just gone out of reach. So it gets a thread of its own,
    /// which is left behind if it takes too long.
    fn drop(&mut self) {
        let session = self.session.clone();
        let (ended, end) = mpsc::channel();
        let close = move || {
            let _told = ended.send(session.close().wait());
        };
        // Without a thread there is nothing to wait for, and no farewell.
        let _thread = std::thread::Builder::new().name("zenoh-close".to_owned()).spawn(close);
        let _closed = end.recv_timeout(CLOSES_WITHIN);
    }
}

impl Zenoh {
    /// Joins the swarm of this id.
    ///
    /// # Errors
    ///
    /// The id is none, or Zenoh refuses the settings or can't listen as they say.
    pub fn open(swarm: &str, node: NodeId, settings: &ZenohSettings) -> Result<Self, OpenError> {
        let allowed = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '_';
        if swarm.is_empty() || !swarm.chars().all(allowed) {
            return Err(OpenError::SwarmId(swarm.to_owned()));
        }
        let session = zenoh::open(configuration(settings)?).wait().map_err(start)?;
        let arrivals = Arc::new(Arrivals::default());
        let receivers = [name(Some(node)), name(None)].map(|receiver| format!("{swarm}/{receiver}"));
        let lost = settings
            .listen
            .iter()
            .chain(&settings.connect)
            .any(|at| at.starts_with("udp/"));
        let hearing = Hearing::begin(session.clone(), receivers, lost, node, Arc::clone(&arrivals))?;
        Ok(Self {
            node,
            swarm: swarm.to_owned(),
            session,
            publishers: BTreeMap::new(),
            hearing,
            arrivals,
        })
    }

    fn publisher(&mut self, to: Option<NodeId>, class: Class) -> Result<&Publisher<'static>, SendError> {
        if self.publishers.len() >= MOST_PUBLISHERS {
            self.publishers.clear();
        }
        match self.publishers.entry((to, class)) {
            std::collections::btree_map::Entry::Occupied(known) => Ok(known.into_mut()),
            std::collections::btree_map::Entry::Vacant(new) => {
                let key = format!(
                    "skein/{}/{}/{}/{}",
                    self.swarm,
                    name(to),
                    class as u8,
                    name(Some(self.node))
                );
                let publisher = self
                    .session
                    .declare_publisher(key)
                    // Nothing here may wait; what is lost is made good above.
                    .congestion_control(CongestionControl::Drop)
                    .priority(priority(class))
                    // Bulk may wait for more to fill a batch.
                    .express(class != Class::Bulk)
                    .wait();
                Ok(new.insert(publisher.map_err(down)?))
            }
        }
    }
}

impl Transport for Zenoh {
    fn node(&self) -> NodeId {
        self.node
    }

    fn largest_bytes(&self) -> usize {
        LARGEST_BYTES
    }

    fn sends_to_each(&self) -> bool {
        true
    }

    fn send(&mut self, _now: NodeTime, to: To, class: Class, bytes: &[u8]) -> Result<(), SendError> {
        self.check_size(bytes)?;
        let to = match to {
            To::One(node) => Some(node),
            To::All => None,
        };
        let publisher = self.publisher(to, class)?;
        publisher.put(bytes).wait().map_err(down)
    }

    fn receive(&mut self, now: NodeTime) -> Option<Datagram> {
        self.hearing.refresh(now);
        self.arrivals.next()
    }

    fn wake_on_arrival(&mut self, wake: Wake) {
        self.arrivals.wake_on(wake);
    }

    fn overflowed(&self) -> u64 {
        self.arrivals.overflowed()
    }
}

fn configuration(settings: &ZenohSettings) -> Result<zenoh::Config, OpenError> {
    let mut config = zenoh::Config::default();
    let mut set = |key: &str, value: &str| {
        config.insert_json5(key, value).map_err(|reason| OpenError::Setting {
            key: key.to_owned(),
            reason: reason.to_string(),
        })
    };
    set("mode", "\"peer\"")?;
    set("listen/endpoints", &list(&settings.listen))?;
    set("connect/endpoints", &list(&settings.connect))?;
    set(
        "scouting/multicast/enabled",
        if settings.multicast { "true" } else { "false" },
    )?;
    // Who is not there yet, or not any more, is tried again, and soon: a flight does not wait.
    set("connect/exit_on_failure", "false")?;
    set("connect/timeout_ms", "-1")?;
    set(
        "connect/retry",
        "{ period_init_ms: 250, period_max_ms: 1000, period_increase_factor: 2 }",
    )?;
    // A node that is alone is ready too. Nobody waits for who may never come.
    set("open/return_conditions/connect_scouted", "false")?;
    set("open/return_conditions/declares", "false")?;
    // A handshake of which a part was lost is begun anew soon; four messages of it take over a second on a slow radio.
    set("transport/unicast/open_timeout", "2000")?;
    set("transport/unicast/accept_timeout", "2000")?;
    // Who vanished is forgotten soon. Every datagram counts as a sign of life, and there are some ten per second.
    set("transport/link/tx/lease", &LEASE_MS.to_string())?;
    set("transport/link/tx/keep_alive", "6")?;
    // What finds the queue to somebody full is dropped soon: by default every such datagram would hold its sender up for a millisecond. So the
    // queues must take a burst: of all classes as many datagrams as Zenoh allows, each in a batch of its own.
    set(
        "transport/link/tx/queue/congestion_control/drop/wait_before_drop",
        "100",
    )?;
    set("transport/link/tx/batch_size", "2048")?;
    let classes = CLASSES.map(|class| format!("{}: 16", queue(class)));
    set("transport/link/tx/queue/size", &format!("{{ {} }}", classes.join(", ")))?;
    for (key, value) in &settings.extra {
        set(key, value)?;
    }
    Ok(config)
}

/// As JSON: endpoints have no characters that Rust and JSON write differently.
fn list(endpoints: &[String]) -> String {
    format!("{endpoints:?}")
}

fn arrive(arrivals: &Arrivals, me: NodeId, sample: &Sample) {
    let mut parts = sample.key_expr().as_str().rsplit('/');
    let from = parts
        .next()
        .and_then(|from| u64::from_str_radix(from, 16).ok())
        .map(NodeId);
    let class = parts.next().and_then(|class| class.parse::<usize>().ok());
    let class = class.and_then(|class| CLASSES.get(class).copied());
    // What this node tells all others comes back to it.
    if let (Some(from), Some(class)) = (from.filter(|from| *from != me), class)
        && sample.payload().len() <= LARGEST_BYTES
    {
        arrivals.put(from, class, sample.payload().to_bytes().into_owned());
    }
}

fn name(node: Option<NodeId>) -> String {
    node.map_or_else(|| "all".to_owned(), |node| format!("{:x}", node.0))
}

fn priority(class: Class) -> Priority {
    match class {
        Class::Command => Priority::RealTime,
        Class::State => Priority::InteractiveHigh,
        Class::Query => Priority::Data,
        Class::Video => Priority::DataLow,
        Class::Bulk => Priority::Background,
    }
}

/// Zenoh's name for the queue of this class.
fn queue(class: Class) -> &'static str {
    match class {
        Class::Command => "real_time",
        Class::State => "interactive_high",
        Class::Query => "data",
        Class::Video => "data_low",
        Class::Bulk => "background",
    }
}

fn start(reason: impl std::fmt::Display) -> OpenError {
    OpenError::Start(reason.to_string())
}

fn down(reason: impl std::fmt::Display) -> SendError {
    SendError::Down(reason.to_string())
}
