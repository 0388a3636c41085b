//! Where a camera looks is taken from its frames as long as they are new, else from the gimbal, else not made up.

use super::*;
use serde_json::{Value, json};
use skein_domain::payload::FrameHeader;
use skein_domain::{PositionNed, VelocityNed};
use skein_view::ActorHealth;
use skein_view::PluginHealth;

const NOW_S: f64 = 100.0;

fn payload(kind: PayloadKind, state: Value) -> PayloadSnapshot {
    PayloadSnapshot {
        name: format!("{kind:?}").to_lowercase(),
        kind,
        actor: ActorHealth::default(),
        plugin: PluginHealth::default(),
        state: Some(state),
        transport_fault: String::new(),
        frame: None,
    }
}

fn camera() -> PayloadSnapshot {
    let state = json!({ "connected": true, "field_of_view_rad": 1.2, "width_px": 640, "height_px": 480 });
    payload(PayloadKind::Camera, state)
}

fn gimbal(connected: bool) -> PayloadSnapshot {
    let state = json!({ "connected": connected, "pitch_rad": -0.6, "yaw_vehicle_rad": 0.25 });
    payload(PayloadKind::Gimbal, state)
}

fn with_frame(taken_s: f64) -> PayloadSnapshot {
    let pose = CameraPose {
        pitch_rad: -0.3,
        field_of_view_rad: 0.9,
        ..CameraPose::default()
    };
    PayloadSnapshot {
        frame: Some(FrameHeader {
            time: NodeTime::from_seconds(taken_s),
            width_px: 320,
            height_px: 240,
            pose: Some(pose),
            ..FrameHeader::default()
        }),
        ..camera()
    }
}

fn views(payloads: &[PayloadSnapshot]) -> Vec<CameraView> {
    let at = VehicleKinematics {
        position: PositionNed::new(10.0, 20.0, -30.0),
        velocity: VelocityNed::new(0.0, 0.0, 0.0),
        yaw_rad: 1.0,
        measured: NodeTime::from_seconds(NOW_S),
    };
    let carrier = Carrier {
        id: VehicleId(7),
        at: Some(at),
        age_s: 0.125,
        payloads,
    };
    carrier.views(NodeTime::from_seconds(NOW_S))
}

#[test]
fn a_new_frame_says_it_best() {
    let found = views(&[gimbal(true), with_frame(NOW_S - 0.5)]);
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].known_from, found[0].width_px), (ViewSource::Frame, 320));
    assert!((found[0].pose.pitch_rad + 0.3).abs() < 1e-12 && (found[0].age_s - 0.5).abs() < 1e-6);
}

#[test]
fn without_a_new_frame_the_gimbal_says_it() {
    for camera in [camera(), with_frame(NOW_S - 60.0)] {
        let found = views(&[camera, gimbal(true)]);
        assert_eq!(found.len(), 1);
        let view = &found[0];
        assert_eq!(
            (view.known_from, view.width_px, view.height_px),
            (ViewSource::Gimbal, 640, 480)
        );
        assert!((view.pose.yaw_rad - 1.25).abs() < 1e-12 && (view.pose.pitch_rad + 0.6).abs() < 1e-12);
        assert_eq!(view.pose.position, PositionNed::new(10.0, 20.0, -30.0));
        assert!((view.pose.field_of_view_rad - 1.2).abs() < 1e-12 && (view.age_s - 0.125).abs() < 1e-12);
    }
}

#[test]
fn what_is_not_known_is_left_out() {
    assert!(views(&[camera()]).is_empty(), "no gimbal and no frame");
    assert!(
        views(&[camera(), gimbal(false)]).is_empty(),
        "a gimbal that is not heard"
    );
    let blind = payload(
        PayloadKind::Camera,
        json!({ "connected": true, "width_px": 640, "height_px": 480 }),
    );
    assert!(views(&[blind, gimbal(true)]).is_empty(), "no field of view");
    let odd = payload(PayloadKind::Camera, json!({ "connected": "perhaps" }));
    assert!(views(&[odd, gimbal(true)]).is_empty(), "a state of another shape");
    assert!(views(&[gimbal(true)]).is_empty(), "no camera");
}
