//! The model alone: what it asks for, that it never promises what the charge does not pay for, and what it learns.

mod flights;

use super::*;
use proptest::prelude::*;
use skein_domain::PositionNed;

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(100.0 + seconds)
}

fn sample(remaining: f32) -> EnergySample {
    EnergySample {
        battery: Battery {
            remaining: Some(remaining),
            ..Battery::default()
        },
        simulated: false,
        airborne: true,
        velocity: Some(VelocityNed::default()),
        wind: Some(VelocityNed::default()),
    }
}

fn way(distance_m: f64) -> WayHome {
    WayHome {
        distance_m,
        bearing_rad: 0.0,
        climb_m: 0.0,
        descent_m: 20.0,
        receding_m_s: 0.0,
    }
}

/// One look with everything fresh.
fn look(remaining: f64, way: &WayHome, wind: Option<VelocityNed>, settings: &EnergySettings) -> EnergyState {
    let mut estimator = EnergyEstimator::new();
    let sample = EnergySample {
        wind,
        ..sample(remaining as f32)
    };
    estimator.observe(at(0.0), &sample, settings);
    estimator.assess(at(0.0), way, settings).expect("known")
}

#[test]
fn the_way_home_costs_what_the_sum_says() {
    let settings = EnergySettings::default();
    let state = look(0.8, &way(960.0), Some(VelocityNed::new(-2.0, 0.0, 0.0)), &settings);
    // 960 m at 8 - 2 - 1 m/s, then 20 s down and 15 s over the place, of 1200 s in all, with three tenths more for the error.
    let expected = (960.0 / 5.0 + 20.0 + 15.0) / 1200.0 * 1.3;
    assert!(
        (state.needed_home.expect("reachable") - expected).abs() < 1e-9,
        "{state:?}"
    );
    assert!((state.ground_speed_home_m_s - 5.0).abs() < 1e-9);
    assert!((state.margin - (0.8_f64 - expected - 0.15)).abs() < 1e-6);
    assert!((state.endurance_s - 960.0).abs() < 1e-3);
    assert_eq!((state.level, state.learned), (EnergyLevel::Ok, false));
}

#[test]
fn the_levels_come_in_their_order_as_the_charge_falls() {
    let settings = EnergySettings::default();
    let way = way(800.0);
    let mut levels = Vec::new();
    for percent in (1..=100).rev() {
        let state = look(
            f64::from(percent) / 100.0,
            &way,
            Some(VelocityNed::default()),
            &settings,
        );
        if levels.last() != Some(&state.level) {
            levels.push(state.level);
        }
    }
    let all = [
        EnergyLevel::Ok,
        EnergyLevel::ReplanSoon,
        EnergyLevel::ReturnNow,
        EnergyLevel::LandNow,
    ];
    assert_eq!(levels, all);
}

#[test]
fn a_wind_that_cannot_be_overcome_is_said() {
    let settings = EnergySettings::default();
    let state = look(0.9, &way(500.0), Some(VelocityNed::new(-9.0, 0.0, 0.0)), &settings);
    assert_eq!((state.needed_home, state.level), (None, EnergyLevel::LandNow));
    assert_eq!(state.ground_speed_home_m_s, 0.0);
    // With it from behind home is easy.
    let state = look(0.9, &way(500.0), Some(VelocityNed::new(9.0, 0.0, 0.0)), &settings);
    assert_eq!(state.level, EnergyLevel::Ok);
    // Just about overcome: dear, not out of reach.
    let state = look(0.9, &way(50.0), Some(VelocityNed::new(-7.2, 0.0, 0.0)), &settings);
    assert!(state.needed_home.is_some());
}

#[test]
fn without_a_report_of_the_charge_nothing_is_said() {
    let settings = EnergySettings::default();
    let mut estimator = EnergyEstimator::new();
    assert_eq!(estimator.assess(at(0.0), &way(0.0), &settings), None);
    let mut blind = sample(f32::NAN);
    estimator.observe(at(0.0), &blind, &settings);
    assert_eq!(estimator.assess(at(0.0), &way(0.0), &settings), None);
    // The voltage stands in for it where the cells are known.
    let settings = EnergySettings {
        cells: Some(4),
        ..settings
    };
    blind.battery.voltage_v = Some(4.0 * 3.825);
    estimator.observe(at(1.0), &blind, &settings);
    let state = estimator.assess(at(1.0), &way(0.0), &settings).expect("known");
    assert!((state.remaining - 0.5).abs() < 1e-3, "{state:?}");
    // It sags with every gust, which is smoothed.
    blind.battery.voltage_v = Some(4.0 * 3.5);
    estimator.observe(at(1.5), &blind, &settings);
    let state = estimator.assess(at(1.5), &way(0.0), &settings).expect("known");
    assert!(state.remaining > 0.45, "{state:?}");
}

#[test]
fn a_charge_that_is_not_reported_any_more_is_used_on() {
    let settings = EnergySettings::default();
    let mut estimator = EnergyEstimator::new();
    estimator.observe(at(0.0), &sample(0.5), &settings);
    let state = estimator.assess(at(120.0), &way(0.0), &settings).expect("known");
    assert!((state.remaining - 0.4).abs() < 1e-3, "{state:?}");
}

#[test]
fn a_level_does_not_flutter() {
    let settings = EnergySettings::default();
    let mut estimator = EnergyEstimator::new();
    let mut changes = 0;
    let mut last = None;
    let edge = look(0.5, &way(800.0), Some(VelocityNed::default()), &settings);
    let remaining = 0.5 - edge.margin;
    for i in 0..400_u32 {
        let jitter = if i % 2 == 0 { 0.004 } else { -0.004 };
        estimator.observe(at(f64::from(i) * 0.1), &sample((remaining + jitter) as f32), &settings);
        let state = estimator
            .assess(at(f64::from(i) * 0.1), &way(800.0), &settings)
            .expect("known");
        changes += u32::from(last.replace(state.level).is_some_and(|l| l != state.level));
    }
    assert!(changes <= 1, "{changes} changes");
    assert_eq!(last, Some(EnergyLevel::ReturnNow));
}

#[test]
fn the_way_between_two_places() {
    let home = PositionNed::new(0.0, 0.0, 2.0);
    let way = WayHome::between(&PositionNed::new(-30.0, -40.0, -8.0), &home, 25.0, 3.0);
    assert!((way.distance_m - 50.0).abs() < 1e-9);
    assert!((way.bearing_rad - f64::atan2(40.0, 30.0)).abs() < 1e-9);
    assert!((way.climb_m - 15.0).abs() < 1e-9 && (way.descent_m - 25.0).abs() < 1e-9);
    let above = WayHome::between(&PositionNed::new(0.0, 0.0, -58.0), &home, 25.0, 0.0);
    assert!(above.climb_m == 0.0 && (above.descent_m - 60.0).abs() < 1e-9);
}

/// Share of a full battery that hovering, and flying, takes per second, as far as known.
fn rates_per_s(estimator: &EnergyEstimator, settings: &EnergySettings) -> (f64, f64) {
    let rates = estimator.consumption.rates(settings);
    (rates.hovering, rates.flying)
}

/// Flies with these true rates, hovering and flying by turns, and gives what was learned.
fn learned(
    hovering: f64,
    flying: f64,
    seconds: u32,
    report: impl Fn(f64, bool) -> Battery,
    settings: &EnergySettings,
) -> (f64, f64) {
    let mut estimator = EnergyEstimator::new();
    let mut charge = 1.0;
    for i in 0..seconds * 5 {
        let t = f64::from(i) * 0.2;
        let flies = (t / 40.0) as u32 % 2 == 1;
        charge -= 0.2 * if flies { flying } else { hovering };
        let velocity = VelocityNed::new(if flies { 8.0 } else { 0.1 }, 0.0, 0.0);
        let sample = EnergySample {
            battery: report(charge, flies),
            velocity: Some(velocity),
            ..sample(0.0)
        };
        estimator.observe(at(t), &sample, settings);
    }
    assert!(estimator.consumption.is_learned(settings));
    rates_per_s(&estimator, settings)
}

#[test]
fn both_rates_are_learned_from_whole_percents() {
    let settings = EnergySettings::default();
    let percents = |charge: f64, _| Battery {
        remaining: Some(((charge * 100.0).ceil() / 100.0) as f32),
        ..Battery::default()
    };
    let (hovering, flying) = (1.0 / 900.0, 1.0 / 600.0);
    let (h, f) = learned(hovering, flying, 400, percents, &settings);
    assert!((h / hovering - 1.0).abs() < 0.1, "hovering {h} of {hovering}");
    assert!((f / flying - 1.0).abs() < 0.1, "flying {f} of {flying}");
}

#[test]
fn the_current_teaches_where_the_capacity_is_known_and_the_report_corrects_it() {
    let settings = EnergySettings {
        capacity_ah: Some(5.0),
        ..EnergySettings::default()
    };
    let (hovering, flying) = (1.0 / 900.0, 1.0 / 700.0);
    // An old battery: it holds 4 Ah of its 5, so that the same current empties it sooner.
    let current = |charge: f64, flies: bool| Battery {
        remaining: Some(charge as f32),
        current_a: Some((if flies { flying } else { hovering } * 4.0 * 3600.0) as f32),
        voltage_v: None,
    };
    let (h, f) = learned(hovering, flying, 300, current, &settings);
    assert!((h / hovering - 1.0).abs() < 0.1, "hovering {h} of {hovering}");
    assert!((f / flying - 1.0).abs() < 0.1, "flying {f} of {flying}");
}

/// PX4's simulated battery: so much per second down to where it is told to stop, and no further.
fn simulated_battery(t: f64, full_to_empty_s: f64, stops_at: f64) -> EnergySample {
    EnergySample {
        simulated: true,
        ..sample((1.0 - t / full_to_empty_s).max(stops_at) as f32)
    }
}

#[test]
fn a_simulated_battery_that_halves_in_thirty_seconds_calls_nobody_home_and_an_empty_one_does() {
    let settings = EnergySettings::default();
    let fly = |stops_at: f64| {
        let mut estimator = EnergyEstimator::new();
        let mut worst = EnergyLevel::Ok;
        for i in 0..36_000_u32 {
            let t = f64::from(i) * 0.1;
            estimator.observe(at(t), &simulated_battery(t, 60.0, stops_at), &settings);
            worst = worst.max(estimator.assess(at(t), &way(200.0), &settings).expect("known").level);
        }
        worst
    };
    assert_eq!(fly(0.5), EnergyLevel::Ok);
    assert_eq!(fly(0.1), EnergyLevel::ReturnNow);
    assert_eq!(fly(0.02), EnergyLevel::LandNow);
    // A real battery that falls so fast is believed: one learns from it, and comes home in time.
    let at_a_third = |simulated: bool| {
        let mut estimator = EnergyEstimator::new();
        let mut level = EnergyLevel::Ok;
        for i in 0..400_u32 {
            let t = f64::from(i) * 0.1;
            let told = EnergySample {
                simulated,
                ..simulated_battery(t, 60.0, 0.0)
            };
            estimator.observe(at(t), &told, &settings);
            level = estimator.assess(at(t), &way(200.0), &settings).expect("known").level;
        }
        level
    };
    assert_eq!(at_a_third(true), EnergyLevel::Ok);
    assert!(at_a_third(false) >= EnergyLevel::ReturnNow);
}

#[test]
fn nothing_is_learned_on_the_ground() {
    let settings = EnergySettings::default();
    let mut estimator = EnergyEstimator::new();
    for i in 0..2000_u32 {
        let idle = EnergySample {
            airborne: false,
            ..sample(1.0 - i as f32 * 0.0004)
        };
        estimator.observe(at(f64::from(i)), &idle, &settings);
    }
    let (h, f) = rates_per_s(&estimator, &settings);
    assert!((h - 1.0 / 1200.0).abs() < 1e-12 && (f - 1.0 / 1200.0).abs() < 1e-12);
}

proptest! {
    #[test]
    fn further_is_never_cheaper(remaining in 0.0..1.0, distance in 0.0..5000.0, more in 0.0..5000.0, head in -7.0..7.0_f64) {
        let settings = EnergySettings::default();
        let wind = Some(VelocityNed::new(-head, 0.0, 0.0));
        let near = look(remaining, &way(distance), wind, &settings);
        let far = look(remaining, &way(distance + more), wind, &settings);
        prop_assert!(far.needed_home >= near.needed_home);
        prop_assert!(far.margin <= near.margin && far.return_in_s <= near.return_in_s);
        prop_assert!(far.level >= near.level);
    }

    #[test]
    fn more_headwind_is_never_cheaper(remaining in 0.0..1.0, distance in 20.0..5000.0, head in -7.0..12.0_f64, more in 0.0..6.0, across in -6.0..6.0) {
        let settings = EnergySettings::default();
        let less = look(remaining, &way(distance), Some(VelocityNed::new(-head, across, 0.0)), &settings);
        let more = look(remaining, &way(distance), Some(VelocityNed::new(-head - more, across, 0.0)), &settings);
        let cost = |state: &EnergyState| state.needed_home.unwrap_or(f64::INFINITY);
        prop_assert!(cost(&more) >= cost(&less));
        prop_assert!(more.level >= less.level);
    }

    /// As long as it may stay, the charge pays for the way home, the allowance and the reserve; as long as it may go home, for the
    /// way itself.
    #[test]
    fn no_way_home_is_promised_that_is_not_paid_for(
        remaining in 0.0..1.0,
        distance in 0.0..6000.0,
        climb in 0.0..100.0,
        north in -12.0..12.0,
        east in -12.0..12.0,
        airspeed in 3.0..20.0,
    ) {
        let settings = EnergySettings { airspeed_m_s: airspeed, ..EnergySettings::default() };
        let way = WayHome { climb_m: climb, ..way(distance) };
        let state = look(remaining, &way, Some(VelocityNed::new(north, east, 0.0)), &settings);
        match state.level {
            EnergyLevel::Ok | EnergyLevel::ReplanSoon => {
                let needed = state.needed_home.expect("promised");
                prop_assert!(state.remaining >= needed + state.reserve);
            }
            EnergyLevel::ReturnNow => {
                let needed = state.needed_home.expect("promised");
                prop_assert!(state.remaining >= needed / (1.0 + settings.model_error_share) - 1e-9);
            }
            EnergyLevel::LandNow => {}
        }
        prop_assert!(state.return_in_s >= 0.0 && state.return_in_s.is_finite());
    }

    #[test]
    fn numbers_that_are_none_promise_nothing(values in prop::array::uniform8(any::<f64>()), remaining in any::<f32>()) {
        let settings = EnergySettings::default();
        let mut estimator = EnergyEstimator::new();
        let sample = EnergySample {
            battery: Battery { remaining: Some(remaining), voltage_v: Some(values[0] as f32), current_a: Some(values[1] as f32) },
            simulated: false,
            airborne: true,
            velocity: Some(VelocityNed::new(values[2], values[3], 0.0)),
            wind: Some(VelocityNed::new(values[4], values[5], 0.0)),
        };
        for i in 0..3 {
            estimator.observe(at(f64::from(i)), &sample, &settings);
        }
        let way = WayHome { distance_m: values[6], climb_m: values[7], receding_m_s: values[5], ..way(0.0) };
        if let Some(state) = estimator.assess(at(3.0), &way, &settings) {
            for number in [state.remaining, state.margin, state.endurance_s, state.return_in_s, state.needed_home.unwrap_or(0.0)] {
                prop_assert!(number.is_finite(), "{state:?}");
            }
            let known = values[6].is_finite() && values[7].is_finite();
            prop_assert!(known || state.level == EnergyLevel::LandNow, "{state:?}");
        }
    }
}
