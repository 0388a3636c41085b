//! The follower's setpoint: consistent with itself, carried on by the anchor's age, and on the leader's arc in a turn.

use super::*;
use proptest::prelude::*;
use skein_domain::{AccelerationNed, OffsetFrd, PositionNed, VelocityNed};

const NOW: NodeTime = NodeTime(60_000_000);

fn standing(offset: OffsetFrd) -> SlotMove {
    SlotMove {
        from: offset,
        to: offset,
        detour_up_m: 0.0,
        start: NodeTime(0),
        duration_s: 0.0,
    }
}

fn triple(limit: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-limit..limit).prop_map(Vector3::from)
}

prop_compose! {
    fn anchor()(
        position in triple(500.0), velocity in triple(10.0), acceleration in triple(3.0),
        heading_rad in -3.0..3.0, heading_rate_rad_s in -0.5..0.5, heading_acceleration_rad_s2 in -0.4..0.4,
    ) -> AnchorReference {
        AnchorReference {
            position: position.into(), velocity: velocity.into(), acceleration: acceleration.into(),
            heading_rad, heading_rate_rad_s, time: NOW, heading_acceleration_rad_s2,
        }
    }
}

proptest! {
    #[test]
    fn velocity_and_acceleration_are_those_of_the_position(
        anchor in anchor(), from in triple(50.0), to in triple(50.0), detour_up_m in -5.0..5.0_f64,
        age_s in 0.01..0.9_f64, duration_s in 5.0..30.0_f64, share in 0.05..0.95_f64,
    ) {
        let now = NOW.plus_seconds(age_s);
        let start = now.plus_seconds(-share * duration_s);
        let slot = SlotMove { from: from.into(), to: to.into(), detour_up_m, start, duration_s };
        let step_s = 1e-3;
        let at = |seconds: f64| setpoint(&anchor, &slot, now.plus_seconds(seconds));
        let (before, here, after) = (at(-step_s), at(0.0), at(step_s));
        let velocity = (after.position.unwrap().vector() - before.position.unwrap().vector()) / (2.0 * step_s);
        let acceleration = (after.velocity.unwrap().vector() - before.velocity.unwrap().vector()) / (2.0 * step_s);
        prop_assert!((velocity - here.velocity.unwrap().vector()).norm() < 1e-2);
        prop_assert!((acceleration - here.acceleration.unwrap().vector()).norm() < 5e-2);
        let turned = wrap_angle_rad(after.yaw_rad.unwrap() - before.yaw_rad.unwrap()) / (2.0 * step_s);
        prop_assert!((turned - here.yaw_rate_rad_s.unwrap()).abs() < 1e-6);
    }

    #[test]
    fn an_older_anchor_gives_the_same_setpoint(anchor in anchor(), offset in triple(50.0), age_s in 0.0..0.9) {
        // Two leaders' reports of the same constant motion, one older: the follower must not notice.
        let steady = AnchorReference {
            acceleration: AccelerationNed::default(), heading_rate_rad_s: 0.0, heading_acceleration_rad_s2: 0.0, ..anchor
        };
        let later = AnchorReference {
            position: steady.position.after(&steady.velocity, age_s), time: NOW.plus_seconds(age_s), ..steady
        };
        let slot = standing(offset.into());
        let now = NOW.plus_seconds(age_s);
        let (old, fresh) = (setpoint(&steady, &slot, now), setpoint(&later, &slot, now));
        prop_assert!(old.position.unwrap().distance_m(&fresh.position.unwrap()) < 1e-4);
        prop_assert_eq!(old.velocity, fresh.velocity);
    }
}

#[test]
fn in_a_turn_the_outer_slot_is_faster_on_a_common_circle() {
    // The leader flies 5 m/s to the north and turns right at 0.1 rad/s: the centre is 50 m to the east.
    let anchor = AnchorReference {
        velocity: VelocityNed::new(5.0, 0.0, 0.0),
        acceleration: AccelerationNed::new(0.0, 0.5, 0.0),
        heading_rate_rad_s: 0.1,
        time: NOW,
        ..AnchorReference::default()
    };
    let outer = setpoint(&anchor, &standing(OffsetFrd::new(0.0, -20.0, 0.0)), NOW);
    assert_eq!(outer.position, Some(PositionNed::new(0.0, -20.0, 0.0)));
    assert!((outer.velocity.unwrap().north_m_s - 7.0).abs() < 1e-12);
    // v²/r = 49/70, to the centre.
    assert!((outer.acceleration.unwrap().vector() - Vector3::new(0.0, 0.7, 0.0)).norm() < 1e-12);
    let inner = setpoint(&anchor, &standing(OffsetFrd::new(0.0, 20.0, 0.0)), NOW);
    assert!((inner.velocity.unwrap().north_m_s - 3.0).abs() < 1e-12);
}

#[test]
fn an_anchor_that_is_too_old_is_not_flown_on() {
    let anchor = AnchorReference {
        velocity: VelocityNed::new(5.0, 0.0, 0.0),
        time: NOW,
        ..AnchorReference::default()
    };
    let slot = standing(OffsetFrd::new(-10.0, 0.0, 0.0));
    let old = setpoint(&anchor, &slot, NOW.plus_seconds(60.0));
    assert_eq!(
        old.position,
        Some(PositionNed::new(5.0 * MAX_EXTRAPOLATION_S - 10.0, 0.0, 0.0))
    );
    assert_eq!(old.velocity, Some(VelocityNed::default()));
}

#[test]
fn an_anchor_from_the_future_counts_as_now() {
    let anchor = AnchorReference {
        velocity: VelocityNed::new(5.0, 0.0, 0.0),
        time: NOW,
        ..AnchorReference::default()
    };
    let early = setpoint(&anchor, &standing(OffsetFrd::default()), NodeTime(0));
    assert_eq!(early.position, Some(PositionNed::default()));
}

#[test]
fn numbers_that_are_not_finite_stay_visible() {
    let bad = AnchorReference {
        heading_rad: f64::NAN,
        time: NOW,
        ..AnchorReference::default()
    };
    assert!(!setpoint(&bad, &standing(OffsetFrd::new(1.0, 0.0, 0.0)), NOW).is_well_formed());
}
