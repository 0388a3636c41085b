//! Three vehicles' ground-station links, recorded on one port, sent to a real endpoint from three ports.

use crate::log;
use ractor::Actor;
use skein_domain::link::VehicleLink;
use skein_domain::{Clock, NodeTime};
use skein_link_px4::{Endpoint, EndpointAddress, EndpointArguments, EndpointEvent, EndpointSettings, LinkTable};
use std::collections::BTreeMap;
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

#[tokio::test]
async fn three_vehicles_behind_one_port_are_three_links() {
    let frames = log::read("three-vehicles-one-port");
    let clock = Arc::new(LogClock::default());
    clock.0.store(frames[0].now().0, Ordering::Relaxed);
    let links = Arc::new(LinkTable::new());
    let (sender, mut events) = mpsc::unbounded_channel();
    let address: EndpointAddress = "udp-listen://127.0.0.1:0".parse().unwrap();
    let mut settings = EndpointSettings::new("ground", address);
    settings.coalesce_above_hz = f64::INFINITY;
    let arguments = EndpointArguments {
        settings,
        clock: clock.clone(),
        links: links.clone(),
        events: Arc::new(move |event| sender.send(event).unwrap()),
    };
    let (actor, task) = Actor::spawn(None, Endpoint, arguments).await.unwrap();
    let Some(EndpointEvent::Bound {
        local_addr: Some(to), ..
    }) = events.recv().await
    else {
        panic!("not bound")
    };

    let mut vehicles: BTreeMap<u8, (UdpSocket, u64)> = BTreeMap::new();
    let (metrics, mut sent) = (links.metrics()[0].1.clone(), 0);
    for frame in frames.iter().filter(|frame| frame.system_id() < 10) {
        clock.0.store(frame.now().0, Ordering::Relaxed);
        if !vehicles.contains_key(&frame.system_id()) {
            let socket = UdpSocket::bind(SocketAddr::from(([127, 0, 0, 1], 0))).await.unwrap();
            vehicles.insert(frame.system_id(), (socket, 0));
        }
        let (socket, count) = vehicles.get_mut(&frame.system_id()).unwrap();
        socket.send_to(&frame.bytes, to).await.unwrap();
        (*count, sent) = (*count + 1, sent + 1);
        if sent % 64 == 0 {
            // The socket's buffer is not endless; the counters are written with every tick.
            while metrics.read().frames_in + 64 < sent {
                clock.0.fetch_add(1, Ordering::Relaxed);
                tokio::task::yield_now().await;
            }
        }
    }
    while metrics.read().frames_in < sent {
        clock.0.fetch_add(100, Ordering::Relaxed);
        tokio::task::yield_now().await;
    }
    let counters = metrics.read();
    assert_eq!(
        (
            counters.frames_in,
            counters.bad_crc,
            counters.foreign,
            counters.undecodable
        ),
        (sent, 0, 0, 0)
    );
    assert_eq!(links.links().len(), 3);
    for (id, (socket, _)) in &vehicles {
        let link = links.link(*id).unwrap();
        let (telemetry, health) = link.read(clock.now());
        assert_eq!(link.source().address, Some(socket.local_addr().unwrap()));
        assert!(health.connected && health.loss == 0.0, "{id}: {health:?}");
        assert!(
            (100.0..200.0).contains(&health.receive_rate_hz) || health.receive_rate_hz > 300.0,
            "{health:?}"
        );
        assert!(telemetry.local_frame.is_some() && telemetry.home.is_some());
        // Answers go to where the frames came from.
        let mut buffer = [0; 512];
        let (len, from) = socket.recv_from(&mut buffer).await.unwrap();
        assert!(from == to && len > 10 && buffer[5] == 245);
    }
    // Three different places on the ground, about 3 m and 30 m apart: no link was given another's positions.
    let longitudes: Vec<f64> = links
        .links()
        .iter()
        .map(|l| l.read(clock.now()).0.local_frame.unwrap().origin.longitude_deg)
        .collect();
    for (found, said) in longitudes.iter().zip([8.545_594_2, 8.545_634_4, 8.545_673_2]) {
        assert!((found - said).abs() < 2e-6, "{longitudes:?}");
    }
    let mut discovered = Vec::new();
    while let Ok(event) = events.try_recv() {
        match event {
            EndpointEvent::Discovered {
                system_id,
                autopilot,
                vehicle_type,
                ..
            } => {
                assert_eq!((autopilot, vehicle_type), (12, 2));
                discovered.push(system_id);
            }
            other => panic!("{other:?}"),
        }
    }
    discovered.sort_unstable();
    assert_eq!(discovered, [1, 2, 3]);
    actor.stop(None);
    task.await.unwrap();
}
