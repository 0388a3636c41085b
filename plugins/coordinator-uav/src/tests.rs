//! When it says that it can host the coordinator, and that it flies as the model it holds.

use crate::{CoordinatorUav, Settings};
use proptest::prelude::*;
use skein_plugin_sdk::domain::exchange::{Create, Effect, Event, OwnState};
use skein_plugin_sdk::domain::payload::CoordinatorCapability;
use skein_plugin_sdk::domain::telemetry::VehicleKinematics;
use skein_plugin_sdk::domain::{Battery, FlightMode, Incarnation, LandedState, NodeTime, VehicleId};
use skein_plugin_sdk::{Effects, UavModel};

const PERIOD_US: u64 = 20_000;

fn create(settings: Settings, snapshot: Option<Vec<u8>>) -> CoordinatorUav {
    let create = Create {
        vehicle: VehicleId(4),
        incarnation: Incarnation(1),
        config_json: "{}".to_owned(),
        snapshot,
        now: NodeTime(0),
        payload: None,
        system_id: None,
    };
    CoordinatorUav::create(create, settings).expect("is created")
}

/// On the ground with this charge, all well.
fn own(charge: Option<f32>) -> OwnState {
    OwnState {
        kinematics: Some(VehicleKinematics::default()),
        mode: FlightMode::Hold,
        landed: LandedState::OnGround,
        battery: Battery {
            remaining: charge,
            ..Battery::default()
        },
        link_connected: true,
        ..OwnState::default()
    }
}

/// One vehicle and its clock.
struct Bench {
    model: CoordinatorUav,
    now: NodeTime,
    said: Vec<CoordinatorCapability>,
    effects: Vec<Effect>,
}

impl Bench {
    fn new(settings: Settings) -> Self {
        let model = create(settings, None);
        Self {
            model,
            now: NodeTime(0),
            said: Vec::new(),
            effects: Vec::new(),
        }
    }

    fn run(&mut self, seconds: f64, own: OwnState) {
        for _ in 0..(seconds * 1e6) as u64 / PERIOD_US {
            self.now.0 += PERIOD_US;
            let mut effects = Effects::default();
            self.model
                .handle(self.now, &[Event::Own(own), Event::Tick], &mut effects);
            for effect in effects.take() {
                match effect {
                    Effect::Capability(capability) => self.said.push(capability),
                    other => self.effects.push(other),
                }
            }
        }
    }

    fn capable(&self) -> Vec<bool> {
        self.said.iter().map(|said| said.capable).collect()
    }
}

#[test]
fn it_is_capable_once_its_conditions_have_held_for_a_while() {
    let mut bench = Bench::new(Settings {
        priority: 7,
        ..Settings::default()
    });
    bench.run(1.9, own(Some(0.9)));
    assert_eq!(bench.capable(), [false]);
    bench.run(0.3, own(Some(0.9)));
    assert_eq!(bench.capable(), [false, true]);
    assert!(bench.said.iter().all(|said| said.priority == 7));
    bench.run(10.0, own(Some(0.9)));
    assert_eq!(bench.said.len(), 2, "it is said when it changes");
}

#[test]
fn a_charge_about_the_limit_does_not_change_it_back_and_forth() {
    let mut bench = Bench::new(Settings::default());
    bench.run(3.0, own(Some(0.5)));
    bench.run(1.0, own(Some(0.29)));
    assert_eq!(bench.capable(), [false, true, false], "at once");
    for _ in 0..20 {
        bench.run(2.5, own(Some(0.31)));
        bench.run(2.5, own(Some(0.29)));
    }
    assert_eq!(bench.said.len(), 3);
    bench.run(3.0, own(Some(0.36)));
    assert_eq!(bench.capable(), [false, true, false, true]);
}

#[test]
fn each_condition_counts() {
    let well = own(Some(0.9));
    let spoiled: [(&str, OwnState); 3] = [
        (
            "link",
            OwnState {
                link_connected: false,
                ..well
            },
        ),
        (
            "position",
            OwnState {
                kinematics: None,
                ..well
            },
        ),
        ("charge", own(Some(0.1))),
    ];
    for (what, state) in spoiled {
        let mut bench = Bench::new(Settings::default());
        bench.run(3.0, well);
        bench.run(0.1, state);
        assert_eq!(bench.capable(), [false, true, false], "{what}");
    }
    let mut bench = Bench::new(Settings {
        needs_flight: true,
        ..Settings::default()
    });
    bench.run(3.0, well);
    assert_eq!(bench.capable(), [false], "on the ground");
    let flying = OwnState {
        armed: true,
        landed: LandedState::InAir,
        mode: FlightMode::Offboard,
        ..well
    };
    let mut bench = Bench::new(Settings {
        needs_flight: true,
        ..Settings::default()
    });
    bench.run(3.0, flying);
    assert_eq!(bench.capable(), [false, true], "holding in the air");
}

#[test]
fn without_a_word_of_the_charge_the_setting_decides() {
    for without_battery in [true, false] {
        let mut bench = Bench::new(Settings {
            without_battery,
            ..Settings::default()
        });
        bench.run(3.0, own(None));
        assert_eq!(bench.said.last().map(|said| said.capable), Some(without_battery));
    }
}

#[test]
fn it_flies_as_the_model_it_holds() {
    let flying = OwnState {
        armed: true,
        landed: LandedState::InAir,
        mode: FlightMode::Offboard,
        ..own(Some(0.9))
    };
    let mut bench = Bench::new(Settings::default());
    bench.run(1.0, flying);
    let setpoints = bench
        .effects
        .iter()
        .filter(|effect| matches!(effect, Effect::Setpoint(_)))
        .count();
    assert_eq!(setpoints, 50, "one in every period");
}

#[test]
fn settings_that_cannot_be_are_refused() {
    for config in [
        r#"{"min_battery": 1.5}"#,
        r#"{"settle_s": -1}"#,
        r#"{"flight": {"cruise_speed_m_s": 0}}"#,
    ] {
        let settings: Settings = serde_json::from_str(config).expect("is JSON");
        let create = Create {
            vehicle: VehicleId(4),
            incarnation: Incarnation(1),
            config_json: config.to_owned(),
            snapshot: None,
            now: NodeTime(0),
            payload: None,
            system_id: None,
        };
        assert!(CoordinatorUav::create(create, settings).is_err(), "{config}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_restored_instance_has_the_same_state_and_says_the_same(
        charges in prop::collection::vec((prop::option::of(0.0..1.0f32), 0.02..3.0f64, any::<bool>()), 1..12),
    ) {
        let mut bench = Bench::new(Settings::default());
        for (charge, seconds, connected) in charges {
            bench.run(seconds, OwnState { link_connected: connected, ..own(charge) });
            let snapshot = bench.model.snapshot();
            let restored = create(Settings::default(), Some(snapshot.clone()));
            prop_assert_eq!(restored.snapshot(), snapshot);
            // From here on both say the same; the restored one says it once more.
            let mut other = Bench { model: restored, now: bench.now, said: Vec::new(), effects: Vec::new() };
            let next = OwnState { link_connected: connected, ..own(charge) };
            other.run(0.5, next);
            bench.run(0.5, next);
            prop_assert_eq!(other.said.last(), bench.said.last());
        }
    }

    #[test]
    fn garbage_is_no_snapshot_and_no_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let mut bench = Bench::new(Settings::default());
        bench.model = create(Settings::default(), Some(bytes));
        bench.run(3.0, own(Some(0.9)));
        prop_assert_eq!(bench.said.last().map(|said| said.capable), Some(true));
    }
}
