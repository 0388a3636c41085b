//! A human or the autopilot's failsafe always wins, and restarts of the autopilot are noticed.

use super::autopilot::Autopilot;
use super::rig::Rig;
use super::tasks::lead;
use skein_domain::exchange::{Effect, Event};
use skein_domain::{FlightMode, FlightState, PositionNed, Refusal, VehicleCommand};

const FAR: VehicleCommand = VehicleCommand::GoTo {
    position: PositionNed::new(300.0, 0.0, -20.0),
    yaw_rad: None,
    speed_m_s: None,
};

#[test]
fn leaving_offboard_unasked_takes_the_vehicle_out_of_our_control() {
    for mode in [
        FlightMode::Position,
        FlightMode::Manual,
        FlightMode::Return,
        FlightMode::Hold,
        FlightMode::Land,
    ] {
        let mut rig = Rig::holding(10.0);
        let id = rig.command(FAR);
        rig.run(2.0);
        rig.autopilot.change_mode(mode, false);
        let effects = rig.tick();
        assert!(effects.contains(&Effect::StopStream), "{effects:?}");
        assert_eq!(
            (rig.state, rig.refusal(id)),
            (FlightState::PilotControl, Some(Refusal::PilotInControl))
        );
        assert!(rig.detail.contains(&mode.to_string()), "{}", rig.detail);
        let (streamed, asked) = (rig.setpoints().len(), rig.requests().len());
        rig.task(lead(None));
        rig.run(3.0);
        assert_eq!(
            (rig.setpoints().len(), rig.requests().len()),
            (streamed, asked),
            "{mode}: it keeps out of it"
        );
        assert!(rig.notices().iter().any(|text| text.contains("in control")));
    }
}

#[test]
fn a_mode_seen_only_in_the_telemetry_counts_too() {
    let mut rig = Rig::holding(10.0);
    rig.autopilot.mode = FlightMode::Position; // The event was lost with a restart, say.
    rig.tick();
    assert_eq!(rig.state, FlightState::PilotControl);
}

#[test]
fn coming_back_to_offboard_does_not_give_it_back() {
    let mut rig = Rig::holding(10.0);
    rig.autopilot.change_mode(FlightMode::Return, false);
    rig.autopilot.change_mode(FlightMode::Offboard, false);
    rig.tick();
    assert_eq!(rig.state, FlightState::PilotControl, "both within one period");
    let streamed = rig.setpoints().len();
    rig.run(0.5);
    assert_eq!(rig.setpoints().len(), streamed);
}

#[test]
fn an_operator_takes_it_back() {
    for command in [VehicleCommand::Hold, FAR, VehicleCommand::Return] {
        let mut rig = Rig::holding(10.0);
        rig.autopilot.change_mode(FlightMode::Position, false);
        rig.run(1.0);
        rig.autopilot.position.x += 50.0;
        rig.tick();
        let start = rig.now;
        rig.command(command);
        rig.run(3.0);
        assert_eq!(rig.autopilot.mode, FlightMode::Offboard, "{}", command.name());
        rig.assert_no_jump_since(start);
    }
}

#[test]
fn land_by_command_out_of_a_pilots_control() {
    let mut rig = Rig::holding(10.0);
    rig.autopilot.change_mode(FlightMode::Position, false);
    rig.run(1.0);
    let streamed = rig.setpoints().len();
    let id = rig.command(VehicleCommand::Land);
    rig.run_until("landed", 40.0, |rig| rig.is_done(id));
    assert_eq!(rig.setpoints().len(), streamed, "no stream is needed to land");
}

#[test]
fn a_pilot_who_takes_it_while_offboard_is_asked_for_keeps_it() {
    let mut rig = Rig::holding(10.0);
    rig.autopilot.change_mode(FlightMode::Position, false);
    rig.run(1.0);
    rig.autopilot.offboard = super::autopilot::Answer::Silent;
    let id = rig.command(VehicleCommand::Hold);
    rig.run(0.5);
    rig.autopilot.change_mode(FlightMode::Manual, false);
    rig.tick();
    assert_eq!(
        (rig.state, rig.refusal(id)),
        (FlightState::PilotControl, Some(Refusal::PilotInControl))
    );
}

#[test]
fn a_pilot_may_break_a_landing_and_a_climb_off() {
    let mut rig = Rig::holding(10.0);
    let land = rig.command(VehicleCommand::Land);
    rig.run(3.0);
    rig.autopilot.change_mode(FlightMode::Position, false);
    rig.tick();
    assert_eq!(
        (rig.state, rig.refusal(land)),
        (FlightState::PilotControl, Some(Refusal::PilotInControl))
    );

    let mut rig = Rig::idle();
    let take_off = rig.command(VehicleCommand::TakeOff { height_m: 20.0 });
    rig.run_until("climbing", 10.0, |rig| rig.autopilot.height_m() > 3.0);
    rig.autopilot.change_mode(FlightMode::Position, false);
    rig.tick();
    assert_eq!(
        (rig.state, rig.refusal(take_off)),
        (FlightState::PilotControl, Some(Refusal::PilotInControl))
    );
}

#[test]
fn on_the_ground_and_disarmed_it_is_ours_again() {
    let mut rig = Rig::holding(4.0);
    rig.autopilot.change_mode(FlightMode::Land, false);
    rig.run_until("on the ground", 30.0, |rig| rig.state == FlightState::Idle);
    let id = rig.command(VehicleCommand::TakeOff { height_m: 4.0 });
    rig.run_until("taken off", 30.0, |rig| rig.is_done(id));
}

#[test]
fn a_pilot_who_takes_off_by_himself_is_left_alone() {
    let mut rig = Rig::idle();
    rig.autopilot.armed = true;
    rig.autopilot.mode = FlightMode::Position;
    rig.run(0.5);
    assert_eq!(rig.state, FlightState::Idle);
    rig.autopilot.position.z -= 3.0;
    rig.run(0.5);
    assert_eq!(rig.state, FlightState::PilotControl);
    assert!(rig.setpoints().is_empty() && rig.requests().is_empty());
}

#[test]
fn a_restart_in_flight_is_a_fault_and_on_the_ground_is_none() {
    let mut rig = Rig::holding(10.0);
    let id = rig.command(FAR);
    rig.run(1.0);
    rig.inbox.push(Event::Rebooted);
    let effects = rig.tick();
    assert!(effects.contains(&Effect::StopStream));
    assert_eq!(rig.state, FlightState::Faulted);
    assert!(matches!(rig.refusal(id), Some(Refusal::Autopilot { result, .. }) if result == "restarted"));
    let streamed = rig.setpoints().len();
    rig.run(1.0);
    assert_eq!(rig.setpoints().len(), streamed);
    // An operator has looked at it.
    let hold = rig.command(VehicleCommand::Hold);
    rig.run_until("holding", 10.0, |rig| rig.is_done(hold));

    let mut rig = Rig::new(Autopilot {
        ready: Some(false),
        ..Autopilot::default()
    });
    let id = rig.command(VehicleCommand::TakeOff { height_m: 5.0 });
    rig.run(0.5);
    rig.inbox.push(Event::Rebooted);
    rig.tick();
    assert!(rig.state == FlightState::Idle && rig.refusal(id).is_some());
}

#[test]
fn disarmed_in_the_air_is_a_fault() {
    for landing in [false, true] {
        let mut rig = Rig::holding(20.0);
        if landing {
            rig.command(VehicleCommand::Land);
            rig.run(2.0);
        }
        rig.autopilot.armed = false;
        rig.run(5.0);
        assert_eq!(rig.state, FlightState::Faulted);
        // It lies somewhere now; an operator acknowledges it.
        rig.autopilot.position.z = rig.autopilot.home.down_m;
        let id = rig.command(VehicleCommand::Disarm);
        rig.run(0.1);
        assert!(rig.is_done(id) && rig.state == FlightState::Idle);
    }
}
