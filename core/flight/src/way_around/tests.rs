//! Ways around: clear of everything, no longer than need be, and refused with the zone where there is none.

use super::*;
use proptest::prelude::*;
use skein_domain::{BreachAction, ZoneKind};
use skein_safety::{Fence, Zone};
use std::collections::{HashMap, VecDeque};
use std::f64::consts::TAU;

const CLEARANCE: Clearance = Clearance {
    horizontal_m: 5.0,
    vertical_m: 3.0,
};

fn at(north_m: f64, east_m: f64, height_m: f64) -> PositionNed {
    PositionNed::new(north_m, east_m, -height_m)
}

fn zone(name: &str, kind: ZoneKind, corners: Vec<[f64; 2]>, floor_m: f64, ceiling_m: f64) -> Zone {
    Zone {
        name: name.to_owned(),
        kind,
        action: BreachAction::Hold,
        volume: Fence::new(corners, floor_m, ceiling_m).expect("a fence"),
    }
}

fn square(north_m: f64, east_m: f64, half_m: f64) -> Vec<[f64; 2]> {
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[n, e]| [north_m + n * half_m, east_m + e * half_m])
        .to_vec()
}

fn tower(north_m: f64, east_m: f64, half_m: f64) -> Zone {
    zone(
        "tower",
        ZoneKind::Exclusion,
        square(north_m, east_m, half_m),
        -10.0,
        500.0,
    )
}

fn field() -> Zone {
    zone("field", ZoneKind::Inclusion, square(0.0, 0.0, 200.0), 0.0, 120.0)
}

/// What must hold for every way.
fn is_right(fences: &Fences, start: &PositionNed, goal: &PositionNed, way: &WayAround) -> Result<(), String> {
    let mut from = *start;
    let mut length_m = 0.0;
    for (to, share) in way.waypoints.iter().zip(&way.clearance_shares) {
        fences.contains_way(&from, to).map_err(|e| e.to_string())?;
        let clearance = CLEARANCE.scaled(*share);
        fences
            .keeps_clearance(&from, to, &clearance)
            .map_err(|e| e.to_string())?;
        length_m += from.distance_m(to);
        from = *to;
    }
    if from != *goal || (length_m - way.length_m).abs() > 1e-6 {
        return Err(format!("it ends at {from:?} after {length_m} m"));
    }
    Ok(())
}

#[test]
fn the_straight_way_is_taken_where_it_is_clear() {
    let fences = Fences::new(vec![field(), tower(0.0, 0.0, 20.0)]);
    let way = way_around(&fences, &at(-100.0, 50.0, 30.0), &at(100.0, 50.0, 40.0), &CLEARANCE).expect("a way");
    assert_eq!(way.waypoints, [at(100.0, 50.0, 40.0)]);
    let nothing = way_around(&Fences::default(), &at(0.0, 0.0, 0.0), &at(9.0, 0.0, 0.0), &CLEARANCE).expect("a way");
    assert_eq!(nothing.waypoints.len(), 1);
}

#[test]
fn around_a_tower_it_is_as_short_as_can_be() {
    let fences = Fences::new(vec![field(), tower(0.0, 0.0, 20.0)]);
    let (start, goal) = (at(-100.0, 0.0, 30.0), at(100.0, 0.0, 30.0));
    let way = way_around(&fences, &start, &goal, &CLEARANCE).expect("a way");
    is_right(&fences, &start, &goal, &way).expect("right");
    // To the arcs of 5 m about two corners and along the wall between them: the tangent, the arc, 40 m, and back.
    let (to_corner, arc) = (80.0_f64.hypot(20.0), 5.0_f64);
    let tangent_m = (to_corner * to_corner - arc * arc).sqrt();
    let turned_rad = (20.0_f64).atan2(80.0) + (arc / to_corner).asin();
    let shortest_m = 2.0 * tangent_m + 2.0 * arc * turned_rad + 40.0;
    assert!(way.length_m >= shortest_m - 1e-3, "{} is too short", way.length_m);
    assert!(way.length_m < shortest_m + 1.0, "{} against {shortest_m}", way.length_m);
}

#[test]
fn over_or_under_where_that_is_shorter() {
    let low = zone("hangar", ZoneKind::Exclusion, square(0.0, 0.0, 60.0), -10.0, 25.0);
    let fences = Fences::new(vec![field(), low]);
    let (start, goal) = (at(-100.0, 0.0, 20.0), at(100.0, 0.0, 20.0));
    let way = way_around(&fences, &start, &goal, &CLEARANCE).expect("a way");
    is_right(&fences, &start, &goal, &way).expect("right");
    assert!(way.waypoints.iter().any(|p| -p.down_m >= 28.0), "{way:?}");
    assert!(way.length_m < 204.0, "{}", way.length_m);
    let airspace = zone("approach", ZoneKind::Exclusion, square(0.0, 0.0, 60.0), 40.0, 500.0);
    let fences = Fences::new(vec![field(), airspace]);
    let (start, goal) = (at(-100.0, 0.0, 50.0), at(100.0, 0.0, 50.0));
    let way = way_around(&fences, &start, &goal, &CLEARANCE).expect("a way");
    is_right(&fences, &start, &goal, &way).expect("right");
    assert!(way.waypoints.iter().any(|p| -p.down_m <= 37.0), "{way:?}");
    // Where a ceiling leaves no room over it, around it goes.
    let high = zone("mast", ZoneKind::Exclusion, square(0.0, 0.0, 60.0), -10.0, 118.0);
    let fences = Fences::new(vec![field(), high]);
    let way = way_around(&fences, &start, &goal, &CLEARANCE).expect("a way");
    is_right(&fences, &start, &goal, &way).expect("right");
    assert!(
        way.waypoints.iter().all(|p| p.down_m == -50.0) && way.length_m > 210.0,
        "{way:?}"
    );
}

#[test]
fn about_reflex_corners_of_the_field_and_from_field_to_field() {
    let notched = vec![
        [0.0, 0.0],
        [100.0, 0.0],
        [100.0, 30.0],
        [40.0, 30.0],
        [40.0, 60.0],
        [100.0, 60.0],
        [100.0, 90.0],
        [0.0, 90.0],
    ];
    let u = Fences::new(vec![zone("u", ZoneKind::Inclusion, notched, 0.0, 50.0)]);
    // The same of three zones that overlap.
    let bar = |name: &str, north: [f64; 2], east: [f64; 2]| {
        let corners = vec![
            [north[0], east[0]],
            [north[1], east[0]],
            [north[1], east[1]],
            [north[0], east[1]],
        ];
        zone(name, ZoneKind::Inclusion, corners, 0.0, 50.0)
    };
    let three = Fences::new(vec![
        bar("left", [0.0, 100.0], [0.0, 30.0]),
        bar("bottom", [0.0, 40.0], [0.0, 90.0]),
        bar("right", [0.0, 100.0], [60.0, 90.0]),
    ]);
    let (start, goal) = (at(90.0, 15.0, 20.0), at(90.0, 75.0, 20.0));
    let mut lengths = Vec::new();
    for fences in [u, three] {
        let way = way_around(&fences, &start, &goal, &CLEARANCE).expect("a way");
        is_right(&fences, &start, &goal, &way).expect("right");
        lengths.push(way.length_m);
    }
    assert!(lengths.iter().all(|m| (145.0..160.0).contains(m)), "{lengths:?}");
}

#[test]
fn ends_near_corners_are_left_and_reached() {
    let fences = Fences::new(vec![field(), tower(0.0, 0.0, 20.0)]);
    let (start, goal) = (at(-20.5, -20.5, 30.0), at(20.0, 21.0, 30.0));
    let way = way_around(&fences, &start, &goal, &CLEARANCE).expect("a way");
    is_right(&fences, &start, &goal, &way).expect("right");
    assert!(way.clearance_shares.iter().any(|share| *share < 0.2), "{way:?}");
}

#[test]
fn no_way_is_refused_with_the_zone() {
    let wall = zone(
        "runway",
        ZoneKind::Exclusion,
        vec![[-10.0, -250.0], [10.0, -250.0], [10.0, 250.0], [-10.0, 250.0]],
        -10.0,
        500.0,
    );
    let fences = Fences::new(vec![field(), wall]);
    let (start, goal) = (at(-100.0, 0.0, 30.0), at(100.0, 0.0, 30.0));
    let zone = "runway".to_owned();
    assert_eq!(
        way_around(&fences, &start, &goal, &CLEARANCE),
        Err(NoWay::Blocked { zone })
    );
    let within = way_around(&fences, &at(0.0, 0.0, 30.0), &goal, &CLEARANCE);
    assert!(
        matches!(&within, Err(NoWay::Start { refusal }) if refusal.to_string().contains("runway")),
        "{within:?}"
    );
    let beyond = way_around(&fences, &start, &at(300.0, 0.0, 30.0), &CLEARANCE);
    assert!(
        matches!(&beyond, Err(NoWay::Goal { refusal }) if refusal.to_string().contains("field")),
        "{beyond:?}"
    );
    let odd = way_around(&fences, &at(f64::NAN, 0.0, 30.0), &goal, &CLEARANCE);
    assert_eq!(odd, Err(NoWay::Invalid { what: "the start" }));
    assert!(matches!(
        Refusal::from(NoWay::Blocked { zone: "x".to_owned() }),
        Refusal::OutsideFence { .. }
    ));
}

/// Zones of any form with up to 9 corners, some of them with a band that leaves room over or under it.
fn zones() -> impl Strategy<Value = Vec<Zone>> {
    let spokes = prop::collection::vec((8.0..35.0, 0.6..1.0), 3..9);
    let one = (spokes, -150.0..150.0, -150.0..150.0, 0_usize..3).prop_map(|(spokes, north, east, band)| {
        let total: f64 = spokes.iter().map(|(_, share)| share).sum();
        let mut angle = 0.0;
        let mut corners = Vec::new();
        for (radius, share) in spokes {
            corners.push([north + radius * f64::cos(angle), east + radius * f64::sin(angle)]);
            angle += share / total * TAU;
        }
        let (floor_m, ceiling_m) = [(-10.0, 500.0), (-10.0, 40.0), (25.0, 500.0)][band];
        zone("zone", ZoneKind::Exclusion, corners, floor_m, ceiling_m)
    });
    prop::collection::vec(one, 1..9)
}

/// The length of a way on a grid at the start's height that keeps the clearance, from the grid's place nearest to the start.
fn on_a_grid(fences: &Fences, start: &PositionNed, goal: &PositionNed) -> Option<f64> {
    const STEP_M: f64 = 16.0;
    let place = |(i, j): (i32, i32)| {
        at(
            start.north_m + f64::from(i) * STEP_M,
            start.east_m + f64::from(j) * STEP_M,
            -start.down_m,
        )
    };
    let clear = |a: &PositionNed, b: &PositionNed| fences.keeps_clearance(a, b, &CLEARANCE).is_ok();
    let mut came_m = HashMap::from([((0, 0), 0.0)]);
    let mut queue = VecDeque::from([(0, 0)]);
    while let Some(here) = queue.pop_front() {
        let (from, so_far_m) = (place(here), came_m[&here]);
        if from.distance_m(goal) <= STEP_M && clear(&from, goal) {
            return Some(so_far_m + from.distance_m(goal));
        }
        for (i, j) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            let next = (here.0 + i, here.1 + j);
            if !came_m.contains_key(&next) && clear(&from, &place(next)) {
                came_m.insert(next, so_far_m + STEP_M);
                queue.push_back(next);
            }
        }
    }
    None
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn ways_are_clear_and_never_longer_than_a_naive_one(
        zones in zones(), a in prop::array::uniform2(-180.0..180.0), b in prop::array::uniform2(-180.0..180.0), heights in prop::array::uniform2(5.0..100.0),
        level in any::<bool>(),
    ) {
        let fences = Fences::new([vec![field()], zones].concat());
        let (start, goal) = (at(a[0], a[1], heights[0]), at(b[0], b[1], if level { heights[0] } else { heights[1] }));
        prop_assume!(fences.contains(&start).is_ok() && fences.contains(&goal).is_ok());
        let found = way_around(&fences, &start, &goal, &CLEARANCE);
        if let Ok(way) = &found {
            prop_assert_eq!(is_right(&fences, &start, &goal, way), Ok(()));
            prop_assert!(way.length_m >= start.distance_m(&goal) - 1e-6);
        }
        if level && let Some(naive_m) = on_a_grid(&fences, &start, &goal) {
            let way = found.expect("there is one on the grid");
            prop_assert!(way.length_m <= naive_m + 1e-6, "{} m against {naive_m} m on the grid", way.length_m);
        }
    }

    #[test]
    fn ends_at_corners_of_zones_do_not_matter(zones in zones(), which in 0_usize..8, corner in 0_usize..9, off in prop::array::uniform2(-3.0..3.0)) {
        let volume = &zones[which % zones.len()].volume;
        let [north, east] = volume.vertices()[corner % volume.vertices().len()];
        let fences = Fences::new([vec![field()], zones].concat());
        let (start, goal) = (at(north + off[0], east + off[1], 30.0), at(190.0, 190.0, 30.0));
        prop_assume!(fences.contains(&start).is_ok());
        if let Ok(way) = way_around(&fences, &start, &goal, &CLEARANCE) {
            prop_assert_eq!(is_right(&fences, &start, &goal, &way), Ok(()));
        }
    }
}
