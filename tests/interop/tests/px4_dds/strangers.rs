//! Others on the topics of a vehicle in the air, and nonsense from itself: told, not obeyed, and it flies on.

use crate::rig::{Flown, PATIENCE, Skein, domain, nothing_wrong, peer, triple, vehicle};
use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};
use skein_domain::link::VehicleLink;
use skein_domain::{FlightMode, Telemetry};
use skein_link_dds::DdsEvent;
use skein_tests_interop::Peer;

/// One in the air, in OFFBOARD.
fn flying() -> Result<(u16, Peer, Skein, Flown, [f64; 3])> {
    let (domain, mut peer) = (domain(), peer()?);
    let skein = Skein::start(domain)?;
    peer.say(&vehicle("it", domain, "px4_1", "1.18", 6, &json!({})))?;
    let mut flown = skein.vehicle("px4_1", 6)?;
    let over = flown.enter_offboard()?;
    Ok((domain, peer, skein, flown, over))
}

fn stranger(who: &str, domain: u16, topic: &str, message: &str, more: &Value) -> Value {
    let topic = format!("rt/px4_1/fmu/{topic}");
    let mut line = json!({"do": "stranger", "who": who, "domain": domain, "topic": topic, "message": message});
    if let (Some(line), Some(more)) = (line.as_object_mut(), more.as_object()) {
        line.extend(more.clone());
    }
    line
}

fn told_of(skein: &Skein, topic: &str) -> Result<()> {
    skein.wait(&format!("{topic} has another writer"), |event| match event {
        DdsEvent::ForeignPublisher { topic: found } if found.to_string() == topic => Some(()),
        _ => None,
    })
}

/// For a while: in OFFBOARD, heard, sent setpoints, and nowhere but where it was sent.
fn flies_on(flown: &mut Flown, peer: &Peer, over: [f64; 3]) -> Result<()> {
    let sent = peer.truth("it")["setpoints"].as_u64().context("a number")?;
    let in_place = |t: &Telemetry| {
        t.mode == FlightMode::Offboard
            && t.local.is_none_or(|local| {
                (local.north_m - over[0]).hypot(local.east_m - over[1]) < 1.0 && (local.down_m - over[2]).abs() < 1.0
            })
    };
    let mut bad = None;
    flown.until("setpoints come", |t, _| {
        bad = bad.or_else(|| (!in_place(t)).then_some(*t));
        bad.is_some()
            || peer.truth("it")["setpoints"]
                .as_u64()
                .is_some_and(|now| now > sent + 50)
    })?;
    ensure!(bad.is_none(), "{bad:?}");
    ensure!(
        peer.truth("it")["nav_state"] == 14 && peer.truth("it")["streams_lost"] == 0,
        "{}",
        peer.truth("it")
    );
    Ok(())
}

#[test]
#[ignore = "long: part of `cargo xtask test interop`"]
fn strangers_are_told_and_take_no_vehicle_out_of_the_air() -> Result<()> {
    let (domain, mut peer, skein, mut flown, over) = flying()?;
    // A recording that is played back: plausible, and half a kilometre off.
    let played = json!({"shape": "local", "values": {
        "timestamp": 5_000_000, "x": 500.0, "xy_valid": true, "z_valid": true, "v_xy_valid": true, "v_z_valid": true}});
    peer.say(&stranger(
        "recording",
        domain,
        "out/vehicle_local_position_v1",
        "VehicleLocalPosition",
        &played,
    ))?;
    // Octets that are nothing, another type on a topic of its own, and answers that it never gave.
    let nonsense = json!({"octets": [9, 9, 9, 9, 9, 9, 9]});
    peer.say(&stranger(
        "nonsense",
        domain,
        "out/vehicle_status_v4",
        "std_msgs::msg::dds_::String_",
        &nonsense,
    ))?;
    peer.say(&stranger(
        "noise",
        domain,
        "out/vehicle_status_v4",
        "VehicleStatus",
        &nonsense,
    ))?;
    let answer =
        json!({"shape": "ack", "values": {"command": 400, "result": 4, "target_system": 245, "target_component": 190}});
    peer.say(&stranger(
        "answers",
        domain,
        "out/vehicle_command_ack_v1",
        "VehicleCommandAck",
        &answer,
    ))?;
    // One that would steer it: PX4 obeys whoever writes, so that it can but be told. This one sends what PX4 does not take.
    let steering = json!({"octets": [0, 0, 0, 0]});
    peer.say(&stranger(
        "steering",
        domain,
        "in/trajectory_setpoint",
        "another::Type",
        &steering,
    ))?;
    told_of(&skein, "/px4_1/fmu/in/trajectory_setpoint")?;
    flies_on(&mut flown, &peer, over)?;
    told_of(&skein, "/px4_1/fmu/out/vehicle_local_position_v1")?;
    told_of(&skein, "/px4_1/fmu/out/vehicle_status_v4")?;
    flies_on(&mut flown, &peer, over)?;
    flown.order(skein_domain::AutopilotCommand::Arm)?;
    let two = skein
        .events()
        .into_iter()
        .any(|event| matches!(event, DdsEvent::Duplicate { .. }));
    ensure!(!two, "{:?}", skein.events());
    nothing_wrong(&peer, "it", &[400, 22, 176])
}

#[test]
#[ignore = "long: part of `cargo xtask test interop`"]
fn nonsense_of_its_own_is_dropped_in_flight() -> Result<()> {
    let (_, mut peer, skein, mut flown, over) = flying()?;
    let faults = json!({"do": "change", "who": "it", "faults": {
        "vehicle_local_position": {"fields": {"x": "nan", "vy": "3e38"}},
        "vehicle_attitude": {"fields": {}, "octets": {}, "cut": 20},
        "vehicle_global_position": {"fields": {"lat": "1e308"}},
        "battery_status": {"more": 4000},
        "vehicle_gps_position": {"octets": {"fix_type": 255}},
        "vehicle_land_detected": {"octets": {"landed": 255}},
        "home_position": {"fields": {"alt": "inf"}}}});
    peer.say(&faults)?;
    let heard = |t: &Telemetry| [t.heard.local, t.heard.attitude, t.heard.global];
    let before = flown.until("nothing more is believed", |t, _| {
        [t.heard.local, t.heard.attitude, t.heard.global]
            .iter()
            .all(|at| t.heard.system_status.seconds_since(*at) > 0.3)
    })?;
    flies_on(&mut flown, &peer, over)?;
    let during = flown.step()?;
    ensure!(heard(&during) == heard(&before), "{during:?}");
    peer.say(&json!({"do": "change", "who": "it", "faults": {}}))?;
    flown.until("it is believed again", |t, _| {
        heard(t).iter().zip(heard(&before)).all(|(now, then)| *now > then)
    })?;
    flies_on(&mut flown, &peer, over)?;
    let bad = skein
        .events()
        .into_iter()
        .find(|event| !matches!(event, DdsEvent::Discovered { .. }));
    ensure!(bad.is_none(), "{bad:?}");
    nothing_wrong(&peer, "it", &[400, 22, 176])
}

#[test]
#[ignore = "long: part of `cargo xtask test interop`"]
fn a_flood_holds_up_nothing() -> Result<()> {
    let (domain, mut peer, _skein, mut flown, over) = flying()?;
    let (_, quiet) = flown.link.read(flown.now());
    let flood = |shape: &str, values: Value| json!({"shape": shape, "values": values, "each_step": 40});
    let turned = flood("attitude", json!({"timestamp": 5_000_000, "q": [0.0, 1.0, 0.0, 0.0]}));
    peer.say(&stranger(
        "turned",
        domain,
        "out/vehicle_attitude",
        "VehicleAttitude",
        &turned,
    ))?;
    let answers = flood(
        "ack",
        json!({"command": 400, "result": 4, "target_system": 245, "target_component": 190}),
    );
    peer.say(&stranger(
        "answers",
        domain,
        "out/vehicle_command_ack_v1",
        "VehicleCommandAck",
        &answers,
    ))?;
    for _ in 0..3 {
        flies_on(&mut flown, &peer, over)?;
    }
    let telemetry = flown.step()?;
    ensure!(telemetry.roll_rad.abs() < 0.1, "turned by a stranger: {telemetry:?}");
    ensure!(flown.now().seconds_since(telemetry.heard.local) < 1.0, "{telemetry:?}");
    ensure!(quiet.connected && flown.link.read(flown.now()).1.connected);
    flown.order(skein_domain::AutopilotCommand::Land)?;
    flown.setpoint = None;
    peer.wait(PATIENCE, "the landing", |told| {
        (triple(&told.truth["it"], "position")[2] > -3.0).then_some(())
    })?;
    nothing_wrong(&peer, "it", &[400, 22, 176, 21])
}
