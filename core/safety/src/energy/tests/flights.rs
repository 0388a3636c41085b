//! Whole flights until the battery says that it is enough: however wrong the configured model, they end on the ground with charge.

use super::*;

/// The truth that the estimator does not know.
#[derive(Debug, Clone, Copy)]
struct Truth {
    hovering: f64,
    flying: f64,
    wind: [f64; 2],
    tells_wind: bool,
    /// Where it flies to: bearing and speed over the ground. It flies on until it is told otherwise.
    bearing_rad: f64,
    speed_m_s: f64,
    /// Steps in which the charge is reported.
    step: f64,
}

/// How a flight ended.
#[derive(Debug)]
struct End {
    remaining: f64,
    from_home_m: f64,
    replan_at_s: Option<f64>,
    return_at_s: Option<f64>,
}

const PERIOD_S: f64 = 0.5;
const HEIGHT_M: f64 = 30.0;

/// Flies away until told to return, then home until there or told to land, then down.
fn fly(truth: &Truth, settings: &EnergySettings) -> End {
    let mut estimator = EnergyEstimator::new();
    let (mut place, mut charge, mut t) = ([0.0_f64, 0.0_f64], 0.95_f64, 0.0);
    let mut end = End {
        remaining: 0.0,
        from_home_m: 0.0,
        replan_at_s: None,
        return_at_s: None,
    };
    loop {
        t += PERIOD_S;
        let distance_m = place[0].hypot(place[1]);
        let home_rad = f64::atan2(-place[1], -place[0]);
        let velocity = if end.return_at_s.is_some() {
            let wind = Wind::Reported {
                north_m_s: truth.wind[0],
                east_m_s: truth.wind[1],
            };
            let speed = wind
                .ground_speed_m_s(settings.airspeed_m_s, home_rad, 0.0)
                .unwrap_or(0.0);
            [speed * home_rad.cos(), speed * home_rad.sin()]
        } else {
            [
                truth.speed_m_s * truth.bearing_rad.cos(),
                truth.speed_m_s * truth.bearing_rad.sin(),
            ]
        };
        let airspeed = (velocity[0] - truth.wind[0]).hypot(velocity[1] - truth.wind[1]);
        charge -= PERIOD_S * if airspeed > 2.0 { truth.flying } else { truth.hovering };
        place = [place[0] + velocity[0] * PERIOD_S, place[1] + velocity[1] * PERIOD_S];
        let sample = EnergySample {
            velocity: Some(VelocityNed::new(velocity[0], velocity[1], 0.0)),
            wind: truth
                .tells_wind
                .then(|| VelocityNed::new(truth.wind[0], truth.wind[1], 0.0)),
            ..sample(((charge / truth.step).floor() * truth.step) as f32)
        };
        estimator.observe(at(t), &sample, settings);
        let way = WayHome {
            distance_m,
            bearing_rad: home_rad,
            climb_m: 0.0,
            descent_m: HEIGHT_M,
            receding_m_s: -(velocity[0] * home_rad.cos() + velocity[1] * home_rad.sin()),
        };
        let state = estimator.assess(at(t), &way, settings).expect("known");
        if state.level >= EnergyLevel::ReplanSoon {
            end.replan_at_s.get_or_insert(t);
        }
        if state.level >= EnergyLevel::ReturnNow {
            end.return_at_s.get_or_insert(t);
        }
        let is_home = end.return_at_s.is_some() && distance_m < 8.0;
        if is_home || state.level == EnergyLevel::LandNow || charge <= 0.0 {
            let down_s = HEIGHT_M / settings.descent_m_s + 5.0;
            end.remaining = charge - down_s * truth.hovering;
            end.from_home_m = distance_m;
            return end;
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Consumption up to 30 % above the configured one, any way out, any wind that is told or is no more than assumed.
    #[test]
    fn flights_with_a_model_thirty_percent_wrong_end_at_home_with_charge(
        hover_error in 0.7..1.3,
        fly_error in 0.7..1.3,
        wind_m_s in 0.0..4.0,
        wind_rad in 0.0..6.3,
        tells_wind in any::<bool>(),
        bearing_rad in 0.0..6.3,
        speed_m_s in 0.0..8.0,
        whole_percents in any::<bool>(),
    ) {
        let settings = EnergySettings::default();
        let truth = Truth {
            hovering: hover_error / settings.hover_endurance_s,
            flying: fly_error / settings.flying_endurance_s,
            wind: [wind_m_s * f64::cos(wind_rad), wind_m_s * f64::sin(wind_rad)],
            tells_wind,
            bearing_rad,
            speed_m_s,
            step: if whole_percents { 0.01 } else { 1e-6 },
        };
        let end = fly(&truth, &settings);
        prop_assert!(end.from_home_m < 10.0, "{end:?}");
        prop_assert!(end.remaining > 0.08, "{end:?}");
        prop_assert!(end.replan_at_s < end.return_at_s, "{end:?}");
    }

    /// Whatever the wind does and however wrong the model is: on the ground before the charge is at its end.
    #[test]
    fn no_flight_falls_out_of_the_sky(
        hover_error in 0.5..2.0,
        fly_error in 0.5..2.0,
        wind_m_s in 0.0..12.0,
        wind_rad in 0.0..6.3,
        tells_wind in any::<bool>(),
        bearing_rad in 0.0..6.3,
        speed_m_s in 0.0..8.0,
    ) {
        let settings = EnergySettings::default();
        let truth = Truth {
            hovering: hover_error / settings.hover_endurance_s,
            flying: fly_error / settings.flying_endurance_s,
            wind: [wind_m_s * f64::cos(wind_rad), wind_m_s * f64::sin(wind_rad)],
            tells_wind,
            bearing_rad,
            speed_m_s,
            step: 0.01,
        };
        let end = fly(&truth, &settings);
        prop_assert!(end.remaining > 0.0, "{end:?}");
    }
}

#[test]
fn the_swarm_is_told_well_before_it_becomes_urgent() {
    let settings = EnergySettings::default();
    let truth = Truth {
        hovering: 1.0 / settings.hover_endurance_s,
        flying: 1.0 / settings.flying_endurance_s,
        wind: [0.0, 0.0],
        tells_wind: true,
        bearing_rad: 0.3,
        speed_m_s: 6.0,
        step: 0.01,
    };
    let end = fly(&truth, &settings);
    let ahead_s = end.return_at_s.expect("returned") - end.replan_at_s.expect("told");
    assert!((60.0..150.0).contains(&ahead_s), "{ahead_s} s");
}
