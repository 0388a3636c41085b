//! Which commands are sent for what, and what is refused before anything is sent.

use super::*;

const ON_GROUND: Situation = Situation {
    mode: FlightMode::Hold,
    armed: true,
    landed: LandedState::OnGround,
    streaming: false,
    place: Some(Geodetic {
        latitude_deg: 47.4,
        longitude_deg: 8.5,
        altitude_amsl_m: 489.0,
    }),
    home: Some(Geodetic {
        latitude_deg: 47.4,
        longitude_deg: 8.5,
        altitude_amsl_m: 480.0,
    }),
};

fn altitude(plan: Result<Plan, Refusal>) -> f32 {
    plan.unwrap().steps[0].command.parameters[6]
}

#[test]
fn a_take_off_is_above_the_ground_it_stands_on() {
    let take_off = AutopilotCommand::TakeOff { height_m: 10.0 };
    assert_eq!(altitude(plan(take_off, &ON_GROUND)), 499.0);
    assert_eq!(
        altitude(plan(
            take_off,
            &Situation {
                place: None,
                ..ON_GROUND
            }
        )),
        490.0,
        "launch place as second best"
    );
    let nowhere = Situation {
        place: None,
        home: None,
        ..ON_GROUND
    };
    assert_eq!(plan(take_off, &nowhere), Err(Refusal::NoPosition));
    let disarmed = Situation {
        armed: false,
        ..ON_GROUND
    };
    assert!(matches!(plan(take_off, &disarmed), Err(Refusal::NotPermitted { .. })));
    let flying = Situation {
        landed: LandedState::InAir,
        ..ON_GROUND
    };
    assert!(matches!(plan(take_off, &flying), Err(Refusal::NotPermitted { .. })));
    for height_m in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
        let refused = plan(AutopilotCommand::TakeOff { height_m }, &ON_GROUND);
        assert!(matches!(refused, Err(Refusal::InvalidValue { .. })), "{height_m}");
    }
}

#[test]
fn arming_leaves_offboard_first_where_px4_shows_it_after_a_landing() {
    let landed = Situation {
        armed: false,
        mode: FlightMode::Offboard,
        ..ON_GROUND
    };
    let goals: Vec<Goal> = plan(AutopilotCommand::Arm, &landed)
        .unwrap()
        .steps
        .iter()
        .map(|s| s.goal)
        .collect();
    assert_eq!(goals, [Goal::Mode(FlightMode::Hold), Goal::Armed(true)]);
    let streaming = Situation {
        streaming: true,
        ..landed
    };
    assert_eq!(
        plan(AutopilotCommand::Arm, &streaming).unwrap().steps.len(),
        1,
        "it may be armed in OFFBOARD then"
    );
    assert_eq!(plan(AutopilotCommand::Arm, &ON_GROUND).unwrap().steps.len(), 1);
}

#[test]
fn modes_that_have_their_own_way_or_none_are_refused() {
    for &mode in FlightMode::ALL {
        let planned = plan(AutopilotCommand::SetMode { mode }, &ON_GROUND);
        let own_way = matches!(
            mode,
            FlightMode::Unknown | FlightMode::Offboard | FlightMode::TakeOff | FlightMode::Termination
        );
        assert_eq!(planned.is_err(), own_way, "{mode}");
        if let Ok(planned) = planned {
            assert_eq!(planned.steps[0].goal, Goal::Mode(mode));
            let parameters = planned.steps[0].command.parameters;
            let px4 = Px4Mode {
                main: parameters[1] as u8,
                sub: parameters[2] as u8,
            };
            assert_eq!(px4.flight_mode(), mode);
        }
    }
}

#[test]
fn landing_waits_for_a_take_off_that_has_not_begun_and_makes_no_sense_on_the_ground() {
    let climbing_soon = Situation {
        mode: FlightMode::TakeOff,
        ..ON_GROUND
    };
    assert_eq!(
        plan(AutopilotCommand::Land, &climbing_soon).unwrap().condition,
        Condition::LiftedOff
    );
    let flying = Situation {
        landed: LandedState::InAir,
        ..ON_GROUND
    };
    assert_eq!(
        plan(AutopilotCommand::Land, &flying).unwrap().condition,
        Condition::None
    );
    let parked = Situation {
        armed: false,
        ..ON_GROUND
    };
    for command in [AutopilotCommand::Land, AutopilotCommand::ReturnToLaunch] {
        assert!(matches!(plan(command, &parked), Err(Refusal::NotPermitted { .. })));
        assert!(
            plan(
                command,
                &Situation {
                    landed: LandedState::Unknown,
                    ..parked
                }
            )
            .is_ok(),
            "not known: let it try"
        );
    }
}
