//! The largest turning rate: no slot too fast in either turn, and none of the allowed speed left unused.

use super::*;
use crate::formation::slots;
use proptest::prelude::*;
use skein_domain::{FormationRequest, Shape};

/// Speed of a slot while the leader flies forward and the formation turns to the right.
fn slot_speed_m_s(slot: &OffsetFrd, leader_speed_m_s: f64, rate_rad_s: f64) -> f64 {
    (leader_speed_m_s - rate_rad_s * slot.right_m).hypot(rate_rad_s * slot.forward_m)
}

proptest! {
    #[test]
    fn no_slot_is_faster_than_the_limit_and_the_rate_is_the_largest(
        shape in prop::sample::select(&Shape::ALL[..Shape::ALL.len() - 1]), count in 2_usize..60, spacing_m in 2.0..20.0,
        leader_share in 0.0..1.0, max_speed_m_s in 1.0..20.0,
    ) {
        let slots = slots(&FormationRequest::new(shape, spacing_m), count).unwrap();
        let limit = max_speed_m_s * TURN_SPEED_SHARE;
        let leader = limit * leader_share;
        let rate = max_turn_rate_rad_s(&slots, leader, max_speed_m_s);
        let fastest = |rate: f64| {
            let both = |slot| slot_speed_m_s(slot, leader, rate).max(slot_speed_m_s(slot, leader, -rate));
            slots.iter().map(both).fold(0.0, f64::max)
        };
        prop_assert!(fastest(rate) <= limit * (1.0 + 1e-9));
        prop_assert!(rate == MAX_TURN_RATE_RAD_S || fastest(rate * 1.01 + 1e-9) > limit);
        let gentle = max_turn_rate_within_rad_s(&slots, leader, max_speed_m_s, 2.0);
        prop_assert!(gentle <= rate && gentle * fastest(gentle) <= 2.0 + 1e-9);
    }
}

#[test]
fn unusable_numbers_and_a_leader_at_the_limit_allow_no_turn() {
    let slots = slots(&FormationRequest::new(Shape::Line, 5.0), 5).unwrap();
    for (leader, max) in [
        (9.5, 10.0),
        (f64::NAN, 10.0),
        (5.0, f64::NAN),
        (5.0, f64::INFINITY),
        (0.0, 0.0),
    ] {
        assert_eq!(max_turn_rate_rad_s(&slots, leader, max), 0.0);
    }
    assert_eq!(
        max_turn_rate_rad_s(&[OffsetFrd::new(f64::NAN, 0.0, 0.0)], 5.0, 10.0),
        0.0
    );
    assert_eq!(max_turn_rate_within_rad_s(&slots, 5.0, 10.0, f64::NAN), 0.0);
    assert_eq!(
        max_turn_rate_rad_s(&[OffsetFrd::default()], 5.0, 10.0),
        MAX_TURN_RATE_RAD_S
    );
}
