//! The simulated scene behind the settings: what moves in it, what is wrong with the camera, and the truth in the state.

use crate::synthetic::Synthetic;
use crate::truth::CameraReport;
use crate::{Camera, Settings};
use payload_mavlink::rig::{Rig, quiet};
use serde_json::{Value, json};
use skein_domain::exchange::{OwnState, PeerState};
use skein_domain::payload::{CameraPose, CameraState};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{NodeTime, PositionNed, VehicleId, VelocityNed};
use skein_sim::PayloadPlan;

const SIZE_PX: (u32, u32) = (320, 180);

fn settings(json: Value) -> Settings {
    serde_json::from_value(json).unwrap()
}

/// A bird that crosses ahead of the camera, and one that hovers behind it.
fn two_birds() -> Value {
    json!([
        { "kind": "bird", "path": { "hover": { "north_m": -10.0, "east_m": 0.0, "down_m": -20.0 } } },
        { "kind": "bird", "size_m": 1.5, "speed_m_s": 6.0, "path": { "line": {
            "from": { "north_m": 20.0, "east_m": -4.0, "down_m": -20.0 },
            "to": { "north_m": 20.0, "east_m": 20.0, "down_m": -20.0 } } } },
    ])
}

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

fn own() -> OwnState {
    OwnState {
        kinematics: Some(VehicleKinematics {
            position: PositionNed::new(0.0, 0.0, -20.0),
            ..VehicleKinematics::default()
        }),
        ..OwnState::default()
    }
}

fn picture(scene: &mut Synthetic, settings: &Settings, now: NodeTime) -> (CameraPose, Vec<u8>) {
    let pose = scene.pose(now, &own(), settings, 1.2).unwrap();
    let mut rgb = vec![0; 3 * (SIZE_PX.0 * SIZE_PX.1) as usize];
    scene.draw(now, &pose, SIZE_PX, &mut rgb);
    (pose, rgb)
}

#[test]
fn objects_move_through_the_picture_and_the_truth_names_them() {
    let settings = settings(json!({ "objects": two_birds() }));
    let mut scene = Synthetic::new(&settings, VehicleId(1));
    let velocity = VelocityNed::new(1.0, 0.0, 0.0);
    let peer = PeerState {
        id: VehicleId(7),
        kinematics: VehicleKinematics {
            position: PositionNed::new(8.0, 2.0, -20.0),
            velocity,
            ..VehicleKinematics::default()
        },
        airborne: true,
    };
    scene.see(&[peer], &settings);
    let (pose, first) = picture(&mut scene, &settings, at(0.5));
    let before = scene.truth(1, at(0.5), &pose, SIZE_PX);
    let (_, second) = picture(&mut scene, &settings, at(1.0));
    let after = scene.truth(2, at(1.0), &pose, SIZE_PX);
    assert_ne!(first, second);
    let names = |truth: &crate::PictureTruth| truth.seen.iter().map(|seen| seen.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&before), ["vehicle 7", "bird 2"]);
    assert_eq!(before.seen[0].seen.velocity, velocity);
    let (bird, later) = (before.seen[1].seen, after.seen[1].seen);
    assert_eq!(bird.velocity, VelocityNed::new(0.0, 6.0, 0.0));
    assert!((later.position.east_m - bird.position.east_m - 3.0).abs() < 1e-9);
    assert!(later.center_x_px > bird.center_x_px + 20.0, "{bird:?} {later:?}");
    // The same again from another instance.
    let mut other = Synthetic::new(&settings, VehicleId(1));
    other.see(&[peer], &settings);
    assert_eq!(picture(&mut other, &settings, at(1.0)).1, second);
}

#[test]
fn the_header_knows_of_the_sway_and_not_of_the_pose_error() {
    let plain = Settings::default();
    let rough = settings(json!({ "sway_rad": 0.2, "pose_error_rad": 0.03 }));
    let level = Synthetic::new(&plain, VehicleId(1));
    let scene = Synthetic::new(&rough, VehicleId(1));
    let (mut rolled_rad, mut off_rad) = (0.0_f64, 0.0_f64);
    for tick in 0..200 {
        let now = at(f64::from(tick) * 0.2);
        let still = level.pose(now, &own(), &plain, 1.2).unwrap();
        assert_eq!(level.believed(now, &still), still);
        let pose = scene.pose(now, &own(), &rough, 1.2).unwrap();
        assert_eq!(CameraPose { roll_rad: 0.0, ..pose }, still);
        let believed = scene.believed(now, &pose);
        assert!((believed.roll_rad - pose.roll_rad).abs() <= 0.03 + 1e-12);
        rolled_rad = rolled_rad.max(pose.roll_rad.abs());
        off_rad = off_rad.max((believed.yaw_rad - pose.yaw_rad).abs());
    }
    assert!(rolled_rad > 0.1 && off_rad > 0.01, "{rolled_rad} {off_rad}");
}

#[test]
fn each_setting_changes_the_picture_and_each_vehicle_has_its_own_noise() {
    let draw = |json: Value, vehicle: u16| {
        let settings = settings(json);
        picture(&mut Synthetic::new(&settings, VehicleId(vehicle)), &settings, at(2.0)).1
    };
    let plain = draw(json!({}), 1);
    for changed in [
        json!({ "look": "infrared" }),
        json!({ "clouds": 0.5 }),
        json!({ "exposure_change": 0.5 }),
        json!({ "noise_levels": 4.0 }),
        json!({ "sway_rad": 0.2 }),
        json!({ "objects": two_birds() }),
    ] {
        assert_ne!(draw(changed.clone(), 1), plain, "{changed}");
    }
    assert_eq!(draw(json!({ "pose_error_rad": 0.1 }), 1), plain);
    assert_eq!(draw(json!({}), 2), plain);
    let noisy = json!({ "noise_levels": 4.0 });
    assert_ne!(draw(noisy.clone(), 1), draw(noisy, 2));
}

#[test]
fn the_truth_stands_beside_the_state_and_only_when_asked_for() {
    let mut report = CameraReport {
        camera: CameraState::default(),
        truth: None,
    };
    let plain = serde_json::to_value(&report).unwrap();
    assert_eq!(plain, serde_json::to_value(CameraState::default()).unwrap());
    let settings = settings(json!({ "truth": true, "objects": two_birds() }));
    let mut scene = Synthetic::new(&settings, VehicleId(1));
    let (pose, _) = picture(&mut scene, &settings, at(1.0));
    report.truth = Some(scene.truth(5, at(1.0), &pose, SIZE_PX));
    let told = serde_json::to_value(&report).unwrap();
    assert_eq!(
        serde_json::from_value::<CameraState>(told.clone()).unwrap(),
        report.camera
    );
    let truth = &told["truth"];
    assert_eq!((&truth["frame"], &truth["time"]), (&json!(5), &json!(1_000_000)));
    let seen = &truth["seen"][0];
    assert_eq!(
        (&seen["name"], &seen["kind"]),
        (&json!("bird 2"), &json!("bird")),
        "{told}"
    );
    assert!(seen["position"]["north_m"].is_number() && seen["velocity"]["east_m_s"].is_number());
    assert!(seen["width_px"].as_f64().unwrap() > 5.0 && seen["inside"].as_f64().unwrap() > 0.99);
    // Without a frame there is none.
    let mut rig = Rig::<Camera>::new(
        &quiet(PayloadPlan::default()),
        r#"{"truth": true}"#,
        PositionNed::default(),
        0.0,
    );
    rig.run(1.0);
    assert!(
        rig.state()["truth"].is_null() && rig.state()["width_px"].is_number(),
        "{}",
        rig.state()
    );
}

#[test]
fn settings_that_cannot_be_are_refused_by_what_is_wrong() {
    let object = |change: Value| {
        let mut object =
            json!({ "kind": "quadrotor", "path": { "hover": { "north_m": 0.0, "east_m": 0.0, "down_m": -9.0 } } });
        object
            .as_object_mut()
            .unwrap()
            .extend(change.as_object().unwrap().clone());
        json!({ "objects": [two_birds()[0], object] })
    };
    let place = json!({ "north_m": 0.0, "east_m": 0.0, "down_m": -9.0 });
    let above = json!({ "north_m": 0.0, "east_m": 0.0, "down_m": -99.0 });
    for (wrong, reason) in [
        (json!({ "clouds": 1.5 }), "clouds = 1.5: it must be within 0 and 1"),
        (json!({ "exposure_change": 1.0 }), "exposure_change = 1"),
        (json!({ "noise_levels": -1.0 }), "noise_levels = -1"),
        (json!({ "sway_rad": 2.0 }), "sway_rad = 2"),
        (json!({ "pose_error_rad": 1.0 }), "pose_error_rad = 1"),
        (
            object(json!({ "size_m": 0.0 })),
            "objects, number 2 (quadrotor): size_m = 0: it must be within 0.01 and 1000",
        ),
        (object(json!({ "speed_m_s": -3.0 })), "speed_m_s = -3"),
        (object(json!({ "phase": 1.5 })), "phase = 1.5"),
        (
            object(json!({ "path": { "circle": { "centre": place, "radius_m": 0.0 } } })),
            "radius_m = 0",
        ),
        (
            object(json!({ "path": { "line": { "from": place, "to": above } } })),
            "the way over the ground",
        ),
        (
            object(json!({ "path": { "hover": { "north_m": 1e6, "east_m": 0.0, "down_m": 0.0 } } })),
            "hover.north_m = 1000000",
        ),
        (json!({ "objects": vec![two_birds()[0].clone(); 65] }), "65 of them"),
        (
            json!({ "source": "rtsp", "url": "rtsp://camera", "truth": true }),
            "source = \"synthetic\"",
        ),
    ] {
        let refusal = settings(wrong.clone()).check().unwrap_err();
        assert!(refusal.contains(reason), "{wrong}: {refusal}");
    }
    for unknown in [
        object(json!({ "kind": "balloon" })),
        object(json!({ "colour": "red" })),
        object(json!({ "path": { "spiral": {} } })),
        json!({ "look": "ultraviolet" }),
    ] {
        assert!(
            serde_json::from_value::<Settings>(unknown.clone()).is_err(),
            "{unknown}"
        );
    }
    assert_eq!(settings(object(json!({}))).check(), Ok(()));
}
