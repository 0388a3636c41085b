//! The simulation over real sockets on the loopback interface.

use super::*;
use crate::settings::{PortPlan, Px4Ports};
use mavlink::dialects::common::MavMessage;
use skein_domain::PositionNed;
use skein_sim_payloads::{PayloadPlan, RadioSettings};
use std::net::UdpSocket;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(20);

fn listener() -> UdpSocket {
    let socket = UdpSocket::bind("127.0.0.1:0").expect("binds");
    socket
        .set_read_timeout(Some(Duration::from_millis(200)))
        .expect("time-out");
    socket
}

/// System ids heard until all of `wanted` were, or patience ends.
fn hear(socket: &UdpSocket, wanted: &[u8]) -> Vec<u8> {
    let (begin, mut heard, mut buffer) = (Instant::now(), Vec::new(), [0; 512]);
    while begin.elapsed() < PATIENCE && !wanted.iter().all(|w| heard.contains(w)) {
        if let Ok((length, _)) = socket.recv_from(&mut buffer) {
            let id = buffer[..length][5];
            if !heard.contains(&id) {
                heard.push(id);
            }
        }
    }
    heard.sort_unstable();
    heard
}

fn wait_for(simulation: &Simulation, done: impl Fn(&TruthFrame) -> bool) -> bool {
    let begin = Instant::now();
    while begin.elapsed() < PATIENCE {
        if done(&simulation.truth()) {
            return true;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    false
}

#[test]
fn every_vehicle_is_heard_added_ones_too_and_killed_ones_fall_silent() {
    let socket = listener();
    let ports = PortPlan::SendTo(socket.local_addr().expect("address"));
    let settings = SimSettings {
        vehicles: 3,
        first_system_id: 7,
        ports,
        ..SimSettings::default()
    };
    let simulation = Simulation::start(settings).expect("starts");
    assert_eq!(
        simulation.truth().vehicles.len(),
        3,
        "the truth is there from the first moment"
    );
    assert_eq!(hear(&socket, &[7, 8, 9]), [7, 8, 9]);
    let new = simulation.add(VehicleStart {
        position: PositionNed::new(50.0, 0.0, -10.0),
        ..VehicleStart::default()
    });
    assert_eq!(new.expect("adds"), 10);
    assert_eq!(hear(&socket, &[10]).last(), Some(&10));
    let freed = simulation.ports()[1].onboard;
    simulation.kill(8).expect("kills");
    assert!(wait_for(&simulation, |t| t.vehicle(8).is_some_and(|v| !v.alive)));
    UdpSocket::bind(freed).expect("its port is free");
    // What was sent before still waits in the socket: read on until it has been used up.
    let killed_at_s = simulation.truth().time_s;
    let mut buffer = [0; 512];
    while simulation.truth().time_s < killed_at_s + 1.0 {
        let _ = socket.recv_from(&mut buffer);
    }
    let mut heard = Vec::new();
    for _ in 0..500 {
        if socket.recv_from(&mut buffer).is_ok() {
            heard.push(buffer[5]);
        }
    }
    assert!([7, 9, 10].iter().all(|id| heard.contains(id)));
    assert!(!heard.contains(&8), "it is silent");
    assert!(matches!(simulation.kill(8), Err(SimError::UnknownVehicle(8))));
    simulation.stop();
}

#[test]
fn a_taken_port_is_a_clear_error() {
    let taken = UdpSocket::bind("127.0.0.1:0").expect("binds");
    let port = taken.local_addr().expect("address").port();
    let ports = Px4Ports {
        onboard_local: port,
        onboard_partner: 9,
        ground_local: 0,
        ground_partner: 9,
    };
    let settings = SimSettings {
        vehicles: 1,
        ports: PortPlan::Px4At(ports),
        ..SimSettings::default()
    };
    match Simulation::start(settings) {
        Err(SimError::Bind {
            system_id: 1, address, ..
        }) => assert_eq!(address.port(), port),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_partner_of_a_link_is_fixed_but_others_are_obeyed() {
    let (partner, ground, stranger) = (listener(), listener(), listener());
    let port = |s: &UdpSocket| s.local_addr().expect("address").port();
    let ports = Px4Ports {
        onboard_local: 0,
        onboard_partner: port(&partner),
        ground_local: 0,
        ground_partner: port(&ground),
    };
    let settings = SimSettings {
        vehicles: 1,
        ports: PortPlan::Px4At(ports),
        ..SimSettings::default()
    };
    let simulation = Simulation::start(settings).expect("starts");
    assert_eq!(hear(&partner, &[1]), [1]);
    assert_eq!(hear(&ground, &[1]), [1]);
    assert!(wait_for(&simulation, |t| t.time_s > 4.3));
    // ARM, as a MAVLink 2 frame.
    let mut payload = 1.0_f32.to_le_bytes().to_vec();
    payload.extend([0; 24]);
    payload.extend([0x90, 0x01, 1, 1, 0]);
    let mut frame = vec![0xFD, payload.len() as u8, 0, 0, 0, 255, 190, 76, 0, 0];
    frame.extend(payload);
    let crc = mavlink::calculate_crc(&frame[1..], 152);
    frame.extend(crc.to_le_bytes());
    let onboard = simulation.ports()[0].onboard;
    stranger.send_to(&frame, onboard).expect("sends");
    assert!(wait_for(&simulation, |t| t.vehicles[0].armed));
    assert!(
        stranger.recv_from(&mut [0; 512]).is_err(),
        "the answer goes to the partner"
    );
}

#[test]
fn a_referee_is_called_fifty_times_a_second() {
    let settings = SimSettings {
        vehicles: 2,
        ports: PortPlan::SendTo("127.0.0.1:9".parse().expect("address")),
        ..SimSettings::default()
    };
    let simulation = Simulation::start(settings).expect("starts");
    let (send, calls) = std::sync::mpsc::channel();
    simulation
        .observe(Box::new(move |frame| {
            let _ = send.send((frame.sequence, frame.time_s));
        }))
        .expect("observes");
    let seen: Vec<_> = calls.iter().take(50).collect();
    simulation.stop();
    let (first, last) = (seen[0], seen[49]);
    assert_eq!(last.0 - first.0, 49, "none is left out");
    assert!((last.1 - first.1 - 0.98).abs() < 0.05, "{first:?} {last:?}");
}

#[test]
fn losses_and_delays_are_what_was_asked_for() {
    let socket = listener();
    let ports = PortPlan::SendTo(socket.local_addr().expect("address"));
    let simulation = Simulation::start(SimSettings {
        vehicles: 1,
        ports,
        ..SimSettings::default()
    })
    .expect("starts");
    simulation
        .impair(
            1,
            Impairment {
                loss: 0.3,
                delay_s: 0.05,
                jitter_s: 0.02,
            },
        )
        .expect("impairs");
    let mut buffer = [0; 512];
    let (mut last, mut missing, mut count) = (None, 0_u32, 0_u32);
    let mut ages = Vec::new();
    let begin = Instant::now();
    while count < 1200 && begin.elapsed() < PATIENCE {
        let Ok((length, _)) = socket.recv_from(&mut buffer) else {
            continue;
        };
        let frame = &buffer[..length];
        let sequence = frame[4];
        if let Some(last) = last {
            let step = sequence.wrapping_sub(last) as i8;
            missing = missing.saturating_add_signed(i32::from(step) - 1);
        }
        last = Some(sequence);
        count += 1;
        if u32::from(frame[7]) == 30
            && let Ok(MavMessage::ATTITUDE(a)) =
                mavlink::Message::parse(mavlink::MavlinkVersion::V2, 30, &frame[10..length - 2])
        {
            ages.push(simulation.truth().time_s - f64::from(a.time_boot_ms) * 1e-3);
        }
    }
    let loss = f64::from(missing) / f64::from(missing + count);
    assert!((0.2..0.4).contains(&loss), "{loss}");
    ages.sort_by(f64::total_cmp);
    let middle = ages[ages.len() / 2];
    assert!((0.03..0.12).contains(&middle), "{middle}");
}

#[test]
fn a_radio_at_the_end_of_its_range_really_loses_datagrams_if_it_is_to() {
    let radio = RadioSettings {
        shadowing_db: 0.0,
        loses_datagrams: true,
        ..RadioSettings::default()
    };
    let range_m = radio.distance_m(radio.sensitivity_dbm);
    let socket = listener();
    let simulation = Simulation::start(SimSettings {
        vehicles: 1,
        ports: PortPlan::SendTo(socket.local_addr().expect("address")),
        payloads: PayloadPlan {
            radio: Some(RadioSettings {
                ground_station: PositionNed::new(range_m, 0.0, 0.0),
                ..radio
            }),
            ..PayloadPlan::default()
        },
        ..SimSettings::default()
    })
    .expect("starts");
    assert!(wait_for(&simulation, |t| t.time_s > 0.1));
    let truth = simulation
        .truth()
        .vehicle(1)
        .and_then(|v| v.radio)
        .expect("has a radio");
    assert!((truth.loss - 0.5).abs() < 0.01, "{truth:?}");
    let mut buffer = [0; 512];
    let (mut last, mut missing, mut count) = (None, 0_u32, 0_u32);
    let begin = Instant::now();
    while count < 1000 && begin.elapsed() < PATIENCE {
        let Ok(length) = socket.recv(&mut buffer) else {
            continue;
        };
        // The autopilot's frames; the radio counts its own.
        if let [_, _, _, _, sequence, 1, 1, ..] = buffer[..length] {
            missing += last.map_or(0, |last: u8| u32::from(sequence.wrapping_sub(last)) - 1);
            last = Some(sequence);
            count += 1;
        }
    }
    let loss = f64::from(missing) / f64::from(missing + count);
    assert!((0.4..0.6).contains(&loss), "{loss}");
}

#[test]
fn a_grid_is_as_square_as_it_can_be_and_its_ground_differs() {
    let settings = SimSettings {
        vehicles: 7,
        ground_relief_m: 4.0,
        ..SimSettings::default()
    };
    let places = settings.places();
    assert_eq!(places.len(), 7);
    assert_eq!(places[3].position.north_m, 5.0);
    for (i, a) in places.iter().enumerate() {
        assert!(a.position.down_m.abs() <= 4.0);
        for b in &places[i + 1..] {
            assert!(a.position.horizontal_distance_m(&b.position) >= 5.0 - 1e-9);
        }
    }
    assert_eq!(settings.places(), places, "the same seed, the same places");
}

#[test]
fn system_ids_are_found_where_there_are_any() {
    assert_eq!(free_system_id(|_| true, 1), None);
    assert_eq!(free_system_id(|id| id < 255, 1), Some(255));
    assert_eq!(free_system_id(|id| id > 3, 4), Some(1));
}

#[test]
fn a_mixed_swarm_gets_its_faults_and_its_wind_while_it_runs() {
    let socket = listener();
    let settings = SimSettings {
        vehicles: 2,
        ports: PortPlan::SendTo(socket.local_addr().expect("address")),
        wind: WindSettings::CALM,
        ..SimSettings::default()
    };
    let mut starts = settings.places();
    starts[1].airframe = crate::Airframe::CameraCarrier;
    starts[1].battery = Some(0.4);
    let simulation = Simulation::start(SimSettings { starts, ..settings }).expect("starts");
    let battery = |frame: &TruthFrame, id: u8| frame.vehicle(id).map(|v| (v.battery * 100.0).round());
    let truth = simulation.truth();
    assert_eq!((battery(&truth, 1), battery(&truth, 2)), (Some(100.0), Some(40.0)));
    simulation.inflict(1, Fault::BatteryCharge(0.25)).expect("is there");
    assert!(wait_for(&simulation, |t| battery(t, 1) == Some(25.0)));
    simulation.set_wind(WindSettings::default()).expect("runs");
    assert!(matches!(
        simulation.inflict(9, Fault::Silent(true)),
        Err(SimError::UnknownVehicle(9))
    ));
    for id in [1, 2] {
        simulation.inflict(id, Fault::Silent(true)).expect("is there");
    }
    // What is on its way is heard; then nothing is.
    let begin = Instant::now();
    let mut buffer = [0; 512];
    while socket.recv_from(&mut buffer).is_ok() {
        assert!(begin.elapsed() < PATIENCE, "still heard");
    }
    simulation.inflict(2, Fault::Silent(false)).expect("is there");
    assert_eq!(hear(&socket, &[2]), [2]);
}
