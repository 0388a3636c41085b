//! Payloads over MAVLink: who answers what, and that the messages say what is really the case.

use super::rig::{Rig, command_frame, quiet};
use crate::settings::SimSettings;
use crate::truth::VehicleTruth;
use crate::vehicle::LinkKind;
use mavlink::Message;
use mavlink::dialects::common::*;
use nalgebra::{Quaternion, UnitQuaternion};
use skein_domain::PositionNed;
use skein_sim_payloads::{CameraSettings, GimbalOutput, GimbalSettings, PayloadPlan, RadioSettings};
use std::collections::BTreeMap;

const OK: Option<MavResult> = Some(MavResult::MAV_RESULT_ACCEPTED);
const DENIED: Option<MavResult> = Some(MavResult::MAV_RESULT_DENIED);

fn carrying(payloads: PayloadPlan) -> SimSettings {
    SimSettings { payloads, ..quiet() }
}

pub fn all() -> SimSettings {
    carrying(PayloadPlan::all())
}

pub fn take_control(rig: &mut Rig) {
    assert_eq!(rig.command(1001, [245.0, 190.0, 0.0, 0.0, 0.0, 0.0, 0.0]), OK);
}

fn asks(rig: &mut Rig, component: u8, message: u32, index: f32) -> Option<MavMessage> {
    let before = rig.received.len();
    let answer = rig.command_to(1, component, 512, [message as f32, index, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let found = rig.received[before..]
        .iter()
        .rev()
        .find(|(_, _, m)| m.message_id() == message)
        .map(|(_, _, m)| m.clone());
    assert_eq!(answer == OK, found.is_some(), "{message}: {answer:?}");
    found
}

fn pitchyaw(pitch_deg: f32, yaw_deg: f32, flags: f32) -> [f32; 7] {
    [pitch_deg, yaw_deg, f32::NAN, f32::NAN, flags, 0.0, 0.0]
}

#[test]
fn a_bare_vehicle_says_and_answers_what_it_did() {
    let mut rig = Rig::ready(&quiet());
    rig.run(3.0);
    let strange = |(_, _, m): &(f64, LinkKind, MavMessage)| matches!(m.message_id(), 109 | 259..=290);
    assert!(!rig.received.iter().any(strange));
    assert_eq!(
        rig.command(1000, pitchyaw(0.0, 0.0, 0.0)),
        None,
        "left to a manager that is not there"
    );
    assert_eq!(rig.command_to(1, 100, 2000, [0.0; 7]), None, "no such component");
    let truth = rig.truth();
    assert!(truth.gimbal.is_none() && truth.camera.is_none() && truth.radio.is_none());
}

#[test]
fn everything_speaks_at_its_rate_from_its_component_and_flies_as_before() {
    let mut rig = Rig::flying(&all(), 5.0);
    rig.run(2.0);
    for (id, rate_hz) in [(281, 0.5), (285, 10.0), (109, 1.0), (0, 3.0)] {
        for link in [LinkKind::Onboard, LinkKind::GroundStation] {
            let found = rig.rate_hz(link, id, 4.0);
            assert!((found - rate_hz).abs() < 0.6, "{id}: {found} Hz");
        }
    }
    let mut kinds = BTreeMap::new();
    for (_, _, message) in &rig.received {
        if let MavMessage::HEARTBEAT(m) = message {
            *kinds.entry(m.mavtype as u32).or_insert(0) += 1;
        }
    }
    assert_eq!(kinds.into_keys().collect::<Vec<_>>(), [2, 26, 30]);
}

#[test]
fn the_gimbal_is_found_taken_and_steered() {
    let mut rig = Rig::ready(&all());
    let Some(MavMessage::GIMBAL_MANAGER_INFORMATION(manager)) = asks(&mut rig, 1, 280, 0.0) else {
        panic!()
    };
    assert_eq!(manager.gimbal_device_id, 154);
    assert!((manager.pitch_min + 120_f32.to_radians()).abs() < 1e-6);
    for component in [154, 0] {
        let Some(MavMessage::GIMBAL_DEVICE_INFORMATION(device)) = asks(&mut rig, component, 283, 0.0) else {
            panic!()
        };
        assert_eq!(device.model_name.to_str().unwrap(), "Simulated gimbal");
    }
    assert_eq!(
        asks(&mut rig, 1, 283, 0.0),
        None,
        "the autopilot has no such message of its own"
    );
    assert_eq!(
        rig.command(1000, pitchyaw(-30.0, 20.0, 0.0)),
        DENIED,
        "nobody is in control"
    );
    take_control(&mut rig);
    assert_eq!(rig.command(1000, pitchyaw(-30.0, 20.0, 0.0)), OK);
    rig.run(1.5);
    let truth = rig.truth().gimbal.unwrap();
    assert!(
        (truth.pitch_rad.to_degrees() + 30.0).abs() < 0.1 && (truth.yaw_vehicle_rad.to_degrees() - 20.0).abs() < 0.1
    );
    assert_eq!(truth.owner, (245, 190));
    rig.run(1.0);
    let status = rig.last(|m| match m {
        MavMessage::GIMBAL_MANAGER_STATUS(m) => Some((m.primary_control_sysid, m.primary_control_compid)),
        _ => None,
    });
    assert_eq!(status, Some((245, 190)));
    // What the device says is where it is.
    let q = rig.last(|m| match m {
        MavMessage::GIMBAL_DEVICE_ATTITUDE_STATUS(m) => Some(m.q.map(f64::from)),
        _ => None,
    });
    let [w, x, y, z] = q.unwrap();
    let (_, pitch_rad, yaw_rad) = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).euler_angles();
    assert!((pitch_rad - truth.pitch_rad).abs() < 1e-3 && (yaw_rad - truth.yaw_vehicle_rad).abs() < 1e-3);
    assert_eq!(rig.command(1001, [-3.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0]), OK);
    assert_eq!(rig.command(1000, pitchyaw(0.0, 0.0, 0.0)), DENIED, "given back");
}

#[test]
fn messages_steer_it_too_in_every_way_and_only_those_of_whoever_is_in_control() {
    let mut rig = Rig::ready(&all());
    let pitch_deg = |rig: &mut Rig| {
        rig.run(1.5);
        rig.truth().gimbal.unwrap().pitch_rad.to_degrees()
    };
    let turned = |pitch_rad: f64| {
        let turn = UnitQuaternion::from_euler_angles(0.0, pitch_rad, 0.0);
        GIMBAL_MANAGER_SET_ATTITUDE_DATA {
            q: [turn.w, turn.i, turn.j, turn.k].map(|value: f64| value as f32),
            flags: GimbalManagerFlags::empty(),
            target_system: 1,
            target_component: 1,
            ..GIMBAL_MANAGER_SET_ATTITUDE_DATA::default()
        }
    };
    rig.send(LinkKind::Onboard, &turned(-0.5));
    assert!(pitch_deg(&mut rig).abs() < 0.01, "not in control");
    take_control(&mut rig);
    rig.send(LinkKind::Onboard, &turned(0.2));
    assert!((pitch_deg(&mut rig) - 11.46).abs() < 0.1);
    let pitch_yaw = GIMBAL_MANAGER_SET_PITCHYAW_DATA {
        pitch: -0.5,
        target_system: 1,
        target_component: 1,
        gimbal_device_id: 154,
        ..GIMBAL_MANAGER_SET_PITCHYAW_DATA::default()
    };
    rig.send(LinkKind::Onboard, &pitch_yaw);
    assert!(
        (pitch_deg(&mut rig) - 11.46).abs() < 0.1,
        "PX4 does not know this message"
    );
    rig.send(
        LinkKind::Onboard,
        &GIMBAL_MANAGER_SET_MANUAL_CONTROL_DATA {
            pitch: -0.5,
            yaw: 0.0,
            flags: GimbalManagerFlags::empty(),
            target_system: 1,
            target_component: 1,
            ..GIMBAL_MANAGER_SET_MANUAL_CONTROL_DATA::default()
        },
    );
    assert!((pitch_deg(&mut rig) + 28.65).abs() < 0.1, "radians to PX4");
    // To the device itself, past its manager.
    rig.send(
        LinkKind::Onboard,
        &GIMBAL_DEVICE_SET_ATTITUDE_DATA {
            q: [1.0, 0.0, 0.0, 0.0],
            target_system: 1,
            target_component: 154,
            ..GIMBAL_DEVICE_SET_ATTITUDE_DATA::default()
        },
    );
    assert!((pitch_deg(&mut rig) + 28.65).abs() < 0.1, "it obeys its manager only");
    rig.vehicle.reboot();
    assert_eq!(
        rig.command(1000, pitchyaw(0.0, 0.0, 0.0)),
        DENIED,
        "the manager has forgotten"
    );
}

#[test]
fn a_region_of_interest_is_kept_in_view_while_it_flies() {
    let mut rig = Rig::offboard(&all(), 20.0);
    let here = rig.truth().geodetic;
    let (latitude_deg, altitude_m) = (here.latitude_deg + 30.0 / 111_195.0, rig.amsl(0.0));
    // 30 m north on the ground, given as COMMAND_INT so that no digit is lost.
    rig.send(
        LinkKind::Onboard,
        &COMMAND_INT_DATA {
            command: MavCmd::MAV_CMD_DO_SET_ROI_LOCATION,
            x: (latitude_deg * 1e7) as i32,
            y: (here.longitude_deg * 1e7) as i32,
            z: altitude_m,
            frame: MavFrame::MAV_FRAME_GLOBAL,
            target_system: 1,
            target_component: 1,
            ..COMMAND_INT_DATA::default()
        },
    );
    rig.run(2.0);
    let place = rig
        .truth()
        .position
        .moved(nalgebra::Vector3::new(30.0, 0.0, rig.truth().height_m));
    let mut target = rig.own_position();
    target.y += 15.0;
    rig.stream = Some(super::rig::position(target));
    for _ in 0..40 {
        rig.run(0.1);
        let truth = rig.truth();
        let way = place.vector() - truth.position.vector();
        let gimbal = truth.gimbal.unwrap();
        let yaw_off = (gimbal.yaw_north_rad - way.y.atan2(way.x)).to_degrees();
        let pitch_off = (gimbal.pitch_rad - (-way.z).atan2(way.xy().norm())).to_degrees();
        assert!(yaw_off.abs() < 2.0 && pitch_off.abs() < 2.0, "{yaw_off} {pitch_off}");
    }
    assert_eq!(rig.command(197, [0.0; 7]), OK);
    rig.run(2.0);
    assert!(rig.truth().gimbal.unwrap().pitch_rad.abs() < 0.01);
}

#[test]
fn the_camera_answers_everything_it_is_asked_in_both_ways() {
    let mut rig = Rig::ready(&all());
    let Some(MavMessage::CAMERA_INFORMATION(information)) = asks(&mut rig, 100, 259, 0.0) else {
        panic!()
    };
    assert_eq!((information.resolution_h, information.gimbal_device_id), (1280, 154));
    assert!(information.model_name.starts_with(b"Simulated camera\0"));
    for id in [260, 261, 262, 269, 270, 271] {
        for component in [100, 0] {
            assert!(asks(&mut rig, component, id, 0.0).is_some(), "{id}");
        }
    }
    assert_eq!(asks(&mut rig, 100, 263, 0.0), None, "no picture yet");
    assert_eq!(asks(&mut rig, 100, 269, 2.0), None, "there is one stream");
    for (command, id) in [(521, 259), (522, 260), (525, 261), (527, 262), (2504, 269), (2505, 270)] {
        let before = rig.received.len();
        assert_eq!(rig.command_to(1, 100, command, [1.0; 7]), OK, "{command}");
        assert!(
            rig.received[before..].iter().any(|(_, _, m)| m.message_id() == id),
            "{command}"
        );
    }
    assert_eq!(
        rig.command_to(1, 100, 400, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        Some(MavResult::MAV_RESULT_UNSUPPORTED)
    );
    assert!(!rig.truth().armed, "a camera arms nobody");
}

#[test]
fn pictures_are_taken_told_of_and_fill_the_storage() {
    let camera = CameraSettings {
        storage_mib: 20.0,
        picture_mib: 6.0,
        ..CameraSettings::default()
    };
    let mut rig = Rig::ready(&carrying(PayloadPlan {
        camera: Some(camera),
        ..PayloadPlan::default()
    }));
    assert_eq!(rig.command_to(1, 100, 2000, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]), OK);
    assert_eq!(
        rig.command_to(1, 100, 2000, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        Some(MavResult::MAV_RESULT_TEMPORARILY_REJECTED)
    );
    rig.run(5.0);
    let captured: Vec<_> = rig
        .received
        .iter()
        .filter_map(|(_, link, m)| match (link, m) {
            (LinkKind::Onboard, MavMessage::CAMERA_IMAGE_CAPTURED(m)) => Some((m.image_index, m.capture_result.bits())),
            _ => None,
        })
        .collect();
    assert_eq!(captured, [(0, 1), (1, 1), (2, 1), (-1, 0)]);
    assert_eq!(rig.truth().camera.unwrap().pictures, 3);
    assert_eq!(
        rig.command_to(1, 100, 2000, [0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
        Some(MavResult::MAV_RESULT_FAILED)
    );
    let Some(MavMessage::STORAGE_INFORMATION(storage)) = asks(&mut rig, 100, 261, 1.0) else {
        panic!()
    };
    assert_eq!((storage.total_capacity, storage.available_capacity), (20.0, 2.0));
    assert_eq!(rig.command_to(1, 100, 526, [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]), OK);
    assert_eq!(rig.command_to(1, 100, 2000, [0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]), OK);
}

#[test]
fn recording_zoom_mode_and_stream() {
    let mut rig = Rig::ready(&all());
    assert_eq!(rig.command_to(1, 100, 2500, [0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0]), OK);
    rig.run(3.0);
    assert!(
        (rig.rate_hz(LinkKind::Onboard, 262, 2.0) - 4.0).abs() < 0.6,
        "as often as was asked for"
    );
    assert!(rig.truth().camera.unwrap().recording);
    assert_eq!(
        rig.command_to(1, 100, 530, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        Some(MavResult::MAV_RESULT_TEMPORARILY_REJECTED)
    );
    assert_eq!(rig.command_to(1, 100, 2501, [0.0; 7]), OK);
    rig.run(2.5);
    assert_eq!(rig.rate_hz(LinkKind::Onboard, 262, 2.0), 0.0);
    assert_eq!(rig.command_to(1, 100, 530, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]), OK);
    assert_eq!(rig.command_to(1, 100, 531, [2.0, 50.0, 0.0, 0.0, 0.0, 0.0, 0.0]), OK);
    rig.run(2.0);
    assert!((rig.truth().camera.unwrap().zoom_factor - 3.5).abs() < 1e-6);
    let Some(MavMessage::CAMERA_SETTINGS(settings)) = asks(&mut rig, 100, 260, 0.0) else {
        panic!()
    };
    assert_eq!(
        (settings.mode_id, settings.zoomLevel),
        (CameraMode::CAMERA_MODE_VIDEO, 50.0)
    );
    assert_eq!(rig.command_to(1, 100, 2502, [1.0; 7]), OK);
    let Some(MavMessage::VIDEO_STREAM_STATUS(stream)) = asks(&mut rig, 100, 270, 1.0) else {
        panic!()
    };
    assert_eq!(stream.flags, VideoStreamStatusFlags::VIDEO_STREAM_STATUS_FLAGS_RUNNING);
    assert_eq!(
        rig.command_to(1, 100, 511, [271.0, 200_000.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        OK
    );
    rig.run(3.0);
    assert!((rig.rate_hz(LinkKind::Onboard, 271, 2.0) - 5.0).abs() < 0.6);
}

#[test]
fn the_radio_is_heard_weaker_farther_away() {
    let at = |ground_station: PositionNed| {
        let mut rig = Rig::ready(&carrying(PayloadPlan {
            radio: Some(RadioSettings {
                ground_station,
                shadowing_db: 0.0,
                ..RadioSettings::default()
            }),
            ..PayloadPlan::default()
        }));
        rig.run(2.0);
        let status = rig.last(|m| match m {
            MavMessage::RADIO_STATUS(m) => Some((f64::from(m.rssi) / 1.9 - 127.0, m.rxerrors)),
            _ => None,
        });
        (status.unwrap(), rig.truth().radio.unwrap())
    };
    let ((near_dbm, errors), truth) = at(PositionNed::default());
    assert!((near_dbm - truth.signal_dbm).abs() < 0.3 && errors == 0);
    assert!((truth.distance_m - 36.7).abs() < 0.5);
    let ((far_dbm, errors), truth) = at(PositionNed::new(3000.0, 0.0, 0.0));
    assert!(far_dbm < near_dbm - 40.0 && errors > 100, "{far_dbm} {errors}");
    assert!(truth.loss > 0.8);
}

#[test]
fn commands_to_unknown_components_and_other_systems_are_not_answered() {
    let mut rig = Rig::ready(&all());
    for (system, component) in [(1, 101), (1, 155), (2, 100), (2, 154)] {
        let frame = command_frame(system, component, 512, [259.0; 7]);
        let before = rig.received.len();
        rig.send_bytes(LinkKind::Onboard, &frame);
        rig.run(0.2);
        let answered = rig.received[before..]
            .iter()
            .any(|(_, _, m)| matches!(m.message_id(), 77 | 259));
        assert!(!answered, "{system}/{component}");
    }
}

#[test]
fn what_it_carries_changes_nothing_of_how_it_flies() {
    let fly = |payloads| {
        let mut rig = Rig::ready(&SimSettings {
            payloads,
            ..SimSettings::default()
        });
        rig.take_off(6.0);
        rig.run(12.0);
        rig.truth()
    };
    let bare = fly(PayloadPlan::default());
    let laden = fly(PayloadPlan::all());
    assert!(laden.gimbal.is_some() && bare.gimbal.is_none());
    let without = VehicleTruth {
        gimbal: None,
        camera: None,
        radio: None,
        ..laden
    };
    assert_eq!(without, bare, "the same seed, the same flight");
}

#[test]
fn servos_are_the_autopilots_own_device_and_say_where_they_stand_apart_from_what_was_asked() {
    let mut rig = Rig::ready(&carrying(PayloadPlan {
        gimbal: Some(GimbalSettings {
            output: GimbalOutput::Servos { stabilised: false },
            ..GimbalSettings::default()
        }),
        ..PayloadPlan::default()
    }));
    let Some(MavMessage::GIMBAL_MANAGER_INFORMATION(manager)) = asks(&mut rig, 1, 280, 0.0) else {
        panic!()
    };
    assert_eq!((manager.gimbal_device_id, manager.cap_flags.bits()), (1, 132_530));
    assert_eq!(asks(&mut rig, 1, 283, 0.0), None);
    assert_eq!(rig.command_to(1, 154, 512, [285.0; 7]), None, "no such component");
    take_control(&mut rig);
    assert_eq!(rig.command(1000, pitchyaw(-20.0, 10.0, 12.0)), OK);
    rig.run(3.0);
    let said = rig.last(|m| match m {
        MavMessage::GIMBAL_DEVICE_ATTITUDE_STATUS(m) => Some((m.gimbal_device_id, m.q.map(f64::from))),
        _ => None,
    });
    let (device, [w, x, y, z]) = said.unwrap();
    let (_, pitch_rad, _) = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).euler_angles();
    assert!(device == 1 && (pitch_rad.to_degrees() + 20.0).abs() < 0.1);
    #[expect(deprecated, reason = "what PX4 sends")]
    let stands = rig.last(|m| match m {
        MavMessage::MOUNT_ORIENTATION(m) => Some((m.pitch, m.yaw)),
        _ => None,
    });
    let (pitch_deg, yaw_deg) = stands.unwrap();
    assert!(
        pitch_deg.abs() < 0.5 && (yaw_deg - 10.0).abs() < 0.1,
        "{pitch_deg} {yaw_deg}"
    );
}
