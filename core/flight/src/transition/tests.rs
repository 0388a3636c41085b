//! Transitions: the planned distance is the flown one, limits are kept, everybody arrives.

use super::*;
use crate::formation;
use crate::time_law::Ability;
use proptest::prelude::*;
use skein_domain::{FormationRequest, Shape};

mod members;

const LIMITS: MotionLimits = MotionLimits {
    speed_m_s: 8.0,
    acceleration_m_s2: 3.0,
    climb_m_s: 2.5,
    min_distance_m: 2.5,
};
const START: NodeTime = NodeTime(7_000_000);

/// All shapes that need nothing but a spacing.
fn shapes() -> Vec<Shape> {
    Shape::ALL
        .iter()
        .copied()
        .filter(|shape| *shape != Shape::Free)
        .collect()
}

fn slots(shape: Shape, count: usize, spacing_m: f64, altitude_step_m: f64) -> Result<Vec<OffsetFrd>, FormationError> {
    let request = FormationRequest {
        altitude_step_m,
        ..FormationRequest::new(shape, spacing_m)
    };
    formation::slots(&request, count)
}

/// Tolerance of times in whole microseconds, in shares.
const ROUNDING: f64 = 1e-6;

/// Smallest distance between any two moves, looked at `steps` times.
fn flown_min_distance_m(plan: &TransitionPlan, steps: u32) -> f64 {
    let mut least_m = f64::INFINITY;
    for k in 0..=steps {
        let now = START.plus_seconds(plan.duration_s * f64::from(k) / f64::from(steps));
        let places: Vec<_> = plan
            .moves
            .iter()
            .map(|slot| sample(slot, now).offset.vector())
            .collect();
        for (i, a) in places.iter().enumerate() {
            for b in &places[i + 1..] {
                least_m = least_m.min((a - b).norm());
            }
        }
    }
    least_m
}

/// The largest speed, acceleration and climb of any move, in shares of the limits.
fn used_shares(plan: &TransitionPlan, limits: &MotionLimits) -> [f64; 3] {
    let mut used = [0.0_f64; 3];
    for slot in &plan.moves {
        for k in 0..=500 {
            let now = START.plus_seconds(plan.duration_s * f64::from(k) / 500.0);
            let here = sample(slot, now);
            used[0] = used[0].max(here.velocity.norm() / limits.speed_m_s);
            used[1] = used[1].max(here.acceleration.norm() / limits.acceleration_m_s2);
            used[2] = used[2].max(here.velocity.z.abs() / limits.climb_m_s);
        }
    }
    used
}

/// Vehicles on a jittered grid: any two at least `least_m` apart, in any order, the leader one of them at zero.
fn starts(least_m: f64) -> impl Strategy<Value = Vec<OffsetFrd>> {
    let jitter = 0.6;
    let cell_m = least_m + 2.0 * jitter;
    (2_usize..=50).prop_flat_map(move |count| {
        let cells: Vec<usize> = (0..100).collect();
        let cells = Just(cells).prop_shuffle();
        let jitters = prop::collection::vec(prop::array::uniform3(-jitter..jitter), count);
        (cells, jitters).prop_map(move |(cells, jitters)| {
            let place = |(cell, j): (&usize, &[f64; 3])| {
                Vector3::new(
                    (cell / 10) as f64 * cell_m + j[0],
                    (cell % 10) as f64 * cell_m + j[1],
                    2.0 * j[2],
                )
            };
            let places: Vec<_> = cells.iter().zip(&jitters).map(place).collect();
            places.iter().map(|p| (p - places[0]).into()).collect()
        })
    })
}

/// Eight rows of seven at five metres, the leader anywhere in it, seen in some heading.
fn launch_grid(leader: usize, heading_rad: f64) -> Vec<OffsetFrd> {
    let place = |i: usize| Vector3::new((i / 7) as f64 * 5.0, (i % 7) as f64 * 5.0, 0.0);
    let order = std::iter::once(leader).chain((0..50).filter(|i| *i != leader));
    order
        .map(|i| OffsetFrd::from_ned(place(i) - place(leader), heading_rad))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn the_planned_distance_is_the_flown_one_and_limits_are_kept(
        from in starts(2.5),
        shape in prop::sample::select(shapes()),
        spacing_m in 2.5..8.0,
        climb_m_s in 0.5..4.0,
    ) {
        let targets = slots(shape, from.len(), spacing_m, 0.0).unwrap();
        let limits = MotionLimits { climb_m_s, ..LIMITS };
        let plan = plan(&from, &targets, &limits, START).unwrap();
        prop_assert!(plan.min_distance_m >= 0.8 * 2.5 - 0.01, "{}", plan.min_distance_m);
        let flown_m = flown_min_distance_m(&plan, 300);
        prop_assert!(flown_m >= plan.min_distance_m - 1e-6, "{flown_m} < {}", plan.min_distance_m);
        prop_assert!(used_shares(&plan, &limits).iter().all(|used| *used <= 1.0 + ROUNDING));
    }

    #[test]
    fn with_a_metre_to_spare_the_asked_distance_is_kept_in_full(
        from in starts(3.5),
        shape in prop::sample::select(shapes()),
        step_m in prop_oneof![Just(0.0), 0.1..1.0],
    ) {
        // A sphere's places may come too close by it.
        let step_m = if shape == Shape::Sphere { 0.0 } else { step_m };
        let targets = slots(shape, from.len(), 5.0, step_m).unwrap();
        let plan = plan(&from, &targets, &LIMITS, START).unwrap();
        prop_assert!(plan.min_distance_m >= 2.49, "{}", plan.min_distance_m);
    }

    #[test]
    fn everybody_ends_in_a_slot_of_its_own_and_the_leader_stays(
        from in starts(2.5),
        shape in prop::sample::select(shapes()),
    ) {
        let targets = slots(shape, from.len() + 2, 5.0, 0.0).unwrap();
        let plan = plan(&from, &targets, &LIMITS, START).unwrap();
        let zero = OffsetFrd::default();
        prop_assert_eq!((plan.moves[0].from, plan.moves[0].to, plan.moves[0].detour_up_m), (zero, zero, 0.0));
        let mut left = targets[1..].to_vec();
        for (slot, start) in plan.moves.iter().zip(&from).skip(1) {
            prop_assert_eq!(slot.from, *start);
            prop_assert_eq!((slot.start, slot.duration_s), (START, plan.duration_s));
            let at = left.iter().position(|target| *target == slot.to);
            prop_assert!(at.is_some(), "{:?} is no free slot", slot.to);
            left.swap_remove(at.unwrap());
        }
    }

    #[test]
    fn a_sample_has_the_derivatives_of_its_position(
        from in prop::array::uniform3(-50.0..50.0), to in prop::array::uniform3(-50.0..50.0),
        detour_up_m in -10.0..10.0, duration_s in 1.0..30.0, share in 0.01..0.99,
    ) {
        let offset = |[f, r, d]: [f64; 3]| OffsetFrd::new(f, r, d);
        let slot = SlotMove { from: offset(from), to: offset(to), detour_up_m, start: START, duration_s };
        let step_s = 1e-3;
        let at = |seconds: f64| sample(&slot, START.plus_seconds(share * duration_s + seconds));
        let (before, here, after) = (at(-step_s), at(0.0), at(step_s));
        let velocity = (after.offset.vector() - before.offset.vector()) / (2.0 * step_s);
        let acceleration = (after.velocity - before.velocity) / (2.0 * step_s);
        prop_assert!((velocity - here.velocity).norm() < 1e-2 * (1.0 + velocity.norm()));
        prop_assert!((acceleration - here.acceleration).norm() < 1e-2 * (1.0 + acceleration.norm()));
    }
}

#[test]
fn fifty_vehicles_change_between_all_shapes_from_the_launch_grid() {
    let shape_slots = |shape: Shape| slots(shape, 50, 5.0, 0.0).unwrap();
    for (leader, heading_rad) in [(0, 0.0), (0, 0.7), (24, 0.0), (24, 2.1), (49, 3.0)] {
        for first in &shapes() {
            let mut plans =
                vec![plan(&launch_grid(leader, heading_rad), &shape_slots(*first), &LIMITS, START).unwrap()];
            for next in &shapes() {
                let from: Vec<_> = plans[0].moves.iter().map(|slot| slot.to).collect();
                plans.push(plan(&from, &shape_slots(*next), &LIMITS, START).unwrap());
            }
            for plan in &plans {
                assert!(
                    plan.min_distance_m >= 2.49,
                    "{leader} {heading_rad} {first:?}: {}",
                    plan.min_distance_m
                );
                assert!(flown_min_distance_m(plan, 200) >= plan.min_distance_m - 1e-6);
                // Detours cost no more than a few seconds over the time of the longest straight way.
                let straight_s = plan.moves.iter().map(straight_s).fold(0.0, f64::max);
                assert!(
                    plan.duration_s <= straight_s + 6.0,
                    "{leader} {first:?}: {} {straight_s}",
                    plan.duration_s
                );
            }
        }
    }
}

fn straight_s(slot: &SlotMove) -> f64 {
    let way = slot.to.vector() - slot.from.vector();
    let ability = Ability {
        speed_m_s: 8.0,
        acceleration_m_s2: 3.0,
        climb_m_s: 2.5,
    };
    crate::time_law::duration_s([way.x, way.y, way.z], 0.0, &ability, 0.0)
}

#[test]
fn a_follower_right_ahead_passes_over_the_leader() {
    let from = [OffsetFrd::default(), OffsetFrd::new(10.0, 0.0, 0.0)];
    let targets = slots(Shape::Column, 2, 10.0, 0.0).unwrap();
    let plan = plan(&from, &targets, &LIMITS, START).unwrap();
    assert!(plan.moves[1].detour_up_m >= 2.5);
    assert!(plan.min_distance_m >= 2.49);
    let half = sample(&plan.moves[1], START.plus_seconds(plan.duration_s / 2.0));
    assert!(
        (half.offset.down_m + plan.moves[1].detour_up_m).abs() < 1e-6,
        "{half:?}"
    );
}

#[test]
fn who_is_in_place_stays_there_at_once() {
    let targets = slots(Shape::Wedge, 7, 5.0, 0.5).unwrap();
    let plan = plan(&targets, &targets, &LIMITS, START).unwrap();
    assert_eq!(plan.duration_s, 0.0);
    assert!(
        plan.moves
            .iter()
            .all(|slot| slot.from == slot.to && slot.detour_up_m == 0.0)
    );
}

#[test]
fn one_alone_has_nobody_to_come_close_to() {
    let plan = plan(&[OffsetFrd::default()], &[OffsetFrd::default()], &LIMITS, START).unwrap();
    assert_eq!(
        (plan.moves.len(), plan.duration_s, plan.min_distance_m),
        (1, 0.0, f64::INFINITY)
    );
}

#[test]
fn what_cannot_be_planned_is_refused_with_its_reason() {
    let zero = OffsetFrd::default();
    let bad = OffsetFrd::new(0.0, f64::NAN, 0.0);
    assert_eq!(plan(&[], &[], &LIMITS, START), Err(FormationError::NoMembers));
    let short = plan(&[zero, zero], &[zero], &LIMITS, START);
    assert_eq!(short, Err(FormationError::NotEnoughSlots { members: 2, slots: 1 }));
    assert_eq!(
        plan(&[zero, bad], &[zero; 2], &LIMITS, START),
        Err(FormationError::NotFinite { index: 1 })
    );
    assert_eq!(
        plan(&[zero; 2], &[bad, zero], &LIMITS, START),
        Err(FormationError::NotFinite { index: 0 })
    );
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let limits = MotionLimits {
            climb_m_s: value,
            ..LIMITS
        };
        let refused = plan(&[zero], &[zero], &limits, START);
        assert!(matches!(
            refused,
            Err(FormationError::InvalidLimit { limit: "climb_m_s", .. })
        ));
    }
}

#[test]
fn before_and_after_the_move_the_slot_stands_still() {
    let (from, to) = (OffsetFrd::new(1.0, 2.0, 3.0), OffsetFrd::new(4.0, 5.0, 6.0));
    let slot = SlotMove {
        from,
        to,
        detour_up_m: 2.0,
        start: START,
        duration_s: 10.0,
    };
    let still = |offset| SlotSample {
        offset,
        velocity: Vector3::zeros(),
        acceleration: Vector3::zeros(),
    };
    assert_eq!(sample(&slot, NodeTime(0)), still(from));
    assert_eq!(sample(&slot, START.plus_seconds(10.0)), still(to));
    for duration_s in [0.0, -1.0, f64::NAN] {
        assert_eq!(sample(&SlotMove { duration_s, ..slot }, START), still(to));
    }
    let lost = sample(
        &SlotMove {
            from: OffsetFrd::new(f64::NAN, 0.0, 0.0),
            ..slot
        },
        START.plus_seconds(5.0),
    );
    assert!(!lost.offset.is_finite(), "the gate must see that it is not a number");
}
