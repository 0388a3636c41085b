//! The straight way: limits kept, continuous, exactly from and to its ends.

use super::*;
use proptest::prelude::*;

fn place() -> impl Strategy<Value = PositionNed> {
    (-500.0..500.0, -500.0..500.0, -100.0..0.0).prop_map(|(n, e, d)| PositionNed::new(n, e, d))
}

proptest! {
    #[test]
    fn limits_are_kept_and_the_motion_is_continuous(
        from in place(), to in place(), speed in 0.5..15.0, acceleration in 0.5..6.0, climb in 0.5..5.0, share in 0.0..1.0,
    ) {
        let limits = PathLimits { acceleration_m_s2: acceleration, climb_m_s: climb, descent_m_s: 1.5 };
        let way = GoTo::within(from, to, speed, &limits).unwrap();
        let t_s = share * way.duration_s();
        let (position, velocity, used, finished) = way.sample(t_s);
        prop_assert!(!finished);
        prop_assert!(velocity.norm() <= speed * (1.0 + 1e-9));
        prop_assert!(-velocity.down_m_s <= climb * (1.0 + 1e-9) && velocity.down_m_s <= 1.5 * (1.0 + 1e-9));
        prop_assert!(used.norm() <= acceleration * (1.0 + 1e-9));
        let step_s = 1e-4;
        let (next, next_velocity, ..) = way.sample(t_s + step_s);
        prop_assert!(((next.vector() - position.vector()) / step_s - velocity.vector()).norm() < 1e-2);
        prop_assert!((next_velocity.vector() - velocity.vector()).norm() <= acceleration * step_s * 1.01 + 1e-9);
        let (a, b) = (from.distance_m(&position), position.distance_m(&to));
        prop_assert!((a + b - from.distance_m(&to)).abs() < 1e-6, "it is off the straight line");
    }

    #[test]
    fn it_takes_as_long_as_a_trapezoid_does(from in place(), to in place(), speed in 0.5..15.0, acceleration in 0.5..6.0) {
        let way = GoTo::new(from, to, speed, acceleration).unwrap();
        let length_m = from.distance_m(&to);
        let expected_s = if length_m < speed * speed / acceleration {
            2.0 * (length_m / acceleration).sqrt()
        } else {
            length_m / speed + speed / acceleration
        };
        prop_assert!((way.duration_s() - expected_s).abs() < 1e-6 * (1.0 + expected_s));
        prop_assert_eq!(way.sample(0.0).0, from);
        prop_assert_eq!(way.sample(way.duration_s() + 1.0), (to, VelocityNed::default(), AccelerationNed::default(), true));
    }
}

#[test]
fn where_it_is_already_it_has_arrived() {
    let here = PositionNed::new(1.0, 2.0, -3.0);
    let way = GoTo::new(here, here, 5.0, 2.0).unwrap();
    assert_eq!(way.duration_s(), 0.0);
    assert_eq!(
        way.sample(0.0),
        (here, VelocityNed::default(), AccelerationNed::default(), true)
    );
}

#[test]
fn unusable_numbers_are_refused_and_odd_times_answered() {
    let here = PositionNed::default();
    let there = PositionNed::new(10.0, 0.0, 0.0);
    let odd = PositionNed::new(f64::NAN, 0.0, 0.0);
    assert_eq!(GoTo::new(odd, there, 5.0, 2.0), Err(RouteError::StartNotFinite));
    assert_eq!(
        GoTo::new(here, odd, 5.0, 2.0),
        Err(RouteError::WaypointNotFinite { index: 0 })
    );
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            GoTo::new(here, there, value, 2.0),
            Err(RouteError::InvalidLimit { limit: "speed_m_s", .. })
        ));
        assert!(matches!(
            GoTo::new(here, there, 5.0, value),
            Err(RouteError::InvalidLimit {
                limit: "acceleration_m_s2",
                ..
            })
        ));
    }
    let way = GoTo::new(here, there, 5.0, 2.0).unwrap();
    for t_s in [f64::NAN, -1.0, f64::NEG_INFINITY] {
        assert_eq!(way.sample(t_s).0, here);
    }
    assert!(way.sample(f64::INFINITY).3);
}
