//! Slots: distances, the leader's place, the outline of each shape, and what is refused.

use super::*;
use proptest::prelude::*;

mod outlines;

/// A request for any shape, with offsets on a loose grid for the free one.
fn request(shape: Shape, spacing_m: f64) -> FormationRequest {
    let offset = |i: u32| {
        let (row, column) = (f64::from(i / 15), f64::from(i % 15));
        OffsetFrd::new(1.5 - row * 1.2 * spacing_m, 3.0 + column * 1.1 * spacing_m, column)
    };
    FormationRequest {
        offsets: (shape == Shape::Free).then(|| (0..200).map(offset).collect()),
        ..FormationRequest::new(shape, spacing_m)
    }
}

/// By looking at every pair.
fn closest_m(slots: &[OffsetFrd], vertical_factor: f64) -> f64 {
    let mut least_m = f64::INFINITY;
    for (i, a) in slots.iter().enumerate() {
        for b in &slots[i + 1..] {
            let apart = a.vector() - b.vector();
            least_m = least_m.min(apart.x.hypot(apart.y).hypot(apart.z / vertical_factor));
        }
    }
    least_m
}

/// But for rounding; both are infinite for one alone.
fn same(a: f64, b: f64) -> bool {
    a == b || (a - b).abs() <= 1e-9 * b
}

fn has_heights(shape: Shape) -> bool {
    matches!(shape, Shape::Box | Shape::Sphere | Shape::Helix)
}

prop_compose! {
    fn any_request()(
        shape in prop::sample::select(Shape::ALL),
        spacing_m in 0.5..100.0,
        scale in 0.3..3.0,
        rotation_deg in -720.0..720.0,
        arc_deg in prop::option::of(0.001..=360.0),
        layers in prop::option::of(1_u16..8),
        pitch in prop::option::of(1.5..20.0),
    ) -> FormationRequest {
        FormationRequest {
            scale, rotation_deg, arc_deg, layers,
            pitch_m: pitch.map(|pitch: f64| pitch * spacing_m),
            ..request(shape, spacing_m)
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn any_two_slots_are_at_least_the_spacing_apart(request in any_request(), count in 1_usize..=200) {
        let spacing_m = request.spacing_m * request.scale;
        for slots in [slots(&request, count).unwrap(), centred_slots(&request, count).unwrap()] {
            prop_assert_eq!(slots.len(), count);
            let flat = if has_heights(request.shape) { VERTICAL_FACTOR } else { f64::INFINITY };
            prop_assert!(closest_m(&slots, flat) >= spacing_m, "{} of {spacing_m}", closest_m(&slots, flat));
            let least_m = smallest_distance_m(&slots);
            prop_assert!(same(least_m, closest_m(&slots, 1.0)));
            prop_assert!(least_m >= spacing_m);
            prop_assert!(same(smallest_separation_m(&slots), closest_m(&slots, VERTICAL_FACTOR)));
        }
    }

    #[test]
    fn the_leader_is_first_at_zero_or_the_middle_is(request in any_request(), count in 1_usize..=200) {
        let led = slots(&request, count).unwrap();
        prop_assert_eq!(led[0].vector(), Vector3::zeros());
        let centred = centred_slots(&request, count).unwrap();
        let shift = centred[0].vector() - led[0].vector();
        let size_m = 1.0 + led.iter().map(OffsetFrd::norm).fold(0.0, f64::max);
        for (a, b) in led.iter().zip(&centred) {
            prop_assert!((b.vector() - a.vector() - shift).norm() < 1e-9 * size_m);
        }
        if request.shape != Shape::Free {
            let mean = centred.iter().map(OffsetFrd::vector).sum::<Vector3<f64>>() / count as f64;
            prop_assert!(mean.norm() < 1e-9 * size_m, "{mean}");
        }
    }

    #[test]
    fn level_shapes_climb_by_the_altitude_step(request in any_request(), count in 1_usize..80, step_m in -5.0..5.0) {
        let flat = slots(&request, count).unwrap();
        let stepped = FormationRequest { altitude_step_m: step_m, ..request.clone() };
        match slots(&stepped, count) {
            Ok(slots) => {
                for (i, (slot, level)) in slots.iter().zip(&flat).enumerate() {
                    let up_m = i as f64 * step_m * request.scale;
                    prop_assert!((slot.down_m + up_m - level.down_m).abs() < 1e-9 * (1.0 + up_m.abs() + level.norm()));
                }
                if request.shape != Shape::Free {
                    prop_assert!(smallest_distance_m(&slots) >= request.spacing_m * request.scale);
                }
            }
            Err(FormationError::AltitudeStepTooClose { distance_m, least_m, .. }) => {
                prop_assert!(has_heights(request.shape) && distance_m < least_m);
            }
            Err(other) => prop_assert!(false, "{other}"),
        }
    }

    #[test]
    fn rotation_turns_and_scale_widens(request in any_request(), count in 1_usize..80) {
        let plain = FormationRequest { rotation_deg: 0.0, scale: 1.0, ..request.clone() };
        let plain = slots(&plain, count).unwrap();
        let turned = slots(&request, count).unwrap();
        for (a, b) in plain.iter().zip(&turned) {
            let expected = a.rotated(request.rotation_deg.to_radians()) * request.scale;
            prop_assert!((b.vector() - expected).norm() < 1e-6 * (1.0 + expected.norm()));
        }
    }

    #[test]
    fn every_follower_has_a_neighbour_not_much_further_than_the_spacing(
        shape in prop::sample::select(vec![
            Shape::Line, Shape::Column, Shape::Wedge, Shape::EchelonLeft, Shape::EchelonRight, Shape::Circle, Shape::Arc,
            Shape::Grid, Shape::Square, Shape::Diamond,
        ]),
        count in 2_usize..120,
        spacing_m in 0.5..50.0,
    ) {
        // The formation is not wider than it must be: the corners of a square, and the outline of a diamond that is not full.
        let slack = match shape {
            Shape::Square => 1.4143,
            Shape::Diamond if count < 12 => 2.001,
            _ => 1.001,
        };
        let slots = slots(&request(shape, spacing_m), count).unwrap();
        for (i, a) in slots.iter().enumerate() {
            let others = slots.iter().enumerate().filter(|(j, _)| *j != i);
            let nearest_m = others.map(|(_, b)| (a.vector() - b.vector()).norm()).fold(f64::INFINITY, f64::min);
            prop_assert!(nearest_m < spacing_m * slack, "{i}: {nearest_m}");
        }
    }

    #[test]
    fn nobody_flies_in_front_of_the_leader(
        shape in prop::sample::select(Shape::ALL),
        count in 1_usize..=200,
    ) {
        let front = |slot: &OffsetFrd| slot.forward_m <= 1e-9;
        prop_assert!(slots(&request(shape, 5.0), count).unwrap().iter().all(front));
    }

    #[test]
    fn no_number_makes_it_panic_or_answer_with_what_is_no_number(
        shape in prop::sample::select(Shape::ALL),
        count in 0_usize..40,
        numbers in prop::array::uniform6(prop_oneof![
            any::<f64>(), Just(f64::NAN), Just(f64::INFINITY), Just(0.0), Just(f64::MIN_POSITIVE), Just(f64::MAX), 0.1..10.0,
        ]),
        layers in prop::option::of(any::<u16>()),
    ) {
        let [spacing_m, altitude_step_m, rotation_deg, scale, arc_deg, pitch_m] = numbers;
        let asked = FormationRequest {
            spacing_m, altitude_step_m, rotation_deg, scale, arc_deg: Some(arc_deg), pitch_m: Some(pitch_m), layers,
            ..request(shape, 5.0)
        };
        for slots in [slots(&asked, count), centred_slots(&asked, count)].into_iter().flatten() {
            prop_assert!(slots.iter().all(OffsetFrd::is_finite));
        }
    }
}

#[test]
fn unusable_numbers_are_refused() {
    let line = |change: &dyn Fn(&mut FormationRequest)| {
        let mut asked = request(Shape::Line, 5.0);
        change(&mut asked);
        slots(&asked, 3).unwrap_err()
    };
    assert_eq!(slots(&request(Shape::Line, 5.0), 0), Err(FormationError::NoMembers));
    for value in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        let refused = line(&|asked| asked.spacing_m = value);
        assert!(matches!(refused, FormationError::InvalidSpacing { .. }));
        let refused = line(&|asked| asked.scale = value);
        assert!(matches!(refused, FormationError::InvalidScale { .. }));
    }
    for value in [f64::NEG_INFINITY, f64::NAN] {
        let refused = line(&|asked| asked.altitude_step_m = value);
        assert!(matches!(refused, FormationError::InvalidAltitudeStep { .. }));
        let refused = line(&|asked| asked.rotation_deg = value);
        assert!(matches!(refused, FormationError::InvalidRotation { .. }));
    }
    assert_eq!(
        line(&|asked| (asked.spacing_m, asked.scale) = (1e300, 1e300)),
        FormationError::TooLarge
    );
}

#[test]
fn unusable_parameters_of_a_shape_are_refused() {
    for arc_deg in [0.0, -10.0, 360.1, f64::NAN] {
        let asked = FormationRequest {
            arc_deg: Some(arc_deg),
            ..request(Shape::Arc, 5.0)
        };
        assert!(matches!(slots(&asked, 3), Err(FormationError::InvalidArc { .. })));
    }
    let no_layers = FormationRequest {
        layers: Some(0),
        ..request(Shape::Box, 5.0)
    };
    assert_eq!(slots(&no_layers, 3), Err(FormationError::NoLayers));
    for pitch_m in [7.4, -10.0, 0.0, f64::NAN, f64::INFINITY] {
        let asked = FormationRequest {
            pitch_m: Some(pitch_m),
            ..request(Shape::Helix, 5.0)
        };
        let refused = slots(&asked, 3);
        assert!(matches!(
            refused,
            Err(FormationError::InvalidPitch { least_m: 7.5, .. })
        ));
    }
    let sunk = FormationRequest {
        altitude_step_m: -0.8,
        ..request(Shape::Box, 5.0)
    };
    assert!(matches!(
        slots(&sunk, 27),
        Err(FormationError::AltitudeStepTooClose { .. })
    ));
}

#[test]
fn unusable_offsets_are_refused() {
    let free = |offsets: Option<Vec<OffsetFrd>>| {
        let asked = FormationRequest {
            offsets,
            ..request(Shape::Free, 5.0)
        };
        slots(&asked, 3)
    };
    let at = |forward_m| OffsetFrd::new(forward_m, 0.0, 0.0);
    assert_eq!(free(None), Err(FormationError::NoOffsets));
    assert_eq!(
        free(Some(vec![at(0.0), at(1.0)])),
        Err(FormationError::TooFewOffsets { members: 3, offsets: 2 })
    );
    assert_eq!(
        free(Some(vec![at(0.0), at(f64::NAN), at(1.0)])),
        Err(FormationError::NotFinite { index: 1 })
    );
    assert!(matches!(
        free(Some(vec![at(0.0), at(7.0), at(0.05)])),
        Err(FormationError::OffsetsTooClose {
            first: 0,
            second: 2,
            ..
        })
    ));
    // A scale can bring them together; what is not used is not looked at.
    assert_eq!(
        free(Some(vec![at(4.0), at(5.0), at(7.0), at(7.0)])).unwrap(),
        [at(0.0), at(1.0), at(3.0)]
    );
}

#[test]
fn the_smallest_distance_of_what_is_not_finite_passes_no_check() {
    assert_eq!(smallest_distance_m(&[]), f64::INFINITY);
    assert_eq!(smallest_distance_m(&[OffsetFrd::default()]), f64::INFINITY);
    let lost = OffsetFrd::new(0.0, f64::NAN, 0.0);
    assert_eq!(smallest_distance_m(&[OffsetFrd::default(), lost]), 0.0);
    assert_eq!(smallest_separation_m(&[lost, lost]), 0.0);
}
