//! Three vehicles' ground-station links, recorded on one port, sent to a real endpoint from three ports.

use crate::log::{self, Recorded};
use ractor::{Actor, ActorRef};
use skein_domain::link::VehicleLink;
use skein_domain::{Clock, NodeTime};
use skein_link_mavlink::endpoint::EndpointMessage;
use skein_link_mavlink::{
    Endpoint, EndpointAddress, EndpointArguments, EndpointCounters, EndpointEvent, EndpointSettings, LinkTable,
};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use tokio::net::UdpSocket;
use tokio::sync::mpsc;

/// The recording's time.
#[derive(Default)]
struct LogClock(AtomicU64);

impl Clock for LogClock {
    fn now(&self) -> NodeTime {
        NodeTime(self.0.load(Ordering::Relaxed))
    }
}

/// A real endpoint on the recording's clock.
struct Node {
    clock: Arc<LogClock>,
    links: Arc<LinkTable>,
    events: mpsc::UnboundedReceiver<EndpointEvent>,
    port: SocketAddr,
    actor: ActorRef<EndpointMessage>,
}

impl Node {
    async fn start(now: NodeTime) -> Self {
        let clock = Arc::new(LogClock::default());
        clock.0.store(now.0, Ordering::Relaxed);
        let links = Arc::new(LinkTable::new());
        let (sender, mut events) = mpsc::unbounded_channel();
        let address: EndpointAddress = "udp-listen://127.0.0.1:0".parse().unwrap();
        let mut settings = EndpointSettings::new("ground", address);
        settings.coalesce_above_hz = f64::INFINITY;
        let arguments = EndpointArguments {
            settings,
            clock: Arc::clone(&clock) as Arc<dyn Clock>,
            links: Arc::clone(&links),
            events: Arc::new(move |event| sender.send(event).unwrap()),
            references: None,
        };
        let (actor, _) = Actor::spawn(None, Endpoint, arguments).await.unwrap();
        let Some(EndpointEvent::Bound {
            local_addr: Some(port), ..
        }) = events.recv().await
        else {
            panic!("not bound")
        };
        Self {
            clock,
            links,
            events,
            port,
            actor,
        }
    }

    fn counters(&self) -> EndpointCounters {
        self.links.metrics()[0].1.read()
    }

    /// Waits until so many frames have been counted; the counters are written with every tick of the recording's clock.
    async fn counted(&self, frames: u64) {
        while self.counters().frames_in < frames {
            self.clock.0.fetch_add(10, Ordering::Relaxed);
            tokio::task::yield_now().await;
        }
    }

    /// Sends the vehicles' frames, each vehicle's from its own port; gives the ports and the number of frames.
    async fn play(&self, frames: &[Recorded]) -> (BTreeMap<u8, UdpSocket>, u64) {
        let (mut vehicles, mut sent) = (BTreeMap::new(), 0);
        for frame in frames.iter().filter(|frame| frame.system_id() < 10) {
            self.clock.0.store(frame.now().0, Ordering::Relaxed);
            if let Entry::Vacant(vacant) = vehicles.entry(frame.system_id()) {
                vacant.insert(UdpSocket::bind(SocketAddr::from(([127, 0, 0, 1], 0))).await.unwrap());
            }
            vehicles[&frame.system_id()]
                .send_to(&frame.bytes, self.port)
                .await
                .unwrap();
            sent += 1;
            if sent % 64 == 0 {
                // The socket's buffer is not endless.
                self.counted(sent - 64).await;
            }
        }
        self.counted(sent).await;
        (vehicles, sent)
    }

    /// The one link of a vehicle: whole, answered where its frames came from.
    async fn check(&self, id: u8, socket: &UdpSocket) {
        let link = self.links.link(id).unwrap();
        let (telemetry, health) = link.read(self.clock.now());
        assert_eq!(link.source().address, Some(socket.local_addr().unwrap()));
        assert!(health.connected && health.loss == 0.0, "{id}: {health:?}");
        assert!(health.receive_rate_hz > 300.0, "{id}: {health:?}");
        assert!(telemetry.local_frame.is_some() && telemetry.home.is_some());
        let mut buffer = [0; 512];
        let (len, from) = socket.recv_from(&mut buffer).await.unwrap();
        assert!(from == self.port && len > 10 && buffer[5] == 245);
    }
}

#[tokio::test]
async fn three_vehicles_behind_one_port_are_three_links() {
    let frames = log::read("three-vehicles-one-port");
    let mut node = Node::start(frames[0].now()).await;
    let (vehicles, sent) = node.play(&frames).await;
    let counters = node.counters();
    let faults = [counters.bad_crc, counters.foreign, counters.undecodable];
    assert_eq!((counters.frames_in, faults), (sent, [0, 0, 0]));
    assert_eq!(vehicles.len(), 3);
    for (id, socket) in &vehicles {
        node.check(*id, socket).await;
    }
    // Three different places on the ground, some three metres apart: no link was given another's positions.
    for (link, longitude_deg) in node.links.links().iter().zip([8.545_594_2, 8.545_634_4, 8.545_673_2]) {
        let found = link.read(node.clock.now()).0.local_frame.unwrap().origin.longitude_deg;
        assert!((found - longitude_deg).abs() < 2e-6, "{found}");
    }
    let mut discovered = Vec::new();
    while let Ok(event) = node.events.try_recv() {
        let EndpointEvent::Discovered {
            system_id,
            autopilot: 12,
            vehicle_type: 2,
            ..
        } = event
        else {
            panic!("{event:?}")
        };
        discovered.push(system_id);
    }
    discovered.sort_unstable();
    assert_eq!(discovered, [1, 2, 3]);
    node.actor.stop_and_wait(None, None).await.unwrap();
}
