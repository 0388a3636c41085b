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

/// All ways to give as many vehicles as possible a slot, tried one by one: the fewest without, then the least longest (if asked
/// for), then the least total.
fn by_trying_all(costs: &Costs, total: Total, longest_first: bool) -> (usize, f64, f64) {
    fn go(
        costs: &Costs,
        total: Total,
        vehicle: usize,
        taken: &mut Vec<bool>,
        so_far: (usize, f64, f64),
        all: &mut Vec<(usize, f64, f64)>,
    ) {
        if vehicle == costs.vehicles() {
            all.push(so_far);
            return;
        }
        go(
            costs,
            total,
            vehicle + 1,
            taken,
            (so_far.0 + 1, so_far.1, so_far.2),
            all,
        );
        for slot in 0..costs.slots() {
            let length = costs.length(vehicle, slot);
            if length.is_finite() && !taken[slot] {
                taken[slot] = true;
                let cost = if total == Total::Ways { length } else { length * length };
                go(
                    costs,
                    total,
                    vehicle + 1,
                    taken,
                    (so_far.0, so_far.1.max(length), so_far.2 + cost),
                    all,
                );
                taken[slot] = false;
            }
        }
    }
    let mut all = Vec::new();
    go(
        costs,
        total,
        0,
        &mut vec![false; costs.slots()],
        (0, 0.0, 0.0),
        &mut all,
    );
    let order = |a: &(usize, f64, f64), b: &(usize, f64, f64)| {
        let longest = if longest_first {
            a.1.total_cmp(&b.1)
        } else {
            std::cmp::Ordering::Equal
        };
        a.0.cmp(&b.0).then(longest).then(a.2.total_cmp(&b.2))
    };
    all.into_iter().min_by(order).unwrap()
}

/// Few vehicles and slots, some pairs forbidden; often several ways are equally long.
fn small_costs() -> impl Strategy<Value = Costs> {
    (1_usize..=6, 1_usize..=6).prop_flat_map(|(vehicles, slots)| {
        let length = prop_oneof![
            4 => (0_u32..6).prop_map(f64::from),
            4 => 0.0..100.0,
            2 => Just(f64::INFINITY),
            1 => Just(f64::NAN),
        ];
        prop::collection::vec(length, vehicles * slots)
            .prop_map(move |lengths| Costs::from_fn(vehicles, slots, |i, j| lengths[i * slots + j]))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn nothing_is_better_than_what_is_found(
        costs in small_costs(), longest_first in any::<bool>(), squares in any::<bool>(),
    ) {
        let total = if squares { Total::Squares } else { Total::Ways };
        let found = if longest_first { least_longest(&costs, total) } else { least_total(&costs, total) };
        let (without, longest, least) = by_trying_all(&costs, total, longest_first);
        prop_assert_eq!(found.slots.iter().filter(|slot| slot.is_none()).count(), without);
        let mut seen = std::collections::BTreeSet::new();
        prop_assert!(found.slots.iter().flatten().all(|slot| seen.insert(*slot)));
        let ways = || found.slots.iter().enumerate().filter_map(|(i, slot)| slot.map(|slot| costs.length(i, slot)));
        let sum: f64 = ways().map(|way| if squares { way * way } else { way }).sum();
        prop_assert!(sum <= least * (1.0 + 1e-8) + 1e-9, "{sum} > {least}");
        prop_assert_eq!(found.longest, ways().fold(0.0, f64::max));
        prop_assert!((found.total - ways().sum::<f64>()).abs() < 1e-9);
        if longest_first {
            prop_assert_eq!(found.longest, longest);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_total_is_that_of_another_solver(
        from in prop::collection::vec(offset(), 60), slots in prop::collection::vec(offset(), 60), on_a_grid in any::<bool>(),
    ) {
        // On a grid very many ways are equally long.
        let placed = |list: Vec<OffsetFrd>| -> Vec<OffsetFrd> {
            let round = |x: f64| (x / 40.0).round() * 40.0;
            let grid = |o: &OffsetFrd| OffsetFrd::new(round(o.forward_m), round(o.right_m), 0.0);
            if on_a_grid { list.iter().map(grid).collect() } else { list }
        };
        let (from, slots) = (placed(from), placed(slots));
        let squares = pathfinding::prelude::Matrix::from_fn(60, 60, |(i, j)| {
            ((from[i].vector() - slots[j].vector()).norm_squared() * 1e6).round() as i64
        });
        let (least, _) = pathfinding::prelude::kuhn_munkres_min(&squares);
        let least_m2 = least as f64 * 1e-6;
        let sum_m2 = cost_m2(&from, &slots, &assign(&from, &slots));
        prop_assert!((sum_m2 - least_m2).abs() < 1e-6 * (1.0 + least_m2), "{sum_m2} {least_m2}");
    }

    #[test]
    fn many_and_few_allowed_ways_cost_what_another_solver_finds(
        (from, slots) in (120_usize..160, 0_usize..30).prop_flat_map(|(n, spare)| {
            (prop::collection::vec(offset(), n), prop::collection::vec(offset(), n + spare))
        }),
        (longest_first, squares, in_rows) in (any::<bool>(), any::<bool>(), any::<bool>()),
    ) {
        // In rows, so that many ways are equally long, and with more columns than those of a core.
        let placed = |o: &OffsetFrd| if in_rows { OffsetFrd::new((o.forward_m / 20.0).round() * 20.0, o.right_m.round(), 0.0) } else { *o };
        let place = |list: &[OffsetFrd]| list.iter().map(placed).collect::<Vec<_>>();
        let costs = Costs::between(&place(&from), &place(&slots));
        let total = if squares { Total::Squares } else { Total::Ways };
        let found = if longest_first { least_longest(&costs, total) } else { least_total(&costs, total) };
        prop_assert!(found.slots.iter().all(Option::is_some));
        let cost = |length: f64| if squares { length * length } else { length };
        let longest = if longest_first { found.longest } else { f64::INFINITY };
        let whole = pathfinding::prelude::Matrix::from_fn(from.len(), slots.len(), |(i, j)| {
            let length = costs.length(i, j);
            if length <= longest { (cost(length) * 1e6).round() as i64 } else { 1_i64 << 50 }
        });
        let (least, _) = pathfinding::prelude::kuhn_munkres_min(&whole);
        let least = least as f64 * 1e-6;
        let sum: f64 = found.slots.iter().enumerate().map(|(i, slot)| cost(costs.length(i, slot.unwrap()))).sum();
        prop_assert!((sum - least).abs() < 1e-6 * (1.0 + least), "{sum} {least}");
        if longest_first {
            let without = pathfinding::prelude::Matrix::from_fn(from.len(), slots.len(), |(i, j)| {
                i64::from(costs.length(i, j) >= found.longest)
            });
            prop_assert!(pathfinding::prelude::kuhn_munkres_min(&without).0 >= 1);
        }
    }

    #[test]
    fn the_least_longest_way_is_the_least_that_lets_everyone_through(
        from in prop::collection::vec(offset(), 40), slots in prop::collection::vec(offset(), 40),
    ) {
        let costs = Costs::between(&from, &slots);
        let found = least_longest(&costs, Total::Squares);
        prop_assert!(found.slots.iter().all(Option::is_some));
        // With only shorter ways allowed another solver must use a forbidden one.
        let without = pathfinding::prelude::Matrix::from_fn(40, 40, |(i, j)| {
            i64::from(costs.length(i, j) >= found.longest)
        });
        let (forbidden, _) = pathfinding::prelude::kuhn_munkres_min(&without);
        prop_assert!(forbidden >= 1);
        prop_assert!(found.longest <= least_total(&costs, Total::Squares).longest);
    }
}

#[test]
fn a_thousand_on_a_grid_change_places_the_shortest_way() {
    // All one cell to the side: the first column of the new places is the only one that is not taken already.
    let place = |i: usize, shift_m: f64| OffsetFrd::new((i / 32) as f64 * 5.0, (i % 32) as f64 * 5.0 + shift_m, 0.0);
    let from: Vec<_> = (0..1000).map(|i| place(i, 0.0)).collect();
    let slots: Vec<_> = (0..1000).rev().map(|i| place(i, 1.0)).collect();
    let found = least_longest(&Costs::between(&from, &slots), Total::Ways);
    assert!(
        (found.longest - 1.0).abs() < 1e-9 && (found.total - 1000.0).abs() < 1e-6,
        "{} {}",
        found.longest,
        found.total
    );
}

#[test]
fn pairs_can_be_forbidden_or_made_dearer() {
    let at = |right_m| OffsetFrd::new(0.0, right_m, 0.0);
    let places = [at(0.0), at(10.0), at(20.0)];
    let mut costs = Costs::between(&places, &places);
    assert_eq!(least_longest(&costs, Total::Ways).slots, [Some(0), Some(1), Some(2)]);
    costs.add(0, 0, 25.0);
    assert_eq!(least_longest(&costs, Total::Ways).slots, [Some(1), Some(0), Some(2)]);
    costs.forbid(2, 2);
    costs.forbid(2, 1);
    let found = least_longest(&costs, Total::Ways);
    assert_eq!((found.slots, found.longest), (vec![Some(1), Some(2), Some(0)], 20.0));
    for slot in 0..3 {
        costs.forbid(0, slot);
    }
    let found = least_total(&costs, Total::Ways);
    assert_eq!(found.slots, [None, Some(1), Some(0)]);
    assert_eq!((found.longest, found.total), (20.0, 20.0));
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
