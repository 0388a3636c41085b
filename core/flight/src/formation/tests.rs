//! Slots: distances, the leader's place, the outline of each shape.

use super::*;
use proptest::prelude::*;

fn distance_m(a: &OffsetFrd, b: &OffsetFrd) -> f64 {
    (a.vector() - b.vector()).norm()
}

proptest! {
    #[test]
    fn any_two_slots_are_at_least_the_spacing_apart(
        shape in prop::sample::select(Shape::ALL),
        count in 1_usize..80,
        spacing_m in 0.1..200.0,
        step_m in -5.0..5.0,
    ) {
        let slots = slots(shape, count, spacing_m, step_m).unwrap();
        prop_assert_eq!(slots.len(), count);
        prop_assert_eq!(slots[0], OffsetFrd::default());
        for (i, a) in slots.iter().enumerate() {
            prop_assert!((a.down_m + i as f64 * step_m).abs() < 1e-9);
            for b in &slots[i + 1..] {
                let level = OffsetFrd { down_m: a.down_m, ..*b };
                prop_assert!(distance_m(a, &level) >= spacing_m, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn every_follower_has_a_neighbour_at_the_spacing(
        shape in prop::sample::select(Shape::ALL),
        count in 2_usize..80,
        spacing_m in 0.5..50.0,
    ) {
        // The formation is not wider than it must be.
        let slots = slots(shape, count, spacing_m, 0.0).unwrap();
        for (i, a) in slots.iter().enumerate() {
            let others = slots.iter().enumerate().filter(|(j, _)| *j != i);
            let nearest_m = others.map(|(_, b)| distance_m(a, b)).fold(f64::INFINITY, f64::min);
            prop_assert!(nearest_m < spacing_m * 1.001, "{i}: {nearest_m}");
        }
    }

    #[test]
    fn nobody_flies_in_front_of_the_leader(
        shape in prop::sample::select(Shape::ALL),
        count in 1_usize..80,
    ) {
        prop_assert!(slots(shape, count, 5.0, 0.0).unwrap().iter().all(|slot| slot.forward_m <= 1e-9));
    }
}

#[test]
fn shapes_have_their_outline() {
    let at = |shape, count| -> Vec<(f64, f64)> {
        let round = |x: f64| (x * 100.0).round() / 100.0 + 0.0;
        slots(shape, count, 10.0, 0.0)
            .unwrap()
            .iter()
            .map(|s| (round(s.forward_m), round(s.right_m)))
            .collect()
    };
    assert_eq!(at(Shape::Line, 4), [(0.0, 0.0), (0.0, 10.0), (0.0, -10.0), (0.0, 20.0)]);
    assert_eq!(at(Shape::Column, 3), [(0.0, 0.0), (-10.0, 0.0), (-20.0, 0.0)]);
    assert_eq!(at(Shape::Wedge, 3), [(0.0, 0.0), (-7.07, 7.07), (-7.07, -7.07)]);
    assert_eq!(at(Shape::Circle, 2), [(0.0, 0.0), (-10.0, 0.0)]);
    assert_eq!(
        at(Shape::Circle, 4),
        [(0.0, 0.0), (-7.07, 7.07), (-14.14, 0.0), (-7.07, -7.07)]
    );
    assert_eq!(
        at(Shape::Grid, 5),
        [(0.0, 0.0), (0.0, 10.0), (0.0, -10.0), (-10.0, 0.0), (-10.0, 10.0)]
    );
    for shape in Shape::ALL {
        assert_eq!(at(*shape, 1), [(0.0, 0.0)]);
    }
}

#[test]
fn unusable_numbers_are_refused() {
    assert_eq!(slots(Shape::Line, 0, 5.0, 0.0), Err(FormationError::NoMembers));
    for spacing_m in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        assert!(matches!(
            slots(Shape::Line, 3, spacing_m, 0.0),
            Err(FormationError::InvalidSpacing { .. })
        ));
    }
    for step_m in [f64::NEG_INFINITY, f64::NAN] {
        assert!(matches!(
            slots(Shape::Line, 3, 5.0, step_m),
            Err(FormationError::InvalidAltitudeStep { .. })
        ));
    }
}
