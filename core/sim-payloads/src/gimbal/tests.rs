//! Limits that hold whatever is asked for, and angles that are reached.

use super::*;
use proptest::prelude::*;

const STEP_S: f64 = 0.004;

fn goal() -> impl Strategy<Value = AxisGoal> {
    prop_oneof![
        (-8.0..8.0_f64).prop_map(AxisGoal::Angle),
        (-8.0..8.0_f64).prop_map(AxisGoal::Rate),
        any::<f64>().prop_map(AxisGoal::Angle),
        any::<f64>().prop_map(AxisGoal::Rate),
    ]
}

proptest! {
    #[test]
    fn limits_are_never_exceeded_whatever_is_asked(
        asked in prop::collection::vec((goal(), goal(), -9.0..9.0_f64, 1_usize..300), 1..12),
        step_s in prop::sample::select(vec![0.004, 0.008, 0.02]),
    ) {
        let settings = GimbalSettings::default();
        let mut head = Head::new(settings);
        for (pitch, yaw, drift_rad_s, steps) in asked {
            for _ in 0..steps {
                let before = head;
                head.step(pitch, yaw, drift_rad_s, step_s);
                let (pitch_limits, yaw_limits) = head.limits();
                for (axis, old, limits) in [(head.pitch, before.pitch, pitch_limits), (head.yaw, before.yaw, yaw_limits)] {
                    prop_assert!((limits.min_rad..=limits.max_rad).contains(&axis.angle_rad), "{axis:?}");
                    prop_assert!(axis.rate_rad_s.abs() <= limits.rate_rad_s, "{axis:?}");
                    let acceleration = (axis.rate_rad_s - old.rate_rad_s) / step_s;
                    prop_assert!(acceleration.abs() <= limits.acceleration_rad_s2 * (1.0 + 1e-6), "{acceleration} {axis:?} {old:?}");
                    // The rate is what it really moves at, also into an end stop.
                    prop_assert!((axis.angle_rad - old.angle_rad - axis.rate_rad_s * step_s).abs() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn an_angle_within_the_limits_is_reached_without_overshoot(pitch_rad in -2.09..0.52_f64, yaw_rad in -3.1..3.1_f64) {
        let mut head = Head::new(GimbalSettings::default());
        let mut farthest = (0.0_f64, 0.0_f64);
        for _ in 0..(3.0 / STEP_S) as usize {
            head.step(AxisGoal::Angle(pitch_rad), AxisGoal::Angle(yaw_rad), 0.0, STEP_S);
            farthest = (farthest.0.max(head.pitch.angle_rad.abs()), farthest.1.max(head.yaw.angle_rad.abs()));
        }
        prop_assert!((head.pitch.angle_rad - pitch_rad).abs() < 1e-4 && (head.yaw.angle_rad - yaw_rad).abs() < 1e-4);
        prop_assert!(farthest.0 <= pitch_rad.abs() + 1e-9 && farthest.1 <= yaw_rad.abs() + 1e-9);
    }
}

#[test]
fn a_turn_takes_as_long_as_rate_and_acceleration_say() {
    let mut head = Head::new(GimbalSettings::default());
    let mut steps = 0;
    while (head.yaw.angle_rad - 90_f64.to_radians()).abs() > 1e-3 {
        head.step(AxisGoal::Angle(0.0), AxisGoal::Angle(90_f64.to_radians()), 0.0, STEP_S);
        steps += 1;
    }
    // One second at full rate, and an eighth of a second to get there and back.
    let seconds = f64::from(steps) * STEP_S;
    assert!((seconds - 1.125).abs() < 0.03, "{seconds}");
}
