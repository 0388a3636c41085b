//! Flights away from the ground station and back: the warning comes once, in time, and ends.

use crate::{Radio, Settings};
use mavlink::MessageData;
use mavlink::dialects::common::RADIO_STATUS_DATA;
use payload_mavlink::encode;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use skein_domain::exchange::{Create, Effect, Event, OwnState, Severity};
use skein_domain::payload::MavlinkMessage;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{Incarnation, NodeTime, PositionNed, VehicleId, VelocityNed};
use skein_plugin_sdk::{Effects, Payload};
use skein_sim::RadioSettings;

const TICK_S: f64 = 0.2;
const SPEED_M_S: f64 = 8.0;

struct Flight {
    radio: Radio,
    air: RadioSettings,
    shadow: Normal<f64>,
    random: ChaCha8Rng,
    time_s: f64,
    distance_m: f64,
    effects: Effects,
}

fn create(incarnation: u32, snapshot: Option<Vec<u8>>) -> Radio {
    let create = Create {
        vehicle: VehicleId(1),
        incarnation: Incarnation(incarnation),
        config_json: "{}".to_owned(),
        snapshot,
        now: NodeTime::from_seconds(1.0),
        payload: Some("radio".to_owned()),
        system_id: None,
    };
    Radio::create(create, Settings::default()).unwrap()
}

/// As a SiK radio counts.
fn raw(dbm: f64) -> u8 {
    ((dbm + 127.0) * 1.9).round().clamp(1.0, 254.0) as u8
}

impl Flight {
    fn new(exponent: f64, shadow_db: f64, seed: u64) -> Self {
        Self {
            radio: create(1, None),
            air: RadioSettings {
                exponent,
                // Whatever the exponent, a link of some hundred metres.
                power_dbm: 20.0 - 25.0 * (2.7 - exponent),
                ..RadioSettings::default()
            },
            shadow: Normal::new(0.0, shadow_db).unwrap(),
            random: ChaCha8Rng::seed_from_u64(seed),
            time_s: 10.0,
            distance_m: 2.0,
            effects: Effects::default(),
        }
    }

    /// Where the weaker end hears the other just at its sensitivity.
    fn fails_m(&self) -> f64 {
        self.air.distance_m(self.air.sensitivity_dbm)
    }

    fn step(&mut self, speed_m_s: f64) {
        self.time_s += TICK_S;
        self.distance_m += speed_m_s * TICK_S;
        let own = OwnState {
            kinematics: Some(VehicleKinematics {
                position: PositionNed::new(self.distance_m, 0.0, 0.0),
                velocity: VelocityNed::new(speed_m_s, 0.0, 0.0),
                ..VehicleKinematics::default()
            }),
            home: Some(PositionNed::default()),
            ..OwnState::default()
        };
        let mut heard = || raw(self.air.signal_dbm(self.distance_m) + self.shadow.sample(&mut self.random));
        let said = RADIO_STATUS_DATA {
            rssi: heard(),
            remrssi: heard(),
            noise: raw(self.air.noise_dbm),
            remnoise: raw(self.air.ground_noise_dbm),
            ..RADIO_STATUS_DATA::default()
        };
        let message = MavlinkMessage {
            system_id: 51,
            component_id: 68,
            message_id: RADIO_STATUS_DATA::ID,
            payload: encode(&said),
        };
        let events = [Event::Own(own), Event::Mavlink(message), Event::Tick];
        self.radio
            .handle(NodeTime::from_seconds(self.time_s), &events, &mut self.effects);
    }

    fn warnings(&self) -> usize {
        let warns = |effect: &&Effect| {
            matches!(
                effect,
                Effect::Notice {
                    severity: Severity::Warning,
                    ..
                }
            )
        };
        self.effects.as_slice().iter().filter(warns).count()
    }

    fn happened(&self) -> Vec<String> {
        let events = self.effects.as_slice().iter().filter_map(|effect| match effect {
            Effect::Occurrence { event_json } => serde_json::from_str::<serde_json::Value>(event_json).ok(),
            _ => None,
        });
        events
            .map(|event| event["event"].as_str().unwrap_or_default().to_owned())
            .collect()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn whoever_flies_away_is_warned_once_and_in_time(exponent in 2.0..4.0_f64, shadow_db in 0.0..4.0_f64, seed in any::<u64>()) {
        let mut flight = Flight::new(exponent, shadow_db, seed);
        let fails_m = flight.fails_m();
        while flight.warnings() == 0 && flight.distance_m < fails_m {
            flight.step(SPEED_M_S);
        }
        prop_assert!(flight.distance_m < fails_m, "no warning before the link failed at {fails_m:.0} m");
        for _ in 0..20 {
            flight.step(SPEED_M_S);
        }
        prop_assert_eq!(flight.warnings(), 1);
        prop_assert_eq!(flight.happened(), ["range_warning"]);
    }

    #[test]
    fn whoever_hovers_near_is_left_alone(exponent in 2.0..4.0_f64, shadow_db in 0.0..4.0_f64, seed in any::<u64>()) {
        let mut flight = Flight::new(exponent, shadow_db, seed);
        let near_m = 0.08 * flight.fails_m();
        while flight.distance_m < near_m {
            flight.step(1.0);
        }
        for _ in 0..1500 {
            flight.step(0.0);
        }
        prop_assert_eq!(flight.warnings(), 0, "at {:.0} m of {:.0} m", near_m, flight.fails_m());
    }
}

#[test]
fn the_warning_ends_on_the_way_back_and_is_not_repeated_by_another_instance() {
    let mut flight = Flight::new(2.7, 1.0, 7);
    while flight.warnings() == 0 {
        flight.step(SPEED_M_S);
    }
    for incarnation in 2..12 {
        flight.radio = create(incarnation, Some(flight.radio.snapshot()));
        flight.step(0.0);
    }
    assert_eq!(flight.warnings(), 1);
    while flight.distance_m > 20.0 {
        flight.step(-SPEED_M_S);
    }
    assert_eq!(flight.happened(), ["range_warning", "range_recovered"]);
    assert_eq!(flight.warnings(), 1);
}
