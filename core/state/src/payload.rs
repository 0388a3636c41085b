//! One payload of a vehicle, beyond the life of its actor.
//!
//! Must never do: wait for the payload.

use crate::mailbox::{ActorSlot, PayloadMessage};
use crate::plugin::PluginRecord;
use crate::video::Video;
use arc_swap::ArcSwapOption;
use parking_lot::{Mutex, MutexGuard};
use skein_config::PayloadRule;
use skein_domain::NodeTime;
use skein_domain::payload::{PayloadKind, PixelFormat};
use skein_domain::preflight::PreflightItem;
use skein_link_mavlink::EndpointAddress;
use skein_plugin_host::Frame;
use skein_view::ActorHealth;
use std::net::SocketAddr;
use std::ops::Deref;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

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
    /// Its actor.
    pub actor: ActorSlot<PayloadMessage>,
    /// When the next tick is due, in microseconds of the node's clock.
    next_tick_us: AtomicU64,
    state: Mutex<PayloadPublished>,
    frame: ArcSwapOption<Frame>,
    /// What it gives as a camera, for those who look at it.
    pub video: Arc<Video>,
}

impl PayloadRecord {
    /// One that was never started.
    pub fn new(rule: PayloadRule, kind: PayloadKind, life: PluginRecord, transport: Option<TransportAddress>) -> Self {
        Self {
            name: rule.name.clone(),
            kind,
            rule,
            life: Arc::new(life),
            transport,
            actor: ActorSlot::default(),
            next_tick_us: AtomicU64::new(0),
            state: Mutex::default(),
            frame: ArcSwapOption::empty(),
            video: Arc::default(),
        }
    }

    /// The control loop wakes it if its tick is due and none waits. A late one is skipped, never caught up.
    pub fn send_due_tick(&self, now: NodeTime) {
        let due_us = self.next_tick_us.load(Ordering::Relaxed);
        if now.0 < due_us {
            return;
        }
        let rate_hz = self.life.plugin().manifest().tick_rate_hz.clamp(1, 1_000);
        let next_us = now.0.max(due_us + 1_000_000 / u64::from(rate_hz));
        self.next_tick_us.store(next_us, Ordering::Relaxed);
        self.actor.send_tick(PayloadMessage::Tick);
    }

    /// What it last published, to be read.
    pub fn state(&self) -> impl Deref<Target = PayloadPublished> {
        self.state.lock()
    }

    /// The same, for its actor, and for the fleet when that has ended.
    pub fn change_state(&self) -> MutexGuard<'_, PayloadPublished> {
        self.state.lock()
    }

    /// The last frame of pixels, or JPEG, that it gave.
    pub fn frame(&self) -> Option<Arc<Frame>> {
        self.frame.load_full()
    }

    /// Its actor has a new frame.
    pub fn show_frame(&self, now: NodeTime, frame: Arc<Frame>) {
        self.video.take(now, &frame);
        if frame.header.format != PixelFormat::H264 {
            self.frame.store(Some(frame));
        }
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
