//! The flyer: found fit to fly, taken off, streamed to; and its rates stay what they are.

use super::*;

const PLACE: Geodetic = Geodetic {
    latitude_deg: 47.4,
    longitude_deg: 8.5,
    altitude_amsl_m: 488.0,
};
const GROUND_STATION: Sender = Sender {
    system_id: 245,
    component_id: 190,
};

fn flyer() -> Flyer {
    Flyer::new(7, PLACE)
}

fn long(flyer: &mut Flyer, command: MavCmd, parameters: [f32; 7]) -> Vec<MavMessage> {
    let [param1, param2, param3, param4, param5, param6, param7] = parameters;
    let message = COMMAND_LONG_DATA {
        param1,
        param2,
        param3,
        param4,
        param5,
        param6,
        param7,
        command,
        target_system: 7,
        target_component: 1,
        confirmation: 0,
    };
    flyer.on_message(&MavMessage::COMMAND_LONG(message), GROUND_STATION, 1.0)
}

fn fly(flyer: &mut Flyer, from_s: f64, seconds: f64) {
    let steps = (seconds * 50.0) as u32;
    (1..=steps).for_each(|i| flyer.move_to(from_s + f64::from(i) / 50.0));
}

#[test]
fn all_streams_together_are_115_messages_a_second() {
    assert_eq!(STREAMS.iter().map(|(_, rate_hz)| rate_hz).sum::<f64>(), 115.0);
}

#[test]
fn it_arms_takes_off_and_follows_setpoints_in_offboard() {
    let mut flyer = flyer();
    flyer.move_to(1.0);
    let ack = long(
        &mut flyer,
        MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    );
    let [MavMessage::COMMAND_ACK(ack)] = ack.as_slice() else {
        panic!("{ack:?}")
    };
    assert_eq!(
        (ack.target_system, ack.target_component, ack.result),
        (245, 190, MavResult::MAV_RESULT_ACCEPTED)
    );
    assert!(
        flyer
            .heartbeat()
            .base_mode
            .contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED)
    );
    assert_eq!(flyer.landed_state(), MavLandedState::MAV_LANDED_STATE_ON_GROUND);

    long(
        &mut flyer,
        MavCmd::MAV_CMD_NAV_TAKEOFF,
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 498.0],
    );
    assert_eq!(flyer.heartbeat().custom_mode, 2 << 24 | 4 << 16);
    fly(&mut flyer, 1.0, 1.0);
    assert_eq!(flyer.landed_state(), MavLandedState::MAV_LANDED_STATE_TAKEOFF);
    assert!((flyer.velocity.z + SPEED_M_S).abs() < 1e-9);
    fly(&mut flyer, 2.0, 2.0);
    assert_eq!(
        (flyer.heartbeat().custom_mode, flyer.landed_state()),
        (3 << 24 | 4 << 16, MavLandedState::MAV_LANDED_STATE_IN_AIR)
    );
    assert!((flyer.height_m() - 10.0).abs() < 1e-6);

    let mut setpoint = SET_POSITION_TARGET_LOCAL_NED_DATA {
        x: 3.0,
        z: -10.0,
        target_system: 7,
        ..Default::default()
    };
    setpoint.type_mask = PositionTargetTypemask::empty();
    assert!(flyer.setpoint(&setpoint));
    fly(&mut flyer, 4.0, 1.0);
    assert!(flyer.position.x.abs() < 1e-9, "not in OFFBOARD yet");
    long(
        &mut flyer,
        MavCmd::MAV_CMD_DO_SET_MODE,
        [1.0, 6.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    );
    flyer.setpoint(&setpoint);
    fly(&mut flyer, 5.0, 2.0);
    assert!((flyer.position.x - 3.0).abs() < 1e-6);

    long(&mut flyer, MavCmd::MAV_CMD_NAV_LAND, [0.0; 7]);
    fly(&mut flyer, 7.0, 5.0);
    assert!(!flyer.armed && flyer.height_m() < 0.1);
}

#[test]
fn what_is_for_another_is_counted_and_not_followed() {
    let mut flyer = flyer();
    let setpoint = SET_POSITION_TARGET_LOCAL_NED_DATA {
        target_system: 8,
        ..Default::default()
    };
    assert!(!flyer.setpoint(&setpoint));
    let command = COMMAND_LONG_DATA {
        target_system: 9,
        command: MavCmd::MAV_CMD_NAV_LAND,
        ..Default::default()
    };
    assert!(
        flyer
            .on_message(&MavMessage::COMMAND_LONG(command), GROUND_STATION, 1.0)
            .is_empty()
    );
    assert_eq!(flyer.misaddressed(), 2);
}

#[test]
fn requests_are_answered_and_rates_are_not_changed() {
    let mut flyer = flyer();
    let acks = long(
        &mut flyer,
        MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL,
        [30.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    );
    assert!(matches!(acks.as_slice(), [MavMessage::COMMAND_ACK(_)]));
    for (id, expected) in [(49.0, 49), (148.0, 148), (242.0, 242)] {
        let answers = long(
            &mut flyer,
            MavCmd::MAV_CMD_REQUEST_MESSAGE,
            [id, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        );
        assert_eq!(mavlink::Message::message_id(&answers[1]), expected);
    }
    let ping = MavMessage::TIMESYNC(TIMESYNC_DATA {
        ts1: 42,
        ..Default::default()
    });
    let answers = flyer.on_message(&ping, GROUND_STATION, 2.0);
    let [MavMessage::TIMESYNC(pong)] = answers.as_slice() else {
        panic!("no answer")
    };
    assert_eq!((pong.ts1, pong.tc1), (42, 2_000_000_000));
}

#[test]
fn positions_of_all_kinds_agree() {
    let mut flyer = flyer();
    flyer.position = Vector3::new(100.0, -50.0, -20.0);
    let MavMessage::GLOBAL_POSITION_INT(global) = flyer.telemetry(Stream::GlobalPosition, 3.0) else {
        panic!()
    };
    let place = Geodetic {
        latitude_deg: f64::from(global.lat) * 1e-7,
        longitude_deg: f64::from(global.lon) * 1e-7,
        altitude_amsl_m: f64::from(global.alt) * 1e-3,
    };
    assert!((flyer.frame.position(&place).vector() - flyer.position).norm() < 0.05);
    assert_eq!((global.time_boot_ms, global.relative_alt), (3000, 20_000));
}
