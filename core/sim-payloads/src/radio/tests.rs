//! Path loss, and what a SiK radio makes of it.

use super::*;
use proptest::prelude::*;
use rand_chacha::rand_core::SeedableRng;

#[test]
fn ten_times_as_far_is_weaker_by_ten_times_the_exponent() {
    let settings = RadioSettings::default();
    assert!((settings.signal_dbm(100.0) - settings.signal_dbm(1000.0) - 27.0).abs() < 1e-9);
    assert_eq!(settings.signal_dbm(0.0), 20.0 - 31.7, "never nearer than a metre");
    let range_m = settings.distance_m(settings.sensitivity_dbm);
    assert!((settings.loss(settings.signal_dbm(range_m)) - 0.5).abs() < 1e-9);
    assert!((1000.0..3000.0).contains(&range_m), "{range_m}");
}

#[test]
fn near_by_nothing_is_lost_and_far_away_everything() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let near = PositionNed::new(50.0, 0.0, -20.0);
    let mut radio = Radio::new(RadioSettings::default(), &near, &mut rng);
    for _ in 0..1000 {
        radio.step(&near, 0.1, &mut rng);
    }
    assert_eq!(radio.errors(), 0);
    let far = PositionNed::new(20_000.0, 0.0, -20.0);
    for _ in 0..100 {
        radio.step(&far, 0.1, &mut rng);
    }
    assert!((490..=500).contains(&radio.errors()), "{}", radio.errors());
}

proptest! {
    #[test]
    fn raw_values_are_those_of_a_sik_radio(dbm in -200.0..50.0_f64) {
        let raw = sik_raw(dbm);
        prop_assert!(raw <= 254);
        if (-127.0..6.0).contains(&dbm) {
            prop_assert!((f64::from(raw) / 1.9 - 127.0 - dbm).abs() < 0.27);
        }
    }

    #[test]
    fn farther_is_never_better(near_m in 1.0..5000.0_f64, more_m in 0.0..5000.0_f64) {
        let settings = RadioSettings::default();
        let (near, far) = (settings.signal_dbm(near_m), settings.signal_dbm(near_m + more_m));
        prop_assert!(far <= near && settings.loss(far) >= settings.loss(near));
        prop_assert!((0.0..=1.0).contains(&settings.loss(far)));
        prop_assert!((settings.distance_m(near) - near_m).abs() < 1e-6 * near_m);
    }

    #[test]
    fn the_same_seed_gives_the_same_signal(seed in any::<u64>()) {
        let signal = || {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let at = PositionNed::new(300.0, 0.0, 0.0);
            let mut radio = Radio::new(RadioSettings::default(), &at, &mut rng);
            (0..50).for_each(|_| radio.step(&at, 0.5, &mut rng));
            radio.signal_dbm
        };
        prop_assert_eq!(signal(), signal());
    }
}
