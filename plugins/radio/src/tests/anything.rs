//! Whatever arrives: no panic, the same events give the same effects, a snapshot goes on.

use crate::link::Figures;
use crate::{Radio, RssiScale, Settings};
use mavlink::dialects::common::RADIO_STATUS_DATA;
use proptest::prelude::*;
use skein_domain::exchange::{Create, Event, OwnState};
use skein_domain::payload::{MavlinkMessage, RadioCommand};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{CommandId, Incarnation, NodeTime, PositionNed, VehicleId, VelocityNed};
use skein_plugin_sdk::{Effects, Payload};

fn instance(snapshot: Option<Vec<u8>>) -> Radio {
    let create = Create {
        vehicle: VehicleId(1),
        incarnation: Incarnation(1),
        config_json: "{}".to_owned(),
        snapshot,
        now: NodeTime::from_seconds(1.0),
        payload: Some("radio".to_owned()),
        system_id: None,
    };
    Radio::create(create, Settings::default()).unwrap()
}

fn event() -> impl Strategy<Value = Event> {
    let message = prop::collection::vec(any::<u8>(), 0..20).prop_map(|payload| {
        Event::Mavlink(MavlinkMessage {
            system_id: 51,
            component_id: 68,
            message_id: 109,
            payload,
        })
    });
    let number = || prop_oneof![any::<f64>(), -2000.0..2000.0_f64];
    let own = (number(), number()).prop_map(|(north_m, north_m_s)| {
        Event::Own(OwnState {
            kinematics: Some(VehicleKinematics {
                position: PositionNed::new(north_m, 0.0, 0.0),
                velocity: VelocityNed::new(north_m_s, 0.0, 0.0),
                ..VehicleKinematics::default()
            }),
            home: Some(PositionNed::default()),
            ..OwnState::default()
        })
    });
    prop_oneof![3 => message, 1 => own, 2 => Just(Event::Tick)]
}

fn run(radio: &mut Radio, events: &[Event]) -> Effects {
    let mut effects = Effects::default();
    for (count, event) in (1_u64..).zip(events) {
        let now = NodeTime(1_000_000 + count * 150_000);
        radio.handle(now, std::slice::from_ref(event), &mut effects);
        if count % 20 == 0 {
            radio.command(
                now,
                CommandId(count),
                RadioCommand::SetPower { power_dbm: f64::NAN },
                &mut effects,
            );
        }
    }
    effects
}

proptest! {
    #[test]
    fn nothing_makes_it_panic_and_the_same_comes_of_the_same(events in prop::collection::vec(event(), 0..150)) {
        let (mut radio, mut again) = (instance(None), instance(None));
        prop_assert_eq!(run(&mut radio, &events), run(&mut again, &events));
        let snapshot = radio.snapshot();
        prop_assert_eq!(again.snapshot(), snapshot.clone());
        prop_assert_eq!(instance(Some(snapshot.clone())).snapshot(), snapshot);
    }

    #[test]
    fn any_snapshot_is_survived(bytes in prop::collection::vec(any::<u8>(), 0..100)) {
        run(&mut instance(Some(bytes)), &[Event::Tick]);
    }
}

#[test]
fn signal_strength_is_read_as_the_radio_counts() {
    let said = RADIO_STATUS_DATA {
        rssi: 190,
        remrssi: 255,
        noise: 38,
        remnoise: 0,
        ..RADIO_STATUS_DATA::default()
    };
    let sik = Figures::from_radio_status(&said, RssiScale::Sik);
    assert!((sik.rssi_dbm.unwrap() + 27.0).abs() < 1e-9);
    assert!((sik.noise_dbm.unwrap() + 107.0).abs() < 1e-9);
    assert_eq!((sik.remote_rssi_dbm, sik.remote_noise_dbm), (None, None));
    assert!((sik.snr_db(&Settings::default()).unwrap() - 80.0).abs() < 1e-9);
    let signed = Figures::from_radio_status(&said, RssiScale::SignedDbm);
    assert_eq!(signed.rssi_dbm, Some(-66.0));
    // Without noise the one to reckon with.
    let quiet = Figures {
        noise_dbm: None,
        ..signed
    };
    assert_eq!(quiet.snr_db(&Settings::default()), Some(34.0));
}

#[test]
fn settings_that_cannot_be_are_refused() {
    for settings in [r#"{"poll_hz": 0.0}"#, r#"{"warn_share": 2.0}"#, r#"{"memory_s": 0.0}"#] {
        let settings: Settings = serde_json::from_str(settings).unwrap();
        assert!(settings.check().is_err(), "{settings:?}");
    }
    assert!(serde_json::from_str::<Settings>(r#"{"colour": 1}"#).is_err());
}
