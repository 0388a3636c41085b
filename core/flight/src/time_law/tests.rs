//! The time law: smooth, at rest at both ends, derivatives and peaks as stated.

use super::*;
use proptest::prelude::*;

const STEP: f64 = 1e-5;

fn differs(curve: impl Fn(f64) -> Curve, at: f64) -> (f64, f64) {
    let (before, here, after) = (curve(at - STEP), curve(at), curve(at + STEP));
    let first = (after.value - before.value) / (2.0 * STEP) - here.first;
    let second = (after.first - before.first) / (2.0 * STEP) - here.second;
    (first, second)
}

proptest! {
    #[test]
    fn derivatives_are_those_of_the_value(share in -0.2..1.2_f64, duration_s in 1.0..60.0) {
        // Also across the ends, where it stands still: speed and acceleration are continuous there.
        let t_s = share * duration_s;
        let bump_at = |t_s: f64| bump_over_time(progress(t_s, duration_s));
        for (first, second) in [differs(|t_s: f64| progress(t_s, duration_s), t_s), differs(bump_at, t_s)] {
            prop_assert!(first.abs() < 1e-3 && second.abs() < 2e-2, "{first} {second}");
        }
        let (first, second) = differs(bump, share.clamp(0.0, 1.0));
        prop_assert!(first.abs() < 1e-3 && second.abs() < 1e-3);
    }

    #[test]
    fn it_goes_forward_only_and_covers_the_same_at_both_ends(t_s in 0.0..60.0, duration_s in 0.1..60.0) {
        let (here, mirrored) = (progress(t_s, duration_s), progress(duration_s - t_s, duration_s));
        prop_assert!((0.0..=1.0).contains(&here.value) && here.first >= 0.0);
        prop_assert!((here.value + mirrored.value - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_slope_of_the_bump_is_bounded(share in 0.0..1.0, s1 in 0.0..1.0_f64, s2 in 0.0..1.0_f64) {
        let (low, high) = (s1.min(s2), s1.max(s2));
        let between = low + share * (high - low);
        prop_assert!(bump(between).first.abs() <= bump_slope_between(low, high) + 1e-12);
        prop_assert!((-1e-12..=1.0).contains(&bump(between).value));
    }

    #[test]
    fn a_duration_keeps_every_limit_and_wastes_little(
        way in prop::array::uniform3(-100.0..100.0),
        lift in prop_oneof![Just(0.0), -15.0..15.0],
        speed in 0.5..20.0, acceleration in 0.5..10.0, climb in 0.5..10.0,
    ) {
        let duration = duration_s(way, lift, &Ability { speed_m_s: speed, acceleration_m_s2: acceleration, climb_m_s: climb }, 0.0);
        let mut used = 0.0_f64;
        for k in 0..=5000 {
            let s = progress(duration * f64::from(k) / 5000.0, duration);
            let b = bump_over_time(s);
            let horizontal = way[0].hypot(way[1]);
            let (v, a) = (way[2] * s.first + lift * b.first, way[2] * s.second + lift * b.second);
            used = used
                .max((horizontal * s.first).hypot(v) / speed)
                .max(v.abs() / climb)
                .max((horizontal * s.second).hypot(a) / acceleration);
        }
        prop_assert!(used <= 1.0 + 1e-9, "{used}");
        prop_assert!(used >= 0.98, "{used}");
    }
}

#[test]
fn both_ends_are_at_rest() {
    for (t_s, value) in [(-1.0, 0.0), (0.0, 0.0), (10.0, 1.0), (70.0, 1.0)] {
        assert_eq!(
            progress(t_s, 10.0),
            Curve {
                value,
                first: 0.0,
                second: 0.0
            }
        );
    }
    assert_eq!((bump(0.0).value, bump(0.5).value, bump(1.0).value), (0.0, 1.0, 0.0));
}

#[test]
fn a_long_way_is_flown_at_the_speed_limit() {
    let ability = Ability {
        speed_m_s: 8.0,
        acceleration_m_s2: 3.0,
        climb_m_s: 2.0,
    };
    // 15.5 s at 8 m/s, and half of each ramp's 4 s.
    assert_eq!(duration_s([124.0, 0.0, 0.0], 0.0, &ability, 0.0), 19.5);
    // Short: limited by the acceleration, √(6 · 6 / 3) s.
    assert!((duration_s([6.0, 0.0, 0.0], 0.0, &ability, 0.0) - 12.0_f64.sqrt()).abs() < 1e-12);
    assert_eq!(duration_s([0.0, 0.0, 0.0], 0.0, &ability, 0.0), 0.0);
}

#[test]
fn numbers_that_are_not_finite_do_not_loop() {
    let ability = Ability {
        speed_m_s: 8.0,
        acceleration_m_s2: 3.0,
        climb_m_s: 2.0,
    };
    for odd in [f64::NAN, f64::INFINITY, 1e300] {
        duration_s([odd, 0.0, 0.0], 1.0, &ability, 0.0);
        duration_s([1.0, 0.0, 0.0], odd, &ability, 0.0);
        progress(odd, 10.0);
        progress(1.0, odd);
    }
}
