//! Trajectories: what is promised of them, over many seeded cases.

mod cases;

use super::sampling::at;
use super::*;
use cases::{journeys, limits, moving_start, place};
use proptest::prelude::*;

const START: NodeTime = NodeTime(5_000_000);

fn both() -> impl Strategy<Value = Smoothness> {
    prop_oneof![Just(Smoothness::Jerk), Just(Smoothness::Snap)]
}

/// Sampled closely, with the ends of the pieces.
fn times(trajectory: &Trajectory) -> Vec<f64> {
    // Piece by piece: a short one beside a long one has its peaks too.
    let mut began = 0.0;
    let mut all = Vec::new();
    for piece in &trajectory.pieces {
        all.extend((0..=400).map(|i| began + piece.duration_s * f64::from(i) / 400.0));
        began += piece.duration_s;
    }
    all
}

fn assert_within(trajectory: &Trajectory, limits: &FlightLimits, slack: f64) {
    for t in times(trajectory) {
        let s = at(trajectory, t);
        let v = s.velocity;
        let within = |value: f64, limit: f64| value <= limit * (1.0 + slack) + 1e-9;
        assert!(
            within(v.vector().xy().norm(), limits.max_speed_m_s),
            "speed {v:?} at {t} s"
        );
        assert!(within(-v.down_m_s, limits.max_climb_m_s), "climb {v:?} at {t} s");
        assert!(within(v.down_m_s, limits.max_descent_m_s), "descent {v:?} at {t} s");
        assert!(
            within(s.acceleration.norm(), limits.max_acceleration_m_s2),
            "acceleration {:?} at {t} s",
            s.acceleration
        );
    }
}

fn assert_continuous(trajectory: &Trajectory) {
    let mut at_s = 0.0;
    for pair in trajectory.pieces.windows(2) {
        at_s += pair[0].duration_s;
        let (before, after) = (
            sampling::piece_at(&pair[0], pair[0].duration_s),
            sampling::piece_at(&pair[1], 0.0),
        );
        for (k, size) in [(0, 1e-6), (1, 1e-6), (2, 1e-5)] {
            let off = (before[k] - after[k]).norm();
            assert!(
                off < size * (1.0 + before[k].norm()),
                "derivative {k} jumps by {off} at {at_s} s"
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn they_pass_their_waypoints_in_step_within_the_limits(journeys in journeys(1..6, 1..8), smoothness in both()) {
        let plan = plan_together(&journeys, START, smoothness).expect("can be flown");
        for (journey, trajectory) in journeys.iter().zip(&plan.trajectories) {
            prop_assert_eq!(check(trajectory), Ok(()));
            prop_assert_eq!(trajectory.start, START);
            for (waypoint, passed_s) in journey.waypoints.iter().zip(&plan.passes_s) {
                let there = at(trajectory, passed_s - 1e-9).position;
                prop_assert!(there.distance_m(waypoint) < 1e-3, "{there:?} is not {waypoint:?}");
            }
            let first = at(trajectory, 0.0);
            prop_assert!((first.velocity.vector() - journey.start.velocity.vector()).norm() < 1e-6);
            prop_assert!((first.acceleration.vector() - journey.start.acceleration.vector()).norm() < 1e-6);
            let last = sample(trajectory, NodeTime(u64::MAX));
            prop_assert!(last.finished && last.velocity.norm() == 0.0);
            assert_continuous(trajectory);
            assert_within(trajectory, &journey.limits, 1e-9);
        }
    }

    #[test]
    fn starts_in_flight_are_taken_over(journey in moving_start(), smoothness in both()) {
        match plan(journey.start, &journey.waypoints, &journey.limits, START, smoothness) {
            Ok(trajectory) => {
                let first = sample(&trajectory, START);
                prop_assert!((first.velocity.vector() - journey.start.velocity.vector()).norm() < 1e-6);
                prop_assert!((first.acceleration.vector() - journey.start.acceleration.vector()).norm() < 1e-6);
                assert_continuous(&trajectory);
                assert_within(&trajectory, &journey.limits, 1.2e-3);
            }
            Err(why) => prop_assert_eq!(why, TrajectoryError::StartBeyondLimits { index: 0 }),
        }
    }

    #[test]
    fn peaks_are_bounds_and_near(journeys in journeys(1..2, 1..6), smoothness in both()) {
        let plan = plan_together(&journeys, START, smoothness).expect("can be flown");
        let bounds = peaks(&plan.trajectories[0]).expect("well formed");
        let seen = times(&plan.trajectories[0]).into_iter().map(|t| at(&plan.trajectories[0], t));
        let (mut speed, mut acceleration) = (0.0_f64, 0.0_f64);
        for s in seen {
            speed = speed.max(s.velocity.vector().xy().norm());
            acceleration = acceleration.max(s.acceleration.norm());
        }
        prop_assert!(speed <= bounds.speed_m_s + 1e-9 && bounds.speed_m_s <= speed * 1.005 + 1e-6, "{speed} {bounds:?}");
        prop_assert!(acceleration <= bounds.acceleration_m_s2 + 1e-9);
        prop_assert!(bounds.acceleration_m_s2 <= acceleration * 1.02 + 1e-6, "{acceleration} {bounds:?}");
    }

    #[test]
    fn the_smallest_distance_is_a_bound_and_near(journeys in journeys(2..5, 1..6), later_s in 0.0..20.0) {
        let mut plan = plan_together(&journeys, START, Smoothness::Jerk).expect("can be flown");
        plan.trajectories[0].start = START.plus_seconds(later_s);
        let mut nearest = f64::INFINITY;
        let mut pairs = f64::INFINITY;
        for (j, one) in plan.trajectories.iter().enumerate() {
            for other in &plan.trajectories[..j] {
                pairs = pairs.min(min_distance_m(one, other));
                for i in 0..4_000 {
                    let now = START.plus_seconds((plan.duration_s() + later_s) * f64::from(i) / 3_999.0);
                    nearest = nearest.min(sample(one, now).position.distance_m(&sample(other, now).position));
                }
            }
        }
        let (bound, _) = distance::nearest(&plan.trajectories);
        prop_assert!((bound - pairs).abs() < 0.003, "{bound} {pairs}");
        prop_assert!(bound <= nearest + 1e-9, "{bound} is no bound of {nearest}");
        let between_samples_m = (plan.duration_s() + later_s) / 3_999.0 * 25.0;
        prop_assert!(bound > nearest - 0.01 - between_samples_m, "{bound} is far below {nearest}");
    }

    #[test]
    fn uploaded_legs_stay_near(journeys in journeys(1..2, 1..6), tolerance in 0.1..3.0) {
        let plan = plan_together(&journeys, START, Smoothness::Jerk).expect("can be flown");
        let trajectory = &plan.trajectories[0];
        let list = to_waypoints(trajectory, tolerance).expect("well formed");
        let mut from = (journeys[0].start.position, 0.0);
        for to in &list {
            let leg_s = to.passed_s - from.1;
            prop_assert!(at(trajectory, to.passed_s - 1e-9).position.distance_m(&to.position) < 1e-3);
            prop_assert!((to.speed_m_s * leg_s - from.0.distance_m(&to.position)).abs() < 1e-6);
            for i in 0..8 {
                let p = at(trajectory, from.1 + leg_s * f64::from(i) / 8.0).position;
                let leg = to.position.vector() - from.0.vector();
                let share = ((p.vector() - from.0.vector()).dot(&leg) / leg.norm_squared().max(1e-12)).clamp(0.0, 1.0);
                let off = (p.vector() - from.0.vector() - leg * share).norm();
                prop_assert!(off <= tolerance + 1e-6, "{off} m off");
            }
            from = (to.position, to.passed_s);
        }
        prop_assert!(from.0.distance_m(journeys[0].waypoints.last().expect("has one")) < 1e-3);
        prop_assert!((from.1 - plan.duration_s()).abs() < 1e-6);
    }

    #[test]
    fn nothing_panics_on_numbers_that_are_none(
        values in prop::collection::vec(prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::MAX), Just(0.0), -10.0..10.0], 24),
        smoothness in both(),
    ) {
        let v = |i: usize| values[i];
        let start = MotionState {
            position: PositionNed::new(v(0), v(1), v(2)),
            velocity: VelocityNed::new(v(3), v(4), v(5)),
            acceleration: AccelerationNed::new(v(6), v(7), v(8)),
        };
        let limits = FlightLimits { max_speed_m_s: v(9), max_climb_m_s: v(10), max_descent_m_s: v(11), ..limits(v(12), 1.0) };
        let waypoints = [PositionNed::new(v(13), v(14), v(15)), PositionNed::new(v(16), v(17), v(18))];
        if let Ok(trajectory) = plan(start, &waypoints, &limits, START, smoothness) {
            prop_assert_eq!(check(&trajectory), Ok(()));
        }
        let axis = |i: usize| values[i..i + 4].to_vec();
        let piece = skein_domain::TrajectoryPiece { duration_s: v(23), north: axis(0), east: axis(4), down: axis(8) };
        let wild = Trajectory { start: START, pieces: vec![piece.clone(), piece], yaw_rad: Some(v(22)) };
        let _ = (sample(&wild, NodeTime(9_000_000)), peaks(&wild), to_waypoints(&wild, v(21)), min_distance_m(&wild, &wild));
    }
}

/// Twice the distances and twice the speeds take the same time: the plan depends on nothing but the shape.
#[test]
fn time_scales_with_the_limits() {
    let waypoints = [place(40.0, 0.0, 0.0), place(40.0, 30.0, -5.0), place(0.0, 30.0, 0.0)];
    let start = MotionState::at_rest(place(0.0, 0.0, 0.0));
    let slow = plan(start, &waypoints, &limits(4.0, 2.0), START, Smoothness::Snap).expect("can be flown");
    let slower = FlightLimits {
        max_speed_m_s: 2.0,
        max_climb_m_s: 1.0,
        max_descent_m_s: 0.5,
        max_acceleration_m_s2: 0.5,
        ..limits(4.0, 2.0)
    };
    let fast = FlightLimits {
        max_speed_m_s: 4.0,
        max_climb_m_s: 2.0,
        max_descent_m_s: 1.0,
        ..slower
    };
    let fast = FlightLimits {
        max_acceleration_m_s2: 2.0,
        ..fast
    };
    let (a, b) = (
        plan(start, &waypoints, &slower, START, Smoothness::Snap).expect("can be flown"),
        plan(start, &waypoints, &fast, START, Smoothness::Snap).expect("can be flown"),
    );
    let ratio = duration_s(&a) / duration_s(&b);
    assert!((ratio - 2.0).abs() < 0.01, "{ratio}");
    assert!(duration_s(&slow) < duration_s(&a));
}

#[test]
fn a_straight_flight_is_the_minimum_jerk_one() {
    // Peak speed 15/8 of the mean, peak acceleration 10/√3 d/T² (Flash & Hogan 1985).
    let start = MotionState::at_rest(place(0.0, 0.0, 0.0));
    let fast = limits(1_000.0, 2.0);
    let way = plan(start, &[place(50.0, 0.0, 0.0)], &fast, START, Smoothness::Jerk).expect("can be flown");
    let expected_s = (10.0 / 3.0_f64.sqrt() * 50.0 / 2.0).sqrt();
    assert!(
        (duration_s(&way) / expected_s - 1.0).abs() < 2e-3,
        "{} {expected_s}",
        duration_s(&way)
    );
    let middle = at(&way, duration_s(&way) / 2.0);
    assert!((middle.velocity.north_m_s - 15.0 / 8.0 * 50.0 / duration_s(&way)).abs() < 1e-6);
    assert!(middle.acceleration.norm() < 1e-6 && (middle.position.north_m - 25.0).abs() < 1e-6);
}

/// No other spline through the same places at the same times, with the same ends, costs less.
#[test]
fn nothing_is_smoother() {
    let basis = spline::Basis::new(Smoothness::Jerk).expect("there is one");
    let begin = spline::Begin {
        position: place(0.0, 0.0, 0.0).vector(),
        velocity: [1.0, 0.0, 0.0].into(),
        acceleration: Default::default(),
    };
    let places = [[10.0, 3.0, 0.0], [15.0, 9.0, -2.0], [4.0, 12.0, 0.0]].map(nalgebra::Vector3::from);
    let durations = [3.0, 1.5, 4.0];
    let best = spline::through(&basis, &begin, &places, &durations).expect("solved");
    // Optimal splines are continuous up to the fourth derivative at the waypoints (Euler-Lagrange).
    for pair in best.windows(2) {
        let t = pair[0].duration_s;
        for (a, b) in [(&pair[0].north, &pair[1].north), (&pair[0].down, &pair[1].down)] {
            let jerk = 6.0 * a[3] + 24.0 * a[4] * t + 60.0 * a[5] * t * t;
            let snap = 24.0 * a[4] + 120.0 * a[5] * t;
            assert!((jerk - 6.0 * b[3]).abs() < 1e-6 && (snap - 24.0 * b[4]).abs() < 1e-6);
        }
    }
}

#[test]
fn who_flies_on_keeps_its_speed() {
    let start = MotionState {
        position: place(0.0, 0.0, -20.0),
        velocity: VelocityNed::new(8.0, 0.0, 0.0),
        acceleration: AccelerationNed::default(),
    };
    let way = plan(
        start,
        &[place(60.0, 0.0, -20.0), place(120.0, 20.0, -20.0)],
        &limits(10.0, 2.0),
        START,
        Smoothness::Jerk,
    )
    .expect("can be flown");
    let slowest = (0..50)
        .map(|i| at(&way, 0.06 * f64::from(i)).velocity.norm())
        .fold(f64::INFINITY, f64::min);
    assert!(slowest > 6.0, "{slowest} m/s");
}

#[test]
fn who_has_to_turn_back_brakes_instead_of_swinging_out() {
    let moving = Journey {
        start: MotionState {
            position: place(0.0, 0.0, -20.0),
            velocity: VelocityNed::new(8.0, 0.0, 0.0),
            acceleration: AccelerationNed::new(0.5, 0.0, 0.0),
        },
        waypoints: vec![place(-10.0, 0.0, -20.0)],
        limits: limits(12.0, 2.0),
    };
    // The other one needs minutes.
    let slow = Journey {
        start: MotionState::at_rest(place(0.0, 50.0, -20.0)),
        waypoints: vec![place(300.0, 50.0, -20.0)],
        limits: limits(2.0, 1.0),
    };
    let plan = plan_together(&[moving, slow], START, Smoothness::Jerk).expect("can be flown");
    let farthest = times(&plan.trajectories[0])
        .into_iter()
        .map(|t| at(&plan.trajectories[0], t).position.north_m)
        .fold(0.0, f64::max);
    assert!(
        plan.duration_s() > 150.0 && farthest < 40.0,
        "{farthest} m in {} s",
        plan.duration_s()
    );
    assert!(plan.min_distance_m > 45.0);
}

#[test]
fn refusals_name_the_vehicle() {
    let good = Journey {
        start: MotionState::at_rest(place(0.0, 0.0, 0.0)),
        waypoints: vec![place(1.0, 0.0, 0.0)],
        limits: limits(5.0, 2.0),
    };
    let refusal = |bad: Journey| plan_together(&[good.clone(), bad], START, Smoothness::Jerk).map(|_| ());
    let without = Journey {
        waypoints: vec![],
        ..good.clone()
    };
    assert_eq!(refusal(without), Err(TrajectoryError::NoWaypoints { index: 1 }));
    let nan = Journey {
        waypoints: vec![place(f64::NAN, 0.0, 0.0)],
        ..good.clone()
    };
    assert_eq!(
        refusal(nan),
        Err(TrajectoryError::WaypointNotUsable { index: 1, waypoint: 0 })
    );
    let still = Journey {
        limits: limits(0.0, 2.0),
        ..good.clone()
    };
    assert_eq!(refusal(still), Err(TrajectoryError::InvalidLimits { index: 1 }));
    assert_eq!(
        plan_together(&[], START, Smoothness::Jerk).map(|p| p.min_distance_m),
        Ok(f64::INFINITY)
    );
}

#[test]
fn before_its_start_and_after_its_end_it_stands() {
    let start = MotionState::at_rest(place(3.0, 4.0, -5.0));
    let way = plan(
        start,
        &[place(10.0, 4.0, -5.0)],
        &limits(5.0, 2.0),
        START,
        Smoothness::Jerk,
    )
    .expect("can be flown");
    let before = sample(&way, NodeTime(0));
    assert!(!before.begun && !before.finished && before.position.distance_m(&start.position) < 1e-9);
    let after = sample(&way, NodeTime(60_000_000));
    assert!(after.finished && after.position.distance_m(&place(10.0, 4.0, -5.0)) < 1e-6);
    let during = sample(&way, START.plus_seconds(1.5));
    assert!(during.yaw_rad.is_some_and(|yaw| yaw.abs() < 1e-9), "along its course");
}
