//! Flights to places: go to, hold, land at a spot, return.

use super::autopilot::{Answer, Autopilot};
use super::rig::Rig;
use skein_domain::exchange::{CommandProgress, Effect, Event};
use skein_domain::{AutopilotCommand, FlightMode, FlightState, PositionNed, Refusal, VehicleCommand, VelocityNed};

fn go_to(position: PositionNed) -> VehicleCommand {
    VehicleCommand::GoTo {
        position,
        yaw_rad: None,
        speed_m_s: None,
    }
}

fn fastest_m_s(rig: &Rig) -> f64 {
    rig.setpoints()
        .iter()
        .filter_map(|(_, s)| s.velocity)
        .map(|v| v.norm())
        .fold(0.0, f64::max)
}

#[test]
fn go_to_arrives_at_its_speed_and_holds_there() {
    let mut rig = Rig::holding(5.0);
    let (start, to) = (rig.now, PositionNed::new(50.0, 10.0, -12.0));
    let id = rig.command(VehicleCommand::GoTo {
        position: to,
        yaw_rad: Some(1.0),
        speed_m_s: Some(3.0),
    });
    rig.run(1.0);
    assert_eq!(rig.state, FlightState::GoingTo);
    rig.run_until("there", 60.0, |rig| rig.is_done(id));
    assert_eq!(rig.state, FlightState::Holding);
    assert!(rig.here().distance_m(&to) < 0.5);
    rig.run(2.0);
    assert!(rig.here().distance_m(&to) < 0.05);
    assert!((2.9..3.01).contains(&fastest_m_s(&rig)), "{} m/s", fastest_m_s(&rig));
    assert_eq!(rig.setpoints().last().and_then(|(_, s)| s.yaw_rad), Some(1.0));
    rig.assert_no_jump_since(start);
}

#[test]
fn a_change_of_mind_in_full_flight_is_smooth() {
    let mut rig = Rig::holding(20.0);
    let start = rig.now;
    rig.command(go_to(PositionNed::new(200.0, 0.0, -20.0)));
    rig.run(6.0);
    assert!(rig.autopilot.velocity.norm() > 4.5);
    // Aside, back, on, and stop: each in the middle of the former.
    for to in [
        PositionNed::new(30.0, 200.0, -25.0),
        PositionNed::new(-100.0, 0.0, -20.0),
    ] {
        rig.command(go_to(to));
        rig.run(5.0);
    }
    let hold = rig.command(VehicleCommand::Hold);
    rig.run_until("stopped", 10.0, |rig| rig.is_done(hold));
    assert!(rig.state == FlightState::Holding && rig.autopilot.velocity.norm() < 0.5);
    let stopped_at = rig.here();
    rig.run(5.0);
    assert!(rig.here().distance_m(&stopped_at) < 1.0);
    rig.assert_no_jump_since(start);
}

#[test]
fn a_hold_command_brakes_within_the_acceleration() {
    let mut rig = Rig::holding(20.0);
    rig.command(go_to(PositionNed::new(200.0, -20.0, -20.0)));
    rig.run(6.0);
    let from = rig.here();
    let hold = rig.command(VehicleCommand::Hold);
    rig.run_until("stopped", 10.0, |rig| rig.is_done(hold));
    rig.run(2.0);
    // v²/2a = 6.25 m, and what the vehicle lags behind.
    assert!(
        (5.0..8.0).contains(&rig.here().distance_m(&from)),
        "{} m",
        rig.here().distance_m(&from)
    );
}

#[test]
fn an_arrival_that_does_not_come_is_given_up() {
    let mut rig = Rig::holding(20.0);
    let id = rig.command(go_to(PositionNed::new(30.0, -20.0, -20.0)));
    rig.run(2.0);
    let stuck = rig.autopilot.position;
    for _ in 0..3000 {
        rig.autopilot.position = stuck; // Something holds it back.
        rig.tick();
    }
    assert!(matches!(rig.refusal(id), Some(Refusal::TimedOut { what, .. }) if what == "arrival"));
    assert_eq!(rig.state, FlightState::Holding);
}

#[test]
fn land_is_done_when_it_stands_disarmed() {
    let mut rig = Rig::holding(5.0);
    let id = rig.command(VehicleCommand::Land);
    rig.run_until("landing", 2.0, |rig| rig.autopilot.mode == FlightMode::Land);
    rig.run(0.1);
    assert_eq!(rig.state, FlightState::Landing);
    // The stream ends once the autopilot lands, not before.
    let stop = rig
        .log
        .iter()
        .rposition(|(_, e)| *e == Effect::StopStream)
        .expect("the stream was ended");
    let land = rig.log.iter().position(|(_, e)| {
        matches!(
            e,
            Effect::Autopilot {
                command: AutopilotCommand::Land,
                ..
            }
        )
    });
    assert!(land.is_some_and(|land| land < stop));
    assert!(!rig.log[stop..].iter().any(|(_, e)| matches!(e, Effect::Setpoint(_))));
    rig.run_until("landed", 30.0, |rig| rig.is_done(id));
    assert!(rig.state == FlightState::Idle && !rig.autopilot.armed);
    assert_eq!(rig.progress(id), [CommandProgress::Executing, CommandProgress::Done]);
    assert!(
        !rig.notices().iter().any(|text| text.contains("pilot")),
        "{:?}",
        rig.notices()
    );
}

#[test]
fn land_at_lands_on_the_spot() {
    let mut rig = Rig::holding(8.0);
    let (start, height_m) = (rig.now, rig.autopilot.height_m());
    let spot = PositionNed::new(25.0, -5.0, rig.autopilot.home.down_m);
    let id = rig.command(VehicleCommand::LandAt { spot });
    rig.run_until("over the spot", 30.0, |rig| {
        rig.requests().last() == Some(&AutopilotCommand::Land)
    });
    assert!(
        (rig.autopilot.height_m() - height_m).abs() < 0.1,
        "it keeps its height on the way"
    );
    assert!(rig.here().horizontal_distance_m(&spot) < 0.25 && rig.autopilot.velocity.norm() < 0.31);
    rig.assert_no_jump_since(start);
    rig.run_until("landed", 40.0, |rig| rig.is_done(id));
    assert!(rig.here().horizontal_distance_m(&spot) < 0.3);
}

#[test]
fn what_does_not_settle_lands_all_the_same_and_says_so() {
    let mut rig = Rig::holding(8.0);
    let spot = rig.here();
    let id = rig.command(VehicleCommand::LandAt { spot });
    while rig.requests().last() != Some(&AutopilotCommand::Land) {
        rig.autopilot.position.x = spot.north_m + 0.4; // The wind is stronger.
        rig.tick();
        assert!(rig.now.as_seconds() < 100.0, "it waits for ever");
    }
    rig.run_until("landed", 40.0, |rig| rig.is_done(id));
    assert!(
        rig.notices().iter().any(|text| text.contains("does not settle")),
        "{:?}",
        rig.notices()
    );
}

#[test]
fn return_goes_home_by_setpoints_and_lands() {
    let mut rig = Rig::holding(6.0);
    let there = rig.command(go_to(PositionNed::new(40.0, 0.0, -7.5)));
    rig.run_until("there", 60.0, |rig| rig.is_done(there));
    let id = rig.command(VehicleCommand::Return);
    rig.run(1.0);
    assert_eq!(
        (rig.state, rig.autopilot.mode),
        (FlightState::Returning, FlightMode::Offboard)
    );
    rig.run_until("home", 60.0, |rig| rig.is_done(id));
    assert!(rig.here().horizontal_distance_m(&rig.autopilot.home) < 0.3);
    assert!(!rig.requests().contains(&AutopilotCommand::ReturnToLaunch));
}

#[test]
fn return_is_left_to_the_autopilot_where_no_setpoints_can_be_made() {
    // A pilot flew it away, and OFFBOARD is refused.
    let denied = Refusal::Autopilot {
        result: "denied".to_owned(),
        text: String::new(),
    };
    let mut rig = Rig::holding(6.0);
    rig.autopilot.change_mode(FlightMode::Position, false);
    rig.autopilot.position.x += 30.0;
    rig.run(0.2);
    rig.autopilot.offboard = Answer::Refuses(denied);
    let id = rig.command(VehicleCommand::Return);
    rig.run_until("returning by itself", 10.0, |rig| {
        rig.autopilot.mode == FlightMode::Return
    });
    rig.run(1.0);
    assert_eq!(rig.state, FlightState::Returning);
    let streamed = rig.setpoints().len();
    rig.run_until("home", 60.0, |rig| rig.is_done(id));
    assert_eq!(
        rig.setpoints().len(),
        streamed,
        "no setpoints while the autopilot returns"
    );

    // No position estimate.
    let mut rig = Rig::holding(6.0);
    rig.autopilot.has_position = false;
    rig.run(0.5);
    let id = rig.command(VehicleCommand::Return);
    rig.run_until("returning by itself", 10.0, |rig| {
        rig.autopilot.mode == FlightMode::Return
    });
    rig.run_until("home", 60.0, |rig| rig.is_done(id));
}

#[test]
fn a_landing_that_is_refused_leaves_it_holding() {
    let denied = Refusal::Autopilot {
        result: "denied".to_owned(),
        text: String::new(),
    };
    let mut rig = Rig::holding(6.0);
    rig.autopilot.land = Answer::Refuses(denied.clone());
    let start = rig.now;
    let id = rig.command(VehicleCommand::Land);
    rig.run_until("refused", 10.0, |rig| rig.refusal(id).is_some());
    assert_eq!((rig.refusal(id), rig.state), (Some(denied), FlightState::Holding));
    rig.run(2.0);
    assert_eq!(rig.autopilot.mode, FlightMode::Offboard);
    rig.assert_no_jump_since(start);
}

#[test]
fn a_landing_can_be_broken_off() {
    let mut rig = Rig::holding(10.0);
    let land = rig.command(VehicleCommand::Land);
    rig.run_until("half down", 20.0, |rig| rig.autopilot.height_m() < 6.0);
    let hold = rig.command(VehicleCommand::Hold);
    rig.run_until("holding", 10.0, |rig| rig.is_done(hold));
    assert_eq!(
        (rig.state, rig.autopilot.mode),
        (FlightState::Holding, FlightMode::Offboard)
    );
    assert_eq!(rig.refusal(land), Some(Refusal::Superseded));
    rig.run(3.0);
    assert!(rig.autopilot.height_m() > 3.0, "{} m", rig.autopilot.height_m());
}

#[test]
fn a_landing_broken_off_before_it_was_answered_is_not_taken_for_a_pilots() {
    let mut rig = Rig::holding(10.0);
    rig.command(VehicleCommand::Land);
    rig.tick();
    let hold = rig.command(VehicleCommand::Hold);
    rig.run_until("holding", 10.0, |rig| rig.is_done(hold));
    rig.run(2.0);
    assert_eq!(
        (rig.state, rig.autopilot.mode),
        (FlightState::Holding, FlightMode::Offboard)
    );
    assert!(rig.autopilot.height_m() > 8.0);
}

#[test]
fn a_flight_that_the_gate_refuses_is_broken_off_where_the_vehicle_is() {
    let mut rig = Rig::holding(10.0);
    let id = rig.command(go_to(PositionNed::new(200.0, -20.0, -11.5)));
    rig.run(6.0);
    let fence = Refusal::OutsideFence {
        detail: "north".to_owned(),
    };
    rig.gate = Some(fence.clone());
    rig.run(1.0);
    assert_eq!(rig.state, FlightState::GoingTo, "it may pass");
    rig.run(2.0);
    assert_eq!((rig.refusal(id), rig.state), (Some(fence), FlightState::Holding));
    rig.gate = None;
    let (from, start) = (rig.here(), rig.now);
    rig.run(5.0);
    assert!(rig.here().distance_m(&from) < 1.0, "{} m", rig.here().distance_m(&from));
    rig.assert_no_jump_since(start.plus_seconds(0.1));
}

#[test]
fn a_short_refusal_only_delays_the_flight() {
    let mut rig = Rig::holding(10.0);
    let to = PositionNed::new(60.0, -20.0, -11.5);
    let id = rig.command(go_to(to));
    rig.run(5.0);
    rig.gate = Some(Refusal::TooClose {
        other: skein_domain::VehicleId(2),
        distance_m: 1.0,
        limit_m: 2.0,
    });
    rig.run(1.5);
    rig.gate = None;
    let start = rig.now.plus_seconds(0.1);
    rig.run_until("there", 60.0, |rig| rig.is_done(id));
    rig.assert_no_jump_since(start);
}

#[test]
fn a_lost_link_stops_no_setpoint_and_uses_up_no_time() {
    let mut rig = Rig::holding(10.0);
    let id = rig.command(go_to(PositionNed::new(60.0, -20.0, -11.5)));
    rig.run(2.0);
    rig.autopilot.link_connected = false;
    rig.inbox.push(Event::LinkLost(true));
    let (before, start) = (rig.progress(id), rig.now);
    rig.run(60.0);
    assert_eq!(
        rig.progress(id),
        before,
        "nothing is said of a vehicle that is not heard"
    );
    assert_eq!(rig.state, FlightState::GoingTo);
    rig.assert_no_jump_since(start);
    rig.autopilot.link_connected = true;
    rig.inbox.push(Event::LinkLost(false));
    rig.run(1.0);
    assert!(rig.is_done(id));

    // The same while landing: its time-out counts only what is heard.
    let id = rig.command(VehicleCommand::Land);
    rig.run(2.0);
    rig.autopilot.link_connected = false;
    rig.run(300.0);
    assert_eq!(rig.progress(id), [CommandProgress::Executing]);
    rig.autopilot.link_connected = true;
    rig.run(1.0);
    assert!(rig.is_done(id));
}

#[test]
fn the_distance_to_the_goal_is_told_in_every_period() {
    let mut rig = Rig::holding(10.0);
    rig.command(go_to(PositionNed::new(30.0, -20.0, -11.5)));
    let effects = rig.tick();
    let told = effects.iter().find_map(|e| match e {
        Effect::TrackingError { distance_m } => Some(*distance_m),
        _ => None,
    });
    assert!(
        told.is_some_and(|distance_m| (19.5..20.5).contains(&distance_m)),
        "{told:?}"
    );
}

#[test]
fn a_new_instance_in_the_air_holds_what_it_finds() {
    let mut autopilot = Autopilot {
        armed: true,
        mode: FlightMode::Offboard,
        ..Autopilot::default()
    };
    autopilot.position.z -= 20.0;
    autopilot.velocity = VelocityNed::new(3.0, 0.0, 0.0).vector();
    let mut rig = Rig::new(autopilot);
    let effects = rig.tick();
    assert!(
        effects.iter().any(|e| matches!(e, Effect::Setpoint(_))),
        "a setpoint at once: {effects:?}"
    );
    assert_eq!(rig.state, FlightState::Holding);
    let start = rig.now;
    rig.run(5.0);
    assert!(rig.autopilot.velocity.norm() < 0.1);
    rig.assert_no_jump_since(start);

    // What another controls is left alone.
    let mut autopilot = Autopilot {
        armed: true,
        mode: FlightMode::Position,
        ..Autopilot::default()
    };
    autopilot.position.z -= 20.0;
    let mut rig = Rig::new(autopilot);
    rig.run(1.0);
    assert!(rig.state == FlightState::PilotControl && rig.setpoints().is_empty() && rig.requests().is_empty());
}
