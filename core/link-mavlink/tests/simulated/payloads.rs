//! Payloads at a vehicle's link: what they are given of its messages, and what they send.

use crate::net::Net;
use crate::puppet::Puppet;
use crate::rig::Rig;
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, GIMBAL_DEVICE_ATTITUDE_STATUS_DATA, GIMBAL_MANAGER_SET_ATTITUDE_DATA,
    GIMBAL_MANAGER_SET_PITCHYAW_DATA, GimbalManagerFlags, MavAutopilot, MavCmd, MavMessage, MavResult, MavType,
    RADIO_STATUS_DATA,
};
use mavlink::{MavlinkVersion, Message, MessageData};
use nalgebra::UnitQuaternion;
use parking_lot::Mutex;
use skein_domain::Refusal;
use skein_domain::link::{MessageTap, VehicleLink};
use skein_domain::payload::MavlinkMessage;
use skein_link_mavlink::EndpointEvent;
use skein_link_mavlink::frame::each_in_datagram;
use skein_link_mavlink::{EndpointCounters, Px4Link};
use skein_px4::LinkSettings;
use skein_sim::{PayloadPlan, PortPlan, SimSettings, Simulation};
use std::net::SocketAddr;
use std::sync::Arc;
use tokio::net::UdpSocket;

/// Keeps what it is given.
pub struct Ear {
    wanted: Vec<u32>,
    heard: Mutex<Vec<MavlinkMessage>>,
}

impl MessageTap for Ear {
    fn wants(&self, message_id: u32) -> bool {
        self.wanted.contains(&message_id)
    }

    fn take(&self, message: MavlinkMessage) {
        self.heard.lock().push(message);
    }
}

impl Ear {
    pub fn at(link: &Px4Link, wanted: &[u32]) -> Arc<Self> {
        let ear = Arc::new(Self {
            wanted: wanted.to_vec(),
            heard: Mutex::default(),
        });
        let tap: Arc<dyn MessageTap> = ear.clone();
        link.tap(Arc::downgrade(&tap));
        ear
    }

    pub fn heard(&self) -> Vec<MavlinkMessage> {
        self.heard.lock().clone()
    }

    /// Sender's component and what it said, oldest first.
    pub fn messages(&self) -> Vec<(u8, MavMessage)> {
        let read = |m: MavlinkMessage| {
            let message = MavMessage::parse(MavlinkVersion::V2, m.message_id, &m.payload);
            message.ok().map(|message| (m.component_id, message))
        };
        self.heard().into_iter().filter_map(read).collect()
    }
}

/// A message as a payload gives it to be sent.
pub fn outgoing<D: MessageData>(message: &D) -> MavlinkMessage {
    let mut payload = vec![0; 255];
    let len = message.ser(MavlinkVersion::V2, &mut payload);
    payload.truncate(len);
    MavlinkMessage {
        message_id: D::ID,
        payload,
        ..MavlinkMessage::default()
    }
}

async fn socket() -> UdpSocket {
    UdpSocket::bind(SocketAddr::from(([127, 0, 0, 1], 0))).await.unwrap()
}

/// A vehicle that has just been found: its link, and the socket it speaks from.
async fn found(net: &mut Net, port: SocketAddr, puppet: &mut Puppet) -> (Arc<Px4Link>, UdpSocket) {
    let socket = socket().await;
    socket.send_to(&puppet.heartbeat(), port).await.unwrap();
    (net.discovered(puppet.system_id).await, socket)
}

fn gimbal_of(system_id: u8) -> Puppet {
    Puppet {
        component_id: 154,
        ..Puppet::new(system_id)
    }
}

fn attitude(stamp_ms: u32) -> GIMBAL_DEVICE_ATTITUDE_STATUS_DATA {
    GIMBAL_DEVICE_ATTITUDE_STATUS_DATA {
        time_boot_ms: stamp_ms,
        ..GIMBAL_DEVICE_ATTITUDE_STATUS_DATA::default()
    }
}

#[tokio::test]
async fn a_tap_is_given_what_it_wants_of_every_component_and_is_forgotten_when_it_is_gone() {
    let mut net = Net::new();
    let (_actor, port) = net.listen("swarm").await;
    let (mut autopilot, mut gimbal) = (Puppet::new(4), gimbal_of(4));
    let (link, socket) = found(&mut net, port, &mut autopilot).await;
    let ear = Ear::at(&link, &[32, 285]);
    let gone = Arc::downgrade(&Ear::at(&link, &[32]));
    assert_eq!(gone.strong_count(), 0, "the link keeps nobody alive");
    let mut datagram = autopilot.position(2.0);
    datagram.extend(autopilot.heartbeat());
    datagram.extend(gimbal.frame(&attitude(77)));
    datagram.extend(gimbal.heartbeat_of(MavType::MAV_TYPE_GIMBAL, MavAutopilot::MAV_AUTOPILOT_INVALID));
    socket.send_to(&datagram, port).await.unwrap();
    net.until("both", |_| ear.heard().len() == 2).await;
    let heard = ear.heard();
    let from: Vec<_> = heard
        .iter()
        .map(|m| (m.system_id, m.component_id, m.message_id))
        .collect();
    assert_eq!(from, [(4, 1, 32), (4, 154, 285)]);
    assert_eq!(
        ear.messages()[1].1,
        MavMessage::GIMBAL_DEVICE_ATTITUDE_STATUS(attitude(77))
    );
    // What the link reads itself it reads all the same.
    assert_eq!(link.read(net.now()).0.local.unwrap().north_m, 2.0);

    // From elsewhere: a gimbal may have a line of its own, and is no second autopilot there either.
    let elsewhere = self::socket().await;
    for stamp_ms in 100..160 {
        let mut datagram = gimbal.frame(&attitude(stamp_ms));
        datagram.extend(gimbal.heartbeat_of(MavType::MAV_TYPE_GIMBAL, MavAutopilot::MAV_AUTOPILOT_INVALID));
        elsewhere.send_to(&datagram, port).await.unwrap();
        socket.send_to(&autopilot.heartbeat(), port).await.unwrap();
    }
    net.until("all", |_| ear.heard().len() == 62).await;
    assert!(!link.is_contested());
    assert_eq!(net.links.links().len(), 1);
    assert_eq!(link.source().address, Some(socket.local_addr().unwrap()));
    assert!(!net.has(|e| matches!(e, EndpointEvent::Duplicate { .. } | EndpointEvent::Moved { .. })));
    drop(ear);
    socket.send_to(&autopilot.position(3.0), port).await.unwrap();
    net.until("read on", |now| link.read(now).0.local.unwrap().north_m == 3.0)
        .await;
}

#[tokio::test]
async fn a_gimbal_that_speaks_first_is_no_vehicle() {
    let mut net = Net::new();
    let (_actor, port) = net.listen("swarm").await;
    let (mut autopilot, mut gimbal) = (Puppet::new(4), gimbal_of(4));
    let from = socket().await;
    // Some gimbals wrongly name an autopilot of theirs.
    for autopilot in [MavAutopilot::MAV_AUTOPILOT_INVALID, MavAutopilot::MAV_AUTOPILOT_PX4] {
        let heartbeat = gimbal.heartbeat_of(MavType::MAV_TYPE_GIMBAL, autopilot);
        from.send_to(&heartbeat, port).await.unwrap();
    }
    net.until("counted", |_| net.links.metrics()[0].1.read().unadopted == 2)
        .await;
    assert!(net.links.links().is_empty());
    let (link, _socket) = found(&mut net, port, &mut autopilot).await;
    assert_eq!(link.identity().vehicle_type, 2);
}

#[tokio::test]
async fn what_a_radio_says_is_given_to_the_vehicles_behind_it() {
    let mut net = Net::new();
    let (_actor, port) = net.listen("swarm").await;
    let (mut near, mut far, mut other) = (Puppet::new(4), Puppet::new(5), Puppet::new(6));
    let (near_link, radio_socket) = found(&mut net, port, &mut near).await;
    radio_socket.send_to(&far.heartbeat(), port).await.unwrap();
    let far_link = net.discovered(5).await;
    let (other_link, other_socket) = found(&mut net, port, &mut other).await;
    let ears = [&near_link, &far_link, &other_link].map(|link| Ear::at(link, &[109]));
    let mut radio = Puppet {
        component_id: 68,
        ..Puppet::new(51)
    };
    let status = RADIO_STATUS_DATA {
        rssi: 200,
        remrssi: 190,
        noise: 40,
        ..RADIO_STATUS_DATA::default()
    };
    radio_socket.send_to(&radio.frame(&status), port).await.unwrap();
    net.until("heard", |_| ears[0].heard().len() + ears[1].heard().len() == 2)
        .await;
    for ear in &ears[..2] {
        assert_eq!(ear.messages(), [(68, MavMessage::RADIO_STATUS(status.clone()))]);
        assert_eq!(ear.heard()[0].system_id, 51);
    }
    other_socket.send_to(&radio.frame(&status), port).await.unwrap();
    net.until("heard", |_| ears[2].heard().len() == 1).await;
    assert_eq!(ears.each_ref().map(|ear| ear.heard().len()), [1, 1, 1]);
    assert_eq!(net.links.links().len(), 3, "a radio is no vehicle");
}

/// The next frame with this message, as it came.
async fn received(socket: &UdpSocket, message_id: u32) -> (u8, u8, Vec<u8>) {
    let mut buffer = [0; 512];
    loop {
        let (len, _) = socket.recv_from(&mut buffer).await.unwrap();
        let mut found = None;
        each_in_datagram(&buffer[..len], &mut EndpointCounters::default(), |_, frame| {
            if frame.header.message_id == message_id {
                found = Some((
                    frame.header.system_id,
                    frame.header.component_id,
                    frame.payload.to_vec(),
                ));
            }
        });
        if let Some(found) = found {
            return found;
        }
    }
}

#[tokio::test]
async fn a_payloads_message_reaches_the_vehicle_and_is_refused_when_that_is_lost() {
    let mut net = Net::new();
    let (_actor, port) = net.listen("swarm").await;
    let (link, socket) = found(&mut net, port, &mut Puppet::new(4)).await;
    let message = outgoing(&GIMBAL_MANAGER_SET_PITCHYAW_DATA {
        pitch: -0.5,
        yaw: 0.25,
        target_system: 4,
        target_component: 1,
        ..GIMBAL_MANAGER_SET_PITCHYAW_DATA::default()
    });
    link.send_payload(net.now(), &message).unwrap();
    assert_eq!(received(&socket, 287).await, (245, 190, message.payload.clone()));
    let unknown = MavlinkMessage {
        message_id: 60_000,
        ..message.clone()
    };
    assert!(matches!(
        link.send_payload(net.now(), &unknown),
        Err(Refusal::NotSupported { .. })
    ));
    let long = MavlinkMessage {
        payload: vec![1; 200],
        ..message.clone()
    };
    assert!(matches!(
        link.send_payload(net.now(), &long),
        Err(Refusal::InvalidValue { .. })
    ));
    net.until("lost", |now| !link.read(now).1.connected).await;
    assert!(matches!(
        link.send_payload(net.now(), &message),
        Err(Refusal::LinkLost { .. })
    ));
}

fn simulate(to: SocketAddr, vehicles: usize) -> Simulation {
    Simulation::start(SimSettings {
        vehicles,
        ports: PortPlan::SendTo(to),
        payloads: PayloadPlan::all(),
        ..SimSettings::default()
    })
    .unwrap()
}

fn command(target: (u8, u8), command: MavCmd, [param1, param2, param3]: [f32; 3]) -> MavlinkMessage {
    outgoing(&COMMAND_LONG_DATA {
        param1,
        param2,
        param3,
        command,
        target_system: target.0,
        target_component: target.1,
        ..COMMAND_LONG_DATA::default()
    })
}

/// Sends a command until its component has acknowledged it to us.
async fn acknowledged(net: &Net, link: &Px4Link, ear: &Ear, message: &MavlinkMessage, by: u8) -> MavResult {
    let number = u16::from_le_bytes([message.payload[28], message.payload[29]]);
    let mut result = None;
    link.send_payload(net.now(), message).unwrap();
    net.until(&format!("acknowledgement of {number}"), |_| {
        result = ear.messages().into_iter().find_map(|(component, heard)| match heard {
            MavMessage::COMMAND_ACK(ack)
                if component == by
                    && ack.command as u32 == u32::from(number)
                    && (ack.target_system, ack.target_component) == (245, 190) =>
            {
                Some(ack.result)
            }
            _ => None,
        });
        result.is_some()
    })
    .await;
    result.unwrap()
}

#[tokio::test]
async fn the_payloads_of_simulated_vehicles_are_heard_and_steered_through_their_links() {
    let mut net = Net::new();
    let (_actor, port) = net.listen("swarm").await;
    let simulation = simulate(port, 2);
    let (link, other) = (net.discovered(1).await, net.discovered(2).await);
    let ears = [&link, &other].map(|link| Ear::at(link, &[77, 109, 262, 281, 285]));
    let is_from = |ear: &Ear, id, component| {
        let heard = ear.heard();
        heard.iter().any(|m| m.message_id == id && m.component_id == component)
    };
    for ear in &ears {
        net.until("status, attitude and radio", |_| {
            is_from(ear, 281, 1) && is_from(ear, 285, 154) && is_from(ear, 109, 68)
        })
        .await;
    }
    let ear = &ears[0];
    let turn = UnitQuaternion::from_euler_angles(0.0, -0.6, 0.4);
    let attitude = outgoing(&GIMBAL_MANAGER_SET_ATTITUDE_DATA {
        flags: GimbalManagerFlags::empty(),
        q: [turn.w, turn.i, turn.j, turn.k],
        angular_velocity_x: f32::NAN,
        angular_velocity_y: f32::NAN,
        angular_velocity_z: f32::NAN,
        target_system: 1,
        target_component: 1,
        gimbal_device_id: 154,
    });
    let take_control = command((1, 1), MavCmd::MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE, [245.0, 190.0, 0.0]);
    assert_eq!(
        acknowledged(&net, &link, ear, &take_control, 1).await,
        MavResult::MAV_RESULT_ACCEPTED
    );
    link.send_payload(net.now(), &attitude).unwrap();
    let points = |id: u8| simulation.truth().vehicle(id).unwrap().gimbal.unwrap();
    net.until("pointing", |_| {
        let gimbal = points(1);
        (gimbal.pitch_rad + 0.6).abs() < 0.01 && (gimbal.yaw_vehicle_rad - 0.4).abs() < 0.01
    })
    .await;
    assert!(
        points(2).pitch_rad.abs() < 0.01,
        "the other vehicle's stays where it is"
    );

    let start = command((1, 100), MavCmd::MAV_CMD_VIDEO_START_CAPTURE, [0.0, 2.0, 0.0]);
    assert_eq!(
        acknowledged(&net, &link, ear, &start, 100).await,
        MavResult::MAV_RESULT_ACCEPTED
    );
    net.until("recording", |_| {
        let heard = ear.messages();
        let recording = heard
            .iter()
            .any(|(_, m)| matches!(m, MavMessage::CAMERA_CAPTURE_STATUS(m) if m.video_status == 1));
        recording && simulation.truth().vehicle(1).unwrap().camera.unwrap().recording
    })
    .await;
    assert!(!ears[1].heard().iter().any(|m| m.message_id == 262));
    assert!(net.links.links().len() == 2 && !link.is_contested() && !other.is_contested());
    assert!(!net.has(|e| matches!(e, EndpointEvent::Duplicate { .. } | EndpointEvent::Moved { .. })));
}

#[test]
fn what_was_turned_off_comes_back_when_a_payload_wants_it_and_nothing_counts_as_lost() {
    let settings = SimSettings {
        payloads: PayloadPlan::all(),
        ..SimSettings::default()
    };
    let mut rig = Rig::with(LinkSettings::default(), settings);
    let in_ten_seconds = |rig: &mut Rig, id: u32| {
        rig.received.clear();
        rig.run(10.0);
        rig.received.get(&id).copied().unwrap_or(0)
    };
    rig.wanted = vec![281];
    rig.run(20.0);
    assert!((4..=6).contains(&in_ten_seconds(&mut rig, 281)), "wanted: it stays on");
    rig.wanted.clear();
    rig.run(20.0);
    assert_eq!(in_ten_seconds(&mut rig, 281), 0, "nobody reads it: off");
    assert!(
        (95..=105).contains(&in_ten_seconds(&mut rig, 285)),
        "a device's own are left alone"
    );
    rig.wanted = vec![281];
    rig.core().want(|id| id == 281);
    rig.run(2.0);
    assert!((4..=6).contains(&in_ten_seconds(&mut rig, 281)), "back at its own rate");
    // Each component counts its frames for itself; for the link that is no loss.
    let (_, health) = rig.read();
    assert!(health.connected && health.loss < 0.005, "{health:?}");
}
