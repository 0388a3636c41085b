//! The model with a vehicle made of a few lines, in simulated time.

use super::{LogBookUav, Settings};
use skein_plugin_sdk::domain::exchange::{Create, Effect, Event, OwnState};
use skein_plugin_sdk::domain::telemetry::VehicleKinematics;
use skein_plugin_sdk::domain::{FlightMode, Incarnation, LandedState, NodeTime, PositionNed, VehicleId};
use skein_plugin_sdk::{Effects, UavModel};

fn create(settings: Settings, snapshot: Option<Vec<u8>>) -> LogBookUav {
    let create = Create {
        vehicle: VehicleId(1),
        incarnation: Incarnation(1),
        config_json: "{}".to_owned(),
        snapshot,
        now: NodeTime(0),
        payload: None,
        system_id: None,
    };
    LogBookUav::create(create, settings).expect("is created")
}

/// In the air, 30 m from home, for some seconds from a moment on.
fn fly(model: &mut LogBookUav, from_s: f64, seconds: f64) -> Vec<Effect> {
    let mut all = Vec::new();
    for period in 0..=(seconds / 0.02) as u32 {
        let now = NodeTime::from_seconds(from_s + f64::from(period) * 0.02);
        let own = OwnState {
            kinematics: Some(VehicleKinematics {
                position: PositionNed::new(30.0, 0.0, -10.0),
                measured: now,
                ..VehicleKinematics::default()
            }),
            mode: FlightMode::Offboard,
            armed: true,
            landed: LandedState::InAir,
            home: Some(PositionNed::default()),
            link_connected: true,
            ..OwnState::default()
        };
        let mut effects = Effects::default();
        model.handle(now, &[Event::Own(own), Event::Tick], &mut effects);
        all.extend(effects.take());
    }
    all
}

#[test]
fn it_flies_and_keeps_its_book() {
    let mut model = create(Settings::default(), None);
    let effects = fly(&mut model, 1.0, 3.0);
    assert!(
        effects
            .iter()
            .filter(|effect| matches!(effect, Effect::Setpoint(_)))
            .count()
            > 140
    );
    let last = effects.iter().rev().find_map(|effect| match effect {
        Effect::Report { state_json } => Some(state_json.as_str()),
        _ => None,
    });
    assert_eq!(last, Some(r#"{"airborne_s":3,"farthest_m":30}"#));
}

#[test]
fn it_tells_once_how_long_it_flies() {
    let settings: Settings = serde_json::from_str(r#"{"tell_after_s": 2.0}"#).expect("are settings");
    let mut model = create(settings, None);
    let effects = fly(&mut model, 1.0, 5.0);
    let told = effects
        .iter()
        .filter(|effect| matches!(effect, Effect::Notice { .. }))
        .count();
    assert_eq!(told, 1);
}

#[test]
fn it_goes_on_after_a_restart() {
    let mut model = create(Settings::default(), None);
    fly(&mut model, 1.0, 3.0);
    let snapshot = model.snapshot();
    let mut restored = create(Settings::default(), Some(snapshot.clone()));
    assert_eq!(restored.snapshot(), snapshot, "nothing is lost or added");
    let effects = fly(&mut restored, 4.02, 2.5);
    let last = effects.iter().rev().find_map(|effect| match effect {
        Effect::Report { state_json } => Some(state_json.as_str()),
        _ => None,
    });
    assert_eq!(last, Some(r#"{"airborne_s":5,"farthest_m":30}"#));
}
