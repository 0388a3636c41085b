//! What hardly changes is told as the same, what matters is not rounded away.

use super::*;
use skein_domain::EnergyLevel;

fn charge(remaining: f64, return_in_s: f64) -> EnergyState {
    EnergyState {
        remaining,
        needed_home: Some(0.2),
        reserve: 0.15,
        margin: remaining - 0.35,
        endurance_s: 612.3,
        return_in_s,
        level: EnergyLevel::Ok,
        learned: true,
        ground_speed_home_m_s: 7.96,
    }
}

#[test]
fn a_charge_that_hardly_changes_is_told_once() {
    assert_eq!(energy(charge(0.8001, 301.0)), energy(charge(0.7999, 299.0)));
    assert_ne!(energy(charge(0.80, 300.0)), energy(charge(0.79, 300.0)));
    assert_ne!(energy(charge(0.80, 300.0)), energy(charge(0.80, 310.0)));
    let told = energy(charge(0.2949, 12.4));
    assert_eq!((told.remaining, told.return_in_s), (0.29, 10.0));
}

#[test]
fn values_keep_their_first_digits() {
    for (value, told) in [(0.0, 0.0), (5.43, 5.4), (-12.7, -13.0), (0.3049, 0.3), (1234.0, 1200.0)] {
        assert!((to_digits(value) - told).abs() < 1e-9, "{value}: {}", to_digits(value));
    }
    assert!(to_digits(f64::NAN).is_nan());
}
