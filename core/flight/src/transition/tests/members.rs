//! Members that are not alike: slow ones, those with a view to keep, those that hold a slot, and those without a leader.

use super::*;
use crate::formation::{View, views};
use skein_safety::avoidance::{self, AvoidanceSettings};

fn able(max_speed_m_s: f64) -> FlightLimits {
    FlightLimits {
        max_speed_m_s,
        max_climb_m_s: 3.0,
        max_descent_m_s: 2.0,
        max_acceleration_m_s2: 4.0,
        min_turn_radius_m: 0.0,
        endurance_s: None,
        keeps_view: false,
    }
}

fn index_of(slots: &[OffsetFrd], place: &OffsetFrd) -> usize {
    slots.iter().position(|slot| slot == place).unwrap()
}

proptest! {
    // Where no way is found the change is refused, which may happen to one in hundreds, not to more.
    #![proptest_config(ProptestConfig { cases: 48, max_global_rejects: 2, ..ProptestConfig::default() })]

    #[test]
    fn each_keeps_to_its_own_limits(
        from in starts(2.5), shape in prop::sample::select(shapes()), led in any::<bool>(), taken_m_s in 0.0..4.0,
        speeds in prop::collection::vec(2.0..15.0, 50), climbs in prop::collection::vec(0.5..4.0, 50),
    ) {
        let request = FormationRequest::new(shape, 5.0);
        let slots = if led {
            formation::slots(&request, from.len()).unwrap()
        } else {
            formation::centred_slots(&request, from.len()).unwrap()
        };
        let able: Vec<FlightLimits> = speeds
            .iter()
            .zip(&climbs)
            .take(from.len())
            .map(|(speed, climb)| FlightLimits { max_climb_m_s: *climb, ..able(*speed) })
            .collect();
        let change = Change { able: &able, led, taken_m_s, ..Change::new(&from, &slots, &LIMITS) };
        let plan = change.plan(START).map_err(|refused| TestCaseError::reject(refused.to_string()))?;
        prop_assert!(flown_min_distance_m(&plan, 200) >= plan.min_distance_m - 1e-6);
        prop_assert!(plan.min_distance_m >= 0.8 * 2.5 - 0.01);
        let mut left = slots.clone();
        for (slot, able) in plan.moves.iter().zip(&able) {
            let spare_m_s = (0.9 * able.max_speed_m_s - taken_m_s).max(0.1 * able.max_speed_m_s.min(LIMITS.speed_m_s));
            let limits = MotionLimits {
                speed_m_s: LIMITS.speed_m_s.min(spare_m_s),
                climb_m_s: LIMITS.climb_m_s.min(able.max_climb_m_s).min(able.max_descent_m_s),
                ..LIMITS
            };
            let own = TransitionPlan { moves: vec![*slot], ..plan.clone() };
            prop_assert!(used_shares(&own, &limits).iter().all(|used| *used <= 1.0 + ROUNDING));
            left.swap_remove(index_of(&left, &slot.to));
        }
        if led {
            prop_assert_eq!(plan.moves[0].to, OffsetFrd::default());
        }
    }

    #[test]
    fn another_spacing_or_rotation_keeps_everyone_in_its_slot(
        shape in prop::sample::select(shapes()), count in 2_usize..60, spacing_m in 5.0..8.0, scale in 0.8..2.0,
        rotation_deg in -25.0..25.0, order in any::<u64>(),
    ) {
        let before = FormationRequest::new(shape, spacing_m);
        let after = FormationRequest { scale, rotation_deg, ..before.clone() };
        let former = formation::slots(&before, count).unwrap();
        let slots = formation::slots(&after, count).unwrap();
        // The members are in their slots in some order.
        let mut from = former.clone();
        let shift = 1 + order as usize % (count - 1).max(1);
        from[1..].rotate_left(shift % (count - 1).max(1));
        let held = held_slots(&from, &former);
        let change = Change { held: Some(&held), ..Change::new(&from, &slots, &LIMITS) };
        let plan = change.plan(START).unwrap();
        let others = Change::new(&from, &slots, &LIMITS).plan(START).unwrap();
        let stayed = plan.moves.iter().zip(&held).all(|(slot, held)| slot.to == slots[*held]);
        prop_assert!(plan.duration_s <= 1.2 * others.duration_s + 1e-6);
        // Straight ways away from the leader cannot cross; only much longer ones are given up for others.
        prop_assert!(stayed || others.duration_s < plan.duration_s + 1e-6);
        if rotation_deg.abs() < 5.0 {
            prop_assert!(stayed, "{:?}", shape);
        }
    }
}

#[test]
fn a_slow_member_gets_the_short_way() {
    // Two in a row ahead of two slots: either both go 20 m, or one goes 10 m and the other 30 m.
    let at = |forward_m, right_m| OffsetFrd::new(forward_m, right_m, 0.0);
    let from = [at(0.0, 0.0), at(-10.0, 20.0), at(-20.0, 20.0)];
    let slots = [at(0.0, 0.0), at(-40.0, 20.0), at(-30.0, 20.0)];
    for slow in [1, 2] {
        let mut members = [able(12.0); 3];
        members[slow] = able(2.0);
        let change = Change {
            able: &members,
            ..Change::new(&from, &slots, &LIMITS)
        };
        let plan = change.plan(START).unwrap();
        assert_eq!(plan.moves[slow].to, slots[2], "{slow}");
        // It stretches the move of all.
        assert!(plan.duration_s > 10.0 / 1.8);
        assert!(plan.moves.iter().all(|slot| slot.duration_s == plan.duration_s));
    }
}

#[test]
fn a_camera_gets_a_slot_with_nobody_ahead() {
    for shape in [
        Shape::Wedge,
        Shape::Grid,
        Shape::Line,
        Shape::EchelonLeft,
        Shape::Circle,
    ] {
        let slots = formation::slots(&FormationRequest::new(shape, 5.0), 20).unwrap();
        let free = views(&slots);
        let from: Vec<OffsetFrd> = (0..20).map(|i| OffsetFrd::new(f64::from(-i) * 4.0, 6.0, 0.0)).collect();
        let mut members = [able(12.0); 20];
        // The last in the row is far from the front.
        members[19].keeps_view = true;
        let change = Change {
            able: &members,
            ..Change::new(&from, &slots, &LIMITS)
        };
        let plan = change.plan(START).unwrap();
        let got = free[index_of(&slots, &plan.moves[19].to)];
        assert_eq!(got, View::Ahead, "{shape:?}");
    }
}

/// The largest share of the speed at which the filter lets two close that any two moves use, looked at `steps` times. Two that end, or have
/// to pass, nearer than the filter likes are left out: there is no speed for that.
fn most_used(plan: &TransitionPlan, filter: &AvoidanceSettings, steps: u32) -> f64 {
    let looked = |a: &SlotMove, b: &SlotMove, steps: u32| {
        let used = |k: u32| {
            let now = START.plus_seconds(plan.duration_s * f64::from(k) / f64::from(steps));
            let (a, b) = (sample(a, now), sample(b, now));
            let apart = b.offset.vector() - a.offset.vector();
            avoidance::used_share(&apart, &(a.velocity - b.velocity), 0.1, filter)
        };
        (0..=steps)
            .map(used)
            .try_fold(0.0, |most, used| Some(f64::max(most, used?)))
    };
    let of_pair = |a: &SlotMove, b: &SlotMove| match looked(a, b, steps)? {
        // Whoever passes too near does so for a moment that may lie between two looks.
        much if much > 1.0 => looked(a, b, 20 * steps),
        used => Some(used),
    };
    let pairs = plan.moves.iter().enumerate();
    pairs
        .flat_map(|(i, a)| plan.moves[i + 1..].iter().filter_map(move |b| of_pair(a, b)))
        .fold(0.0, f64::max)
}

/// As they are unless configured otherwise: a little more than what the filter keeps them apart by.
const APART: MotionLimits = MotionLimits {
    speed_m_s: 6.0,
    min_distance_m: 2.8,
    ..LIMITS
};

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, max_global_rejects: 2, ..ProptestConfig::default() })]

    #[test]
    fn nobody_closes_faster_than_the_filter_lets_it(
        from in starts(3.5), shape in prop::sample::select(shapes()), led in any::<bool>(),
    ) {
        let request = FormationRequest::new(shape, 5.0);
        let slots = if led {
            formation::slots(&request, from.len()).unwrap()
        } else {
            formation::centred_slots(&request, from.len()).unwrap()
        };
        let filter = AvoidanceSettings::default();
        let change = Change { led, ..Change::new(&from, &slots, &APART) };
        let plan = change.plan(START).map_err(|refused| TestCaseError::reject(refused.to_string()))?;
        let slower = Change { filter: Some(&filter), ..change }.plan(START).unwrap();
        let same = |a: &SlotMove, b: &SlotMove| (a.from, a.to, a.detour_up_m) == (b.from, b.to, b.detour_up_m);
        prop_assert!(plan.moves.iter().zip(&slower.moves).all(|(a, b)| same(a, b)));
        prop_assert!(slower.duration_s >= plan.duration_s);
        let used = most_used(&slower, &filter, 200);
        prop_assert!(used <= 1.0, "{used} of what is permitted, {} s instead of {}", slower.duration_s, plan.duration_s);
    }
}

#[test]
fn who_goes_straight_for_the_leader_brakes_in_time_for_the_filter() {
    let place = |away_m: f64| OffsetFrd::new(-away_m, away_m, 0.0);
    let (from, slots) = ([place(0.0), place(14.1)], [place(0.0), place(3.5)]);
    let filter = AvoidanceSettings::default();
    let change = Change::new(&from, &slots, &APART);
    let plan = change.plan(START).unwrap();
    assert!(most_used(&plan, &filter, 500) > 1.0);
    let change = Change {
        filter: Some(&filter),
        ..change
    };
    let slower = change.plan(START).unwrap();
    assert!(most_used(&slower, &filter, 500) <= 1.0);
    assert!(slower.duration_s < 2.0 * plan.duration_s, "{} s", slower.duration_s);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, max_global_rejects: 8, ..ProptestConfig::default() })]

    #[test]
    fn no_detour_leads_lower_than_may_be_flown(
        from in starts(3.5), shape in prop::sample::select(shapes()), room_m in 0.0..6.0,
    ) {
        let slots = formation::slots(&FormationRequest::new(shape, 5.0), from.len()).unwrap();
        let ends_m = from.iter().chain(&slots).map(|place| place.down_m).fold(0.0, f64::max);
        let lowest_m = ends_m + room_m;
        let change = Change { lowest_down_m: Some(lowest_m), ..Change::new(&from, &slots, &APART) };
        let plan = change.plan(START).map_err(|refused| TestCaseError::reject(refused.to_string()))?;
        for slot in &plan.moves {
            for k in 0..=200 {
                let here = sample(slot, START.plus_seconds(plan.duration_s * f64::from(k) / 200.0));
                prop_assert!(here.offset.down_m <= lowest_m + 1e-9, "{:?} of {lowest_m}", here.offset);
            }
        }
    }
}

#[test]
fn without_a_leader_the_first_moves_too() {
    let slots = formation::centred_slots(&FormationRequest::new(Shape::Line, 10.0), 3).unwrap();
    let from = [
        OffsetFrd::new(0.0, 30.0, 0.0),
        OffsetFrd::new(0.0, 40.0, 0.0),
        OffsetFrd::new(0.0, 50.0, 0.0),
    ];
    let change = Change {
        led: false,
        ..Change::new(&from, &slots, &LIMITS)
    };
    let plan = change.plan(START).unwrap();
    let rights: Vec<f64> = plan.moves.iter().map(|slot| slot.to.right_m.round()).collect();
    assert_eq!(rights, [-10.0, 0.0, 10.0]);
    assert_eq!(plan.moves[0].from, from[0]);
}

#[test]
fn lists_of_members_that_do_not_fit_are_refused() {
    let zero = OffsetFrd::default();
    let (from, slots) = ([zero, zero], [zero, OffsetFrd::new(5.0, 0.0, 0.0)]);
    let refused = |able: &[FlightLimits], held: Option<&[usize]>| {
        let change = Change {
            able,
            held,
            ..Change::new(&from, &slots, &LIMITS)
        };
        change.plan(START).unwrap_err()
    };
    let entries = |list| FormationError::ListDoesNotFit {
        list,
        members: 2,
        entries: 1,
    };
    assert_eq!(refused(&[able(5.0)], None), entries("limits"));
    assert_eq!(refused(&[], Some(&[0])), entries("held slots"));
    assert!(matches!(
        refused(&[able(5.0), able(f64::NAN)], None),
        FormationError::InvalidLimit {
            limit: "max_speed_m_s",
            ..
        }
    ));
    // Held slots that cannot be are none.
    let apart = [zero, OffsetFrd::new(9.0, 0.0, 0.0)];
    for held in [[0, 7], [0, 0], [1, 0]] {
        let change = Change {
            held: Some(&held),
            ..Change::new(&apart, &slots, &LIMITS)
        };
        assert_eq!(change.plan(START).unwrap().moves[1].to, slots[1]);
    }
}
