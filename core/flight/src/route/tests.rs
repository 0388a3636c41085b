//! Routes: continuous, within speed and acceleration, close to the corners, and sane for odd ones.

use super::*;
use proptest::prelude::*;
use std::f64::consts::PI;

fn place() -> impl Strategy<Value = PositionNed> {
    (-200.0..200.0, -200.0..200.0, -60.0..-5.0).prop_map(|(n, e, d)| PositionNed::new(n, e, d))
}

/// Usual routes, and some with turns right back, short legs and repeated waypoints.
fn waypoints() -> impl Strategy<Value = Vec<PositionNed>> {
    prop::collection::vec((place(), 0_u8..6), 2..10).prop_map(|steps| {
        let mut all: Vec<PositionNed> = Vec::new();
        for (place, kind) in steps {
            let (last, before) = (all.last().copied(), all.iter().rev().nth(1).copied());
            all.push(match (kind, last, before) {
                (0, Some(last), _) => last,
                (1, Some(last), _) => last.moved(Vector3::new(0.3, -0.2, 0.1)),
                (2, _, Some(before)) => before,
                (3, Some(last), _) => PositionNed {
                    down_m: place.down_m,
                    ..last
                },
                _ => place,
            });
        }
        all
    })
}

fn distance_to_legs_m(point: &PositionNed, corners: &[PositionNed]) -> f64 {
    let to_leg = |pair: &[PositionNed]| {
        let (a, way) = (pair[0].vector(), pair[1].vector() - pair[0].vector());
        let share = if way.norm() > 0.0 {
            ((point.vector() - a).dot(&way) / way.norm_squared()).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (point.vector() - a - way * share).norm()
    };
    corners.windows(2).map(to_leg).fold(f64::INFINITY, f64::min)
}

/// Walks along the whole route in fine steps.
fn walk(trajectory: &RouteTrajectory, steps: u32) -> Vec<(f64, RouteSample)> {
    let at = |k: u32| trajectory.duration_s() * f64::from(k) / f64::from(steps);
    (0..=steps).map(|k| (at(k), trajectory.sample(at(k)))).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn speed_acceleration_and_continuity(
        start in place(), waypoints in waypoints(), speed_m_s in 0.5..12.0, corner_radius_m in 0.0..40.0,
        acceleration in 0.5..5.0, climb_m_s in 0.5..5.0,
    ) {
        let route = Route { waypoints, speed_m_s, corner_radius_m };
        let limits = PathLimits { acceleration_m_s2: acceleration, climb_m_s, descent_m_s: 1.0 };
        let trajectory = RouteTrajectory::within(start, &route, &limits).unwrap();
        prop_assert!(trajectory.duration_s().is_finite());
        for pair in walk(&trajectory, 4000).windows(2) {
            let ((t0, a), (t1, b)) = (pair[0], pair[1]);
            let dt_s = t1 - t0;
            prop_assert!(a.velocity.norm() <= speed_m_s * (1.0 + 1e-9));
            prop_assert!(-a.velocity.down_m_s <= climb_m_s * (1.0 + 1e-9) && a.velocity.down_m_s <= 1.0 + 1e-9);
            prop_assert!(a.acceleration.norm() <= acceleration * (1.0 + 1e-6), "{}", a.acceleration.norm());
            // Where it was plus what the mean velocity makes of it; the velocity changes by no more than the acceleration allows
            // (and by the millimetres of kinks too small for an arc).
            let moved = b.position.vector() - a.position.vector();
            let mean = (a.velocity.vector() + b.velocity.vector()) * 0.5;
            let slack = 1e-3 * speed_m_s + acceleration * dt_s;
            prop_assert!((moved - mean * dt_s).norm() <= slack * dt_s + 1e-9);
            prop_assert!((b.velocity.vector() - a.velocity.vector()).norm() <= acceleration * dt_s * 1.01 + 1e-3 * speed_m_s);
        }
    }

    #[test]
    fn it_stays_near_the_legs_and_ends_at_the_last_waypoint(
        start in place(), waypoints in waypoints(), corner_radius_m in 0.0..40.0,
    ) {
        let route = Route { waypoints, speed_m_s: 5.0, corner_radius_m };
        let trajectory = RouteTrajectory::new(start, &route, 2.0).unwrap();
        let corners: Vec<_> = std::iter::once(start).chain(route.waypoints.iter().copied()).collect();
        for (_, sample) in walk(&trajectory, 500) {
            // An arc that touches two legs at a right angle or less is at most (1 - cos 45°) of its radius off the nearer one;
            // for sharper turns the tangent length bounds it.
            prop_assert!(distance_to_legs_m(&sample.position, &corners) <= corner_radius_m + 0.02);
            prop_assert!(sample.turning || distance_to_legs_m(&sample.position, &corners) < 0.02);
        }
        let end = trajectory.sample(trajectory.duration_s());
        prop_assert!(end.finished && end.velocity == VelocityNed::default());
        prop_assert!(end.position.distance_m(&corners[corners.len() - 1]) < 0.02);
        prop_assert!(trajectory.sample(0.0).position.distance_m(&start) < 1e-9);
        let straight_m: f64 = corners.windows(2).map(|pair| pair[0].distance_m(&pair[1])).sum();
        prop_assert!(trajectory.length_m() <= straight_m + 1e-6);
    }

    #[test]
    fn course_and_its_rate_are_those_of_the_velocity(
        start in place(), waypoints in waypoints(), share in 0.0..1.0,
    ) {
        let route = Route { waypoints, speed_m_s: 5.0, corner_radius_m: 10.0 };
        let trajectory = RouteTrajectory::new(start, &route, 2.0).unwrap();
        let (t_s, step_s) = (share * trajectory.duration_s(), 1e-4);
        let (here, next) = (trajectory.sample(t_s), trajectory.sample(t_s + step_s));
        prop_assert!(here.course_rad.is_finite() && here.course_rate_rad_s.is_finite());
        let level = here.velocity.north_m_s.hypot(here.velocity.east_m_s);
        if level > 0.5 {
            let course_rad = here.velocity.east_m_s.atan2(here.velocity.north_m_s);
            prop_assert!(skein_domain::frames::wrap_angle_rad(course_rad - here.course_rad).abs() < 1e-6);
        }
        if here.turning && next.turning && level > 0.5 {
            let rate = skein_domain::frames::wrap_angle_rad(next.course_rad - here.course_rad) / step_s;
            prop_assert!((rate - here.course_rate_rad_s).abs() < 0.02 * (1.0 + rate.abs()));
        }
    }
}

fn route(waypoints: &[[f64; 2]], corner_radius_m: f64) -> Route {
    let place = |&[north_m, east_m]: &[f64; 2]| PositionNed::new(north_m, east_m, -10.0);
    Route {
        waypoints: waypoints.iter().map(place).collect(),
        speed_m_s: 5.0,
        corner_radius_m,
    }
}

const START: PositionNed = PositionNed {
    north_m: 0.0,
    east_m: 0.0,
    down_m: -10.0,
};

#[test]
fn a_right_angle_is_rounded_with_the_radius() {
    let trajectory = RouteTrajectory::new(START, &route(&[[100.0, 0.0], [100.0, 100.0]], 20.0), 2.0).unwrap();
    assert!((trajectory.length_m() - (80.0 + 10.0 * PI + 80.0)).abs() < 1e-9);
    // 80 m + 80 m + the arc at 5 m/s, and half of the ramps' 2.5 s each.
    assert!((trajectory.duration_s() - ((160.0 + 10.0 * PI) / 5.0 + 2.5)).abs() < 1e-9);
    let middle = trajectory.sample(trajectory.duration_s() / 2.0);
    assert!(middle.turning && !middle.finished);
    assert!((middle.course_rad - PI / 4.0).abs() < 1e-9);
    assert!((middle.course_rate_rad_s - 0.25).abs() < 1e-9);
    assert!((middle.acceleration.norm() - 1.25).abs() < 1e-9);
    let corner = PositionNed::new(100.0, 0.0, -10.0);
    assert!((middle.position.distance_m(&corner) - 20.0 * (2.0_f64.sqrt() - 1.0)).abs() < 1e-9);
}

#[test]
fn a_tight_corner_is_flown_slowly() {
    let trajectory = RouteTrajectory::new(START, &route(&[[100.0, 0.0], [100.0, 100.0]], 2.0), 2.0).unwrap();
    let middle = trajectory.sample(trajectory.duration_s() / 2.0);
    assert!(middle.turning);
    assert!((middle.velocity.norm() - 2.0).abs() < 1e-9, "√(2 m/s² · 2 m)");
}

#[test]
fn a_turn_right_back_stops_at_the_waypoint() {
    let trajectory = RouteTrajectory::new(START, &route(&[[50.0, 0.0], [0.0, 0.0]], 10.0), 2.0).unwrap();
    assert!((trajectory.length_m() - 100.0).abs() < 1e-9);
    let middle = trajectory.sample(trajectory.duration_s() / 2.0);
    assert!(middle.velocity.norm() < 1e-6);
    assert!(middle.position.distance_m(&PositionNed::new(50.0, 0.0, -10.0)) < 1e-6);
}

#[test]
fn a_climb_keeps_the_course_it_had() {
    let waypoints = vec![PositionNed::new(0.0, 50.0, -10.0), PositionNed::new(0.0, 50.0, -40.0)];
    let route = Route {
        waypoints,
        speed_m_s: 5.0,
        corner_radius_m: 5.0,
    };
    let limits = PathLimits {
        acceleration_m_s2: 2.0,
        climb_m_s: 2.0,
        descent_m_s: 1.0,
    };
    let trajectory = RouteTrajectory::within(START, &route, &limits).unwrap();
    let climbing = trajectory.sample(trajectory.duration_s() - 5.0);
    assert!((climbing.velocity.down_m_s + 2.0).abs() < 1e-9);
    assert!((climbing.course_rad - PI / 2.0).abs() < 1e-9);
}

#[test]
fn what_cannot_be_flown_is_refused_with_its_reason() {
    let good = route(&[[10.0, 0.0]], 5.0);
    let new = |route: &Route, acceleration| RouteTrajectory::new(START, route, acceleration);
    assert_eq!(new(&route(&[], 5.0), 2.0), Err(RouteError::NoWaypoints));
    assert_eq!(
        new(&route(&[[0.0, 0.0], [0.0, 0.0]], 5.0), 2.0),
        Err(RouteError::NoLength)
    );
    assert_eq!(
        new(&route(&[[1.0, 0.0], [f64::NAN, 0.0]], 5.0), 2.0),
        Err(RouteError::WaypointNotFinite { index: 1 })
    );
    assert_eq!(
        new(&route(&[[1e300, 0.0]], 5.0), 2.0),
        Err(RouteError::WaypointNotFinite { index: 0 })
    );
    let odd = PositionNed::new(f64::NAN, 0.0, 0.0);
    assert_eq!(RouteTrajectory::new(odd, &good, 2.0), Err(RouteError::StartNotFinite));
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            new(&good, value),
            Err(RouteError::InvalidLimit {
                limit: "acceleration_m_s2",
                ..
            })
        ));
        let slow = Route {
            speed_m_s: value,
            ..good.clone()
        };
        assert!(matches!(
            new(&slow, 2.0),
            Err(RouteError::InvalidLimit { limit: "speed_m_s", .. })
        ));
    }
    for radius_m in [-1.0, f64::NAN, f64::INFINITY] {
        let bad = Route {
            corner_radius_m: radius_m,
            ..good.clone()
        };
        assert!(matches!(new(&bad, 2.0), Err(RouteError::InvalidRadius { .. })));
    }
}

#[test]
fn odd_times_are_answered() {
    let trajectory = RouteTrajectory::new(START, &route(&[[10.0, 0.0]], 5.0), 2.0).unwrap();
    for t_s in [f64::NAN, -5.0, f64::NEG_INFINITY] {
        let sample = trajectory.sample(t_s);
        assert!(sample.position == START && !sample.finished);
    }
    assert!(trajectory.sample(f64::INFINITY).finished);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn a_route_from_a_motion_is_continuous_and_within_its_limits(
        start in place(), waypoints in waypoints(), speed_m_s in 1.0..12.0, corner_radius_m in 0.0..30.0,
        acceleration in 0.5..4.0, moving in (-8.0..8.0, -8.0..8.0, -1.0..1.0),
    ) {
        let route = Route { waypoints, speed_m_s, corner_radius_m };
        let limits = PathLimits::level(acceleration);
        let velocity = VelocityNed::new(moving.0, moving.1, moving.2);
        let Ok(way) = RouteTrajectory::from_motion(start, &velocity, &route, &limits) else { return Ok(()) };
        prop_assert!(way.sample(0.0).position.distance_m(&start) < 1e-6);
        let samples = walk(&way, 3_000);
        for pair in samples.windows(2) {
            let [(t0, a), (t1, b)] = pair else { continue };
            let moved = a.position.distance_m(&b.position);
            prop_assert!(moved <= speed_m_s * (t1 - t0) + 1e-6, "{moved} m in {} s", t1 - t0);
            let change = (b.velocity.vector() - a.velocity.vector()).norm();
            prop_assert!(change <= 1.5 * acceleration * (t1 - t0) + 0.02, "{change} m/s in {} s", t1 - t0);
        }
        let last = route.waypoints.last().expect("has one");
        prop_assert!(way.sample(f64::INFINITY).position.distance_m(last) < 0.5);
    }
}

#[test]
fn a_route_begins_as_fast_as_its_leader_is() {
    let limits = PathLimits::level(2.0);
    let velocity = VelocityNed::new(8.0, 0.0, 0.0);
    for (north_m, east_m) in [(200.0, 0.0), (150.0, 100.0), (50.0, 150.0), (-100.0, 5.0)] {
        let route = Route {
            waypoints: vec![PositionNed::new(north_m, east_m, 0.0)],
            speed_m_s: 8.0,
            corner_radius_m: 10.0,
        };
        let way = RouteTrajectory::from_motion(PositionNed::default(), &velocity, &route, &limits).expect("can be");
        let first = way.sample(0.0);
        assert!(
            (first.velocity.vector() - velocity.vector()).norm() < 0.5,
            "{north_m} {east_m}: {:?}",
            first.velocity
        );
    }
}
