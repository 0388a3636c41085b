//! The session against a PX4 that is played at the level of messages, in simulated time.

mod autopilot;
mod properties;

use super::*;
use crate::sample::Place;
use autopilot::{Autopilot, Rig};
use skein_domain::{FlightMode, Geodetic, LandedState, LocalPositionNed, VehicleId, VelocityNed};

const ORIGIN: Geodetic = Geodetic {
    latitude_deg: 47.397_74,
    longitude_deg: 8.545_59,
    altitude_amsl_m: 488.0,
};

fn hold(rig: &Rig) -> LocalSetpoint {
    LocalSetpoint {
        position: Some(LocalPositionNed::new(1.0, 2.0, -5.0)),
        yaw_rad: Some(0.5),
        ..LocalSetpoint {
            velocity: rig.feed_forward,
            ..LocalSetpoint::default()
        }
    }
}

#[test]
fn telemetry_is_filled_in_the_vehicles_own_frame() {
    let mut rig = Rig::new(Autopilot::default());
    rig.run(3.0, |_| {});
    let (telemetry, health) = rig.session.read(rig.now);
    assert_eq!(
        (telemetry.mode, telemetry.armed, telemetry.landed),
        (FlightMode::Hold, false, LandedState::OnGround)
    );
    assert_eq!(telemetry.ready_to_arm, Some(true));
    assert_eq!(telemetry.local, Some(LocalPositionNed::new(1.5, -2.5, -0.25)));
    assert_eq!(telemetry.velocity, Some(VelocityNed::new(0.0, 0.0, 0.0)));
    let frame = telemetry.local_frame.unwrap();
    assert!(frame.position(&ORIGIN).norm() < 0.01, "{frame:?}");
    assert!(
        (telemetry.yaw_rad - 1.0).abs() < 1e-3 && telemetry.roll_rad.abs() < 1e-3,
        "{}",
        telemetry.yaw_rad
    );
    assert!(telemetry.estimator.unwrap().is_position_good(false));
    assert!(health.connected && health.receive_rate_hz > 50.0, "{health:?}");
    // PX4 is 100 s ahead; its position was measured 5 ms before it was sent, and 1 ms passed on the way.
    assert!((health.clock_offset_s.unwrap() - 100.0).abs() < 0.003, "{health:?}");
    let age_s = rig.now.seconds_since(telemetry.position_time);
    assert!((0.0..0.03).contains(&age_s), "{age_s}");
}

#[test]
fn offboard_is_entered_when_the_stream_has_run_and_arming_is_confirmed_by_the_state() {
    let mut rig = Rig::new(Autopilot::default());
    rig.run(1.0, |_| {});
    rig.session
        .request(rig.now, RequestId(1), AutopilotCommand::EnterOffboard);
    rig.run(0.3, |rig| rig.offer());
    assert!(
        rig.autopilot.heard.is_empty(),
        "the stream has not run yet: {:?}",
        rig.autopilot.heard
    );
    rig.run(2.0, |rig| rig.offer());
    assert_eq!(rig.result(1), Some(Ok(())));
    assert_eq!(rig.autopilot.nav_state, estimate::OFFBOARD);
    let setpoints_before = rig.autopilot.setpoints_before_offboard;
    assert!(setpoints_before >= 20, "{setpoints_before} setpoints before");
    assert!(rig.events.contains(&LinkEvent::ModeChanged {
        from: FlightMode::Hold,
        to: FlightMode::Offboard,
        commanded: true
    }));
    rig.session.request(rig.now, RequestId(2), AutopilotCommand::Arm);
    rig.run(2.0, |rig| rig.offer());
    assert_eq!(rig.result(2), Some(Ok(())));
    assert!(rig.events.contains(&LinkEvent::ArmedChanged { armed: true }));
    let command = &rig.autopilot.heard[1];
    assert_eq!((command.command, command.param1, command.confirmation), (400, 1.0, 0));
    assert_eq!(
        (command.target_system, command.target_component, command.from_external),
        (7, 1, true)
    );
    assert_eq!((command.source_system, command.source_component), (245, 190));
    // In PX4's time: it is 100 s ahead of the node.
    let ahead_s = command.timestamp as f64 * 1e-6 - rig.now.as_seconds();
    assert!((97.5..100.1).contains(&ahead_s), "{ahead_s}");
}

#[test]
fn one_that_has_no_topic_for_landing_tells_by_its_status() {
    let mut rig = Rig::new(Autopilot {
        tells_of_landing: false,
        ..Autopilot::default()
    });
    rig.run(1.0, |_| {});
    assert_eq!(rig.session.read(rig.now).0.landed, LandedState::OnGround);
    rig.fly();
    assert_eq!(rig.session.read(rig.now).0.landed, LandedState::InAir);
    rig.autopilot.flying = false;
    rig.run(0.5, |_| {});
    assert_eq!(rig.session.read(rig.now).0.landed, LandedState::OnGround);
}

#[test]
fn what_is_left_out_of_a_setpoint_is_not_a_number() {
    let mut rig = Rig::new(Autopilot::default());
    rig.feed_forward = Some(VelocityNed::new(0.1, 0.0, 0.0));
    rig.run(1.0, |_| {});
    rig.offer();
    rig.exchange();
    let (mode, setpoint) = rig.autopilot.setpoint.clone().unwrap();
    assert!(mode.position && mode.velocity && !mode.acceleration && !mode.attitude && !mode.direct_actuator);
    assert_eq!(
        (setpoint.position, setpoint.velocity),
        ([1.0, 2.0, -5.0], [0.1, 0.0, 0.0])
    );
    assert!(
        setpoint
            .acceleration
            .iter()
            .chain(&setpoint.jerk)
            .all(|part| part.is_nan())
    );
    assert!((setpoint.yaw - 0.5).abs() < 1e-6 && setpoint.yawspeed.is_nan());
}

#[test]
fn a_command_that_is_lost_is_sent_again_and_given_up_in_the_end() {
    let mut rig = Rig::new(Autopilot {
        deaf_to: 2,
        ..Autopilot::default()
    });
    rig.run(1.0, |_| {});
    rig.session.request(rig.now, RequestId(1), AutopilotCommand::Arm);
    rig.run(3.0, |_| {});
    assert_eq!(rig.result(1), Some(Ok(())));
    assert_eq!(rig.autopilot.heard[0].confirmation, 2);
    rig.autopilot.deaf_to = u32::MAX;
    rig.session.request(rig.now, RequestId(2), AutopilotCommand::Disarm);
    rig.run(4.0, |_| {});
    assert!(
        matches!(rig.result(2), Some(Err(Refusal::TimedOut { .. }))),
        "{:?}",
        rig.result(2)
    );
}

#[test]
fn a_refusal_carries_its_word_and_answers_to_others_are_not_taken() {
    let mut rig = Rig::new(Autopilot {
        refuses: true,
        ..Autopilot::default()
    });
    rig.run(1.0, |_| {});
    let to_another = Sample::Ack(Ack {
        command: 400,
        result: 0,
        target_system: 255,
        target_component: 190,
    });
    rig.session.request(rig.now, RequestId(1), AutopilotCommand::Arm);
    rig.session.on_sample(rig.now, &to_another);
    rig.run(1.0, |_| {});
    let Some(Err(Refusal::Autopilot { result, text })) = rig.result(1) else {
        panic!("{:?}", rig.result(1))
    };
    assert_eq!((result.as_str(), text.as_str()), ("temporarily_rejected", ""));
}

#[test]
fn an_expired_setpoint_becomes_a_hold_and_then_silence() {
    let mut rig = Rig::new(Autopilot::default());
    rig.fly();
    rig.run(1.0, |_| {});
    assert_eq!(rig.session.stream_state(), StreamState::HoldingExpired);
    let (mode, setpoint) = rig.autopilot.setpoint.clone().unwrap();
    assert!(mode.position);
    assert_eq!(setpoint.position, [1.5, -2.5, -0.25], "where it is");
    assert_eq!(setpoint.velocity, [0.0; 3]);
    rig.run(6.0, |_| {});
    assert_eq!(rig.session.stream_state(), StreamState::GivenUp);
    rig.autopilot.setpoint = None;
    rig.run(2.0, |rig| rig.offer());
    assert_eq!(rig.autopilot.setpoint, None, "nothing until OFFBOARD is asked for");
}

#[test]
fn nothing_is_sent_to_one_that_was_taken_over_and_it_is_told() {
    let mut rig = Rig::new(Autopilot::default());
    rig.fly();
    rig.autopilot.nav_state = 2;
    rig.run(1.0, |rig| rig.offer());
    assert!(rig.events.contains(&LinkEvent::ModeChanged {
        from: FlightMode::Offboard,
        to: FlightMode::Position,
        commanded: false
    }));
    rig.autopilot.setpoint = None;
    rig.run(2.0, |rig| rig.offer());
    assert_eq!(rig.autopilot.setpoint, None);
    assert_eq!(rig.session.stream_state(), StreamState::Stopped);
    rig.session
        .request(rig.now, RequestId(9), AutopilotCommand::EnterOffboard);
    rig.run(3.0, |rig| rig.offer());
    assert_eq!(rig.result(9), Some(Ok(())));
}

#[test]
fn the_emergency_stop_goes_first_and_on_until_the_motors_are_seen_stopped() {
    let mut rig = Rig::new(Autopilot::default());
    rig.fly();
    rig.autopilot.deaf_to = 3;
    rig.session.request(rig.now, RequestId(4), AutopilotCommand::Land);
    rig.session
        .request(rig.now, RequestId(5), AutopilotCommand::EmergencyStop);
    let sent = rig.session.outbox.last().cloned();
    let Some(Outgoing::Command(command)) = sent else {
        panic!("{sent:?}")
    };
    assert_eq!((command.command, command.param1, command.param2), (400, 0.0, 21_196.0));
    rig.run(2.0, |rig| rig.offer());
    assert_eq!(rig.result(5), Some(Ok(())));
    assert_eq!(rig.result(4), Some(Err(Refusal::Superseded)));
    assert!(!rig.autopilot.armed);
}

#[test]
fn a_node_that_stood_still_has_lost_nobody() {
    let mut rig = Rig::new(Autopilot::default());
    rig.run(1.0, |_| {});
    rig.now = rig.now.plus_seconds(2.0);
    assert!(rig.session.read(rig.now).1.connected, "nothing was listened for");
    rig.run(1.0, |_| {});
    assert!(!rig.events.contains(&LinkEvent::Lost));
}

#[test]
fn a_silent_vehicle_is_lost_and_regained() {
    let mut rig = Rig::new(Autopilot::default());
    rig.run(1.0, |_| {});
    rig.autopilot.silent = true;
    rig.run(2.0, |_| {});
    assert!(rig.events.contains(&LinkEvent::Lost));
    rig.session.request(rig.now, RequestId(1), AutopilotCommand::Arm);
    rig.collect();
    assert!(matches!(rig.result(1), Some(Err(Refusal::LinkLost { .. }))));
    rig.autopilot.silent = false;
    rig.run(0.5, |_| {});
    assert!(rig.events.contains(&LinkEvent::Regained));
    assert!(rig.session.read(rig.now).1.connected);
}

#[test]
fn one_that_starts_anew_is_sent_nothing_of_before() {
    let mut rig = Rig::new(Autopilot::default());
    rig.fly();
    rig.autopilot.ahead_s = -0.9;
    rig.autopilot.armed = false;
    rig.autopilot.nav_state = 4;
    rig.run(1.0, |_| {});
    assert!(rig.events.contains(&LinkEvent::Rebooted), "{:?}", rig.events);
    assert_eq!(rig.session.stream_state(), StreamState::Stopped);
}

#[test]
fn one_whose_agents_clock_was_set_flies_on() {
    let mut rig = Rig::new(Autopilot {
        synchronised: true,
        ..Autopilot::default()
    });
    rig.fly();
    rig.events.clear();
    for seconds in [0.3, -5.0, 40.0] {
        // PX4 drops what it knew of the clock, says so, and knows another one.
        rig.autopilot.synchronised = false;
        rig.run(0.3, Rig::offer);
        rig.autopilot.synchronised = true;
        rig.autopilot.agent_s += seconds;
        rig.run(1.0, Rig::offer);
    }
    assert!(!rig.events.contains(&LinkEvent::Rebooted), "{:?}", rig.events);
    assert_eq!(rig.session.stream_state(), StreamState::Fresh);
    // Three seconds after it was started anew, with its agent's clock as before.
    rig.autopilot.ahead_s = 3.0 - rig.now.as_seconds();
    rig.run(1.0, |_| {});
    let told = rig.events.iter().filter(|event| **event == LinkEvent::Rebooted).count();
    assert_eq!(told, 1, "{:?}", rig.events);
}

#[test]
fn one_that_has_told_no_launch_place_is_launched_where_it_stands() {
    let mut rig = Rig::new(Autopilot::default());
    let home = |rig: &mut Rig| rig.session.read(rig.now).0.home;
    rig.run(1.0, |_| {});
    let stands_at = rig.session.read(rig.now).0.global;
    assert!(stands_at.is_some());
    assert_eq!(home(&mut rig), stands_at);
    rig.fly();
    rig.autopilot.place_m[0] += 50.0;
    rig.run(1.0, Rig::offer);
    assert_eq!(home(&mut rig), stands_at, "it has left it");
    // What PX4 says itself is what counts.
    let home_sample = |place| {
        Sample::Home(Place {
            stamp_us: 0,
            measured_us: 0,
            valid: true,
            place,
        })
    };
    rig.session.on_sample(rig.now, &home_sample(ORIGIN));
    rig.autopilot.armed = false;
    rig.autopilot.flying = false;
    rig.run(1.0, |_| {});
    assert_eq!(home(&mut rig), Some(ORIGIN));

    // Of one that is first heard in the air it is not known.
    let mut rig = Rig::new(Autopilot {
        armed: true,
        flying: true,
        ..Autopilot::default()
    });
    rig.run(1.0, |_| {});
    assert_eq!(home(&mut rig), None);
}

#[test]
fn with_everything_refused_nothing_leaves() {
    let mut rig = Rig::new(Autopilot::default());
    rig.fly();
    let why = Refusal::LinkLost { vehicle: VehicleId(7) };
    rig.session.refuse_all(rig.now, why.clone());
    rig.autopilot.setpoint = None;
    rig.session
        .request(rig.now, RequestId(3), AutopilotCommand::EmergencyStop);
    rig.run(1.0, |rig| rig.offer());
    assert_eq!(rig.autopilot.setpoint, None);
    assert_eq!(rig.result(3), Some(Err(why)));
    rig.session.not_supported(RequestId(8), "a route");
    rig.collect();
    assert!(matches!(rig.result(8), Some(Err(Refusal::NotSupported { .. }))));
}
