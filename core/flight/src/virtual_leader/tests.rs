//! A virtual leader: where it is does not depend on when it was asked, and it moves as its route and its heading may.

use super::*;
use proptest::prelude::*;

const START: NodeTime = NodeTime(5_000_000);

fn leader(heading: FormationHeading, heading_rad: f64, radius_m: f64) -> VirtualLeader {
    let place = |north_m, east_m| PositionNed::new(north_m, east_m, -30.0);
    let route = Route {
        waypoints: vec![place(80.0, 0.0), place(80.0, 80.0), place(0.0, 80.0), place(0.0, 10.0)],
        speed_m_s: 5.0,
        corner_radius_m: radius_m,
    };
    VirtualLeader::new(
        place(0.0, 0.0),
        &route,
        &PathLimits::level(2.0),
        heading,
        heading_rad,
        START,
    )
    .unwrap()
}

fn at(seconds: f64) -> NodeTime {
    START.plus_seconds(seconds)
}

proptest! {
    #[test]
    fn two_nodes_that_ask_at_other_times_agree(
        max_rate_rad_s in 0.05..0.8, heading_rad in -3.0..3.0, radius_m in 0.0..20.0,
        asked in prop::collection::vec(-10.0..120.0, 1..30),
    ) {
        let mode = FormationHeading::Course { max_rate_rad_s };
        let (one, other) = (leader(mode, heading_rad, radius_m), leader(mode, heading_rad, radius_m));
        let mut sorted = asked.clone();
        sorted.sort_by(f64::total_cmp);
        let in_order: Vec<_> = sorted.iter().map(|t_s| (t_s, one.anchor(at(*t_s)))).collect();
        for t_s in &asked {
            let now = other.anchor(at(*t_s));
            prop_assert!(in_order.iter().any(|(asked, anchor)| *asked == t_s && *anchor == now));
        }
    }

    #[test]
    fn it_moves_as_its_velocity_and_turning_say(
        max_rate_rad_s in 0.05..0.8, heading_rad in -3.0..3.0, radius_m in 0.0..20.0, t_s in 0.01..100.0,
    ) {
        let leader = leader(FormationHeading::Course { max_rate_rad_s }, heading_rad, radius_m);
        let dt = 1e-3;
        let (a, b) = (leader.anchor(at(t_s)), leader.anchor(at(t_s + dt)));
        let moved = b.position.vector() - a.position.vector();
        prop_assert!((moved / dt - a.velocity.vector()).norm() < 0.05);
        prop_assert!(a.heading_rate_rad_s.abs() <= max_rate_rad_s + 1e-12);
        // Within two steps the rate changes by no more than it may in that time.
        let turned = wrap_angle_rad(b.heading_rad - a.heading_rad) / dt;
        let change = max_rate_rad_s / 2.0 * 2.0 * STEP_S;
        prop_assert!((turned - a.heading_rate_rad_s).abs() <= change + 1e-6, "{turned} {}", a.heading_rate_rad_s);
    }
}

#[test]
fn it_stands_before_the_start_and_after_the_end() {
    let leader = leader(FormationHeading::Course { max_rate_rad_s: 0.5 }, 1.0, 10.0);
    for before in [NodeTime(0), START] {
        let anchor = leader.anchor(before);
        assert_eq!(anchor.position, PositionNed::new(0.0, 0.0, -30.0));
        assert_eq!(anchor.velocity.norm(), 0.0);
        assert!((anchor.heading_rad - 1.0).abs() < 1e-9);
        assert_eq!(anchor.time, before);
    }
    assert_eq!(leader.anchor(NodeTime(0)).heading_rate_rad_s, 0.0);
    assert_eq!(leader.end(), START.plus_seconds(leader.route().duration_s()));
    for after_s in [60.0, 1e4] {
        let anchor = leader.anchor(leader.end().plus_seconds(after_s));
        assert_eq!(anchor.position, PositionNed::new(0.0, 10.0, -30.0));
        assert_eq!(
            (
                anchor.velocity.norm(),
                anchor.acceleration.norm(),
                anchor.heading_rate_rad_s
            ),
            (0.0, 0.0, 0.0)
        );
        // The last leg leads west.
        assert!(
            (anchor.heading_rad + std::f64::consts::FRAC_PI_2).abs() < 0.01,
            "{}",
            anchor.heading_rad
        );
    }
}

#[test]
fn a_fixed_heading_stays() {
    let leader = leader(
        FormationHeading::Fixed {
            heading_rad: 0.3,
            max_rate_rad_s: None,
        },
        1.0,
        10.0,
    );
    for t_s in [-1.0, 0.0, 20.0, 500.0] {
        let anchor = leader.anchor(at(t_s));
        assert_eq!(
            (anchor.heading_rad, anchor.heading_rate_rad_s),
            (wrap_angle_rad(0.3), 0.0)
        );
    }
}

#[test]
fn what_cannot_be_flown_is_refused() {
    let mode = FormationHeading::Fixed {
        heading_rad: 0.0,
        max_rate_rad_s: None,
    };
    let new = |route: &Route| {
        VirtualLeader::new(PositionNed::default(), route, &PathLimits::level(2.0), mode, 0.0, START).map(|_| ())
    };
    let mut route = Route {
        waypoints: Vec::new(),
        speed_m_s: 5.0,
        corner_radius_m: 1.0,
    };
    assert_eq!(new(&route), Err(RouteError::NoWaypoints.into()));
    route.waypoints = vec![PositionNed::new(1e7, 0.0, 0.0)];
    assert!(matches!(new(&route), Err(VirtualLeaderError::TooLong { .. })));
    route.waypoints = vec![PositionNed::new(f64::NAN, 0.0, 0.0)];
    assert!(matches!(new(&route), Err(VirtualLeaderError::Route(_))));
}
