//! A velocity is flown while it is repeated, ends when it is not, and never takes a vehicle back from somebody else.

use super::*;
use crate::interfaces::geometry::Vector3;
use proptest::prelude::*;
use skein_domain::FlightState;

fn forward(x: f64) -> Twist {
    Twist {
        linear: Vector3 { x, y: 0.0, z: 0.0 },
        ..Twist::default()
    }
}

fn moved(order: Order) -> Stick {
    match order {
        Order::Move(stick) => stick,
        other => panic!("{other:?}"),
    }
}

/// Flown forward at 1 m/s since zero.
fn engaged() -> Steering {
    let mut steering = Steering::new(0.5, 12.0);
    steering.take(&forward(1.0), 0.0);
    assert_eq!(steering.decide(0.0), Order::Begin);
    assert_eq!(moved(steering.decide(0.05)).forward_m_s, 1.0);
    steering
}

#[test]
fn a_velocity_is_flown_while_it_is_repeated_and_becomes_a_hold_when_it_expires() {
    let mut steering = Steering::new(0.5, 12.0);
    assert_eq!(steering.decide(0.0), Order::Nothing);
    steering.take(&forward(2.0), 0.0);
    assert_eq!(steering.decide(0.0), Order::Begin);
    for step in 1..40 {
        let now_s = f64::from(step) * 0.1;
        steering.take(&forward(2.0), now_s);
        assert_eq!(moved(steering.decide(now_s)).forward_m_s, 2.0, "{now_s}");
    }
    // Not repeated any more: good for half a second.
    assert_eq!(moved(steering.decide(4.3)).forward_m_s, 2.0);
    assert_eq!(steering.decide(4.5), Order::Stop);
    assert_eq!(steering.decide(4.6), Order::Nothing);
    assert!(!steering.is_engaged());
    assert_eq!(steering.report().reason, "no velocity for 0.5 s");
}

#[test]
fn a_velocity_that_changes_all_the_time_is_flown_as_it_changes() {
    let mut steering = engaged();
    for step in 1..50 {
        let now_s = 0.1 + f64::from(step) * 0.02;
        let wanted = 1.0 + f64::from(step % 5);
        steering.take(&forward(wanted), now_s);
        assert_eq!(moved(steering.decide(now_s)).forward_m_s, wanted);
    }
}

#[test]
fn left_is_against_right_and_turning_too() {
    let mut steering = Steering::new(0.5, 12.0);
    let twist = Twist {
        linear: Vector3 { x: 0.0, y: 1.0, z: 0.5 },
        angular: Vector3 { x: 0.0, y: 0.0, z: 0.3 },
    };
    steering.take(&twist, 0.0);
    assert_eq!(steering.decide(0.0), Order::Begin);
    let expected = Stick {
        forward_m_s: 0.0,
        right_m_s: -1.0,
        up_m_s: 0.5,
        yaw_rate_rad_s: -0.3,
    };
    assert_eq!(steering.decide(0.1), Order::Move(expected));
    // Turning alone is something too.
    let mut steering = Steering::new(0.5, 12.0);
    steering.take(
        &Twist {
            linear: Vector3::default(),
            ..twist
        },
        0.0,
    );
    assert_eq!(steering.decide(0.0), Order::Begin);
}

#[test]
fn no_velocity_stops_at_once_and_moves_nobody() {
    let mut steering = Steering::new(0.5, 12.0);
    steering.take(&forward(0.0), 0.0);
    assert_eq!(steering.decide(0.0), Order::Nothing, "who does not move is not stopped");
    let mut steering = engaged();
    steering.take(&forward(0.0), 0.2);
    assert_eq!(
        steering.decide(0.2),
        Order::Move(Stick {
            right_m_s: -0.0,
            yaw_rate_rad_s: -0.0,
            ..Stick::default()
        })
    );
    // Repeated it goes on; ended it holds.
    assert!(steering.is_engaged());
    assert_eq!(steering.decide(0.8), Order::Stop);
}

#[test]
fn who_commands_otherwise_keeps_the_vehicle_until_it_was_silent_here() {
    let mut steering = engaged();
    steering.taken_over("land", 0.2);
    for step in 3..30 {
        let now_s = f64::from(step) * 0.1;
        steering.take(&forward(1.0), now_s);
        assert_eq!(steering.decide(now_s), Order::Nothing, "{now_s}");
    }
    assert_eq!(steering.report().reason, "taken over: land");
    assert_eq!(steering.report().refused, 27);
    steering.take(&forward(1.0), 4.0);
    assert_eq!(steering.decide(4.0), Order::Begin);
}

#[test]
fn a_stick_that_is_refused_means_that_somebody_else_has_the_vehicle_though_nobody_said_so() {
    let landing = Refusal::WrongState {
        state: FlightState::Landing,
        command: "steer".to_owned(),
    };
    let mut steering = engaged();
    steering.stick_refused(&landing, 0.2);
    // What tells of the other's command comes later, and the program goes on all the time.
    steering.taken_over("land", 0.21);
    for step in 3..60 {
        let now_s = f64::from(step) * 0.1;
        steering.take(&forward(1.0), now_s);
        assert_eq!(steering.decide(now_s), Order::Nothing, "{now_s}");
    }
    assert!(steering.report().reason.starts_with("wrong_state"));
    steering.take(&forward(1.0), 7.0);
    assert_eq!(steering.decide(7.0), Order::Begin);
}

#[test]
fn what_passes_by_itself_does_not_end_it() {
    let mut steering = engaged();
    let late = Refusal::TimedOut {
        what: "a stick on its way".to_owned(),
        after_s: 0.7,
    };
    steering.stick_refused(&late, 0.2);
    assert_eq!(moved(steering.decide(0.25)).forward_m_s, 1.0);
    assert_eq!(steering.report().refused, 1);
}

#[test]
fn no_velocity_takes_the_vehicle_from_a_pilot() {
    // One that came before the pilot was seen, and one that begins in his flight.
    for mut steering in [engaged(), Steering::new(0.5, 12.0)] {
        for step in 2..60 {
            let now_s = f64::from(step) * 0.1;
            if !(20..40).contains(&step) {
                steering.take(&forward(1.0), now_s);
            }
            steering.leave_to_pilot(now_s);
            assert_eq!(steering.decide(now_s), Order::Nothing, "{now_s}");
        }
        assert!(steering.report().reason.starts_with("pilot_in_control"));
        // Nor when an operator has it back, but for a velocity that begins after that.
        steering.take(&forward(1.0), 6.0);
        assert_eq!(steering.decide(6.0), Order::Nothing);
        steering.take(&forward(1.0), 7.0);
        assert_eq!(steering.decide(7.0), Order::Begin);
    }
}

#[test]
fn a_refusal_is_told_and_not_asked_again_at_once() {
    let mut steering = Steering::new(0.5, 12.0);
    steering.take(&forward(20.0), 0.0);
    assert_eq!(steering.decide(0.0), Order::Nothing);
    assert!(
        steering.report().reason.starts_with("too_fast"),
        "{:?}",
        steering.report()
    );
    steering.take(&forward(1.0), 1.0);
    assert_eq!(steering.decide(1.0), Order::Begin);
    steering.refused(&Refusal::PilotInControl, 1.0);
    steering.take(&forward(1.0), 1.4);
    assert_eq!(steering.decide(1.6), Order::Nothing);
    steering.take(&forward(1.0), 2.0);
    assert_eq!(steering.decide(2.1), Order::Begin);
}

fn any_twist() -> impl Strategy<Value = Twist> {
    let number = || prop_oneof![any::<f64>(), Just(f64::NAN), Just(1e308), -15.0..15.0f64, Just(0.0)];
    (
        number(),
        number(),
        number(),
        prop_oneof![Just(0.0), any::<f64>(), -3.0..3.0f64],
    )
        .prop_map(|(x, y, z, rate)| Twist {
            linear: Vector3 { x, y, z },
            angular: Vector3 {
                x: 0.0,
                y: 0.0,
                z: rate,
            },
        })
}

proptest! {
    /// Whatever comes in: every stick is finite and slow enough, none comes before the vehicle is asked, and after silence it holds.
    #[test]
    fn whatever_comes_in_is_bounded(twists in proptest::collection::vec((any_twist(), 0.0..0.3f64), 1..80)) {
        let (mut steering, mut now_s) = (Steering::new(0.5, 12.0), 0.0);
        for (twist, step_s) in twists {
            now_s += step_s;
            steering.take(&twist, now_s);
            let was_engaged = steering.is_engaged();
            match steering.decide(now_s) {
                Order::Move(stick) => {
                    prop_assert!(was_engaged && stick.check().is_ok());
                    prop_assert!(stick.forward_m_s.hypot(stick.right_m_s).hypot(stick.up_m_s) <= 12.0);
                }
                Order::Begin => prop_assert!(!was_engaged && steering.is_engaged()),
                Order::Stop => prop_assert!(was_engaged && !steering.is_engaged()),
                Order::Nothing => prop_assert!(!was_engaged),
            }
        }
        let was_engaged = steering.is_engaged();
        let expected = if was_engaged { Order::Stop } else { Order::Nothing };
        prop_assert_eq!(steering.decide(now_s + 0.6), expected);
    }
}
