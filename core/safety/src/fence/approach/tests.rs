//! Who keeps the limits stays inside, slides along boundaries, and is never held where it could go.

use super::super::tests::polygon_about;
use super::super::{Fence, Fences, Zone};
use super::*;
use proptest::prelude::*;
use skein_domain::BreachAction;

const APPROACH: Approach = Approach {
    max_speed_m_s: 12.0,
    braking_m_s2: 3.0,
    reaction_s: 0.1,
    margin_m: 0.0,
};
const PERIOD_S: f64 = 0.02;

fn at(north_m: f64, east_m: f64, height_m: f64) -> PositionNed {
    PositionNed::new(north_m, east_m, -height_m)
}

fn zone(kind: ZoneKind, volume: Fence) -> Zone {
    Zone {
        name: "zone".to_owned(),
        kind,
        action: BreachAction::Hold,
        volume,
    }
}

fn square(half_m: f64, heights: [f64; 2]) -> Fence {
    let corners = vec![
        [-half_m, -half_m],
        [half_m, -half_m],
        [half_m, half_m],
        [-half_m, half_m],
    ];
    Fence::new(corners, heights[0], heights[1]).unwrap()
}

/// The asked velocity brought within the limits, one after the other until all hold; standing still if they do not come to that.
fn filtered(asked: Vector3<f64>, limits: &[HalfSpace]) -> Vector3<f64> {
    let mut velocity = asked;
    for _ in 0..50 {
        for half in limits {
            let over = half.normal.dot(&velocity) - half.limit_m_s;
            if over > 0.0 {
                velocity -= half.normal * over;
            }
        }
        if limits
            .iter()
            .all(|half| half.normal.dot(&velocity) <= half.limit_m_s + 1e-9)
        {
            return velocity;
        }
    }
    Vector3::zeros()
}

/// A vehicle whose velocity follows the asked one within half of the reaction, every part of it alike.
struct Vehicle {
    position: PositionNed,
    velocity: Vector3<f64>,
}

impl Vehicle {
    fn step(&mut self, asked: Vector3<f64>) {
        self.velocity += (asked - self.velocity) * (2.0 * PERIOD_S / APPROACH.reaction_s);
        self.position = self.position.moved(self.velocity * PERIOD_S);
    }
}

#[test]
fn the_speed_from_which_it_stops_in_time() {
    for distance_m in [0.001, 0.5, 10.0, 300.0] {
        let speed_m_s = APPROACH.speed_m_s(distance_m);
        assert!((APPROACH.stopping_m(speed_m_s) - distance_m).abs() < 1e-9 * distance_m.max(1.0));
    }
    let at_once = Approach {
        reaction_s: 0.0,
        ..APPROACH
    };
    assert!(
        (at_once.speed_m_s(6.0) - 6.0).abs() < 1e-12,
        "the root of two times 3 times 6"
    );
    for distance_m in [0.0, -1.0, f64::NAN] {
        assert_eq!(APPROACH.speed_m_s(distance_m), 0.0);
    }
    let none = Approach {
        braking_m_s2: 0.0,
        ..APPROACH
    };
    assert_eq!((none.speed_m_s(5.0), none.stopping_m(5.0)), (0.0, f64::INFINITY));
}

#[test]
fn towards_walls_and_ceilings_only_and_only_near_them() {
    let fences = Fences::from(square(100.0, [0.0, 60.0]));
    assert_eq!(fences.velocity_limits(&at(0.0, 0.0, 30.0), &APPROACH).len(), 0);
    let near = fences.velocity_limits(&at(95.0, 0.0, 30.0), &APPROACH);
    assert_eq!(near.len(), 1);
    assert_eq!(near[0].normal, Vector3::x());
    assert!((near[0].limit_m_s - APPROACH.speed_m_s(5.0)).abs() < 1e-12);
    let high = fences.velocity_limits(&at(0.0, 0.0, 58.0), &APPROACH);
    assert_eq!(high.len(), 1);
    assert_eq!(high[0].normal, -Vector3::z());
    let on_the_wall = fences.velocity_limits(&at(100.0, 0.0, 30.0), &APPROACH);
    assert!(
        on_the_wall
            .iter()
            .any(|half| half.normal == Vector3::x() && half.limit_m_s == 0.0)
    );
    let outside = fences.velocity_limits(&at(103.0, 0.0, 30.0), &APPROACH);
    assert!(
        outside
            .iter()
            .any(|half| half.normal == Vector3::x() && half.limit_m_s == 0.0)
    );
    assert!(
        outside.iter().all(|half| half.contains(&Vector3::new(-5.0, 0.0, 0.0))),
        "back in: {outside:?}"
    );
    assert!(
        fences
            .velocity_limits(&at(f64::NAN, 0.0, 0.0), &APPROACH)
            .iter()
            .all(|half| half.limit_m_s == 0.0)
    );
    assert!(
        Fences::default()
            .velocity_limits(&at(f64::NAN, 0.0, 0.0), &APPROACH)
            .is_empty()
    );
}

#[test]
fn over_an_exclusion_it_may_fly_but_not_sink_into_it() {
    let fences = Fences::new(vec![zone(ZoneKind::Exclusion, square(50.0, [0.0, 30.0]))]);
    let over = fences.velocity_limits(&at(0.0, 0.0, 32.0), &APPROACH);
    assert!(
        over.iter().all(|half| half.contains(&Vector3::new(10.0, 0.0, 0.0))),
        "{over:?}"
    );
    assert!(
        over.iter()
            .any(|half| half.normal == Vector3::z() && half.limit_m_s < 4.0)
    );
    let inside = fences.velocity_limits(&at(45.0, 0.0, 15.0), &APPROACH);
    assert!(
        inside.iter().all(|half| half.contains(&Vector3::new(3.0, 0.0, 0.0))),
        "out: {inside:?}"
    );
    assert!(
        inside.iter().any(|half| !half.contains(&Vector3::new(-0.1, 0.0, 0.0))),
        "not deeper"
    );
}

#[test]
fn it_slides_along_a_wall() {
    let fences = Fences::from(square(100.0, [0.0, 60.0]));
    let mut vehicle = Vehicle {
        position: at(60.0, -80.0, 30.0),
        velocity: Vector3::zeros(),
    };
    for _ in 0..1000 {
        let limits = fences.velocity_limits(&vehicle.position, &APPROACH);
        vehicle.step(filtered(Vector3::new(7.0, 7.0, 0.0), &limits));
        assert!(
            fences.excess(&vehicle.position).distance_m() < 0.02,
            "{:?}",
            vehicle.position
        );
    }
    assert!(
        vehicle.position.north_m > 99.0 && vehicle.position.east_m > 40.0,
        "{:?}",
        vehicle.position
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn who_keeps_the_limits_stays_inside(
        (vertices, centre) in polygon_about(), exclusion in polygon_about(), by in prop::array::uniform2(-50.0..50.0),
        // Together no more than the largest speed.
        asked in prop::collection::vec((-8.0..8.0, -8.0..8.0, -4.0..4.0), 8),
    ) {
        let volume = Fence::new(vertices, 0.0, 60.0).unwrap();
        let (corners, about) = exclusion;
        let moved = corners.iter().map(|v| [centre[0] + by[0] + 0.2 * (v[0] - about[0]), centre[1] + by[1] + 0.2 * (v[1] - about[1])]).collect();
        let fences = Fences::new(vec![
            zone(ZoneKind::Inclusion, volume),
            zone(ZoneKind::Exclusion, Fence::new(moved, 10.0, 40.0).unwrap()),
        ]);
        let mut vehicle = Vehicle { position: at(centre[0], centre[1], 25.0), velocity: Vector3::zeros() };
        prop_assume!(fences.contains(&vehicle.position).is_ok());
        for (north, east, down) in asked {
            for _ in 0..150 {
                let limits = fences.velocity_limits(&vehicle.position, &APPROACH);
                vehicle.step(filtered(Vector3::new(north, east, down), &limits));
                let out_m = fences.excess(&vehicle.position).distance_m();
                // What it goes on within the lag of its velocity. In the tip of a sharp corner that counts for both walls.
                let lag_m = 2.0 * APPROACH.max_speed_m_s * 0.5 * APPROACH.reaction_s;
                prop_assert!(out_m < lag_m, "{out_m} m out at {:?}", vehicle.position);
            }
        }
    }

    #[test]
    fn standing_still_keeps_all_limits_and_coming_back_does(
        (vertices, centre) in polygon_about(), d in prop::array::uniform3(-150.0..150.0),
    ) {
        let fences = Fences::from(Fence::new(vertices, 0.0, 60.0).unwrap());
        let place = at(centre[0] + d[0], centre[1] + d[1], 30.0 + 0.4 * d[2]);
        let limits = fences.velocity_limits(&place, &APPROACH);
        prop_assert!(limits.iter().all(|half| half.limit_m_s >= 0.0 && (half.normal.norm() - 1.0).abs() < 1e-9));
        let excess = fences.excess(&place);
        if excess.outside_m > 0.0 {
            let nearest = fences.zones()[0].volume.nearest_on_outline([place.north_m, place.east_m]).unwrap();
            let back = Vector3::new(nearest[0] - place.north_m, nearest[1] - place.east_m, 0.0).normalize();
            prop_assert!(limits.iter().all(|half| half.contains(&back)), "{limits:?}");
        }
    }
}
