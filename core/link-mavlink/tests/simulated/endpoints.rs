//! Endpoints over UDP: vehicles found, lost, moved, mistaken for each other; ports taken; actors restarted.

use crate::net::Net;
use crate::puppet::Puppet;
use mavlink::dialects::common::{MavAutopilot, MavType};
use skein_domain::link::{LinkEvent, VehicleLink};
use skein_domain::{AutopilotCommand, FlightMode, Refusal, RequestId};
use skein_link_mavlink::{EndpointAddress, EndpointError, EndpointEvent, EndpointSettings};
use skein_sim::{PortPlan, SimSettings, Simulation, VehicleStart};
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::UdpSocket;

fn simulate(to: SocketAddr, first_system_id: u8, vehicles: usize) -> Simulation {
    let ports = PortPlan::SendTo(to);
    Simulation::start(SimSettings {
        vehicles,
        first_system_id,
        ports,
        ..SimSettings::default()
    })
    .unwrap()
}

async fn any_port() -> UdpSocket {
    UdpSocket::bind(SocketAddr::from(([127, 0, 0, 1], 0))).await.unwrap()
}

/// Sends positions from a socket at 50 Hz, a heartbeat with each fifth, until dropped.
struct Sender(tokio::task::JoinHandle<()>);

impl Sender {
    fn start(socket: Arc<UdpSocket>, to: SocketAddr, mut puppet: Puppet) -> Self {
        Self(tokio::spawn(async move {
            let mut period = tokio::time::interval(Duration::from_millis(20));
            for i in 0_u32.. {
                period.tick().await;
                let mut datagram = puppet.position(1.0);
                if i % 5 == 0 {
                    datagram.extend(puppet.heartbeat());
                }
                socket.send_to(&datagram, to).await.unwrap();
            }
        }))
    }
}

impl Drop for Sender {
    fn drop(&mut self) {
        self.0.abort();
    }
}

#[tokio::test]
async fn vehicles_behind_one_port_are_flown_each_on_its_own() {
    let mut net = Net::new();
    let (_actor, port) = net.listen("swarm").await;
    let simulation = simulate(port, 1, 3);
    let links = [
        net.discovered(1).await,
        net.discovered(2).await,
        net.discovered(3).await,
    ];
    for link in &links {
        net.until("ready", |now| link.read(now).0.ready_to_arm == Some(true))
            .await;
    }
    // Each is its own vehicle: neighbours are five metres apart.
    let places: Vec<_> = links
        .iter()
        .map(|link| link.read(net.now()).0.local_frame.unwrap())
        .collect();
    let apart_m = places[0].position(&places[1].origin).norm();
    assert!((3.0..12.0).contains(&apart_m), "{apart_m}");

    assert_eq!(net.ask(&links[0], AutopilotCommand::Arm).await, Ok(()));
    let Err(Refusal::Autopilot { result, .. }) = net
        .ask(
            &links[0],
            AutopilotCommand::SetMode {
                mode: FlightMode::Position,
            },
        )
        .await
    else {
        panic!("no pilot is there");
    };
    assert_eq!(result, "temporarily_rejected");
    assert_eq!(
        net.ask(&links[0], AutopilotCommand::TakeOff { height_m: 4.0 }).await,
        Ok(())
    );
    let truth = simulation.truth();
    let armed: Vec<bool> = [1, 2, 3].iter().map(|id| truth.vehicle(*id).unwrap().armed).collect();
    assert_eq!(armed, [true, false, false]);

    net.until("climbed", |_| simulation.truth().vehicle(1).unwrap().height_m > 2.0)
        .await;
    let Err(Refusal::Autopilot { text, .. }) = net.ask(&links[0], AutopilotCommand::Disarm).await else {
        panic!("in the air")
    };
    assert_eq!(text, "Disarming denied: not landed");
    let counters = net.links.metrics()[0].1.read();
    assert_eq!(
        (
            counters.bad_crc,
            counters.truncated,
            counters.foreign,
            counters.undecodable
        ),
        (0, 0, 0, 0)
    );
    assert!(!net.has(|event| matches!(event, EndpointEvent::Duplicate { .. } | EndpointEvent::Moved { .. })));
}

#[tokio::test]
async fn vehicles_are_lost_join_and_restart_while_the_node_runs() {
    let mut net = Net::new();
    let (_actor, port) = net.listen("swarm").await;
    let simulation = simulate(port, 1, 3);
    let links = [
        net.discovered(1).await,
        net.discovered(2).await,
        net.discovered(3).await,
    ];
    simulation.kill(2).unwrap();
    net.link_event("lost", &links[1], |event| *event == LinkEvent::Lost)
        .await;
    let added = simulation
        .add(VehicleStart {
            system_id: Some(4),
            ..VehicleStart::default()
        })
        .unwrap();
    net.discovered(added).await;

    // Stamps that go back by less are late frames.
    net.until("it has been up for longer", |now| now.as_seconds() > 6.0)
        .await;
    simulation.reboot(3).unwrap();
    net.link_event("rebooted", &links[2], |event| *event == LinkEvent::Rebooted)
        .await;
    let (_, health) = links[0].read(net.now());
    assert!(
        health.connected && health.loss == 0.0,
        "the others are not disturbed: {health:?}"
    );
}

#[tokio::test]
async fn vehicles_on_their_own_ports_share_one_table() {
    let mut net = Net::new();
    let (_a, port_a) = net.listen("first").await;
    let (_b, port_b) = net.listen("second").await;
    let _simulations = [simulate(port_a, 1, 1), simulate(port_b, 2, 1)];
    let (a, b) = (net.discovered(1).await, net.discovered(2).await);
    assert_eq!((&*a.source().endpoint, &*b.source().endpoint), ("first", "second"));
    for link in [&a, &b] {
        net.until("rates", |now| {
            link.read(now).1.receive_rate_hz > 60.0 && link.read(now).1.round_trip_s.is_some()
        })
        .await;
    }
    assert_eq!(net.links.links().len(), 2);
}

#[tokio::test]
async fn what_is_sent_goes_to_the_vehicle_and_not_to_another_sender_of_its_id() {
    let mut net = Net::new();
    let (_actor, port) = net.listen("swarm").await;
    let (first, second) = (Arc::new(any_port().await), Arc::new(any_port().await));
    let one = Sender::start(Arc::clone(&first), port, Puppet::new(7));
    let link = net.discovered(7).await;
    let other = Sender::start(Arc::clone(&second), port, Puppet::new(7));
    let EndpointEvent::Duplicate {
        system_id,
        first: a,
        second: b,
    } = net
        .event("duplicate", |event| matches!(event, EndpointEvent::Duplicate { .. }))
        .await
    else {
        panic!()
    };
    assert_eq!(system_id, 7);
    assert_eq!(
        (a.address, b.address),
        (Some(first.local_addr().unwrap()), Some(second.local_addr().unwrap()))
    );
    assert!(link.is_contested());
    link.request(net.now(), RequestId(9), AutopilotCommand::Land);
    assert_eq!(link.stop_motors(net.now(), RequestId(10)), Ok(()));
    let mut buffer = [0; 300];
    // COMMAND_LONG, forced disarm.
    let is_stop = |frame: &[u8]| frame[7] == 76 && frame[10 + 28..10 + 30] == 400_u16.to_le_bytes();
    loop {
        let received = tokio::time::timeout(Duration::from_secs(10), first.recv_from(&mut buffer)).await;
        let (length, from) = received.unwrap().unwrap();
        assert_eq!(from, port);
        if length > 40 && is_stop(&buffer[..length]) {
            break;
        }
    }
    assert!(
        second.try_recv_from(&mut buffer).is_err(),
        "nothing was ever sent to the other"
    );

    // The first, which stands, goes: the second is the vehicle from now on.
    drop(one);
    let cleared = net
        .event("cleared", |event| {
            matches!(event, EndpointEvent::DuplicateCleared { .. })
        })
        .await;
    let EndpointEvent::DuplicateCleared { remaining, .. } = cleared else {
        panic!()
    };
    assert_eq!(remaining.address, Some(second.local_addr().unwrap()));
    assert!(!link.is_contested());
    drop(other);
}

#[tokio::test]
async fn the_same_id_on_two_endpoints_is_noticed_too() {
    let mut net = Net::new();
    let (_a, port_a) = net.listen("first").await;
    let (_b, port_b) = net.listen("second").await;
    let _one = Sender::start(Arc::new(any_port().await), port_a, Puppet::new(7));
    let link = net.discovered(7).await;
    let other = Sender::start(Arc::new(any_port().await), port_b, Puppet::new(7));
    net.event("duplicate", |event| matches!(event, EndpointEvent::Duplicate { .. }))
        .await;
    drop(other);
    net.event("cleared", |event| {
        matches!(event, EndpointEvent::DuplicateCleared { .. })
    })
    .await;
    assert_eq!(&*link.source().endpoint, "first");
    assert!(link.read(net.now()).1.connected);
}

#[tokio::test]
async fn a_vehicle_that_comes_back_from_another_port_has_moved() {
    let mut net = Net::new();
    let (_actor, port) = net.listen("swarm").await;
    let (old, new) = (Arc::new(any_port().await), Arc::new(any_port().await));
    let before = Sender::start(Arc::clone(&old), port, Puppet::new(7));
    let link = net.discovered(7).await;
    drop(before);
    let _after = Sender::start(Arc::clone(&new), port, Puppet::new(7));
    net.event("moved", |event| {
        matches!(event, EndpointEvent::Moved { system_id: 7, .. })
    })
    .await;
    assert_eq!(link.source().address, Some(new.local_addr().unwrap()));
    // Answers go there.
    let mut buffer = [0; 300];
    let received = tokio::time::timeout(Duration::from_secs(10), new.recv_from(&mut buffer)).await;
    assert_eq!(received.unwrap().unwrap().1, port);
    assert!(!net.has(|event| matches!(event, EndpointEvent::Duplicate { .. })));
}

#[tokio::test]
async fn a_changed_system_id_is_noticed() {
    let mut net = Net::new();
    let (_actor, port) = net.listen("swarm").await;
    let socket = Arc::new(any_port().await);
    let before = Sender::start(Arc::clone(&socket), port, Puppet::new(7));
    net.discovered(7).await;
    drop(before);
    let _after = Sender::start(socket, port, Puppet::new(9));
    net.discovered(9).await;
    net.event("changed", |event| {
        matches!(event, EndpointEvent::SystemIdChanged { from: 7, to: 9, .. })
    })
    .await;
}

#[tokio::test]
async fn a_taken_port_is_a_typed_error_that_names_it() {
    let net = Net::new();
    let taken = any_port().await;
    let address = format!("udp-listen://{}", taken.local_addr().unwrap());
    let error = net.try_start("swarm", &address).await.unwrap_err();
    assert!(matches!(error, EndpointError::AddressInUse { .. }));
    assert!(
        error.to_string().contains(&address) && error.to_string().contains("in use"),
        "{error}"
    );
    drop(taken);
    assert!(
        net.try_start("swarm", &address).await.is_ok(),
        "free again, and so is the name"
    );
    assert!(matches!(
        net.try_start("swarm", "udp-listen://127.0.0.1:0").await,
        Err(EndpointError::NameInUse { .. })
    ));
    let mut settings = EndpointSettings::new(
        "slow",
        EndpointAddress::UdpListen(SocketAddr::from(([127, 0, 0, 1], 0))),
    );
    settings.link.setpoint_rate_hz = 0.5;
    assert!(matches!(
        net.try_start_with(settings).await,
        Err(EndpointError::Setting { .. })
    ));
}

#[tokio::test]
async fn a_restarted_endpoint_keeps_its_links_and_its_port() {
    let mut net = Net::new();
    let (actor, port) = net.listen("swarm").await;
    let _sender = Sender::start(Arc::new(any_port().await), port, Puppet::new(7));
    let link = net.discovered(7).await;
    for restart in 0..3 {
        // As a panic would end it: without any goodbye.
        let running = if restart == 0 {
            actor.clone()
        } else {
            net.try_start("swarm", &format!("udp-listen://{port}")).await.unwrap()
        };
        let before = net.links.metrics()[0].1.read();
        net.until("frames", |_| {
            net.links.metrics()[0].1.read().frames_in > before.frames_in
        })
        .await;
        assert!(link.read(net.now()).1.connected);
        running.kill();
        net.link_event("lost", &link, |event| *event == LinkEvent::Lost).await;
    }
    assert!(Arc::ptr_eq(&link, &net.links.link(7).unwrap()));
    assert!(
        !net.has(|event| matches!(event, EndpointEvent::Discovered { .. })),
        "it was known"
    );
    assert_eq!(net.links.metrics()[0].1.read().starts, 3);
}

#[tokio::test]
async fn nonsense_disturbs_nothing_and_only_autopilots_are_vehicles() {
    let mut net = Net::new();
    let (_actor, port) = net.listen("swarm").await;
    let stranger = any_port().await;
    let mut damaged = Puppet::new(7).heartbeat();
    let last = damaged.len() - 1;
    damaged[last] ^= 1;
    let mut parts = Puppet {
        component_id: 100,
        ..Puppet::new(7)
    };
    let mut ground = Puppet::new(255);
    let mut station = Puppet::new(8);
    let datagrams = [
        damaged,
        vec![],
        vec![0xFD; 1400],
        vec![0; 3000],
        Puppet::new(7).heartbeat()[..9].to_vec(),
        parts.heartbeat_of(MavType::MAV_TYPE_CAMERA, MavAutopilot::MAV_AUTOPILOT_INVALID),
        parts.heartbeat(),
        ground.heartbeat_of(MavType::MAV_TYPE_GCS, MavAutopilot::MAV_AUTOPILOT_INVALID),
        station.heartbeat_of(MavType::MAV_TYPE_GCS, MavAutopilot::MAV_AUTOPILOT_PX4),
        station.heartbeat_of(MavType::MAV_TYPE_QUADROTOR, MavAutopilot::MAV_AUTOPILOT_INVALID),
        Puppet::new(245).heartbeat(),
        Puppet::new(0).heartbeat(),
        Puppet::new(7).position(1.0),
    ];
    for datagram in &datagrams {
        stranger.send_to(datagram, port).await.unwrap();
    }
    net.until("counted", |_| {
        net.links.metrics()[0].1.read().datagrams_in >= datagrams.len() as u64
    })
    .await;
    let counters = net.links.metrics()[0].1.read();
    assert!(net.links.links().is_empty());
    assert_eq!(counters.bad_crc, 1);
    assert!(counters.truncated >= 2 && counters.stray_bytes > 3000, "{counters:?}");
    assert_eq!((counters.unadopted, counters.frames_in), (8, 8), "{counters:?}");

    // A vehicle of a type nobody has heard of is a vehicle.
    let mut odd = Puppet::new(9).heartbeat();
    odd[14] = 200;
    let end = odd.len() - 2;
    let crc = mavlink::calculate_crc(&odd[1..end], 50);
    odd[end..].copy_from_slice(&crc.to_le_bytes());
    stranger.send_to(&odd, port).await.unwrap();
    net.event("odd", |event| {
        matches!(
            event,
            EndpointEvent::Discovered {
                system_id: 9,
                vehicle_type: 200,
                ..
            }
        )
    })
    .await;
}

#[tokio::test]
async fn a_connected_port_speaks_first_and_hears_only_its_partner() {
    let mut net = Net::new();
    let server = Arc::new(any_port().await);
    let address = format!("udp-connect://{}", server.local_addr().unwrap());
    net.try_start("radio", &address).await.unwrap();
    let mut buffer = [0; 300];
    let (len, from) = server.recv_from(&mut buffer).await.unwrap();
    assert_eq!(
        (buffer[0], buffer[5], buffer[6], buffer[7]),
        (0xFD, 245, 190, 0),
        "a heartbeat of ours"
    );
    assert_eq!(buffer[14], 6, "as a ground station; {len} bytes");
    any_port()
        .await
        .send_to(&Puppet::new(66).heartbeat(), from)
        .await
        .unwrap();
    let _sender = Sender::start(server, from, Puppet::new(7));
    net.discovered(7).await;
    assert!(net.links.link(66).is_none());
}
