//! Whole flights and what goes wrong in them.

use crate::rig::Rig;
use skein_domain::FlightMode::{Hold, Land, Offboard, Position, Return, TakeOff};
use skein_domain::link::{LinkEvent, StreamState};
use skein_domain::{AutopilotCommand, LandedState, LocalPositionNed, Refusal};

#[test]
fn from_the_ground_and_back_twice() {
    let mut rig = Rig::new();
    rig.take_off();
    assert!((rig.truth().height_m - 10.0).abs() < 1.0, "{:?}", rig.truth());
    let start = rig.read().0.local.unwrap();
    rig.steer_to(LocalPositionNed::new(
        start.north_m + 12.0,
        start.east_m - 5.0,
        start.down_m - 2.0,
    ));
    rig.run(12.0);
    let (telemetry, health) = rig.read();
    let flown = telemetry.local.unwrap().vector() - start.vector();
    assert!(
        (flown - nalgebra::Vector3::new(12.0, -5.0, -2.0)).norm() < 0.5,
        "{flown:?}"
    );
    assert!((f64::from(health.setpoint_rate_hz) - 50.0).abs() < 3.0, "{health:?}");
    // Where the vehicle says it is, is where it is.
    let frame = telemetry.local_frame.unwrap();
    let apart = frame.position(&rig.truth().geodetic).vector() - telemetry.local.unwrap().vector();
    assert!(apart.norm() < 0.1, "{apart:?}");

    assert_eq!(rig.ask(AutopilotCommand::Land), Ok(()));
    rig.stop();
    rig.run_until("disarmed on the ground", 60.0, |rig| !rig.read().0.armed);
    assert_eq!(rig.read().0.landed, LandedState::OnGround);
    let changes = rig.modes();
    let flight = [
        (Hold, TakeOff, true),
        (TakeOff, Hold, true),
        (Hold, Offboard, true),
        (Offboard, Land, true),
    ];
    assert_eq!(changes[..4], flight);
    assert_eq!(rig.truth().setpoints_refused, 0);

    // PX4 shows OFFBOARD after the landing and would refuse to arm.
    rig.run(1.5);
    assert_eq!(rig.read().0.mode, Offboard);
    assert_eq!(rig.ask(AutopilotCommand::Arm), Ok(()));
    assert_eq!(rig.modes().last(), Some(&(Offboard, Hold, true)));
    assert_eq!(rig.ask(AutopilotCommand::Disarm), Ok(()));
}

#[test]
fn refusals_have_their_reason() {
    let mut rig = Rig::new();
    rig.run_until("heard", 5.0, |rig| rig.core.is_some());
    let Err(Refusal::Autopilot { result, text }) = rig.ask(AutopilotCommand::Arm) else {
        panic!("not ready yet")
    };
    assert_eq!(result, "temporarily_rejected");
    assert!(
        !text.is_empty(),
        "the text comes beside it, because we are a ground station to it"
    );
    assert!(matches!(
        rig.ask(AutopilotCommand::TakeOff { height_m: 5.0 }),
        Err(Refusal::NotPermitted { .. })
    ));
    rig.take_off();
    let Err(Refusal::Autopilot { text, .. }) = rig.ask(AutopilotCommand::Disarm) else {
        panic!("in the air")
    };
    assert_eq!(text, "Disarming denied: not landed");
    let Err(Refusal::Autopilot { text, .. }) = rig.ask(AutopilotCommand::SetMode { mode: Position }) else {
        panic!("no pilot is there")
    };
    assert!(text.contains("Position"), "{text}");
    assert_eq!(rig.read().0.mode, Offboard);
}

#[test]
fn offboard_is_entered_only_behind_a_running_stream() {
    let mut rig = Rig::new();
    rig.take_off();
    assert_eq!(rig.ask(AutopilotCommand::SetMode { mode: Hold }), Ok(()));
    rig.stop();
    let asked_s = rig.now_s;
    let request = rig.request(AutopilotCommand::EnterOffboard);
    rig.run(1.0);
    assert_eq!(rig.outcome(request), None);
    rig.steer_north(0.0);
    let began_s = rig.now_s;
    rig.run_until("OFFBOARD", 3.0, |rig| rig.outcome(request).is_some());
    assert_eq!(rig.outcome(request), Some(Ok(())));
    let set_mode = rig
        .sent
        .iter()
        .find(|(t, id, payload)| *t > asked_s && *id == 76 && payload[28] == 176)
        .unwrap();
    assert!(
        set_mode.0 - began_s >= 0.49,
        "{} after the stream's start",
        set_mode.0 - began_s
    );
    assert_eq!(rig.ask(AutopilotCommand::SetMode { mode: Hold }), Ok(()));
    rig.stop();
    assert!(matches!(
        rig.ask(AutopilotCommand::EnterOffboard),
        Err(Refusal::TimedOut { .. })
    ));
}

#[test]
fn a_vehicle_actor_that_dies_leaves_a_hold_and_then_the_autopilots_failsafe() {
    let mut rig = Rig::new();
    rig.take_off();
    rig.steer_north(5.0);
    rig.run(6.0);
    assert!(rig.truth().velocity.north_m_s > 4.0);
    rig.steering = None;
    let died_s = rig.now_s;
    rig.run(5.0);
    let truth = rig.truth();
    assert_eq!(
        (truth.mode, rig.stream().last()),
        (Offboard, Some(&StreamState::HoldingExpired))
    );
    assert!(truth.velocity.norm() < 0.5, "it stands, {:?}", truth.velocity);
    assert!(truth.offboard_gap_max_s < 0.2, "{}", truth.offboard_gap_max_s);
    rig.run_until("given up", 1.0, |rig| {
        rig.stream().last() == Some(&StreamState::GivenUp)
    });
    let given_up_s = rig.now_s;
    assert!((given_up_s - died_s - 5.2).abs() < 0.1, "{}", given_up_s - died_s);
    rig.run(4.0);
    assert_eq!(rig.truth().mode, Return, "PX4's own failsafe");
    assert!(rig.core().in_failsafe());
    assert_eq!(rig.modes().last(), Some(&(Offboard, Return, false)));

    // The actor is back and streams, as it does by habit: that alone must not bring OFFBOARD back.
    rig.steer_north(0.0);
    rig.run(3.0);
    assert_eq!(
        (rig.truth().mode, rig.setpoints(given_up_s + 0.01, rig.now_s)),
        (Return, 0)
    );
    assert_eq!(rig.ask(AutopilotCommand::EnterOffboard), Ok(()));
    assert_eq!(rig.truth().mode, Offboard);
    assert_eq!(rig.modes().last().map(|change| change.2), Some(true));
}

#[test]
fn the_pilot_wins() {
    let mut rig = Rig::new();
    rig.take_off();
    rig.steer_north(2.0);
    rig.run(2.0);
    rig.vehicle.pilot_mode(Position);
    rig.run_until("seen", 2.0, |rig| {
        rig.modes().last() == Some(&(Offboard, Position, false))
    });
    assert!(!rig.core().in_failsafe(), "a pilot and no failsafe");
    let seen_s = rig.now_s;
    rig.run(3.0);
    assert_eq!(
        (rig.truth().mode, rig.setpoints(seen_s + 0.01, rig.now_s)),
        (Position, 0)
    );
    assert_eq!(rig.stream().last(), Some(&StreamState::Stopped));
    // Handed back by the operator's word, not by itself.
    assert_eq!(rig.ask(AutopilotCommand::EnterOffboard), Ok(()));
    rig.run(1.0);
    assert_eq!(rig.truth().mode, Offboard);
}

#[test]
fn a_restarted_autopilot_is_noticed_and_set_up_again() {
    let mut rig = Rig::new();
    rig.take_off();
    rig.steer_north(3.0);
    rig.run(5.0);
    let before = rig.read().0.local_frame.unwrap();
    let pending = rig.request(AutopilotCommand::SetMode { mode: Hold });
    rig.vehicle.reboot();
    rig.run_until("noticed", 2.0, |rig| rig.has(&LinkEvent::Rebooted));
    assert!(
        matches!(rig.outcome(pending), Some(Err(Refusal::Autopilot { result, .. })) if result == "rebooted")
            || rig.outcome(pending) == Some(Ok(()))
    );
    assert_eq!(rig.read().0.local_frame, None, "its old frame means nothing now");
    assert_eq!(rig.stream().last(), Some(&StreamState::Stopped));
    rig.steering = None;
    rig.run(6.0);
    rig.received.clear();
    rig.run(4.0);
    let local_hz = f64::from(rig.received[&32]) / 4.0;
    assert!((local_hz - 50.0).abs() < 5.0, "asked for anew: {local_hz}");
    let after = rig.read().0.local_frame.unwrap();
    let moved = before.position(&after.origin);
    assert!(moved.norm() > 1.0, "it restarted elsewhere: {moved:?}");
    let telemetry = rig.read().0;
    let apart = after.position(&rig.truth().geodetic).vector() - telemetry.local.unwrap().vector();
    assert!(apart.norm() < 0.15, "{apart:?}");
    assert_eq!(
        rig.events
            .iter()
            .filter(|(_, event)| *event == LinkEvent::Rebooted)
            .count(),
        1
    );
}

#[test]
fn landing_right_after_the_take_off_order_waits_for_the_lift_off() {
    let mut rig = Rig::new();
    rig.run_until("ready", 20.0, Rig::is_ready);
    assert_eq!(rig.ask(AutopilotCommand::Arm), Ok(()));
    assert_eq!(rig.ask(AutopilotCommand::TakeOff { height_m: 10.0 }), Ok(()));
    let landing = rig.request(AutopilotCommand::Land);
    rig.run_until("landing", 15.0, |rig| rig.outcome(landing).is_some());
    assert_eq!(rig.outcome(landing), Some(Ok(())));
    rig.run_until("disarmed on the ground", 40.0, |rig| !rig.read().0.armed);
    assert!(rig.ask(AutopilotCommand::Land).is_err(), "it stands there");
}
