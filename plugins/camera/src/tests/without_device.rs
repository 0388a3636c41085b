//! A camera whose pictures are its frames. Frames themselves need a host that lends buffers; what is done about them is tested here.

use crate::capture::Capture;
use crate::synthetic::Synthetic;
use crate::{Camera, Settings};
use payload_mavlink::rig::{Rig, quiet};
use serde_json::json;
use skein_domain::exchange::{OwnState, PayloadReport, PeerState};
use skein_domain::payload::{GimbalState, PayloadKind};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{NodeTime, PositionNed, Refusal, VehicleId};
use skein_plugin_sdk::Effects;
use skein_sim::PayloadPlan;
use skein_sim_payloads::scene;

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

fn own() -> OwnState {
    OwnState {
        kinematics: Some(VehicleKinematics {
            position: PositionNed::new(0.0, 0.0, -20.0),
            yaw_rad: 0.7,
            ..VehicleKinematics::default()
        }),
        roll_rad: Some(0.1),
        pitch_rad: Some(-0.2),
        ..OwnState::default()
    }
}

fn gimbal(name: &str, state: &GimbalState) -> PayloadReport {
    PayloadReport {
        name: name.to_owned(),
        kind: PayloadKind::Gimbal,
        state_json: Some(serde_json::to_string(state).unwrap()),
    }
}

#[test]
fn it_looks_where_its_gimbal_does() {
    let settings = Settings {
        mount_pitch_rad: -0.3,
        ..Settings::default()
    };
    let mut scene = Synthetic::new(&settings, VehicleId(1));
    let fixed = scene.pose(at(1.0), &own(), &settings, 1.0).unwrap();
    assert!((fixed.pitch_rad + 0.5).abs() < 1e-9 && (fixed.roll_rad - 0.1).abs() < 1e-9 && fixed.yaw_rad == 0.7);
    let state = GimbalState {
        connected: true,
        pitch_rad: -1.0,
        yaw_vehicle_rad: 0.5,
        ..GimbalState::default()
    };
    scene.hear(&gimbal("front", &state), &settings);
    let held = scene.pose(at(1.0), &own(), &settings, 1.0).unwrap();
    assert!((held.pitch_rad + 1.0).abs() < 1e-9 && held.roll_rad == 0.0 && (held.yaw_rad - 1.2).abs() < 1e-9);
    // Another gimbal than the one that carries it.
    let named = Settings {
        gimbal: "rear".to_owned(),
        ..settings
    };
    let mut scene = Synthetic::new(&named, VehicleId(1));
    scene.hear(&gimbal("front", &state), &named);
    assert_eq!(scene.pose(at(1.0), &own(), &named, 1.0).unwrap(), fixed);
    assert_eq!(scene.pose(at(1.0), &OwnState::default(), &named, 1.0), None);
}

#[test]
fn peers_are_in_the_picture() {
    let settings = Settings::default();
    let mut scene = Synthetic::new(&settings, VehicleId(1));
    let pose = scene
        .pose(
            at(1.0),
            &OwnState {
                roll_rad: None,
                pitch_rad: None,
                ..own()
            },
            &settings,
            1.0,
        )
        .unwrap();
    let (width, height) = (160, 120);
    let draw = |scene: &mut Synthetic| {
        let mut out = vec![0; 160 * 120 * 3];
        scene.draw(at(1.0), &pose, (width, height), &mut out);
        out
    };
    let empty = draw(&mut scene);
    let ahead = PositionNed::new(5.0 * 0.7_f64.cos(), 5.0 * 0.7_f64.sin(), -20.0);
    let peer = PeerState {
        id: VehicleId(2),
        kinematics: VehicleKinematics {
            position: ahead,
            ..VehicleKinematics::default()
        },
        airborne: true,
    };
    scene.see(&[peer], &settings);
    let (column, row) = scene::project(&pose, &ahead, width, height).unwrap();
    let middle = (row as usize * 160 + column as usize) * 3;
    assert_ne!(draw(&mut scene)[middle..middle + 3], empty[middle..middle + 3]);
    scene.see(&[], &settings);
    assert_eq!(draw(&mut scene), empty);
}

#[test]
fn frames_come_at_their_rate() {
    let mut capture = Capture::default();
    let due = |capture: &mut Capture, from_s: f64, until_s: f64| {
        let ticks = ((until_s - from_s) * 30.0) as u32;
        (0..ticks)
            .filter(|tick| capture.frame_is_due(at(from_s + f64::from(*tick) / 30.0), 0.2))
            .count()
    };
    assert_eq!(due(&mut capture, 1.0, 11.0), 50);
    // What was missed is not made up for.
    assert!((49..=51).contains(&due(&mut capture, 30.0, 40.0)));
}

#[test]
fn pictures_are_frames_and_recording_lasts_over_a_restart() {
    let (mut capture, mut effects) = (Capture::default(), Effects::default());
    capture.take_pictures(at(1.0), 2, 1.0);
    capture.start_recording(at(1.0), &mut effects);
    let mut pictures = Vec::new();
    for tenth in 10..50 {
        capture.gave_frame(at(f64::from(tenth) * 0.1), &mut effects);
        pictures.push(capture.pictures);
        // Another instance goes on.
        capture = minicbor::decode(&minicbor::to_vec(&capture).unwrap()).unwrap();
    }
    assert_eq!((pictures[0], pictures[9], pictures[10], pictures[39]), (1, 1, 2, 2));
    assert!(!capture.is_capturing() && capture.is_recording());
    assert_eq!(capture.frames, 40);
    assert!((capture.recording_s(at(6.0)) - 5.0).abs() < 1e-9);
    capture.stop_recording(at(7.0), &mut effects);
    capture.stop_recording(at(8.0), &mut effects);
    assert!((capture.recording_s(at(9.0)) - 6.0).abs() < 1e-9);
    assert_eq!(
        effects.as_slice().len(),
        4,
        "two pictures, one beginning, one end: {effects:?}"
    );
}

fn rig(config: &str) -> Rig<Camera> {
    Rig::new(
        &quiet(PayloadPlan::default()),
        config,
        PositionNed::new(0.0, 0.0, -10.0),
        0.0,
    )
}

#[test]
fn what_it_cannot_do_is_refused_with_the_reason() {
    let mut rig = rig("{}");
    rig.run(0.5);
    for (command, ends) in [
        (json!({"command": "zoom", "factor": 2.0}), None),
        (json!({"command": "zoom", "factor": 0.5}), Some("invalid_value")),
        (
            json!({"command": "take_pictures", "count": 0, "interval_s": -1.0}),
            Some("invalid_value"),
        ),
        (json!({"command": "start_stream"}), Some("not_supported")),
        (json!({"command": "set_mode", "mode": "survey"}), None),
    ] {
        let id = rig.command(&command.to_string());
        let end = rig.ended(id).expect("it ends at once");
        assert_eq!(end.err().as_ref().map(Refusal::code), ends, "{command}");
    }
    let state = rig.state();
    assert_eq!((&state["zoom"], &state["mode"]), (&json!(2.0), &json!("survey")));
    assert!(state["field_of_view_rad"].as_f64().unwrap() < Settings::default().field_of_view_rad);
    rig.restart();
    rig.run(0.5);
    assert_eq!(
        (&rig.state()["zoom"], &rig.state()["mode"]),
        (&json!(2.0), &json!("survey"))
    );
    rig.replay();
}

#[test]
fn files_that_are_not_there_are_a_fault() {
    let mut rig = rig(r#"{"source": "stills", "path": "/nowhere/at/all"}"#);
    let told = (0..500).any(|_| {
        rig.run(0.2);
        // Its thread lives in real time.
        std::thread::yield_now();
        rig.state()["fault"]
            .as_str()
            .is_some_and(|fault| fault.contains("/nowhere/at/all"))
    });
    assert!(told, "{}", rig.state());
    assert_eq!(rig.state()["connected"], false);
    let id = rig.command(r#"{"command": "zoom", "factor": 2.0}"#);
    assert!(matches!(rig.ended(id), Some(Err(Refusal::NotSupported { .. }))));
}
