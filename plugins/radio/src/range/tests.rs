//! Tests of the range: learned from flights through a world with shadows, whose true range is known.

use super::*;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const MEMORY_S: f64 = 120.0;
const MARGIN_DB: f64 = 10.0;
const THRESHOLDS: Thresholds = Thresholds {
    before_s: 20.0,
    share: 0.85,
};
const STEP_S: f64 = 0.5;

/// A link whose signal over noise falls off in a known way, with shadows that last some metres.
struct World {
    at_one_metre_db: f64,
    exponent: f64,
    shadow: Normal<f64>,
    present_shadow_db: f64,
    random: ChaCha8Rng,
}

impl World {
    /// One in which the signal is `MARGIN_DB` over the noise at `range_m` on average.
    fn new(exponent: f64, range_m: f64, shadow_db: f64, seed: u64) -> Self {
        Self {
            at_one_metre_db: MARGIN_DB + 10.0 * exponent * range_m.log10(),
            exponent,
            shadow: Normal::new(0.0, shadow_db).unwrap(),
            present_shadow_db: 0.0,
            random: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    fn snr_db(&mut self, distance_m: f64, moved_m: f64) -> f64 {
        // Shadows are alike within some twenty metres.
        let alike = (-moved_m / 20.0).exp();
        let fresh = self.shadow.sample(&mut self.random);
        self.present_shadow_db = alike * self.present_shadow_db + (1.0 - alike * alike).sqrt() * fresh;
        self.at_one_metre_db - 10.0 * self.exponent * distance_m.max(1.0).log10() + self.present_shadow_db
    }
}

/// Flies straight away and tells at which distance the warning came.
fn warned_at_m(world: &mut World, speed_m_s: f64, until_m: f64) -> Option<f64> {
    let mut learned = FallOff::default();
    let mut distance_m = 5.0;
    while distance_m < until_m {
        distance_m += speed_m_s * STEP_S;
        let snr_db = world.snr_db(distance_m, speed_m_s * STEP_S);
        learned.learn(distance_m, snr_db, STEP_S, MEMORY_S);
        let away = Away {
            distance_m,
            radial_m_s: speed_m_s,
        };
        let range_m = learned.range_m(MARGIN_DB);
        if range_m.is_some_and(|range_m| away.warns(range_m, THRESHOLDS, false)) {
            return Some(distance_m);
        }
    }
    None
}

proptest! {
    /// The radio still works with less than the margin: the link itself fails when nothing is left of it.
    #[test]
    fn the_warning_comes_before_the_link_fails(
        exponent in 2.0..4.0_f64, range_m in 200.0..3000.0_f64, shadow_db in 0.0..4.0_f64, speed_m_s in 2.0..15.0_f64, seed in any::<u64>(),
    ) {
        let mut world = World::new(exponent, range_m, shadow_db, seed);
        let fails_m = range_m * 10_f64.powf(MARGIN_DB / (10.0 * exponent));
        let warned_m = warned_at_m(&mut world, speed_m_s, fails_m);
        prop_assert!(warned_m.is_some(), "no warning before {fails_m:.0} m, range {range_m:.0} m");
        // And with time to turn round.
        let left_s = (fails_m - warned_m.unwrap()) / speed_m_s;
        prop_assert!(left_s > 5.0, "only {left_s:.0} s are left");
    }

    #[test]
    fn without_shadows_the_range_is_found(exponent in 2.0..4.0_f64, range_m in 200.0..3000.0_f64) {
        let mut world = World::new(exponent, range_m, 1e-9, 1);
        let mut learned = FallOff::default();
        let mut distance_m = 5.0;
        while distance_m < 0.7 * range_m {
            distance_m += 3.0;
            learned.learn(distance_m, world.snr_db(distance_m, 3.0), STEP_S, MEMORY_S);
        }
        let found_m = learned.range_m(MARGIN_DB).unwrap();
        prop_assert!((0.8..1.25).contains(&(found_m / range_m)), "{found_m:.0} m, not {range_m:.0} m");
    }

    #[test]
    fn no_warning_while_hovering_near(
        exponent in 2.0..4.0_f64, range_m in 300.0..3000.0_f64, shadow_db in 0.0..4.0_f64, near in 0.02..0.12_f64, seed in any::<u64>(),
    ) {
        let mut world = World::new(exponent, range_m, shadow_db, seed);
        let mut learned = FallOff::default();
        let distance_m = near * range_m;
        for step in 0..600 {
            // It drifts to and fro by a metre.
            let drift_m_s = 0.4 * (f64::from(step) * 0.2).sin();
            learned.learn(distance_m, world.snr_db(distance_m, 0.2), STEP_S, MEMORY_S);
            let away = Away { distance_m, radial_m_s: drift_m_s };
            let warns = learned.range_m(MARGIN_DB).is_some_and(|range_m| away.warns(range_m, THRESHOLDS, false));
            prop_assert!(!warns, "at {distance_m:.0} m of {range_m:.0} m, taken for {:?}", learned.range_m(MARGIN_DB));
        }
    }

    #[test]
    fn any_numbers_give_a_range(samples in prop::collection::vec((any::<f64>(), any::<f64>(), any::<f64>()), 0..50)) {
        let mut learned = FallOff::default();
        for (distance_m, snr_db, step_s) in samples {
            learned.learn(distance_m, snr_db.clamp(-200.0, 200.0), step_s, MEMORY_S);
        }
        let range_m = learned.range_m(MARGIN_DB);
        prop_assert!(range_m.is_none_or(|range_m| (1.0..=FARTHEST_M).contains(&range_m)), "{range_m:?}");
    }
}

#[test]
fn the_warning_ends_only_when_things_are_clearly_better() {
    let hovering = |distance_m: f64| Away {
        distance_m,
        radial_m_s: 0.0,
    };
    let range_m = 1000.0;
    assert!(!hovering(840.0).warns(range_m, THRESHOLDS, false));
    assert!(hovering(860.0).warns(range_m, THRESHOLDS, false));
    assert!(hovering(840.0).warns(range_m, THRESHOLDS, true));
    assert!(!hovering(700.0).warns(range_m, THRESHOLDS, true));
}

#[test]
fn whoever_flies_back_has_all_time() {
    let back = Away {
        distance_m: 400.0,
        radial_m_s: -10.0,
    };
    assert_eq!(back.out_of_range_in_s(500.0), None);
    assert!(!back.warns(500.0, THRESHOLDS, false));
    let away = Away {
        radial_m_s: 10.0,
        ..back
    };
    assert_eq!(away.out_of_range_in_s(500.0), Some(10.0));
    assert!(away.warns(500.0, THRESHOLDS, false));
    assert_eq!(away.out_of_range_in_s(300.0), Some(0.0));
}

#[test]
fn nothing_is_said_before_enough_was_measured() {
    let mut learned = FallOff::default();
    for _ in 0..8 {
        learned.learn(100.0, 20.0, 0.5, MEMORY_S);
    }
    assert_eq!(learned.range_m(MARGIN_DB), None);
    for _ in 0..4 {
        learned.learn(100.0, 20.0, 0.5, MEMORY_S);
    }
    // Ten decibels are left over the margin, and links usually fall by 28 per tenfold distance.
    let range_m = learned.range_m(MARGIN_DB).unwrap();
    assert!((range_m - 100.0 * 10_f64.powf(10.0 / 28.0)).abs() < 1.0, "{range_m}");
}
