//! The MAVLink camera of a simulated vehicle, asked and told.

use crate::Camera;
use payload_mavlink::rig::{Rig, quiet};
use serde_json::{Value, json};
use skein_domain::exchange::Effect;
use skein_domain::{PositionNed, Refusal};
use skein_sim::{CameraSettings, CameraTruth, PayloadPlan};

/// One that has found its camera.
fn rig() -> Rig<Camera> {
    let plan = PayloadPlan {
        camera: Some(CameraSettings::default()),
        ..PayloadPlan::default()
    };
    let mut rig = Rig::new(&quiet(plan), r#"{"source": "mavlink"}"#, PositionNed::default(), 0.0);
    assert!(
        rig.run_until(10.0, |rig| rig.state()["storage_free_mib"].is_number()),
        "{}",
        rig.state()
    );
    rig.run(3.0);
    rig
}

fn truth(rig: &Rig<Camera>) -> CameraTruth {
    rig.vehicle.truth().camera.expect("it carries a camera")
}

fn does(rig: &mut Rig<Camera>, command: &str) {
    let id = rig.command(command);
    assert_eq!(rig.end_of(id, 5.0), Some(Ok(())), "{command}");
}

fn happened(rig: &Rig<Camera>) -> Vec<Value> {
    let events = rig.effects.iter().filter_map(|(_, effect)| match effect {
        Effect::Occurrence { event_json } => serde_json::from_str(event_json).ok(),
        _ => None,
    });
    events.collect()
}

#[test]
fn it_says_what_it_is() {
    let rig = rig();
    let state = rig.state();
    assert_eq!(state["connected"], true, "{state}");
    assert!(!state["model"].as_str().unwrap().is_empty(), "{state}");
    assert_eq!((&state["width_px"], &state["height_px"]), (&json!(1280), &json!(720)));
    assert!(
        (state["field_of_view_rad"].as_f64().unwrap() - 70_f64.to_radians()).abs() < 0.01,
        "{state}"
    );
    assert_eq!(state["storage_total_mib"], 4096.0);
    assert_eq!(state["streams"].as_array().unwrap().len(), 1, "{state}");
    rig.replay();
}

#[test]
fn pictures_are_taken_and_counted() {
    let mut rig = rig();
    does(&mut rig, r#"{"command": "take_pictures"}"#);
    does(&mut rig, r#"{"command": "take_pictures", "count": 1}"#);
    rig.run(4.0);
    assert_eq!(
        truth(&rig).pictures,
        2,
        "one for each command, however often it was sent"
    );
    assert_eq!(rig.state()["pictures"], 2);
    does(
        &mut rig,
        r#"{"command": "take_pictures", "count": 0, "interval_s": 0.5}"#,
    );
    rig.run(3.0);
    assert_eq!(rig.state()["capturing"], true);
    does(&mut rig, r#"{"command": "stop_pictures"}"#);
    rig.run(3.0);
    assert_eq!(rig.state()["capturing"], false);
    let pictures = truth(&rig).pictures;
    assert!((6..=10).contains(&pictures), "{pictures}");
    assert_eq!(rig.state()["pictures"], pictures);
    let told = happened(&rig)
        .iter()
        .filter(|event| event["event"] == "picture_taken")
        .count();
    assert_eq!(told, pictures as usize);
    rig.replay();
}

#[test]
fn recording_zoom_mode_and_stream() {
    let mut rig = rig();
    does(&mut rig, r#"{"command": "set_mode", "mode": "video"}"#);
    does(&mut rig, r#"{"command": "start_recording"}"#);
    rig.run(4.0);
    assert!(truth(&rig).recording);
    let state = rig.state();
    assert_eq!(
        (&state["recording"], &state["mode"]),
        (&json!(true), &json!("video")),
        "{state}"
    );
    assert!(state["recording_s"].as_f64().unwrap() > 1.0, "{state}");
    rig.restart();
    does(&mut rig, r#"{"command": "stop_recording"}"#);
    rig.run(3.0);
    assert!(!truth(&rig).recording);
    assert_eq!(rig.state()["recording"], false);
    let kinds: Vec<Value> = happened(&rig).iter().map(|event| event["event"].clone()).collect();
    assert_eq!(kinds, ["recording_started", "recording_stopped"]);
    does(&mut rig, r#"{"command": "zoom", "factor": 3.0}"#);
    rig.run(4.0);
    assert!(
        (rig.state()["zoom"].as_f64().unwrap() - 3.0).abs() < 0.05,
        "{}",
        rig.state()
    );
    let narrow = rig.state()["field_of_view_rad"].as_f64().unwrap();
    assert!(
        (narrow - truth(&rig).field_of_view_rad).abs() < 0.05,
        "{narrow} {:?}",
        truth(&rig)
    );
    does(&mut rig, r#"{"command": "stop_stream"}"#);
    does(&mut rig, r#"{"command": "start_stream"}"#);
    let refused = rig.command(r#"{"command": "zoom", "factor": 30.0}"#);
    assert!(matches!(rig.ended(refused), Some(Err(Refusal::InvalidValue { .. }))));
}

#[test]
fn a_command_that_does_not_arrive_ends_also_over_a_restart() {
    let mut rig = rig();
    rig.deaf = true;
    let id = rig.command(r#"{"command": "start_recording"}"#);
    rig.run(1.0);
    rig.restart();
    let end = rig.end_of(id, 10.0);
    assert!(matches!(end, Some(Err(Refusal::TimedOut { .. }))), "{end:?}");
}

#[test]
fn what_is_not_heard_is_lost() {
    let mut rig = rig();
    rig.mute = true;
    rig.run(7.0);
    assert_eq!(rig.state()["connected"], false);
    let id = rig.command(r#"{"command": "take_pictures"}"#);
    assert!(matches!(rig.ended(id), Some(Err(Refusal::NotRunning { .. }))));
    rig.mute = false;
    assert!(rig.run_until(5.0, |rig| rig.state()["connected"] == true));
}
