//! Assignments: a permutation, never dearer than simpler ones, and without meetings on the way.

use super::*;
use proptest::prelude::*;

fn offset() -> impl Strategy<Value = OffsetFrd> {
    (-200.0..200.0, -200.0..200.0, -30.0..30.0).prop_map(|(f, r, d)| OffsetFrd::new(f, r, d))
}

fn cost_m2(from: &[OffsetFrd], slots: &[OffsetFrd], chosen: &[usize]) -> f64 {
    from.iter()
        .zip(chosen)
        .map(|(a, &slot)| (a.vector() - slots[slot].vector()).norm_squared())
        .sum()
}

/// Each vehicle in turn takes the nearest slot that is left.
fn greedy(from: &[OffsetFrd], slots: &[OffsetFrd]) -> Vec<usize> {
    let mut left: Vec<usize> = (0..slots.len()).collect();
    let nearest = |a: &OffsetFrd| {
        let distance = |slot: usize| (a.vector() - slots[slot].vector()).norm_squared();
        let (at, _) = left
            .iter()
            .enumerate()
            .min_by(|x, y| distance(*x.1).total_cmp(&distance(*y.1)))
            .unwrap();
        left.swap_remove(at)
    };
    from.iter().map(nearest).collect()
}

proptest! {
    #[test]
    fn it_is_one_to_one_and_no_dearer_than_identity_and_greedy(
        (from, slots) in (1_usize..30, 0_usize..5).prop_flat_map(|(n, spare)| {
            (prop::collection::vec(offset(), n), prop::collection::vec(offset(), n + spare))
        }),
    ) {
        let chosen = assign(&from, &slots);
        let mut seen = vec![false; slots.len()];
        for &slot in &chosen {
            prop_assert!(!std::mem::replace(&mut seen[slot], true), "slot {slot} twice");
        }
        let rounding_m2 = 1e-6 * from.len() as f64;
        let cost = cost_m2(&from, &slots, &chosen);
        let identity: Vec<usize> = (0..from.len()).collect();
        prop_assert!(cost <= cost_m2(&from, &slots, &identity) + rounding_m2);
        prop_assert!(cost <= cost_m2(&from, &slots, &greedy(&from, &slots)) + rounding_m2);
    }

    #[test]
    fn vehicles_on_straight_ways_in_step_never_meet(
        (from, slots) in (2_usize..25).prop_flat_map(|n| {
            (prop::collection::vec(offset(), n), prop::collection::vec(offset(), n))
        }),
    ) {
        let chosen = assign(&from, &slots);
        for i in 0..from.len() {
            for j in 0..i {
                let a = from[i].vector() - from[j].vector();
                let b = slots[chosen[i]].vector() - slots[chosen[j]].vector();
                // Otherwise exchanging the two slots would have been cheaper.
                prop_assert!(a.dot(&b) >= -1e-5);
                // So the way from a to b turns by at most a right angle, and the nearest it comes to zero is the altitude of
                // the right-angled triangle.
                let bound_m = a.norm() * b.norm() / a.norm().hypot(b.norm()).max(1e-12);
                for k in 0..=50 {
                    let apart_m = a.lerp(&b, f64::from(k) / 50.0).norm();
                    prop_assert!(apart_m >= bound_m - 1e-3, "{apart_m} < {bound_m}");
                }
            }
        }
    }
}

#[test]
fn numbers_that_are_not_finite_count_as_far() {
    let good = OffsetFrd::new(1.0, 0.0, 0.0);
    let bad = OffsetFrd::new(f64::NAN, 0.0, 0.0);
    let endless = OffsetFrd::new(f64::INFINITY, 0.0, 0.0);
    // The good vehicle gets the good slot whatever the order.
    assert_eq!(assign(&[bad, good], &[good, endless]), [1, 0]);
    assert_eq!(assign(&[good, bad], &[good, endless]), [0, 1]);
    assert_eq!(assign(&[endless; 3], &[bad; 3]).len(), 3);
}

#[test]
fn lists_that_do_not_fit_are_answered_too() {
    let place = OffsetFrd::default();
    assert!(assign(&[], &[place]).is_empty());
    assert_eq!(assign(&[place], &[]), [usize::MAX]);
    let chosen = assign(&[OffsetFrd::new(9.0, 0.0, 0.0), place], &[place]);
    assert_eq!(chosen, [usize::MAX, 0]);
}
