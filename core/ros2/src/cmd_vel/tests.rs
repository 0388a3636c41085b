//! A velocity is flown while it is repeated, ends when it is not, and never takes a vehicle back from somebody else.

use super::*;
use proptest::prelude::*;

fn forward(x: f64) -> Twist {
    Twist {
        linear: Vector3 { x, y: 0.0, z: 0.0 },
        ..Twist::default()
    }
}

/// A vehicle that looks east.
fn at(east_m: f64) -> VehicleKinematics {
    VehicleKinematics {
        position: PositionNed::new(0.0, east_m, -10.0),
        yaw_rad: std::f64::consts::FRAC_PI_2,
        ..VehicleKinematics::default()
    }
}

fn goal_of(order: Order) -> (PositionNed, f64) {
    match order {
        Order::Give(VehicleCommand::GoTo {
            position, speed_m_s, ..
        }) => (position, speed_m_s.expect("a speed")),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_velocity_becomes_a_way_ahead_and_a_hold_when_it_expires() {
    let mut steering = Steering::new(0.5, 12.0);
    assert_eq!(steering.decide(Some(&at(0.0)), 0.0), Order::Nothing);
    steering.take(&forward(2.0), 0.0);
    let (goal, speed_m_s) = goal_of(steering.decide(Some(&at(0.0)), 0.0));
    assert!(
        (goal.east_m - 10.0).abs() < 1e-9 && goal.north_m.abs() < 1e-9 && goal.down_m == -10.0,
        "{goal:?}"
    );
    assert!((speed_m_s - 2.0).abs() < 1e-9);
    // Repeated: nothing new before the way comes to its end.
    for step in 1..20 {
        let now_s = f64::from(step) * 0.1;
        steering.take(&forward(2.0), now_s);
        assert_eq!(
            steering.decide(Some(&at(2.0 * now_s)), now_s),
            Order::Nothing,
            "{now_s}"
        );
    }
    steering.take(&forward(2.0), 2.6);
    let (goal, _) = goal_of(steering.decide(Some(&at(5.2)), 2.6));
    assert!((goal.east_m - 15.2).abs() < 1e-9);
    // Not repeated any more.
    assert_eq!(steering.decide(Some(&at(6.2)), 3.0), Order::Nothing);
    assert_eq!(steering.decide(Some(&at(6.5)), 3.2), Order::Give(VehicleCommand::Hold));
    assert_eq!(steering.decide(Some(&at(6.6)), 3.3), Order::Nothing);
    assert!(!steering.is_engaged());
}

#[test]
fn another_direction_is_taken_up_but_not_more_often_than_twice_a_second() {
    let mut steering = Steering::new(0.5, 12.0);
    let mut orders = 0;
    for step in 0..50 {
        let now_s = f64::from(step) * 0.02;
        steering.take(&forward(1.0 + f64::from(step % 2)), now_s);
        orders += usize::from(steering.decide(Some(&at(0.0)), now_s) != Order::Nothing);
    }
    assert_eq!(orders, 2);
}

#[test]
fn no_velocity_stops_at_once() {
    let mut steering = Steering::new(0.5, 12.0);
    steering.take(&forward(0.0), 0.0);
    assert_eq!(
        steering.decide(Some(&at(0.0)), 0.0),
        Order::Nothing,
        "who does not move is not stopped"
    );
    steering.take(&forward(1.0), 0.1);
    goal_of(steering.decide(Some(&at(0.0)), 0.1));
    steering.take(&forward(0.0), 0.2);
    assert_eq!(steering.decide(Some(&at(0.0)), 0.2), Order::Give(VehicleCommand::Hold));
}

#[test]
fn who_commands_otherwise_keeps_the_vehicle_until_it_was_silent_here() {
    let mut steering = Steering::new(0.5, 12.0);
    steering.take(&forward(1.0), 0.0);
    goal_of(steering.decide(Some(&at(0.0)), 0.0));
    steering.taken_over("land", 0.2);
    for step in 3..30 {
        let now_s = f64::from(step) * 0.1;
        steering.take(&forward(1.0), now_s);
        assert_eq!(steering.decide(Some(&at(0.0)), now_s), Order::Nothing, "{now_s}");
    }
    assert_eq!(steering.report().reason, "taken over: land");
    assert_eq!(steering.report().refused, 27);
    steering.take(&forward(1.0), 4.0);
    goal_of(steering.decide(Some(&at(0.0)), 4.0));
}

#[test]
fn a_refusal_is_told_and_not_asked_again_at_once() {
    let mut steering = Steering::new(0.5, 12.0);
    steering.take(&forward(20.0), 0.0);
    assert_eq!(steering.decide(Some(&at(0.0)), 0.0), Order::Nothing);
    assert!(
        steering.report().reason.starts_with("too_fast"),
        "{:?}",
        steering.report()
    );
    steering.take(&forward(1.0), 1.0);
    goal_of(steering.decide(Some(&at(0.0)), 1.0));
    steering.refused(&Refusal::PilotInControl, 1.0);
    steering.take(&forward(1.0), 1.4);
    assert_eq!(steering.decide(Some(&at(0.0)), 1.6), Order::Nothing);
    steering.take(&forward(1.0), 2.0);
    goal_of(steering.decide(Some(&at(0.0)), 2.1));
}

fn any_twist() -> impl Strategy<Value = Twist> {
    let number = || prop_oneof![any::<f64>(), Just(f64::NAN), Just(1e308), -15.0..15.0f64, Just(0.0)];
    (number(), number(), number(), prop_oneof![Just(0.0), any::<f64>()]).prop_map(|(x, y, z, rate)| Twist {
        linear: Vector3 { x, y, z },
        angular: Vector3 {
            x: 0.0,
            y: 0.0,
            z: rate,
        },
    })
}

proptest! {
    /// Whatever comes in: every way is finite, slow enough and near, and after silence the vehicle holds.
    #[test]
    fn whatever_comes_in_is_bounded(twists in proptest::collection::vec((any_twist(), 0.0..0.3f64), 1..80)) {
        let (mut steering, mut now_s, mut orders) = (Steering::new(0.5, 12.0), 0.0, 0u32);
        for (twist, step_s) in twists {
            now_s += step_s;
            steering.take(&twist, now_s);
            if let Order::Give(command) = steering.decide(Some(&at(0.0)), now_s) {
                orders += 1;
                if let VehicleCommand::GoTo { position, speed_m_s, .. } = command {
                    prop_assert!(position.distance_m(&at(0.0).position) <= 12.0 * AHEAD_S + 1e-6);
                    prop_assert!(speed_m_s.is_some_and(|speed| speed > 0.0 && speed <= 12.0 + 1e-9));
                }
            }
        }
        prop_assert!(f64::from(orders) <= 2.0 * (now_s / SOONEST_S + 2.0));
        let was_engaged = steering.is_engaged();
        let last = steering.decide(Some(&at(0.0)), now_s + 0.6);
        let expected = if was_engaged { Order::Give(VehicleCommand::Hold) } else { Order::Nothing };
        prop_assert_eq!(last, expected);
    }
}
