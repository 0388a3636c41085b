//! The reference follows a goal without a jump, within the limits, and comes to it.

use super::{Goal, step};
use crate::Settings;
use crate::blend::Motion;
use crate::tests::rig::{Rig, create};
use proptest::prelude::*;
use skein_domain::payload::Target;
use skein_domain::{FlightState, NodeTime, PositionNed, Refusal, VehicleCommand, VelocityNed};

const DT_S: f64 = 0.02;

fn observe() -> VehicleCommand {
    VehicleCommand::Observe {
        target: Target::Place {
            position: PositionNed::default(),
        },
        stand_off_m: None,
        height_m: None,
        bearing_rad: None,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn it_comes_to_a_goal_in_steady_motion_within_the_limits(
        from in (-80.0..80.0f64, -80.0..80.0f64, -30.0..-2.0f64),
        start in (-5.0..5.0f64, -5.0..5.0f64, -1.0..1.0f64),
        moving in (-3.5..3.5f64, -3.5..3.5f64),
    ) {
        let settings = Settings::default();
        let goal = Goal {
            position: PositionNed::new(0.0, 0.0, -10.0),
            velocity: VelocityNed::new(moving.0, moving.1, 0.0),
            time: NodeTime(0),
            speed_m_s: 8.0,
        };
        let mut have = Motion {
            position: PositionNed::new(from.0, from.1, from.2),
            velocity: VelocityNed::new(start.0, start.1, start.2),
            ..Motion::default()
        };
        for period in 0..4_000 {
            let now = NodeTime::from_seconds(f64::from(period) * DT_S);
            // As it is told anew, period by period.
            let told = Goal { position: goal.position.after(&goal.velocity, now.as_seconds()), time: now, ..goal };
            let next = step(&have, Some(&told), now, DT_S, &settings);
            prop_assert!(next.acceleration.norm() <= settings.acceleration_m_s2 + 1e-9);
            prop_assert!(next.velocity.vector().xy().norm() <= 8.0 + 1e-6);
            let mean = (have.velocity.vector() + next.velocity.vector()) / 2.0;
            let jump_m = (next.position.vector() - have.position.vector() - mean * DT_S).norm();
            prop_assert!(jump_m < 1e-6, "{}", jump_m);
            have = next;
        }
        let end = goal.position.after(&goal.velocity, 4_000.0 * DT_S);
        prop_assert!(have.position.distance_m(&end) < 0.2, "{:?} is not at {:?}", have, end);
    }
}

#[test]
fn without_a_goal_it_brakes_and_stands() {
    let settings = Settings::default();
    let mut have = Motion {
        velocity: VelocityNed::new(6.0, 0.0, 0.0),
        ..Motion::default()
    };
    for _ in 0..500 {
        have = step(&have, None, NodeTime(0), DT_S, &settings);
    }
    assert!(have.velocity.norm() < 1e-3);
    // 9 m at full braking; the last of it fades out.
    assert!((8.9..12.0).contains(&have.position.north_m), "{have:?}");
}

#[test]
fn only_a_model_that_guides_takes_the_command() {
    let mut rig = Rig::holding(5.0);
    let id = rig.command(observe());
    rig.tick();
    assert!(matches!(rig.refusal(id), Some(Refusal::NotSupported { .. })));
}

#[test]
fn a_guided_flight_goes_where_it_is_told_and_ends_with_any_other() {
    let mut rig = Rig::holding(5.0);
    rig.model = create(Some(skein_plugin_sdk::UavModel::snapshot(&rig.model)), 2, rig.now).with_guidance();
    let id = rig.command(observe());
    rig.tick();
    assert_eq!(rig.model.guided().map(|(by, _)| by), Some(id));
    assert_eq!(rig.state, FlightState::GoingTo);
    let goal = Goal {
        position: PositionNed::new(40.0, 0.0, -12.0),
        velocity: VelocityNed::default(),
        time: rig.now,
        speed_m_s: 6.0,
    };
    rig.model.guide(Some(goal));
    rig.run(20.0);
    assert!(rig.here().distance_m(&goal.position) < 0.3, "{:?}", rig.here());
    rig.model.guided_command_done(&mut skein_plugin_sdk::Effects::default());
    rig.command(VehicleCommand::Hold);
    rig.run(2.0);
    assert_eq!(rig.model.guided(), None);
    assert_eq!(rig.state, FlightState::Holding);
}

#[test]
fn what_the_gate_holds_back_is_tried_again_from_where_the_vehicle_is() {
    let mut rig = Rig::holding(5.0);
    rig.model = create(Some(skein_plugin_sdk::UavModel::snapshot(&rig.model)), 2, rig.now).with_guidance();
    rig.command(observe());
    rig.tick();
    let goal = Goal {
        position: PositionNed::new(60.0, 0.0, -8.0),
        velocity: VelocityNed::default(),
        time: rig.now,
        speed_m_s: 6.0,
    };
    rig.model.guide(Some(goal));
    rig.run(3.0);
    rig.gate = Some(Refusal::TooFast {
        speed_m_s: 9.0,
        limit_m_s: 8.0,
    });
    rig.run(4.0);
    rig.gate = None;
    let before = rig.now;
    rig.run(20.0);
    assert!(rig.here().distance_m(&goal.position) < 0.3, "{:?}", rig.here());
    rig.assert_no_jump_since(before.plus_seconds(0.5));
}
