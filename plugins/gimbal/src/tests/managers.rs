//! What differs between managers and their devices, and gimbals that do not follow.

use super::mavlink::{angles, found, truth};
use crate::Gimbal;
use mavlink::MessageData;
use mavlink::dialects::common::{
    COMMAND_ACK_DATA, GIMBAL_MANAGER_INFORMATION_DATA, GIMBAL_MANAGER_SET_ATTITUDE_DATA,
    GIMBAL_MANAGER_SET_PITCHYAW_DATA, GimbalManagerCapFlags, MavCmd, MavResult,
};
use payload_mavlink::encode;
use payload_mavlink::rig::{OWN, Rig, SYSTEM_ID};
use skein_domain::exchange::{Effect, Event, Severity};
use skein_domain::payload::MavlinkMessage;
use skein_sim::{GimbalOutput, GimbalSettings};

/// One whose axes hardly move.
fn stuck() -> GimbalSettings {
    GimbalSettings {
        rate_max_rad_s: 0.01,
        ..GimbalSettings::default()
    }
}

fn servos(stabilised: bool) -> GimbalSettings {
    GimbalSettings {
        output: GimbalOutput::Servos { stabilised },
        ..GimbalSettings::default()
    }
}

fn notices(rig: &Rig<Gimbal>) -> Vec<(Severity, String)> {
    let notice = |effect: &Effect| match effect {
        Effect::Notice { severity, text } => Some((*severity, text.clone())),
        _ => None,
    };
    rig.effects.iter().filter_map(|(_, effect)| notice(effect)).collect()
}

/// How often the plugin sent a message, or the command, since a count of effects.
fn sent(rig: &Rig<Gimbal>, since: usize, message_id: u32) -> usize {
    let is_it = |effect: &Effect| matches!(effect, Effect::Mavlink(message) if message.message_id == message_id);
    rig.effects[since..].iter().filter(|(_, effect)| is_it(effect)).count()
}

fn told_by<M: MessageData>(rig: &mut Rig<Gimbal>, component_id: u8, message: &M) {
    let message = MavlinkMessage {
        system_id: SYSTEM_ID,
        component_id,
        message_id: M::ID,
        payload: encode(message),
    };
    rig.tell(vec![Event::Own(rig.own()), Event::Mavlink(message)]);
}

#[test]
fn a_gimbal_that_does_not_follow_is_told_of_and_so_is_that_it_follows_again() {
    let mut rig = found(stuck());
    let id = rig.command(&angles(-0.6, 0.0, "vehicle"));
    assert!(
        rig.run_until(5.0, |rig| rig.state()["not_following"] == true),
        "{}",
        rig.state()
    );
    assert_eq!(rig.state()["fault"], "does not follow");
    let told = notices(&rig);
    assert!(
        matches!(&told[..], [(Severity::Warning, text)] if text.contains("does not follow")),
        "{told:?}"
    );
    rig.restart();
    rig.run(1.0);
    assert_eq!(rig.state()["not_following"], true, "a restart forgets nothing");
    assert!(matches!(rig.end_of(id, 12.0), Some(Err(_))));
    // Where it stands is where it is wanted now.
    rig.command(&angles(truth(&rig).pitch_rad, 0.0, "vehicle"));
    rig.run(1.0);
    assert_eq!(
        (&rig.state()["not_following"], &rig.state()["fault"]),
        (&false.into(), &"".into())
    );
    assert_eq!(notices(&rig).len(), 2, "{:?}", notices(&rig));
}

#[test]
fn one_that_turns_slowly_or_stands_at_its_end_stop_is_not_told_of() {
    let mut rig = found(GimbalSettings {
        rate_max_rad_s: 0.1,
        pitch_min_rad: -0.4,
        ..GimbalSettings::default()
    });
    rig.command(&angles(-1.2, 2.0, "vehicle"));
    rig.run(25.0);
    assert!((truth(&rig).yaw_vehicle_rad - 2.0).abs() < 0.05 && truth(&rig).pitch_rad > -0.45);
    assert_eq!(notices(&rig), []);
    assert_eq!(rig.state()["not_following"], false);
}

#[test]
fn a_single_move_is_acknowledged_and_a_stream_is_not_and_the_message_that_px4_drops_is_never_sent() {
    let mut rig = found(GimbalSettings::default());
    let id = rig.command(&angles(-0.2, 0.1, "vehicle"));
    assert_eq!(rig.end_of(id, 5.0), Some(Ok(())));
    rig.run(1.0);
    let since = rig.effects.len();
    let id = rig.command(&angles(-0.3, 0.1, "vehicle"));
    assert_eq!(rig.end_of(id, 5.0), Some(Ok(())));
    assert_eq!(
        (
            sent(&rig, since, 76),
            sent(&rig, since, GIMBAL_MANAGER_SET_ATTITUDE_DATA::ID)
        ),
        (1, 0)
    );
    let since = rig.effects.len();
    for step in 1..=20 {
        rig.command(&angles(-0.3 - 0.02 * f64::from(step), 0.1, "vehicle"));
        rig.run(0.1);
    }
    let commands = sent(&rig, since, 76);
    assert!((3..=5).contains(&commands), "{commands}: no more than two each second");
    assert!(sent(&rig, since, GIMBAL_MANAGER_SET_ATTITUDE_DATA::ID) >= 15);
    rig.run(2.0);
    assert!((truth(&rig).pitch_rad + 0.7).abs() < 0.02);
    assert_eq!(sent(&rig, 0, GIMBAL_MANAGER_SET_PITCHYAW_DATA::ID), 0);
}

#[test]
fn a_manager_that_does_not_know_the_command_is_steered_by_messages() {
    let mut rig = found(GimbalSettings::default());
    rig.command(r#"{"command": "take_control"}"#);
    rig.run(1.0);
    rig.deaf = true;
    rig.command(&angles(-0.5, 0.0, "vehicle"));
    rig.run(0.1);
    let ack = COMMAND_ACK_DATA {
        command: MavCmd::MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW,
        result: MavResult::MAV_RESULT_UNSUPPORTED,
        target_system: OWN.0,
        target_component: OWN.1,
        ..COMMAND_ACK_DATA::default()
    };
    told_by(&mut rig, 1, &ack);
    rig.deaf = false;
    assert!(rig.run_until(3.0, |rig| (truth(rig).pitch_rad + 0.5).abs() < 0.02));
    rig.run(1.0);
    let since = rig.effects.len();
    let id = rig.command(&angles(-0.2, 0.0, "vehicle"));
    assert_eq!(rig.end_of(id, 5.0), Some(Ok(())));
    assert_eq!(sent(&rig, since, 76), 0);
}

#[test]
fn what_a_manager_says_that_it_cannot_is_not_asked_of_it() {
    let mut rig = found(GimbalSettings::default());
    let mut said = GIMBAL_MANAGER_INFORMATION_DATA {
        pitch_min: -1.5,
        pitch_max: 0.3,
        gimbal_device_id: 154,
        cap_flags: GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS
            | GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_LOCK,
        ..GIMBAL_MANAGER_INFORMATION_DATA::default()
    };
    told_by(&mut rig, 1, &said);
    let id = rig.command(&angles(-0.4, 1.0, "vehicle"));
    assert_eq!(rig.end_of(id, 5.0), Some(Ok(())), "it has no yaw");
    assert!(truth(&rig).yaw_vehicle_rad.abs() < 0.01);
    // It turns, but knows no north: the angle from the nose is sent anew.
    said.cap_flags |= GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS
        | GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_FOLLOW;
    told_by(&mut rig, 1, &said);
    let since = rig.effects.len();
    let id = rig.command(&angles(-0.4, 1.0, "north"));
    assert_eq!(rig.end_of(id, 5.0), Some(Ok(())));
    rig.run(1.0);
    assert!(sent(&rig, since, GIMBAL_MANAGER_SET_ATTITUDE_DATA::ID) >= 20);
}

#[test]
fn servos_turn_to_angles_places_and_at_rates() {
    let mut rig = found(servos(true));
    // The last is more than half a circle from the nose, counted from north.
    for (pitch, yaw, frame) in [(-0.6, 0.5, "vehicle"), (-0.2, 2.0, "north"), (-0.2, -2.9, "north")] {
        let id = rig.command(&angles(pitch, yaw, frame));
        assert_eq!(rig.end_of(id, 8.0), Some(Ok(())), "{}", rig.state());
        assert!((truth(&rig).pitch_rad - pitch).abs() < 0.04);
    }
    let id = rig.command(&angles(-0.2, 0.0, "vehicle"));
    assert_eq!(rig.end_of(id, 8.0), Some(Ok(())));
    let before = truth(&rig);
    rig.command(r#"{"command": "rates", "pitch_rad_s": -0.1, "yaw_rad_s": 0.2}"#);
    rig.run(3.0);
    let after = truth(&rig);
    assert!(
        (after.pitch_rad - before.pitch_rad + 0.3).abs() < 0.04,
        "{before:?} {after:?}"
    );
    assert!(
        (after.yaw_vehicle_rad - before.yaw_vehicle_rad - 0.6).abs() < 0.06,
        "{before:?} {after:?}"
    );
    rig.command(r#"{"command": "rates", "pitch_rad_s": 0.0, "yaw_rad_s": 0.0}"#);
    rig.run(0.5);
    let stands = truth(&rig);
    rig.run(2.0);
    assert!((truth(&rig).yaw_vehicle_rad - stands.yaw_vehicle_rad).abs() < 0.01);
    // Into its end stop, and nothing to tell of.
    rig.command(r#"{"command": "rates", "pitch_rad_s": -0.5, "yaw_rad_s": 0.0}"#);
    rig.run(6.0);
    assert_eq!(notices(&rig), []);
    rig.replay();
}

/// As seen with PX4: what it says of itself is what was asked for.
#[test]
fn servos_that_px4_does_not_stabilise_are_told_of_and_not_believed() {
    let mut rig = found(servos(false));
    let id = rig.command(&angles(-0.6, 0.5, "vehicle"));
    assert!(
        rig.run_until(5.0, |rig| rig.state()["not_following"] == true),
        "{}",
        rig.state()
    );
    assert!(
        rig.state()["pitch_rad"].as_f64().unwrap().abs() < 0.01,
        "{}",
        rig.state()
    );
    assert!((rig.state()["yaw_vehicle_rad"].as_f64().unwrap() - 0.5).abs() < 0.02);
    assert!(notices(&rig)[0].1.contains("MNT_DO_STAB"), "{:?}", notices(&rig));
    assert!(matches!(rig.end_of(id, 12.0), Some(Err(_))));
}
