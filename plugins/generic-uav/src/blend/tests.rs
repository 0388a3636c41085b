//! Blends and stops join without a jump.

use super::*;
use proptest::prelude::*;

fn motion(numbers: [f64; 6]) -> Motion {
    let [a, b, c, d, e, f] = numbers;
    let (position, velocity) = (PositionNed::new(a, b, c), VelocityNed::new(d, e, f));
    Motion {
        position,
        velocity,
        ..Motion::default()
    }
}

proptest! {
    #[test]
    fn a_blend_begins_at_what_is_and_ends_at_the_plan(
        have in prop::array::uniform6(-10.0..10.0f64),
        plan in prop::array::uniform6(-10.0..10.0f64),
    ) {
        let (have, plan) = (motion(have), motion(plan));
        let Some(mut blend) = Blend::between(&have, &plan, &Settings::default()) else { return Ok(()) };
        let first = blend.apply(&plan);
        prop_assert!(first.position.distance_m(&have.position) < 1e-9);
        prop_assert!((first.velocity.vector() - have.velocity.vector()).norm() < 1e-9);
        let mut before = first;
        while blend.advance(0.02) {
            let now = blend.apply(&plan);
            // The plan stands still here, so that all motion is the blend's.
            let step = now.position.vector() - before.position.vector();
            let mean = (now.velocity.vector() + before.velocity.vector()) / 2.0 - plan.velocity.vector();
            prop_assert!((step - mean * 0.02).norm() < 1e-3, "velocity is not the rate of the position");
            before = now;
        }
        let last = blend.apply(&plan);
        prop_assert!(last.position.distance_m(&plan.position) < 1e-9);
        prop_assert!((last.velocity.vector() - plan.velocity.vector()).norm() < 1e-9);
    }

    #[test]
    fn a_stop_brakes_evenly(numbers in prop::array::uniform6(-10.0..10.0f64), share in 0.0..1.0f64) {
        let Motion { position, velocity, .. } = motion(numbers);
        let stop = Stop { from: position, velocity };
        let duration = stop.duration_s(2.0);
        let midway = stop.sample(duration * share, 2.0);
        prop_assert!((midway.velocity.norm() - velocity.norm() * (1.0 - share)).abs() < 1e-9);
        let end = stop.sample(f64::INFINITY, 2.0).position;
        prop_assert!((end.distance_m(&position) - velocity.norm().powi(2) / 4.0).abs() < 1e-9);
        prop_assert_eq!(stop.sample(duration + 1.0, 2.0).velocity.norm(), 0.0);
        prop_assert!(midway.position.is_finite() && midway.acceleration.norm() < 2.0 + 1e-9);
    }
}

#[test]
fn in_the_direction_of_flight_nothing_gets_faster_than_cruise() {
    // A plan that speeds up from rest in the very direction the vehicle already flies.
    let settings = Settings::default();
    let have = motion([0.0, 0.0, 0.0, 5.0, 0.0, 0.0]);
    let mut blend = Blend::between(&have, &Motion::default(), &settings).expect("they differ");
    for step in 0..400 {
        let t = f64::from(step) * 0.02;
        let speed = (settings.acceleration_m_s2 * t).min(5.0);
        let plan = motion([0.0, 0.0, 0.0, speed, 0.0, 0.0]);
        let north_m_s = blend.apply(&plan).velocity.north_m_s;
        assert!((-0.01..=5.01).contains(&north_m_s), "{north_m_s} m/s after {t} s");
        blend.advance(0.02);
    }
}

/// Begun while the formation was fast; then it stands, far away.
#[test]
fn what_was_begun_behind_a_fast_plan_is_hastened_once_that_stands() {
    let settings = Settings::default();
    let fast = motion([0.0, 0.0, 0.0, 10.0, 0.0, 0.0]);
    let mut blend = Blend::between(&motion([-300.0, 0.0, 0.0, 9.0, 0.0, 0.0]), &fast, &settings).expect("they differ");
    while blend.elapsed_s < 20.0 {
        assert_eq!(blend.hastened(&fast, &settings), blend, "it is as quick as it can be");
        blend.advance(0.02);
    }
    let stands = Motion::default();
    let hastened = blend.hastened(&stands, &settings);
    assert!(
        hastened.duration_s < 0.6 * (blend.duration_s - blend.elapsed_s),
        "{hastened:?} {blend:?}"
    );
    let (before, after) = (blend.apply(&stands), hastened.apply(&stands));
    assert!(before.position.distance_m(&after.position) < 1e-9);
    assert!((before.velocity.vector() - after.velocity.vector()).norm() < 1e-9);
    assert_eq!(hastened.hastened(&stands, &settings), hastened, "once is enough");
}
