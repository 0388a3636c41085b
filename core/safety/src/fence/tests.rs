//! Fences: which polygons are taken, what is inside, how far outside, and ways between places.

use super::*;
use proptest::prelude::*;
use std::f64::consts::TAU;

const FLOOR_M: f64 = 2.0;
const CEILING_M: f64 = 120.0;

fn fence(vertices: &[[f64; 2]]) -> Fence {
    Fence::new(vertices.to_vec(), FLOOR_M, CEILING_M).unwrap()
}

fn at(north_m: f64, east_m: f64, height_m: f64) -> PositionNed {
    PositionNed::new(north_m, east_m, -height_m)
}

/// Simple polygons, most of them not convex, with a place inside: corners at growing angles about it, in either direction.
pub(crate) fn polygon_about() -> impl Strategy<Value = (Vec<[f64; 2]>, [f64; 2])> {
    // No angle between neighbours reaches half a turn.
    let spokes = prop::collection::vec((20.0..100.0, 0.6..1.0), 3..12);
    (spokes, any::<bool>(), -300.0..300.0, -300.0..300.0).prop_map(|(spokes, reversed, north, east)| {
        let total: f64 = spokes.iter().map(|(_, share)| share).sum();
        let mut angle = 0.0;
        let mut vertices = Vec::new();
        for (radius, share) in spokes {
            vertices.push([north + radius * f64::cos(angle), east + radius * f64::sin(angle)]);
            angle += share / total * TAU;
        }
        if reversed {
            vertices.reverse();
        }
        (vertices, [north, east])
    })
}

fn simple_polygon() -> impl Strategy<Value = Vec<[f64; 2]>> {
    polygon_about().prop_map(|(vertices, _)| vertices)
}

/// How often the polygon goes around a place: another way to tell inside from outside.
fn winding(vertices: &[[f64; 2]], p: [f64; 2]) -> f64 {
    let angle = |[a, b]: Edge2| {
        let (u, v) = ([a[0] - p[0], a[1] - p[1]], [b[0] - p[0], b[1] - p[1]]);
        (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1])
    };
    (edges(vertices).map(angle).sum::<f64>() / TAU).abs()
}

type Edge2 = [[f64; 2]; 2];

proptest! {
    #[test]
    fn inside_is_where_the_polygon_goes_around(
        vertices in simple_polygon(), d_north in -120.0..120.0, d_east in -120.0..120.0,
    ) {
        let fence = fence(&vertices);
        let p = [vertices[0][0] + d_north, vertices[0][1] + d_east];
        let near_m = edges(&vertices).map(|e| distance_to_edge_m(e, p)).fold(f64::INFINITY, f64::min);
        prop_assume!(near_m > 1e-3);
        let inside = winding(&vertices, p) > 0.5;
        prop_assert_eq!(fence.contains(&at(p[0], p[1], 50.0)).is_ok(), inside);
        let expected_m = if inside { 0.0 } else { near_m };
        prop_assert!((fence.excess(&at(p[0], p[1], 50.0)).outside_m - expected_m).abs() < 1e-9);
    }

    #[test]
    fn corners_and_places_on_edges_are_inside(vertices in simple_polygon(), share in 0.0..1.0) {
        let fence = fence(&vertices);
        for [a, b] in edges(&vertices) {
            prop_assert!(fence.contains(&at(a[0], a[1], 50.0)).is_ok());
            let on = [a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share];
            prop_assert!(fence.contains(&at(on[0], on[1], 50.0)).is_ok());
        }
    }

    #[test]
    fn direction_start_and_a_repeated_first_corner_do_not_matter(
        vertices in simple_polygon(), turn in 0_usize..12, d_north in -120.0..120.0, d_east in -120.0..120.0,
    ) {
        let here = at(vertices[0][0] + d_north, vertices[0][1] + d_east, 50.0);
        let expected = fence(&vertices).contains(&here).is_ok();
        let mut other = vertices.clone();
        other.reverse();
        other.rotate_left(turn % vertices.len());
        other.push(other[0]);
        prop_assert_eq!(fence(&other).contains(&here).is_ok(), expected);
    }

    #[test]
    fn a_way_that_passes_stays_inside_throughout(
        vertices in simple_polygon(), a in prop::array::uniform2(-80.0..80.0), b in prop::array::uniform2(-80.0..80.0),
    ) {
        let fence = fence(&vertices);
        let place = |d: [f64; 2]| at(vertices[0][0] + d[0], vertices[0][1] + d[1], 50.0);
        let (from, to) = (place(a), place(b));
        let outside_m = (0..=400).map(|k| {
            let here = from.vector().lerp(&to.vector(), f64::from(k) / 400.0);
            fence.excess(&here.into()).outside_m
        }).fold(0.0, f64::max);
        if fence.contains_way(&from, &to).is_ok() {
            prop_assert!(outside_m < 1e-5, "passed, but goes {outside_m} m out");
        } else {
            // What is refused leaves the fence, by however little: more samples cannot be asked to see less than a few centimetres.
            let ends = fence.contains(&from).is_err() || fence.contains(&to).is_err();
            let touches = edges(&vertices).any(|e| !touches_at([from.north_m, from.east_m], [to.north_m, to.east_m], e).is_empty());
            prop_assert!(ends || touches, "refused without a reason");
        }
    }

    #[test]
    fn heights_count_from_floor_to_ceiling(height_m in -50.0..200.0) {
        let fence = fence(&[[0.0, 0.0], [10.0, 0.0], [0.0, 10.0]]);
        let excess = fence.excess(&at(1.0, 1.0, height_m));
        prop_assert_eq!(fence.contains(&at(1.0, 1.0, height_m)).is_ok(), (FLOOR_M..=CEILING_M).contains(&height_m));
        prop_assert_eq!(excess.above_m, (height_m - CEILING_M).max(0.0));
        prop_assert_eq!(excess.below_m, (FLOOR_M - height_m).max(0.0));
    }
}

#[test]
fn refusals_name_the_limit() {
    let fence = fence(&[[0.0, 0.0], [100.0, 0.0], [100.0, 100.0], [0.0, 100.0]]);
    let detail = |position| match fence.contains(&position) {
        Err(Refusal::OutsideFence { detail }) => detail,
        other => panic!("{other:?}"),
    };
    assert_eq!(detail(at(112.34, 50.0, 50.0)), "12.3 m beyond the boundary");
    assert_eq!(
        detail(at(50.0, 50.0, 130.0)),
        "height 130.0 m is over the ceiling of 120.0 m"
    );
    assert_eq!(detail(at(50.0, 50.0, 1.0)), "height 1.0 m is under the floor of 2.0 m");
    assert!(matches!(
        fence.contains(&at(f64::NAN, 0.0, 0.0)),
        Err(Refusal::InvalidValue { .. })
    ));
    assert!(!fence.excess(&at(0.0, f64::INFINITY, 0.0)).is_inside());
}

#[test]
fn a_way_across_a_notch_is_refused() {
    // A U that is open to the north.
    let fence = fence(&[
        [0.0, 0.0],
        [100.0, 0.0],
        [100.0, 30.0],
        [40.0, 30.0],
        [40.0, 60.0],
        [100.0, 60.0],
        [100.0, 90.0],
        [0.0, 90.0],
    ]);
    let way = |a: [f64; 2], b: [f64; 2]| fence.contains_way(&at(a[0], a[1], 50.0), &at(b[0], b[1], 50.0));
    assert!(way([80.0, 10.0], [80.0, 80.0]).is_err());
    assert!(way([20.0, 10.0], [20.0, 80.0]).is_ok());
    assert!(way([40.0, 10.0], [40.0, 80.0]).is_ok(), "along the bottom of the notch");
    assert!(way([100.0, 30.0], [100.0, 60.0]).is_err(), "from tip to tip");
    assert!(way([100.0, 10.0], [40.0, 30.0]).is_ok());
}

#[test]
fn polygons_that_are_none_are_refused_with_their_reason() {
    let new = |vertices: &[[f64; 2]]| Fence::new(vertices.to_vec(), FLOOR_M, CEILING_M);
    assert_eq!(new(&[]), Err(FenceError::TooFewVertices { count: 0 }));
    assert_eq!(
        new(&[[0.0, 0.0], [1.0, 0.0]]),
        Err(FenceError::TooFewVertices { count: 2 })
    );
    let repeated = [[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]];
    assert_eq!(
        new(&repeated),
        Err(FenceError::TooFewVertices { count: 2 }),
        "the last repeats the first"
    );
    let bow_tie = [[0.0, 0.0], [10.0, 10.0], [10.0, 0.0], [0.0, 10.0]];
    assert_eq!(new(&bow_tie), Err(FenceError::SelfIntersecting { first: 0, second: 2 }));
    let spike = [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [10.0, 0.0], [10.0, 10.0]];
    assert!(matches!(new(&spike), Err(FenceError::SelfIntersecting { .. })));
    let touching = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [5.0, 0.0], [0.0, 10.0]];
    assert!(matches!(new(&touching), Err(FenceError::SelfIntersecting { .. })));
    let twice = [[0.0, 0.0], [10.0, 0.0], [10.0, 0.0], [0.0, 10.0]];
    assert_eq!(new(&twice), Err(FenceError::SelfIntersecting { first: 1, second: 1 }));
    let flat = [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0]];
    assert!(new(&flat).is_err());
    assert_eq!(
        new(&[[0.0, 0.0], [f64::NAN, 0.0], [0.0, 1.0]]),
        Err(FenceError::NotFinite { index: 1 })
    );
    let many: Vec<[f64; 2]> = (0..2000).map(|i| [f64::from(i), f64::from(i * i)]).collect();
    assert_eq!(
        new(&many),
        Err(FenceError::TooManyVertices {
            count: 2000,
            limit: 1000
        })
    );
    for (floor_m, ceiling_m) in [(10.0, 10.0), (20.0, 10.0), (f64::NAN, 10.0), (0.0, f64::INFINITY)] {
        let refused = Fence::new(vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], floor_m, ceiling_m);
        assert!(matches!(refused, Err(FenceError::FloorAboveCeiling { .. })));
    }
}
