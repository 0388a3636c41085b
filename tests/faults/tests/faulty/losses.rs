//! Vehicles that vanish, and frames that are no frames: the others go on.

use mavlink::dialects::common::{
    HEARTBEAT_DATA, LOCAL_POSITION_NED_DATA, MavAutopilot, MavModeFlag, MavState, MavType,
};
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MessageData};
use skein_domain::{FlightState, FormationRequest, Shape, VehicleCommand, VehicleId};
use skein_runtime::Targets;
use skein_sim::{Fault, VehicleStart};
use skein_testkit::Swarm;
use skein_view::{EventKind, FleetSnapshot};
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

fn members(fleet: &FleetSnapshot) -> Vec<u16> {
    let mut ids: Vec<u16> = fleet
        .formation
        .iter()
        .flat_map(|f| f.members.iter().map(|id| id.0))
        .collect();
    ids.sort_unstable();
    ids
}

/// A vehicle that was not there before comes up and takes a slot behind the new leader.
async fn a_newcomer_joins(swarm: &Swarm) {
    let start = VehicleStart {
        system_id: Some(9),
        position: skein_domain::PositionNed::new(-25.0, 0.0, 0.0),
        ..VehicleStart::default()
    };
    let newcomer = u16::from(swarm.simulation().add(start).expect("is added"));
    swarm
        .until("the newcomer ready", Duration::ZERO, |fleet| {
            fleet
                .vehicles
                .iter()
                .any(|v| v.id.0 == newcomer && v.ready_to_arm == Some(true))
        })
        .await;
    let targets = skein_runtime::Targets::Vehicles(vec![VehicleId(newcomer)]);
    let command = skein_domain::VehicleCommand::TakeOff { height_m: 6.0 };
    assert_eq!(swarm.node().command(&targets, command).await[0].refusal, None);
    swarm
        .until("the newcomer in the formation", Duration::from_secs(30), |fleet| {
            members(fleet) == [2, 3, 4, newcomer]
                && fleet
                    .vehicles
                    .iter()
                    .any(|v| v.id.0 == newcomer && v.flight_state == FlightState::Following)
        })
        .await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_vehicle_that_vanishes_is_lost_and_a_new_one_joins() {
    let swarm = Swarm::start(4).await;
    swarm.take_off(6.0).await;
    swarm
        .node()
        .set_formation(FormationRequest::new(Shape::Wedge, 5.0))
        .await
        .expect("is flown");
    swarm
        .until("four fly the wedge", Duration::from_secs(10), |f| {
            members(f) == [1, 2, 3, 4]
        })
        .await;

    // The leader of all vehicles.
    let killed = swarm.node().now();
    swarm.simulation().kill(1).expect("is simulated");
    swarm
        .until(
            "the others closed up behind a new leader",
            Duration::from_secs(3),
            |fleet| {
                let leads = fleet
                    .vehicles
                    .iter()
                    .any(|v| v.id == VehicleId(2) && v.flight_state == FlightState::Leading);
                leads && members(fleet) == [2, 3, 4]
            },
        )
        .await;
    // A leader is replaced before its link counts as lost.
    let lost = skein_testkit::eventually(skein_testkit::patience(), "the loss told", async || {
        let events = swarm.node().events_after(0);
        events
            .into_iter()
            .find(|e| e.kind == EventKind::LinkLost && e.vehicle == Some(VehicleId(1)))
    })
    .await;
    let after_s = lost.time.seconds_since(killed);
    // Not at the first frame that is missing. That it is not late either is the link's own business, whose tests have a clock.
    assert!(after_s > 1.0, "declared lost after {after_s:.1} s");

    a_newcomer_joins(&swarm).await;
    let smallest_m = swarm.simulation().truth().smallest_distance_m().expect("several fly");
    assert!(smallest_m > 2.0, "{smallest_m}");
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_leader_that_was_silent_for_a_moment_comes_back_as_a_follower() {
    let swarm = Swarm::start(3).await;
    swarm.take_off(6.0).await;
    let request = FormationRequest::new(Shape::Wedge, 5.0);
    swarm.node().set_formation(request).await.expect("is flown");
    let is = |fleet: &FleetSnapshot, id: u16, state: FlightState| {
        let vehicles = &fleet.vehicles;
        vehicles
            .iter()
            .any(|v| v.id == VehicleId(id) && v.flight_state == state)
    };
    swarm
        .until("three fly the wedge", Duration::from_secs(10), |f| {
            is(f, 1, FlightState::Leading) && members(f) == [1, 2, 3]
        })
        .await;
    swarm
        .simulation()
        .inflict(1, Fault::Silent(true))
        .expect("is simulated");
    swarm
        .until("another leads", Duration::from_secs(3), |f| {
            is(f, 2, FlightState::Leading) && !members(f).contains(&1)
        })
        .await;
    swarm
        .simulation()
        .inflict(1, Fault::Silent(false))
        .expect("is simulated");
    swarm
        .until("it follows", Duration::from_secs(20), |f| {
            is(f, 1, FlightState::Following) && is(f, 2, FlightState::Leading) && members(f) == [1, 2, 3]
        })
        .await;
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn garbage_on_the_port_disturbs_nobody() {
    let swarm = Swarm::start(2).await;
    swarm.take_off(5.0).await;
    let port = swarm.node().endpoint_addresses()["simulation"];
    let hostile = UdpSocket::bind("127.0.0.1:0").expect("binds");
    // Nothing, noise, a lone magic byte, a header that promises more than there is, an old-style header, a frame with a broken checksum.
    let heartbeat = [0xfd, 9, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 2, 12, 81, 3, 3, 0xde, 0xad];
    let frames: [&[u8]; 6] = [
        &[],
        &[0x55; 300],
        &[0xfd],
        &[0xfd, 255, 0, 0, 1, 1, 1, 0, 0, 0],
        &[0xfe, 9, 0, 1, 1, 0, 1, 2],
        &heartbeat,
    ];
    for _ in 0..200 {
        for frame in frames {
            hostile.send_to(frame, port).expect("is sent");
        }
    }
    let start = swarm.node().now();
    swarm
        .until("three more seconds", Duration::from_secs(3), |fleet| {
            fleet.time > start.plus_seconds(3.0)
        })
        .await;
    let fleet = swarm.node().snapshot();
    assert_eq!(fleet.vehicles.len(), 2, "no vehicle was made of garbage");
    for vehicle in &fleet.vehicles {
        assert_eq!(vehicle.flight_state, FlightState::Holding);
        assert!(vehicle.link.connected);
    }
    let (_, counters) = swarm
        .node()
        .endpoint_metrics()
        .into_iter()
        .next()
        .expect("has an endpoint");
    assert!(counters.read().bad_crc > 0, "the broken checksum was counted");
    swarm.stop().await;
}

/// A frame that says it comes from the autopilot of this system id.
fn forged<D: MessageData>(system_id: u8, message: &D) -> Vec<u8> {
    let header = MavHeader {
        system_id: u32::from(system_id),
        component_id: 1,
        sequence: 0,
    };
    let mut raw = MAVLinkV2MessageRaw::new();
    raw.serialize_message_data(header, message);
    raw.raw_bytes().to_vec()
}

/// Frames of vehicles 1 and 2 from a port of somebody else's: disarmed, in another mode, a kilometre away, just started. And heartbeats of forty
/// vehicles that nobody has.
async fn forge(port: SocketAddr) {
    let heartbeat = HEARTBEAT_DATA {
        custom_mode: 4 << 24 | 5 << 16,
        mavtype: MavType::MAV_TYPE_QUADROTOR,
        autopilot: MavAutopilot::MAV_AUTOPILOT_PX4,
        base_mode: MavModeFlag::empty(),
        system_status: MavState::MAV_STATE_STANDBY,
        mavlink_version: 3,
    };
    let elsewhere = LOCAL_POSITION_NED_DATA {
        time_boot_ms: 20,
        x: 1_000.0,
        ..LOCAL_POSITION_NED_DATA::default()
    };
    let socket = tokio::net::UdpSocket::bind("127.0.0.1:0").await.expect("binds");
    let mut period = tokio::time::interval(Duration::from_millis(20));
    loop {
        period.tick().await;
        for id in [1, 2] {
            for frame in [forged(id, &heartbeat), forged(id, &elsewhere)] {
                socket.send_to(&frame, port).await.expect("is sent");
            }
        }
        for id in 101..=140 {
            socket.send_to(&forged(id, &heartbeat), port).await.expect("is sent");
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn forged_frames_of_vehicles_in_flight_take_nobody_out_of_our_control() {
    let swarm = Swarm::start(3).await;
    swarm.take_off(6.0).await;
    let node = swarm.node();
    let port = node.endpoint_addresses()["simulation"];
    let begun = node.now();
    let forger = tokio::spawn(forge(port));
    let fleet = swarm
        .until("both strangers shown", Duration::from_secs(3), |fleet| {
            let shown = |id: u8| {
                fleet
                    .unadopted
                    .iter()
                    .any(|u| u.system_id.0 == id && u.why.contains("127.0.0.1"))
            };
            let waits = |id: u8| fleet.unadopted.iter().any(|u| u.system_id.0 == id);
            shown(1) && shown(2) && (101..=140).all(waits) && fleet.time > begun.plus_seconds(4.0)
        })
        .await;
    assert!(
        fleet.vehicles.iter().all(|v| v.flight_state == FlightState::Holding),
        "{fleet:?}"
    );
    let given_up =
        |event: &skein_view::EventRecord| matches!(event.kind, EventKind::Stream | EventKind::TakenOver { .. });
    assert!(!node.events_after(0).iter().any(|event| given_up(event)));

    let land = node
        .command(&Targets::Vehicles(vec![VehicleId(1)]), VehicleCommand::Land)
        .await;
    assert_eq!(land[0].refusal, None);
    let key = node.unlock_emergency_stop().key;
    let stopped = node.emergency_stop(&key, &Targets::Vehicles(vec![VehicleId(2)])).await;
    assert_eq!(stopped.expect("is unlocked")[0].refusal, None);
    swarm
        .until("one landed, one stopped", Duration::from_secs(20), |fleet| {
            let of = |id: u16| fleet.vehicles.iter().find(|v| v.id == VehicleId(id));
            of(1).is_some_and(|v| !v.armed) && of(2).is_some_and(|v| !v.armed && v.stopped)
        })
        .await;
    let truth = swarm.truth_now().await;
    let armed: Vec<bool> = [1, 2, 3]
        .map(|id| truth.vehicle(id).expect("is simulated").armed)
        .into();
    assert_eq!(armed, [false, false, true]);
    assert_eq!(node.snapshot().vehicles.len(), 3, "no vehicle was made of heartbeats");
    forger.abort();
    swarm.stop().await;
}
