//! Tracks made by hand: what the judge must see, and what it must not count.

use super::*;
use skein_domain::{FlightMode, LandedState, VelocityNed};

fn line(north_m: f64, touches_ground: bool, setpoint_gap_s: f64) -> VehicleLine {
    VehicleLine {
        system_id: 1,
        position: PositionNed::new(north_m, 0.0, -5.0),
        velocity: VelocityNed::default(),
        armed: !touches_ground,
        landed: LandedState::InAir,
        touches_ground,
        mode: FlightMode::Offboard,
        failsafe: false,
        setpoint_gap_s,
        setpoints: 0,
    }
}

fn track(host: u8, samples: Vec<(f64, VehicleLine)>) -> Track {
    Track {
        samples,
        ..Track::new(host, PathBuf::new())
    }
}

#[test]
fn two_that_pass_each_other_between_their_lines_are_seen_to() {
    let a = track(1, vec![(10.0, line(0.0, false, 0.0)), (11.0, line(10.0, false, 0.0))]);
    let b = track(
        2,
        vec![
            (9.9, line(5.0, false, 0.0)),
            (10.5, line(1.0, false, 0.0)),
            (12.0, line(1.0, false, 0.0)),
        ],
    );
    let found = nearest([&a, &b].into_iter()).expect("they met");
    assert!((found.distance_m - 13.0 / 3.0).abs() < 1e-6, "{found:?}");
    assert_eq!(found.hosts, (1, 2));
}

#[test]
fn two_on_the_ground_are_not_near_each_other() {
    let stands = |host| track(host, vec![(0.0, line(0.0, true, 0.0)), (1.0, line(0.0, true, 0.0))]);
    assert_eq!(nearest([&stands(1), &stands(2)].into_iter()), None);
}

#[test]
fn a_gap_counts_unless_its_node_was_away() {
    let flown = track(
        1,
        vec![
            (1.0, line(0.0, false, 0.02)),
            (2.0, line(0.0, false, 0.9)),
            (3.0, line(0.0, false, 0.1)),
        ],
    );
    assert_eq!(flown.longest_gap(&[]), (0.9, 2.0));
    assert_eq!(flown.longest_gap(&[(1.5, Some(2.5))]), (0.1, 3.0));
    assert_eq!(flown.longest_gap(&[(1.5, None)]), (0.02, 1.0));
}

#[test]
fn a_shape_is_one_wherever_it_points() {
    let line = |east: f64, north: f64| {
        let at = |i: f64| PositionNed::new(north * i, east * i, -8.0);
        [at(0.0), at(1.0), at(2.0), at(-1.0), at(-2.0)]
    };
    assert!(shape_error_m(&line(6.0, 0.0), Shape::Line, 6.0) < 0.01);
    assert!(shape_error_m(&line(0.0, 6.0), Shape::Line, 6.0) < 0.01);
    assert!(shape_error_m(&line(6.0, 3.0), Shape::Line, 6.0) > 0.5);
    assert!(shape_error_m(&line(6.0, 0.0), Shape::Wedge, 6.0) > 0.5);
}
