//! The MAVLink gimbal of a simulated vehicle, found, owned, turned.

use crate::{Gimbal, Settings};
use mavlink::MessageData;
use mavlink::dialects::common::{COMMAND_LONG_DATA, MavCmd};
use payload_mavlink::encode;
use payload_mavlink::rig::{OWN, Rig, SYSTEM_ID, quiet};
use serde_json::json;
use skein_domain::payload::MavlinkMessage;
use skein_domain::{PositionNed, Refusal, SwarmFrame};
use skein_plugin_sdk::Payload;
use skein_sim::{GimbalSettings, PayloadPlan};

const NOSE_RAD: f64 = 0.8;
const QGC: (u8, u8) = (255, 190);

fn rig_with(config: &str) -> Rig<Gimbal> {
    rig_on(GimbalSettings::default(), config)
}

fn rig_on(gimbal: GimbalSettings, config: &str) -> Rig<Gimbal> {
    let plan = PayloadPlan {
        gimbal: Some(gimbal),
        ..PayloadPlan::default()
    };
    Rig::new(&quiet(plan), config, PositionNed::new(20.0, -30.0, -7.0), NOSE_RAD)
}

/// One that has found its gimbal.
fn rig() -> Rig<Gimbal> {
    found(GimbalSettings::default())
}

pub(super) fn found(gimbal: GimbalSettings) -> Rig<Gimbal> {
    let mut rig = rig_on(gimbal, "{}");
    assert!(
        rig.run_until(5.0, |rig| rig.state()["connected"] == true),
        "{}",
        rig.state()
    );
    rig
}

pub(super) fn truth(rig: &Rig<Gimbal>) -> skein_sim::GimbalTruth {
    rig.vehicle.truth().gimbal.expect("it carries a gimbal")
}

pub(super) fn angles(pitch_rad: f64, yaw_rad: f64, yaw_frame: &str) -> String {
    json!({"command": "angles", "pitch_rad": pitch_rad, "yaw_rad": yaw_rad, "yaw_frame": yaw_frame}).to_string()
}

fn configure(who: (u8, u8)) -> MavlinkMessage {
    let command = COMMAND_LONG_DATA {
        param1: f32::from(who.0),
        param2: f32::from(who.1),
        param3: -1.0,
        param4: -1.0,
        command: MavCmd::MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE,
        target_system: SYSTEM_ID,
        target_component: 1,
        ..COMMAND_LONG_DATA::default()
    };
    MavlinkMessage {
        message_id: COMMAND_LONG_DATA::ID,
        payload: encode(&command),
        ..MavlinkMessage::default()
    }
}

/// Somebody takes primary control.
fn taken_by(rig: &mut Rig<Gimbal>, who: (u8, u8)) {
    rig.send_as(who, &configure(who));
    // The manager says every two seconds who has it.
    rig.run(2.5);
}

#[test]
fn it_is_found_and_says_what_it_is() {
    let mut rig = rig();
    rig.run(3.0);
    let state = rig.state();
    assert_eq!(state["owner"]["kind"], "nobody", "{state}");
    assert!(!state["model"].as_str().unwrap().is_empty(), "{state}");
    // What the device can, and what the settings allow.
    let close = |key: &str, value: f64| (state[key].as_f64().unwrap() - value).abs() < 1e-6;
    assert!(close("pitch_min_rad", Settings::default().pitch_min_rad), "{state}");
    assert!(close("pitch_max_rad", 30_f64.to_radians()), "{state}");
    rig.replay();
}

#[test]
fn angles_are_reached_in_either_frame() {
    let mut rig = rig();
    for (pitch, yaw, frame, from_nose) in [
        (-0.6, 0.5, "vehicle", 0.5),
        (-0.2, 2.0, "north", 2.0 - NOSE_RAD),
        (0.1, -3.0, "north", -3.0 - NOSE_RAD + std::f64::consts::TAU),
    ] {
        let id = rig.command(&angles(pitch, yaw, frame));
        assert_eq!(rig.end_of(id, 8.0), Some(Ok(())));
        let truth = truth(&rig);
        assert!((truth.pitch_rad - pitch).abs() < 0.04, "{truth:?}");
        assert!((truth.yaw_vehicle_rad - from_nose).abs() < 0.04, "{truth:?}");
        rig.run(1.0);
        let state = rig.state();
        assert!((state["pitch_rad"].as_f64().unwrap() - pitch).abs() < 0.01, "{state}");
        assert_eq!(state["owner"]["kind"], "us");
        assert_eq!(state["mode"], "angles");
    }
    assert_eq!(truth(&rig).owner, OWN);
    rig.replay();
}

#[test]
fn beyond_its_limits_it_goes_to_them_and_says_so() {
    let mut rig = rig_with(r#"{"pitch_min_rad": -0.5}"#);
    rig.run(3.0);
    let id = rig.command(&angles(-1.4, 0.0, "vehicle"));
    assert_eq!(rig.end_of(id, 8.0), Some(Ok(())));
    assert!((rig.state()["wanted_pitch_rad"].as_f64().unwrap() + 0.5).abs() < 1e-3);
    rig.run(1.0);
    assert!((truth(&rig).pitch_rad + 0.5).abs() < 0.02);
}

#[test]
fn rates_turn_it_until_told_otherwise() {
    let mut rig = rig();
    let id = rig.command(r#"{"command": "rates", "pitch_rad_s": -0.1, "yaw_rad_s": 0.2}"#);
    assert_eq!(rig.end_of(id, 2.0), Some(Ok(())));
    let before = truth(&rig);
    rig.run(2.0);
    let after = truth(&rig);
    assert!(
        (after.pitch_rad - before.pitch_rad + 0.2).abs() < 0.03,
        "{before:?} {after:?}"
    );
    assert!(
        (after.yaw_vehicle_rad - before.yaw_vehicle_rad - 0.4).abs() < 0.05,
        "{before:?} {after:?}"
    );
    let id = rig.command(r#"{"command": "neutral"}"#);
    assert_eq!(rig.end_of(id, 5.0), Some(Ok(())));
    rig.run(1.0);
    assert!(truth(&rig).pitch_rad.abs() < 0.02 && truth(&rig).yaw_vehicle_rad.abs() < 0.02);
}

#[test]
fn a_place_is_looked_at() {
    let mut rig = rig();
    let vehicle = rig.vehicle.truth().position;
    // Forty metres north-east, thirty below.
    let place = PositionNed::new(vehicle.north_m + 40.0, vehicle.east_m + 40.0, vehicle.down_m + 30.0);
    let place = SwarmFrame::new(skein_sim::SimSettings::default().origin).geodetic(&place);
    let id = rig.command(&json!({"command": "point_at", "place": place}).to_string());
    assert_eq!(rig.end_of(id, 8.0), Some(Ok(())));
    rig.run(1.0);
    let truth = truth(&rig);
    assert!(
        (truth.yaw_north_rad - std::f64::consts::FRAC_PI_4).abs() < 0.02,
        "{truth:?}"
    );
    assert!(
        (truth.pitch_rad + (30.0_f64 / 40.0_f64.hypot(40.0)).atan()).abs() < 0.02,
        "{truth:?}"
    );
    assert_eq!(rig.state()["mode"], "point_at");
    assert!(rig.state()["place"].is_object());
}

#[test]
fn another_owner_is_not_fought() {
    let mut rig = rig();
    let id = rig.command(&angles(-0.3, 0.0, "vehicle"));
    assert_eq!(rig.end_of(id, 8.0), Some(Ok(())));
    taken_by(&mut rig, QGC);
    let state = rig.state();
    assert_eq!(
        state["owner"],
        json!({"kind": "other", "system_id": 255, "component_id": 190})
    );
    assert_eq!(state["mode"], "idle");
    let id = rig.command(&angles(-0.5, 0.0, "vehicle"));
    assert!(matches!(rig.ended(id), Some(Err(Refusal::NotPermitted { .. }))));
    rig.run(5.0);
    assert_eq!(truth(&rig).owner, QGC);
    let id = rig.command(r#"{"command": "take_control"}"#);
    assert_eq!(rig.end_of(id, 3.0), Some(Ok(())));
    assert_eq!(truth(&rig).owner, OWN);
    let id = rig.command(&angles(-0.5, 0.0, "vehicle"));
    assert_eq!(rig.end_of(id, 8.0), Some(Ok(())));
    let id = rig.command(r#"{"command": "release_control"}"#);
    assert_eq!(rig.end_of(id, 3.0), Some(Ok(())));
    rig.run(1.0);
    assert_eq!(truth(&rig).owner.0, 0);
    assert_eq!(rig.state()["owner"]["kind"], "nobody");
    rig.replay();
}

/// Who has it is asked before it is taken.
#[test]
fn an_owner_from_before_is_not_fought_either() {
    let mut rig = rig_with("{}");
    rig.run(0.1);
    rig.send_as(QGC, &configure(QGC));
    rig.run(0.05);
    let mut ends = Vec::new();
    for _ in 0..30 {
        let id = rig.command(&angles(-0.5, 0.0, "vehicle"));
        rig.run(0.1);
        ends.push(rig.ended(id));
    }
    assert_eq!(truth(&rig).owner, QGC);
    assert!(
        matches!(ends.last(), Some(Some(Err(Refusal::NotPermitted { .. })))),
        "{ends:?}"
    );
}

/// The manager says only every two seconds who is in control, but denies a move at once.
#[test]
fn a_denied_move_is_not_repeated_against_whoever_took_control() {
    let mut rig = rig();
    let id = rig.command(&angles(-0.3, 0.0, "vehicle"));
    assert_eq!(rig.end_of(id, 8.0), Some(Ok(())));
    rig.run(1.0);
    rig.send_as(QGC, &configure(QGC));
    rig.run(0.1);
    let id = rig.command(&angles(-0.5, 0.0, "vehicle"));
    let end = rig.end_of(id, 1.0);
    assert!(matches!(end, Some(Err(Refusal::NotPermitted { .. }))), "{end:?}");
    assert_eq!(truth(&rig).owner, QGC);
    rig.replay();
}

#[test]
fn what_it_calls_us_is_learned() {
    let mut rig = rig_with(r#"{"own_system_id": 9, "own_component_id": 9}"#);
    rig.run(2.0);
    let id = rig.command(&angles(-0.5, 0.0, "vehicle"));
    assert_eq!(rig.end_of(id, 8.0), Some(Ok(())));
    assert_eq!(truth(&rig).owner, OWN);
}

#[test]
fn a_newer_command_replaces_the_one_before() {
    let mut rig = rig();
    let first = rig.command(&angles(-1.0, 3.0, "vehicle"));
    rig.run(0.3);
    let second = rig.command(&angles(-0.1, 0.0, "vehicle"));
    assert_eq!(rig.ended(first), Some(Err(Refusal::Superseded)));
    assert_eq!(rig.end_of(second, 8.0), Some(Ok(())));
}

#[test]
fn a_command_that_does_not_arrive_ends() {
    let mut rig = rig();
    rig.deaf = true;
    let id = rig.command(&angles(-0.5, 0.0, "vehicle"));
    let end = rig.end_of(id, 15.0);
    assert!(matches!(end, Some(Err(Refusal::TimedOut { .. }))), "{end:?}");
}

#[test]
fn it_is_lost_and_found_again_and_goes_on() {
    let mut rig = rig();
    let id = rig.command(&angles(-0.5, 1.5, "north"));
    assert_eq!(rig.end_of(id, 8.0), Some(Ok(())));
    rig.mute = true;
    rig.run(3.0);
    assert_eq!(rig.state()["connected"], false);
    let id = rig.command(&angles(-0.5, 0.0, "vehicle"));
    assert!(matches!(rig.ended(id), Some(Err(Refusal::NotRunning { .. }))));
    // Meanwhile the manager has forgotten everything.
    rig.vehicle.reboot();
    rig.mute = false;
    assert!(rig.run_until(40.0, |rig| (truth(rig).pitch_rad + 0.5).abs() < 0.02
        && truth(rig).owner == OWN));
    rig.run(1.0);
    assert_eq!(rig.state()["owner"]["kind"], "us");
}

#[test]
fn a_restart_in_the_middle_of_a_turn_is_not_seen() {
    let mut rig = rig();
    let id = rig.command(&angles(-1.2, 3.0, "vehicle"));
    rig.run(0.02);
    for _ in 0..10 {
        rig.restart();
        rig.run(0.15);
    }
    assert_eq!(rig.end_of(id, 8.0), Some(Ok(())));
    assert!((truth(&rig).pitch_rad + 1.2).abs() < 0.04);
    rig.replay();
}

#[test]
fn without_a_gimbal_commands_are_refused() {
    let mut rig: Rig<Gimbal> = Rig::new(&quiet(PayloadPlan::default()), "{}", PositionNed::default(), 0.0);
    rig.run(3.0);
    assert_eq!(rig.state()["connected"], false);
    let id = rig.command(r#"{"command": "take_control"}"#);
    assert!(matches!(rig.ended(id), Some(Err(Refusal::NotRunning { .. }))));
    assert_eq!(Gimbal::MANIFEST.name, "gimbal");
}
