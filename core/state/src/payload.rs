//! One payload of a vehicle, beyond the life of its actor.
//!
//! Must never do: wait for the payload.

use crate::mailbox::PayloadMessage;
use crate::plugin::PluginRecord;
use arc_swap::ArcSwapOption;
use parking_lot::Mutex;
use ractor::ActorRef;
use skein_config::PayloadRule;
use skein_domain::payload::PayloadKind;
use skein_domain::preflight::PreflightItem;
use skein_link_mavlink::EndpointAddress;
use skein_plugin_host::Frame;
use skein_view::ActorHealth;
use std::net::SocketAddr;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64};

/// One payload of a vehicle. It outlives its actor, so that a new incarnation finds its state.
pub struct PayloadRecord {
    /// Its name on the vehicle.
    pub name: String,
    /// What it is.
    pub kind: PayloadKind,
    /// How it is configured.
    pub rule: PayloadRule,
    /// Its plugin instance.
    pub life: Arc<PluginRecord>,
    /// How its device is reached, if not over MAVLink.
    pub transport: Option<TransportAddress>,
    /// The running actor, if any.
    pub actor: ArcSwapOption<ActorRef<PayloadMessage>>,
    /// A tick has been sent and not yet been taken up.
    pub tick_waiting: AtomicBool,
    /// When the next tick is due, in microseconds of the node's clock.
    pub next_tick_us: AtomicU64,
    /// What it last published.
    pub state: Mutex<PayloadPublished>,
    /// The last frame it gave.
    pub frame: ArcSwapOption<Frame>,
}

impl PayloadRecord {
    /// Time between two ticks in microseconds, as its plugin wishes.
    pub fn tick_period_us(&self) -> u64 {
        let rate_hz = self.life.plugin.load().manifest().tick_rate_hz.clamp(1, 1_000);
        1_000_000 / u64::from(rate_hz)
    }
}

/// What a payload publishes for its vehicle, its siblings and the screens.
#[derive(Debug, Clone, Default)]
pub struct PayloadPublished {
    /// Actor's health.
    pub actor: ActorHealth,
    /// Its state as it reported it; none while it does not run.
    pub report: Option<Report>,
    /// Grows with every change of the report.
    pub revision: u64,
    /// What it has to say before its vehicle is armed.
    pub preflight: Vec<PreflightItem>,
    /// Why its transport does not work; empty if it does or has none.
    pub transport_fault: String,
}

/// A state as a plugin reported it.
#[derive(Debug, Clone)]
pub struct Report {
    /// As text, for other plugins.
    pub json: Arc<str>,
    /// Parsed, for screens.
    pub value: Arc<serde_json::Value>,
}

/// Where a device is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TransportAddress {
    /// Datagrams to and from this address.
    Udp(SocketAddr),
    /// A serial line.
    Serial {
        /// The device file.
        path: String,
        /// Bits per second.
        baud: u32,
    },
}

impl FromStr for TransportAddress {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(address) = text.strip_prefix("udp://") {
            return address
                .parse()
                .map(Self::Udp)
                .map_err(|_| format!("\"{address}\" is no ADDRESS:PORT"));
        }
        match text.parse::<EndpointAddress>() {
            Ok(EndpointAddress::Serial { path, baud }) => Ok(Self::Serial { path, baud }),
            _ => Err("choose udp://ADDRESS:PORT or serial:///dev/ttyUSB0?baud=115200".into()),
        }
    }
}
