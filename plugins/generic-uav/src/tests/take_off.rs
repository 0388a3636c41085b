//! From the ground to holding, and what can go wrong on the way.

use super::autopilot::{Answer, Autopilot};
use super::rig::Rig;
use skein_domain::exchange::{CommandProgress, Effect};
use skein_domain::{AutopilotCommand, FlightMode, FlightState, Refusal, VehicleCommand};

const TAKE_OFF: VehicleCommand = VehicleCommand::TakeOff { height_m: 5.0 };

fn temporarily() -> Refusal {
    Refusal::Autopilot {
        result: "temporarily_rejected".to_owned(),
        text: String::new(),
    }
}

fn states(rig: &Rig) -> Vec<FlightState> {
    let mut states: Vec<_> = rig
        .log
        .iter()
        .filter_map(|(_, effect)| match effect {
            Effect::State { state, .. } => Some(*state),
            _ => None,
        })
        .collect();
    states.dedup();
    states
}

#[test]
fn a_take_off_goes_through_its_states_and_ends_at_the_exact_height() {
    let mut rig = Rig::idle();
    let launch = rig.here();
    let id = rig.command(TAKE_OFF);
    rig.run_until("taken off", 20.0, |rig| rig.is_done(id));
    rig.run(4.0);
    use FlightState::{Arming, Holding, Idle, TakingOff};
    assert_eq!(states(&rig), [Idle, Arming, TakingOff, Holding]);
    assert_eq!(
        rig.requests(),
        [
            AutopilotCommand::Arm,
            AutopilotCommand::TakeOff { height_m: 5.0 },
            AutopilotCommand::EnterOffboard
        ]
    );
    assert_eq!(rig.progress(id), [CommandProgress::Executing, CommandProgress::Done]);
    assert!(
        (rig.autopilot.height_m() - 5.0).abs() < 0.02,
        "holds at {:.2} m",
        rig.autopilot.height_m()
    );
    assert!(rig.here().horizontal_distance_m(&launch) < 0.05);
    let (_, last) = rig.setpoints().pop().expect("streams");
    let hold = last.position.expect("has one");
    assert!((launch.down_m - 5.0 - hold.down_m).abs() < 1e-6 && hold.horizontal_distance_m(&launch) < 1e-6);
}

#[test]
fn setpoints_run_before_offboard_is_asked_for() {
    let mut rig = Rig::idle();
    rig.command(TAKE_OFF);
    rig.run_until("holding", 20.0, |rig| rig.state == FlightState::Holding);
    let index = |wanted: &dyn Fn(&Effect) -> bool| rig.log.iter().position(|(_, e)| wanted(e)).expect("is there");
    let first_setpoint = index(&|e| matches!(e, Effect::Setpoint(_)));
    let offboard = index(&|e| {
        matches!(
            e,
            Effect::Autopilot {
                command: AutopilotCommand::EnterOffboard,
                ..
            }
        )
    });
    assert!(first_setpoint < offboard);
}

#[test]
fn arming_is_tried_again_while_the_estimator_settles() {
    let arm = Answer::RefusesAtFirst(3, temporarily());
    let mut rig = Rig::new(Autopilot {
        arm,
        ..Autopilot::default()
    });
    let id = rig.command(TAKE_OFF);
    rig.run_until("taken off", 30.0, |rig| rig.is_done(id));
    let arms = rig.requests().iter().filter(|r| **r == AutopilotCommand::Arm).count();
    assert_eq!(arms, 4);
}

#[test]
fn a_refused_arming_is_never_followed_by_a_take_off() {
    let denied = Refusal::Autopilot {
        result: "denied".to_owned(),
        text: "no".to_owned(),
    };
    for (answer, limit_s) in [
        (Answer::Refuses(denied), 2.0),
        (Answer::Refuses(temporarily()), 40.0),
        (Answer::Silent, 40.0),
        (Answer::Ignores, 60.0),
    ] {
        let mut rig = Rig::new(Autopilot {
            arm: answer.clone(),
            ..Autopilot::default()
        });
        let id = rig.command(TAKE_OFF);
        rig.run_until("refused", limit_s, |rig| rig.refusal(id).is_some());
        rig.run(5.0);
        assert_eq!(rig.state, FlightState::Idle, "{answer:?}");
        assert!(
            !rig.requests()
                .iter()
                .any(|r| matches!(r, AutopilotCommand::TakeOff { .. })),
            "{answer:?}"
        );
        assert!(rig.setpoints().is_empty(), "{answer:?}");
    }
}

#[test]
fn it_waits_until_the_autopilot_is_ready() {
    let mut rig = Rig::new(Autopilot {
        ready: Some(false),
        ..Autopilot::default()
    });
    let id = rig.command(TAKE_OFF);
    rig.run(4.0);
    assert!(rig.requests().is_empty() && rig.state == FlightState::Arming);
    rig.autopilot.ready = Some(true);
    rig.run_until("taken off", 20.0, |rig| rig.is_done(id));

    let mut rig = Rig::new(Autopilot {
        ready: Some(false),
        ..Autopilot::default()
    });
    let id = rig.command(TAKE_OFF);
    rig.run_until("refused", 40.0, |rig| rig.refusal(id).is_some());
    assert!(matches!(rig.refusal(id), Some(Refusal::NotReadyToArm { .. })));
}

#[test]
fn a_mode_that_cannot_be_armed_in_is_left_first() {
    // OFFBOARD without a stream makes PX4 say that it is not ready.
    for mode in [
        FlightMode::Offboard,
        FlightMode::Manual,
        FlightMode::Position,
        FlightMode::Land,
    ] {
        let mut rig = Rig::new(Autopilot {
            mode,
            ..Autopilot::default()
        });
        let id = rig.command(TAKE_OFF);
        rig.run_until("taken off", 20.0, |rig| rig.is_done(id));
        assert_eq!(
            rig.requests().first(),
            Some(&AutopilotCommand::SetMode { mode: FlightMode::Hold }),
            "{mode}"
        );
    }
}

#[test]
fn it_flies_again_after_a_landing_out_of_offboard() {
    let mut rig = Rig::holding(3.0);
    let land = rig.command(VehicleCommand::Land);
    rig.run_until("landed", 30.0, |rig| rig.is_done(land));
    // It is left in a mode that it can be armed in.
    assert_eq!((rig.state, rig.autopilot.mode), (FlightState::Idle, FlightMode::Hold));
    rig.run(1.0);
    assert_eq!(rig.state, FlightState::Idle);
    let again = rig.command(TAKE_OFF);
    rig.run_until("taken off again", 30.0, |rig| rig.is_done(again));
}

#[test]
fn who_stands_disarmed_takes_off_though_offboard_is_still_being_left() {
    let mut rig = Rig::holding(3.0);
    rig.autopilot.hold = Answer::Silent;
    let land = rig.command(VehicleCommand::Land);
    rig.run_until("disarmed", 30.0, |rig| !rig.autopilot.armed);
    rig.run(0.1);
    assert_eq!((rig.state, rig.is_done(land)), (FlightState::Landing, false));
    rig.autopilot.hold = Answer::Obeys;
    let again = rig.command(TAKE_OFF);
    rig.run_until("taken off again", 30.0, |rig| rig.is_done(again));
    assert!(rig.is_done(land), "{:?}", rig.refusal(land));
}

#[test]
fn an_autopilot_that_stays_in_offboard_after_a_landing_has_landed_all_the_same() {
    let denied = Refusal::Autopilot {
        result: "denied".to_owned(),
        text: String::new(),
    };
    for hold in [Answer::Refuses(denied), Answer::Silent, Answer::Ignores] {
        let mut rig = Rig::holding(3.0);
        rig.autopilot.hold = hold;
        let land = rig.command(VehicleCommand::Land);
        rig.run_until("landed", 60.0, |rig| rig.is_done(land));
        assert_eq!(
            (rig.state, rig.autopilot.mode),
            (FlightState::Idle, FlightMode::Offboard)
        );
        rig.autopilot.hold = Answer::Obeys;
        let again = rig.command(TAKE_OFF);
        rig.run_until("taken off again", 30.0, |rig| rig.is_done(again));
    }
}

#[test]
fn a_refused_take_off_is_disarmed() {
    let denied = Refusal::Autopilot {
        result: "denied".to_owned(),
        text: String::new(),
    };
    let mut rig = Rig::new(Autopilot {
        take_off: Answer::Refuses(denied.clone()),
        ..Autopilot::default()
    });
    let id = rig.command(TAKE_OFF);
    rig.run_until("refused", 10.0, |rig| rig.refusal(id).is_some());
    assert_eq!(rig.refusal(id), Some(denied));
    rig.run(1.0);
    assert!(!rig.autopilot.armed && rig.state == FlightState::Idle);
    assert_eq!(rig.requests().last(), Some(&AutopilotCommand::Disarm));
}

#[test]
fn an_accepted_take_off_that_does_not_climb_times_out() {
    let mut rig = Rig::new(Autopilot {
        take_off: Answer::Ignores,
        ..Autopilot::default()
    });
    let id = rig.command(TAKE_OFF);
    rig.run_until("refused", 90.0, |rig| rig.refusal(id).is_some());
    assert!(matches!(rig.refusal(id), Some(Refusal::TimedOut { .. })));
    rig.run(1.0);
    assert!(!rig.autopilot.armed && rig.state == FlightState::Idle);
}

#[test]
fn a_take_off_that_stops_half_way_ends_in_a_landing() {
    let mut rig = Rig::idle();
    let id = rig.command(VehicleCommand::TakeOff { height_m: 30.0 });
    rig.run_until("climbing", 20.0, |rig| rig.autopilot.height_m() > 2.0);
    rig.autopilot.mode = FlightMode::Unknown; // It hangs there: no mode that climbs.
    rig.run_until("refused", 90.0, |rig| rig.refusal(id).is_some());
    rig.run_until("on the ground", 30.0, |rig| {
        rig.state == FlightState::Idle && !rig.autopilot.armed
    });
}

#[test]
fn offboard_refused_leaves_it_to_the_autopilot() {
    let denied = Refusal::Autopilot {
        result: "denied".to_owned(),
        text: String::new(),
    };
    let mut rig = Rig::new(Autopilot {
        offboard: Answer::Refuses(denied.clone()),
        ..Autopilot::default()
    });
    let id = rig.command(TAKE_OFF);
    rig.run_until("refused", 30.0, |rig| rig.refusal(id).is_some());
    assert_eq!((rig.refusal(id), rig.state), (Some(denied), FlightState::PilotControl));
    let before = rig.setpoints().len();
    rig.run(2.0);
    assert_eq!(rig.setpoints().len(), before, "it still streams");
    assert_eq!(rig.autopilot.mode, FlightMode::Hold);
}

#[test]
fn a_disarming_on_the_way_up_is_noticed() {
    let mut rig = Rig::new(Autopilot {
        take_off: Answer::Ignores,
        ..Autopilot::default()
    });
    let id = rig.command(TAKE_OFF);
    rig.run(2.0);
    rig.autopilot.armed = false;
    rig.run(0.1);
    assert!(matches!(rig.refusal(id), Some(Refusal::Autopilot { result, .. }) if result == "disarmed"));
    assert_eq!(rig.state, FlightState::Idle);
}

#[test]
fn without_a_position_it_does_not_take_off() {
    let mut rig = Rig::new(Autopilot {
        has_position: false,
        ..Autopilot::default()
    });
    let id = rig.command(TAKE_OFF);
    rig.run_until("refused", 10.0, |rig| rig.refusal(id).is_some());
    rig.run(1.0);
    assert_eq!(rig.refusal(id), Some(Refusal::NoPosition));
    assert!(
        !rig.autopilot.armed
            && !rig
                .requests()
                .iter()
                .any(|r| matches!(r, AutopilotCommand::TakeOff { .. }))
    );
}

#[test]
fn a_staggered_take_off_begins_when_its_time_has_come() {
    let mut rig = Rig::idle();
    let begin = rig.now.plus_seconds(2.0);
    let id = rig.command_at(TAKE_OFF, begin);
    rig.run(1.9);
    assert!(rig.state == FlightState::Idle && rig.progress(id).is_empty());
    rig.run(0.2);
    assert!(rig.state != FlightState::Idle && rig.progress(id) == [CommandProgress::Executing]);

    // A newer command replaces one that still waits.
    let mut rig = Rig::idle();
    let waiting = rig.command_at(TAKE_OFF, begin.plus_seconds(100.0));
    rig.run(0.1);
    let arm = rig.command(VehicleCommand::Arm);
    rig.run(1.0);
    assert_eq!(rig.refusal(waiting), Some(Refusal::Superseded));
    assert!(rig.is_done(arm) && rig.autopilot.armed && rig.state == FlightState::Idle && rig.detail == "armed");
}

#[test]
fn land_while_arming_breaks_the_take_off_off() {
    let mut rig = Rig::new(Autopilot {
        ready: Some(false),
        ..Autopilot::default()
    });
    let take_off = rig.command(TAKE_OFF);
    rig.run(0.5);
    let land = rig.command(VehicleCommand::Land);
    rig.run(0.5);
    assert_eq!(rig.refusal(take_off), Some(Refusal::Superseded));
    assert!(rig.is_done(land) && rig.state == FlightState::Idle);
}

#[test]
fn hold_in_the_climb_stops_it() {
    let mut rig = Rig::idle();
    let take_off = rig.command(VehicleCommand::TakeOff { height_m: 30.0 });
    rig.run_until("climbing", 20.0, |rig| rig.autopilot.height_m() > 5.0);
    let hold = rig.command(VehicleCommand::Hold);
    rig.run_until("stopped", 10.0, |rig| rig.is_done(hold));
    assert_eq!(rig.refusal(take_off), Some(Refusal::Superseded));
    assert!(rig.state == FlightState::Holding && rig.autopilot.height_m() < 9.0);
}
