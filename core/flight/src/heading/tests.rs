//! The heading: never faster than its limit, gentle, and it gets there.

use super::*;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

const DT_S: f64 = 0.02;

fn course(max_rate_rad_s: f64) -> FormationHeading {
    FormationHeading::Course { max_rate_rad_s }
}

proptest! {
    #[test]
    fn rate_and_its_change_are_never_over_their_limits(
        max_rate in 0.01..1.0,
        courses in prop::collection::vec((-10.0..10.0, 1_usize..200), 1..20),
        dt_s in 0.005..0.1,
    ) {
        let mut follower = HeadingFollower::new(course(max_rate), 0.3);
        let (mut heading, mut rate) = (0.3, 0.0);
        for (course_rad, steps) in courses {
            for _ in 0..steps {
                let (next, next_rate) = follower.step(course_rad, dt_s);
                let turned = wrap_angle_rad(next - heading);
                prop_assert!(turned.abs() <= max_rate * dt_s + 1e-12);
                prop_assert!((turned - next_rate * dt_s).abs() < 1e-9, "the rate is the one flown");
                let change: f64 = next_rate - rate;
                prop_assert!(change.abs() <= max_rate / RAMP_S * dt_s + 1e-12);
                prop_assert!(next.abs() <= PI);
                (heading, rate) = (next, next_rate);
            }
        }
    }

    #[test]
    fn it_arrives_without_going_past(from in -3.0..3.0_f64, to in -3.0..3.0_f64, max_rate in 0.05..1.0) {
        let mut follower = HeadingFollower::new(course(max_rate), from);
        let way = wrap_angle_rad(to - from);
        let steps = ((way.abs() / max_rate + 3.0 * RAMP_S) / DT_S) as usize;
        for _ in 0..steps {
            let (heading, _) = follower.step(to, DT_S);
            let left = wrap_angle_rad(to - heading);
            prop_assert!(left * way.signum() > -1e-3, "past it by {left}");
        }
        prop_assert!(wrap_angle_rad(to - follower.heading_rad()).abs() < 1e-6);
        prop_assert!(follower.rate_rad_s().abs() < 1e-6);
    }
}

#[test]
fn the_short_way_round_is_taken() {
    let mut follower = HeadingFollower::new(course(0.5), PI - 0.1);
    for _ in 0..50 {
        assert!(follower.step(-PI + 0.1, DT_S).1 >= 0.0);
    }
    assert!((follower.step(-PI + 0.1, DT_S).0.abs() - PI).abs() < 0.1);
}

#[test]
fn a_turning_course_is_followed_closely() {
    let mut follower = HeadingFollower::new(course(0.5), 0.0);
    for step in 0..1000 {
        let course_rad = 0.3 * DT_S * f64::from(step);
        let (heading, _) = follower.step(course_rad, DT_S);
        assert!(wrap_angle_rad(course_rad - heading).abs() < 0.3, "{step}");
    }
    assert!((follower.rate_rad_s() - 0.3).abs() < 0.01);
}

#[test]
fn a_fixed_heading_stays_whatever_the_course() {
    let mode = FormationHeading::Fixed {
        heading_rad: FRAC_PI_2,
        max_rate_rad_s: None,
    };
    let mut follower = HeadingFollower::new(mode, 0.0);
    assert_eq!(follower.step(3.0, DT_S), (FRAC_PI_2, 0.0));
    assert_eq!(follower.step(f64::NAN, DT_S), (FRAC_PI_2, 0.0));
}

#[test]
fn numbers_that_are_not_finite_change_nothing_for_the_worse() {
    let mut follower = HeadingFollower::new(course(0.5), f64::NAN);
    assert_eq!(follower.heading_rad(), 0.0);
    for _ in 0..100 {
        follower.step(1.0, DT_S);
    }
    let turning = follower;
    for (course_rad, dt_s) in [(1.0, f64::NAN), (1.0, 0.0), (1.0, -1.0), (1.0, f64::INFINITY)] {
        assert_eq!(
            follower.step(course_rad, dt_s),
            (turning.heading_rad(), turning.rate_rad_s())
        );
    }
    for _ in 0..1000 {
        follower.step(f64::NAN, DT_S);
    }
    assert!(follower.heading_rad().is_finite());
    assert!(follower.rate_rad_s().abs() < 1e-9);
    let mut unlimited = HeadingFollower::new(course(f64::NAN), 0.2);
    let (heading, rate) = unlimited.step(1.0, DT_S);
    assert!((heading - 0.2).abs() < 1e-12 && rate == 0.0);
}

#[test]
fn a_formation_that_flies_turns_to_a_fixed_heading_gently_and_no_faster_than_it_may() {
    let mode = FormationHeading::Fixed {
        heading_rad: FRAC_PI_2,
        max_rate_rad_s: Some(0.05),
    };
    // From a turn that was faster.
    let mut follower = HeadingFollower::resume(mode, 0.0, 0.2);
    let (mut last, mut fastest) = (0.2, 0.0_f64);
    for step in 0..(60.0 / DT_S) as u32 {
        let (_, rate) = follower.step(f64::NAN, DT_S);
        assert!(
            (rate - last).abs() <= 0.2 / RAMP_S * DT_S + 1e-9,
            "{step}: {last} to {rate}"
        );
        last = rate;
        if f64::from(step) * DT_S > 2.0 * RAMP_S {
            fastest = fastest.max(rate.abs());
        }
    }
    assert!(fastest <= 0.05 + 1e-12 && fastest > 0.049, "{fastest}");
    assert!((follower.heading_rad() - FRAC_PI_2).abs() < 1e-3 && last.abs() < 1e-4);
}
