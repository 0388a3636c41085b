//! Whatever comes, in whatever order: no setpoint that is not finite, none while idle or under a pilot's control, no take-off without arming,
//! and every command ends exactly once.

use super::autopilot::{Answer, Autopilot, PERIOD_S};
use super::rig::Rig;
use super::tasks::{COURSE, slot};
use crate::Goal;
use proptest::prelude::*;
use skein_domain::exchange::{CommandProgress, Effect, Event};
use skein_domain::payload::Target;
use skein_domain::{
    AnchorReference, AutopilotCommand, CommandId, FlightMode, FlightState, NodeTime, PositionNed, Refusal, Route,
    Stick, Task, VehicleCommand, VehicleId,
};
use skein_plugin_sdk::UavModel;

/// Something that happens.
#[derive(Debug, Clone)]
enum Happening {
    Command(VehicleCommand, f64),
    Task(Task),
    Anchor(AnchorReference),
    Mode(FlightMode, bool),
    Reboot,
    Link(bool),
    Position(bool),
    Gate(bool),
    Disarm,
    Answers(Answer, u8),
    Restart,
    Guide(Option<Goal>),
    Stick(Stick),
    Nothing,
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![20 => -60.0..60.0f64, 1 => Just(f64::NAN), 1 => Just(f64::INFINITY), 1 => Just(1e300), 1 => Just(0.0)]
}

fn place() -> impl Strategy<Value = PositionNed> {
    (number(), number(), number()).prop_map(|(n, e, d)| PositionNed::new(n, e, d))
}

fn command() -> impl Strategy<Value = VehicleCommand> {
    prop_oneof![
        1 => Just(VehicleCommand::Arm),
        1 => Just(VehicleCommand::Disarm),
        4 => (1.0..20.0f64).prop_map(|height_m| VehicleCommand::TakeOff { height_m }),
        1 => Just(VehicleCommand::Land),
        1 => place().prop_map(|spot| VehicleCommand::LandAt { spot }),
        2 => Just(VehicleCommand::Hold),
        1 => Just(VehicleCommand::Return),
        2 => Just(VehicleCommand::Steer),
        2 => (place(), prop::option::of(number()), prop::option::of(number()))
            .prop_map(|(position, yaw_rad, speed_m_s)| VehicleCommand::GoTo { position, yaw_rad, speed_m_s }),
        2 => place().prop_map(|position| VehicleCommand::Observe {
            target: Target::Place { position },
            stand_off_m: None,
            height_m: None,
            bearing_rad: None,
        }),
    ]
}

fn task() -> impl Strategy<Value = Task> {
    let route = (prop::collection::vec(place(), 0..4), number(), number()).prop_map(
        |(waypoints, speed_m_s, corner_radius_m)| Route {
            waypoints,
            speed_m_s,
            corner_radius_m,
        },
    );
    prop_oneof![
        prop::option::of(route).prop_map(|route| Task::Lead { route, heading: COURSE }),
        number().prop_map(|right_m| Task::Follow {
            leader: Some(VehicleId(1)),
            slot: slot(right_m)
        }),
        Just(Task::Hold),
    ]
}

fn happening() -> impl Strategy<Value = Happening> {
    let refusal = Refusal::Autopilot {
        result: "temporarily_rejected".to_owned(),
        text: String::new(),
    };
    let answer = prop_oneof![
        3 => Just(Answer::Obeys),
        1 => Just(Answer::Refuses(refusal.clone())),
        1 => Just(Answer::RefusesAtFirst(2, refusal)),
        1 => Just(Answer::Ignores),
        1 => Just(Answer::Silent),
    ];
    prop_oneof![
        8 => (command(), prop_oneof![Just(0.0), 0.0..3.0f64]).prop_map(|(c, delay_s)| Happening::Command(c, delay_s)),
        4 => task().prop_map(Happening::Task),
        3 => (place(), number()).prop_map(|(position, heading_rad)| {
            Happening::Anchor(AnchorReference { position, heading_rad, ..Default::default() })
        }),
        1 => (prop::sample::select(FlightMode::ALL), any::<bool>()).prop_map(|(mode, asked)| Happening::Mode(mode, asked)),
        1 => Just(Happening::Reboot),
        1 => any::<bool>().prop_map(Happening::Link),
        1 => any::<bool>().prop_map(Happening::Position),
        1 => any::<bool>().prop_map(Happening::Gate),
        1 => Just(Happening::Disarm),
        1 => (answer, any::<u8>()).prop_map(|(answer, which)| Happening::Answers(answer, which)),
        2 => Just(Happening::Restart),
        2 => prop::option::of((place(), place(), number())).prop_map(|goal| {
            Happening::Guide(goal.map(|(position, velocity, speed_m_s)| Goal {
                position,
                velocity: velocity.vector().into(),
                time: NodeTime(1_000_000),
                speed_m_s,
            }))
        }),
        4 => (number(), number(), number(), number()).prop_map(|(forward_m_s, right_m_s, up_m_s, yaw_rate_rad_s)| {
            Happening::Stick(Stick { forward_m_s, right_m_s, up_m_s, yaw_rate_rad_s })
        }),
        4 => Just(Happening::Nothing),
    ]
}

fn happen(rig: &mut Rig, happening: Happening) -> Option<CommandId> {
    match happening {
        Happening::Command(command, delay_s) => return Some(rig.command_at(command, rig.now.plus_seconds(delay_s))),
        Happening::Task(task) => drop(rig.task(task)),
        Happening::Anchor(anchor) => rig.anchor(AnchorReference {
            time: rig.now,
            ..anchor
        }),
        Happening::Mode(mode, asked) => rig.autopilot.change_mode(mode, asked),
        Happening::Reboot => rig.inbox.push(Event::Rebooted),
        Happening::Link(connected) => rig.autopilot.link_connected = connected,
        Happening::Position(has_position) => rig.autopilot.has_position = has_position,
        Happening::Gate(refuses) => {
            rig.gate = refuses.then_some(Refusal::TooFast {
                speed_m_s: 9.0,
                limit_m_s: 8.0,
            });
        }
        Happening::Disarm => rig.autopilot.armed = false,
        Happening::Answers(answer, which) => match which % 5 {
            0 => rig.autopilot.arm = answer,
            1 => rig.autopilot.take_off = answer,
            2 => rig.autopilot.land = answer,
            3 => rig.autopilot.disarm = answer,
            _ => rig.autopilot.offboard = answer,
        },
        Happening::Restart => {
            let snapshot = rig.model.snapshot();
            rig.model = super::rig::create(Some(snapshot.clone()), 2, rig.now).with_guidance();
            assert_eq!(
                rig.model.snapshot(),
                snapshot,
                "the restored instance has the same state"
            );
        }
        Happening::Guide(goal) => rig.model.guide(goal),
        Happening::Stick(stick) => rig.inbox.push(Event::Stick(stick)),
        Happening::Nothing => {}
    }
    None
}

/// What must hold of one period's effects.
fn check(rig: &Rig, effects: &[Effect]) -> Result<(), TestCaseError> {
    let silent = matches!(
        rig.state,
        FlightState::PilotControl | FlightState::Idle | FlightState::Faulted | FlightState::Arming
    );
    let setpoints = effects.iter().filter_map(|e| match e {
        Effect::Setpoint(setpoint) => Some(setpoint),
        _ => None,
    });
    for (count, setpoint) in setpoints.enumerate() {
        prop_assert!(setpoint.is_well_formed(), "{:?}", setpoint);
        prop_assert!(!silent, "a setpoint in {}", rig.state);
        prop_assert!(count == 0, "more than one setpoint");
    }
    for effect in effects {
        match effect {
            Effect::Autopilot {
                command: AutopilotCommand::TakeOff { .. },
                ..
            } => {
                prop_assert!(
                    rig.autopilot.armed || !rig.autopilot.link_connected,
                    "take-off without arming"
                );
            }
            Effect::TrackingError { distance_m } => prop_assert!(distance_m.is_finite()),
            Effect::Anchor(anchor) => {
                prop_assert!(anchor.position.is_finite() && anchor.heading_rad.is_finite());
                prop_assert_eq!(rig.state, FlightState::Leading);
            }
            _ => {}
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_rules_hold_whatever_comes(happenings in prop::collection::vec((happening(), 1..80u32), 1..40)) {
        let mut rig = Rig::new(Autopilot::default());
        rig.model = super::rig::create(None, 1, rig.now).with_guidance();
        let mut commands = Vec::new();
        // Most runs begin in the air, where the model does most.
        if happenings.len() % 4 != 0 {
            commands.push(rig.command(VehicleCommand::TakeOff { height_m: 5.0 }));
            for _ in 0..500 {
                let effects = rig.tick();
                check(&rig, &effects)?;
            }
        }
        for (what, periods) in happenings {
            commands.extend(happen(&mut rig, what));
            for _ in 0..periods {
                let effects = rig.tick();
                check(&rig, &effects)?;
                prop_assert!(rig.autopilot.position.iter().all(|x| x.is_finite()));
            }
        }
        for id in commands {
            let progress = rig.progress(id);
            let ends = progress.iter().filter(|p| **p != CommandProgress::Executing).count();
            prop_assert!(ends <= 1, "{id}: {progress:?}");
            prop_assert!(progress.iter().skip(1).all(|p| *p != CommandProgress::Executing), "{id}: {progress:?}");
            if ends == 0 {
                // Still under way, and only the newest two can be.
                let flight = &rig.model.flight;
                let alive = flight.command.is_some_and(|c| c.id == id) || flight.waiting.is_some_and(|w| w.id == id);
                prop_assert!(alive, "{id} was lost: {progress:?}");
            }
        }
        prop_assert!(rig.now.as_seconds() > PERIOD_S);
    }
}
