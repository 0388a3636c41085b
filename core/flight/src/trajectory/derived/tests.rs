//! What is left of a trajectory is the same way at the same times.

use super::*;
use crate::trajectory::{MotionState, Smoothness, check, min_distance_m, plan, sample};
use skein_domain::FlightLimits;

fn way() -> Trajectory {
    let limits = FlightLimits {
        max_speed_m_s: 6.0,
        max_climb_m_s: 2.0,
        max_descent_m_s: 1.5,
        max_acceleration_m_s2: 3.0,
        min_turn_radius_m: 0.0,
        endurance_s: None,
        keeps_view: false,
    };
    let waypoints = [
        PositionNed::new(30.0, 5.0, -12.0),
        PositionNed::new(45.0, -20.0, -9.0),
        PositionNed::new(0.0, -30.0, -10.0),
    ];
    let from = MotionState::at_rest(PositionNed::new(1.0, 2.0, -10.0));
    plan(from, &waypoints, &limits, NodeTime::from_seconds(5.0), Smoothness::Snap).unwrap()
}

#[test]
fn the_rest_is_the_same_way_at_the_same_times() {
    let whole = way();
    let takes_s = duration_s(&whole);
    for gone in [-3.0, 0.0, 0.3 * takes_s, 0.71 * takes_s, takes_s + 2.0] {
        let from = whole.start.plus_seconds(gone);
        let rest = rest(&whole, from);
        check(&rest).unwrap();
        for step in 0..60 {
            let now = from.plus_seconds(f64::from(step) * 0.5);
            let (a, b) = (sample(&whole, now), sample(&rest, now));
            let off_m = a.position.distance_m(&b.position);
            let off_m_s = (a.velocity.vector() - b.velocity.vector()).norm();
            assert!(off_m < 1e-6 && off_m_s < 1e-6, "{gone}: {off_m} m, {off_m_s} m/s");
        }
    }
}

#[test]
fn who_has_passed_is_not_met_any_more() {
    let whole = way();
    // It stands where the way begins, which is free again after a while.
    let start = sample(&whole, whole.start).position;
    let late = whole.start.plus_seconds(0.6 * duration_s(&whole));
    assert!(min_distance_m(&whole, &standing(start, whole.start)) < 0.01);
    assert!(min_distance_m(&rest(&whole, late), &standing(start, late)) > 5.0);
}

#[test]
fn heights_count_by_the_factor() {
    let at = |down_m: f64| standing(PositionNed::new(0.0, 0.0, down_m), NodeTime::default());
    let scaled = |t: &Trajectory| with_heights_scaled(t, 0.5);
    let distance_m = min_distance_m(&scaled(&at(-4.0)), &scaled(&at(-10.0)));
    assert!((distance_m - 3.0).abs() < 0.01, "{distance_m}");
}

#[test]
fn the_length_is_that_of_the_way() {
    let limits = FlightLimits {
        max_speed_m_s: 6.0,
        max_climb_m_s: 2.0,
        max_descent_m_s: 1.5,
        max_acceleration_m_s2: 3.0,
        min_turn_radius_m: 0.0,
        endurance_s: None,
        keeps_view: false,
    };
    let from = MotionState::at_rest(PositionNed::default());
    let straight = plan(
        from,
        &[PositionNed::new(30.0, 40.0, 0.0)],
        &limits,
        NodeTime::default(),
        Smoothness::Jerk,
    );
    assert!((length_m(&straight.unwrap(), 0.1) - 50.0).abs() < 1e-6);
    assert!((length_m(&standing(PositionNed::default(), NodeTime::default()), 0.1)).abs() < 1e-12);
}
