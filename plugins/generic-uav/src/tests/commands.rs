//! The table of states and commands: which command is taken up in which state.

use super::autopilot::{Answer, Autopilot};
use super::rig::Rig;
use super::tasks::{follow, lead, leader_anchor};
use skein_domain::exchange::{CommandProgress, Event};
use skein_domain::{CommandId, FlightMode, FlightState, PositionNed, Refusal, VehicleCommand};

const STATES: [FlightState; 12] = [
    FlightState::Idle,
    FlightState::Arming,
    FlightState::TakingOff,
    FlightState::Holding,
    FlightState::GoingTo,
    FlightState::Following,
    FlightState::Leading,
    FlightState::Returning,
    FlightState::Landing,
    FlightState::PilotControl,
    FlightState::Faulted,
    // Once more, on the ground.
    FlightState::PilotControl,
];

/// Rows as in [`STATES`], columns as in [`commands`]: `+` taken up, `-` refused as not fitting the state.
const TABLE: [(&str, &str); 12] = [
    ("idle", "+++------"),
    ("arming", "++++-----"),
    ("taking off", "---++-+--"),
    ("holding", "---++++++"),
    ("going to", "---++++++"),
    ("following", "---++++++"),
    ("leading", "---++++++"),
    ("returning", "---++++++"),
    ("landing", "---++++++"),
    ("pilot", "---++++++"),
    ("faulted", "---++++++"),
    ("pilot on the ground", "+++------"),
];

fn commands(rig: &Rig) -> [VehicleCommand; 9] {
    let place = rig.here();
    [
        VehicleCommand::Arm,
        VehicleCommand::TakeOff { height_m: 5.0 },
        VehicleCommand::Disarm,
        VehicleCommand::Land,
        VehicleCommand::Hold,
        VehicleCommand::LandAt { spot: place },
        VehicleCommand::Return,
        VehicleCommand::GoTo {
            position: place,
            yaw_rad: None,
            speed_m_s: None,
        },
        VehicleCommand::Steer,
    ]
}

/// A vehicle in the state.
fn in_state(row: usize) -> Rig {
    let state = STATES[row];
    let mut rig = match state {
        FlightState::Idle => Rig::idle(),
        FlightState::Arming => Rig::new(Autopilot {
            arm: Answer::Silent,
            ..Autopilot::default()
        }),
        FlightState::TakingOff => Rig::idle(),
        _ => Rig::holding(10.0),
    };
    match state {
        FlightState::Idle | FlightState::Holding => {}
        FlightState::Arming | FlightState::TakingOff => {
            rig.command(VehicleCommand::TakeOff { height_m: 30.0 });
            if state == FlightState::TakingOff {
                rig.run_until("in the climb", 20.0, |rig| rig.autopilot.height_m() > 3.0);
            }
        }
        FlightState::GoingTo => {
            rig.command(VehicleCommand::GoTo {
                position: PositionNed::new(100.0, 0.0, -20.0),
                yaw_rad: None,
                speed_m_s: None,
            });
        }
        FlightState::Following => {
            let anchor = leader_anchor(&rig, rig.here());
            rig.task(follow(0.0));
            rig.anchor(anchor);
        }
        FlightState::Leading => {
            rig.task(lead(None));
        }
        FlightState::Returning => {
            rig.autopilot.home.north_m += 100.0;
            rig.command(VehicleCommand::Return);
        }
        FlightState::Landing => {
            rig.command(VehicleCommand::Land);
        }
        FlightState::PilotControl => {
            rig.autopilot.change_mode(FlightMode::Position, false);
            if row == 11 {
                rig.autopilot.position.z = rig.autopilot.home.down_m;
            }
        }
        FlightState::Faulted => rig.inbox.push(Event::Rebooted),
    }
    rig.run(0.2);
    assert_eq!(rig.state, state, "{}", rig.detail);
    rig
}

#[test]
fn every_command_in_every_state() {
    for (row, (name, wanted)) in TABLE.iter().enumerate() {
        let mut got = String::new();
        for column in 0..9 {
            let mut rig = in_state(row);
            let state = rig.state;
            let command = commands(&rig)[column];
            let id = rig.command(command);
            rig.tick();
            got.push(match rig.progress(id).first() {
                Some(CommandProgress::Executing) => '+',
                Some(CommandProgress::Refused { refusal }) => {
                    let expected = Refusal::WrongState {
                        state,
                        command: command.name().to_owned(),
                    };
                    assert_eq!(*refusal, expected);
                    '-'
                }
                other => panic!("{name}, {}: {other:?}", command.name()),
            });
        }
        assert_eq!(got, *wanted, "{name}");
    }
}

#[test]
fn values_that_make_no_sense_are_refused() {
    let nan = PositionNed::new(f64::NAN, 0.0, 0.0);
    let place = PositionNed::default();
    let bad = [
        VehicleCommand::TakeOff { height_m: f64::NAN },
        VehicleCommand::TakeOff { height_m: -5.0 },
        VehicleCommand::TakeOff { height_m: 0.5 },
        VehicleCommand::TakeOff { height_m: 1e9 },
        VehicleCommand::LandAt { spot: nan },
        VehicleCommand::GoTo {
            position: nan,
            yaw_rad: None,
            speed_m_s: None,
        },
        VehicleCommand::GoTo {
            position: place,
            yaw_rad: Some(f64::INFINITY),
            speed_m_s: None,
        },
        VehicleCommand::GoTo {
            position: place,
            yaw_rad: None,
            speed_m_s: Some(0.0),
        },
        VehicleCommand::GoTo {
            position: place,
            yaw_rad: None,
            speed_m_s: Some(f64::NAN),
        },
    ];
    let mut rig = Rig::holding(5.0);
    for command in bad {
        let id = rig.command(command);
        rig.tick();
        assert!(
            matches!(rig.refusal(id), Some(Refusal::InvalidValue { .. })),
            "{command:?}: {:?}",
            rig.progress(id)
        );
    }
    assert_eq!(rig.state, FlightState::Holding);
}

#[test]
fn a_newer_command_replaces_an_older_one_but_a_refused_one_does_not() {
    let mut rig = Rig::holding(5.0);
    let far = VehicleCommand::GoTo {
        position: PositionNed::new(200.0, 0.0, -8.0),
        yaw_rad: None,
        speed_m_s: None,
    };
    let first = rig.command(far);
    rig.run(1.0);
    let refused = rig.command(VehicleCommand::TakeOff { height_m: 5.0 });
    rig.run(1.0);
    assert!(matches!(rig.refusal(refused), Some(Refusal::WrongState { .. })));
    assert_eq!(rig.progress(first), [CommandProgress::Executing]);
    let second = rig.command(far);
    rig.run(1.0);
    assert_eq!(rig.refusal(first), Some(Refusal::Superseded));
    assert_eq!(rig.progress(second), [CommandProgress::Executing]);
}

#[test]
fn the_same_command_twice_is_one_command() {
    let mut rig = Rig::idle();
    let command = VehicleCommand::TakeOff { height_m: 5.0 };
    let id = rig.command(command);
    rig.inbox.push(Event::Command {
        id,
        command,
        not_before: skein_domain::NodeTime(0),
    });
    rig.run(1.0);
    assert_eq!(rig.progress(id), [CommandProgress::Executing]);
}

#[test]
fn before_anything_is_heard_nothing_is_taken_up() {
    let mut rig = Rig::new(Autopilot::default());
    let id = CommandId(1);
    rig.hand_in(vec![Event::Command {
        id,
        command: VehicleCommand::Arm,
        not_before: rig.now,
    }]);
    assert!(matches!(rig.refusal(id), Some(Refusal::LinkLost { .. })));
}
