//! Whatever arrives: no panic, the same events give the same effects, a snapshot goes on.

use crate::Gimbal;
use crate::manager::MESSAGES;
use proptest::prelude::*;
use skein_domain::exchange::{Create, Event, OwnState};
use skein_domain::payload::{GimbalCommand, GimbalYawFrame, MavlinkMessage};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{CommandId, Geodetic, Incarnation, NodeTime, SystemId, VehicleId};
use skein_plugin_sdk::{Effects, Payload};

#[derive(Debug, Clone)]
enum Step {
    Event(Box<Event>),
    Command(GimbalCommand),
}

fn create(config_json: &str, snapshot: Option<Vec<u8>>) -> Create {
    Create {
        vehicle: VehicleId(1),
        incarnation: Incarnation(1),
        config_json: config_json.to_owned(),
        snapshot,
        now: NodeTime::from_seconds(1.0),
        payload: Some("gimbal".to_owned()),
        system_id: Some(SystemId(1)),
    }
}

fn instance(config_json: &str, snapshot: Option<Vec<u8>>) -> Gimbal {
    let settings = serde_json::from_str(config_json).unwrap();
    Gimbal::create(create(config_json, snapshot), settings).unwrap()
}

fn own() -> OwnState {
    OwnState {
        kinematics: Some(VehicleKinematics {
            yaw_rad: 0.3,
            ..VehicleKinematics::default()
        }),
        global: Some(Geodetic {
            latitude_deg: 47.0,
            longitude_deg: 8.0,
            altitude_amsl_m: 500.0,
        }),
        ..OwnState::default()
    }
}

fn step() -> impl Strategy<Value = Step> {
    let number = prop_oneof![any::<f64>(), -4.0..4.0_f64];
    let message = (
        prop::sample::select(MESSAGES),
        prop::sample::select(vec![1_u8, 154, 0, 7]),
        prop::collection::vec(any::<u8>(), 0..150),
    );
    let message = message.prop_map(|(message_id, component_id, payload)| {
        Step::Event(Box::new(Event::Mavlink(MavlinkMessage {
            system_id: 1,
            component_id,
            message_id,
            payload,
        })))
    });
    let bytes =
        prop::collection::vec(any::<u8>(), 0..60).prop_map(|bytes| Step::Event(Box::new(Event::Received { bytes })));
    let angles = (number.clone(), number.clone(), any::<bool>()).prop_map(|(pitch_rad, yaw_rad, north)| {
        Step::Command(GimbalCommand::Angles {
            pitch_rad,
            yaw_rad,
            yaw_frame: if north {
                GimbalYawFrame::North
            } else {
                GimbalYawFrame::Vehicle
            },
        })
    });
    let place = (number.clone(), number.clone(), number).prop_map(|(latitude_deg, longitude_deg, altitude_amsl_m)| {
        let place = Geodetic {
            latitude_deg,
            longitude_deg,
            altitude_amsl_m,
        };
        Step::Command(GimbalCommand::PointAt { place })
    });
    let control = prop::sample::select(vec![
        GimbalCommand::TakeControl,
        GimbalCommand::ReleaseControl,
        GimbalCommand::Neutral,
    ]);
    prop_oneof![
        4 => message,
        2 => bytes,
        3 => Just(Step::Event(Box::new(Event::Tick))),
        1 => Just(Step::Event(Box::new(Event::Own(own())))),
        1 => angles,
        1 => place,
        1 => control.prop_map(Step::Command),
    ]
}

fn run(gimbal: &mut Gimbal, steps: &[Step]) -> Effects {
    let mut effects = Effects::default();
    for (count, step) in (1_u64..).zip(steps) {
        let now = NodeTime(1_000_000 + count * 70_000);
        match step {
            Step::Event(event) => gimbal.handle(now, std::slice::from_ref(event.as_ref()), &mut effects),
            Step::Command(command) => gimbal.command(now, CommandId(count), *command, &mut effects),
        }
    }
    effects
}

proptest! {
    #[test]
    fn nothing_makes_it_panic_and_the_same_comes_of_the_same(
        config in prop::sample::select(vec!["{}", r#"{"backend": "siyi"}"#]), steps in prop::collection::vec(step(), 0..80),
    ) {
        let mut gimbal = instance(config, None);
        let effects = run(&mut gimbal, &steps);
        let mut again = instance(config, None);
        prop_assert_eq!(run(&mut again, &steps), effects);
        let snapshot = gimbal.snapshot();
        prop_assert_eq!(again.snapshot(), snapshot.clone());
        prop_assert_eq!(instance(config, Some(snapshot.clone())).snapshot(), snapshot);
    }

    #[test]
    fn any_snapshot_is_survived(bytes in prop::collection::vec(any::<u8>(), 0..100)) {
        let mut gimbal = instance("{}", Some(bytes));
        run(&mut gimbal, &[Step::Event(Box::new(Event::Own(own()))), Step::Event(Box::new(Event::Tick))]);
    }
}

#[test]
fn a_snapshot_of_another_backend_is_not_taken_over() {
    let other = instance(r#"{"backend": "siyi"}"#, None).snapshot();
    assert_eq!(instance("{}", Some(other)).snapshot(), instance("{}", None).snapshot());
}

#[test]
fn settings_that_cannot_be_are_refused() {
    for config in [
        r#"{"pitch_min_rad": 1.0, "pitch_max_rad": 0.0}"#,
        r#"{"attempts": 0}"#,
        r#"{"tolerance_rad": -1.0}"#,
    ] {
        let settings = serde_json::from_str(config).unwrap();
        assert!(Gimbal::create(create(config, None), settings).is_err(), "{config}");
    }
    assert!(serde_json::from_str::<crate::Settings>(r#"{"colour": 1}"#).is_err());
}
