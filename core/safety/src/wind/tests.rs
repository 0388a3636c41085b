//! The wind triangle, from its corners and at random.

use super::*;
use proptest::prelude::*;

fn blowing(north_m_s: f64, east_m_s: f64) -> Wind {
    Wind::Reported { north_m_s, east_m_s }
}

#[test]
fn known_triangles() {
    let near = |found: Option<f64>, expected: f64| {
        let found = found.expect("gets there");
        assert!((found - expected).abs() < 1e-9, "{found} instead of {expected}");
    };
    // Home lies north.
    near(blowing(0.0, 0.0).ground_speed_m_s(10.0, 0.0, 0.0), 10.0);
    near(blowing(4.0, 0.0).ground_speed_m_s(10.0, 0.0, 0.0), 14.0);
    near(blowing(-4.0, 0.0).ground_speed_m_s(10.0, 0.0, 0.0), 6.0);
    near(blowing(0.0, 6.0).ground_speed_m_s(10.0, 0.0, 0.0), 8.0);
    near(blowing(-4.0, 0.0).ground_speed_m_s(10.0, 0.0, 1.5), 4.5);
    near(
        Wind::Assumed { headwind_m_s: 3.0 }.ground_speed_m_s(10.0, 1.2, 0.0),
        7.0,
    );
}

#[test]
fn a_wind_as_fast_as_the_vehicle_is_not_overcome() {
    for wind in [
        blowing(-10.0, 0.0),
        blowing(0.0, 10.0),
        blowing(-9.8, 0.0),
        blowing(30.0, 30.0),
    ] {
        assert_eq!(wind.ground_speed_m_s(10.0, 0.0, 0.0), None, "{wind:?}");
    }
    for airspeed_m_s in [0.0, -1.0, f64::NAN] {
        assert_eq!(blowing(0.0, 0.0).ground_speed_m_s(airspeed_m_s, 0.0, 0.0), None);
    }
}

#[test]
fn a_report_that_is_not_finite_is_none() {
    let settings = EnergySettings::default();
    let assumed = Wind::Assumed {
        headwind_m_s: settings.assumed_wind_m_s,
    };
    let broken = VelocityNed::new(f64::NAN, 0.0, 0.0);
    assert_eq!(Wind::known_or_assumed(None, &settings), assumed);
    assert_eq!(Wind::known_or_assumed(Some(&broken), &settings), assumed);
    let good = VelocityNed::new(1.0, 2.0, 0.0);
    assert_eq!(Wind::known_or_assumed(Some(&good), &settings), blowing(1.0, 2.0));
}

proptest! {
    /// Speed over the ground and wind added up give the airspeed: the triangle closes.
    #[test]
    fn the_triangle_closes(n in -12.0..12.0_f64, e in -12.0..12.0_f64, airspeed in 5.0..25.0_f64, bearing in -7.0..7.0_f64) {
        if let Some(speed) = blowing(n, e).ground_speed_m_s(airspeed, bearing, 0.0) {
            let (north, east) = (speed * f64::cos(bearing) - n, speed * f64::sin(bearing) - e);
            prop_assert!((north.hypot(east) - airspeed).abs() < 1e-9);
        }
    }

    #[test]
    fn more_headwind_is_never_faster(head in 0.0..20.0_f64, more in 0.0..10.0_f64, across in -9.0..9.0_f64, airspeed in 5.0..25.0_f64) {
        let less = blowing(-head, across).ground_speed_m_s(airspeed, 0.0, 0.0);
        let more = blowing(-head - more, across).ground_speed_m_s(airspeed, 0.0, 0.0);
        prop_assert!(more.unwrap_or(0.0) <= less.unwrap_or(0.0));
    }
}
