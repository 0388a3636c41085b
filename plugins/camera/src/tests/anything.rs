//! Whatever arrives: no panic, the same events give the same effects, a snapshot goes on.

use crate::remote::MESSAGES;
use crate::{Camera, Settings};
use proptest::prelude::*;
use skein_domain::exchange::{Create, Event};
use skein_domain::payload::{CameraCommand, CameraMode, MavlinkMessage};
use skein_domain::{CommandId, Incarnation, NodeTime, SystemId, VehicleId};
use skein_plugin_sdk::{Effects, Payload};

#[derive(Debug, Clone)]
enum Step {
    Event(Box<Event>),
    Command(CameraCommand),
}

fn instance(config_json: &str, snapshot: Option<Vec<u8>>) -> Camera {
    let create = Create {
        vehicle: VehicleId(1),
        incarnation: Incarnation(1),
        config_json: config_json.to_owned(),
        snapshot,
        now: NodeTime::from_seconds(1.0),
        payload: Some("camera".to_owned()),
        system_id: Some(SystemId(1)),
    };
    Camera::create(create, serde_json::from_str(config_json).unwrap()).unwrap()
}

fn step() -> impl Strategy<Value = Step> {
    let message = (
        prop::sample::select(MESSAGES),
        prop::collection::vec(any::<u8>(), 0..256),
    );
    let message = message.prop_map(|(message_id, payload)| {
        Step::Event(Box::new(Event::Mavlink(MavlinkMessage {
            system_id: 1,
            component_id: 100,
            message_id,
            payload,
        })))
    });
    let taken =
        (any::<u32>(), any::<f64>()).prop_map(|(count, interval_s)| CameraCommand::TakePictures { count, interval_s });
    let zoom = any::<f64>().prop_map(|factor| CameraCommand::Zoom { factor });
    let others = prop::sample::select(vec![
        CameraCommand::StopPictures,
        CameraCommand::StartRecording,
        CameraCommand::StopRecording,
        CameraCommand::SetMode {
            mode: CameraMode::Video,
        },
        CameraCommand::StartStream { stream: 1 },
    ]);
    prop_oneof![
        4 => message,
        3 => Just(Step::Event(Box::new(Event::Tick))),
        1 => taken.prop_map(Step::Command),
        1 => zoom.prop_map(Step::Command),
        1 => others.prop_map(Step::Command),
    ]
}

fn run(camera: &mut Camera, steps: &[Step]) -> Effects {
    let mut effects = Effects::default();
    for (count, step) in (1_u64..).zip(steps) {
        let now = NodeTime(1_000_000 + count * 110_000);
        match step {
            Step::Event(event) => camera.handle(now, std::slice::from_ref(event.as_ref()), &mut effects),
            Step::Command(command) => camera.command(now, CommandId(count), *command, &mut effects),
        }
    }
    effects
}

proptest! {
    #[test]
    fn nothing_makes_it_panic_and_the_same_comes_of_the_same(
        config in prop::sample::select(vec!["{}", r#"{"source": "mavlink"}"#, r#"{"mavlink": true}"#]),
        steps in prop::collection::vec(step(), 0..80),
    ) {
        let mut camera = instance(config, None);
        let effects = run(&mut camera, &steps);
        let mut again = instance(config, None);
        prop_assert_eq!(run(&mut again, &steps), effects);
        let snapshot = camera.snapshot();
        prop_assert_eq!(again.snapshot(), snapshot.clone());
        prop_assert_eq!(instance(config, Some(snapshot.clone())).snapshot(), snapshot);
    }

    #[test]
    fn any_snapshot_is_survived(bytes in prop::collection::vec(any::<u8>(), 0..100)) {
        let mut camera = instance("{}", Some(bytes));
        run(&mut camera, &[Step::Event(Box::new(Event::Tick))]);
    }
}

#[test]
fn settings_that_cannot_be_are_refused() {
    for settings in [
        r#"{"source": "video"}"#,
        r#"{"rate_hz": 0.0}"#,
        r#"{"width_px": 100000}"#,
        r#"{"zoom_max": 0.5}"#,
        r#"{"source": "rtp"}"#,
        r#"{"source": "rtp", "listen": "5600"}"#,
        r#"{"source": "rtp", "listen": "0.0.0.0:0"}"#,
        r#"{"source": "rtp", "listen": "camera:5600"}"#,
        r#"{"source": "rtp", "listen": "0.0.0.0:5600", "parameter_sets": "no base64"}"#,
        r#"{"source": "gstreamer"}"#,
        r#"{"source": "gstreamer", "pipeline": " "}"#,
        r#"{"source": "gstreamer", "pipeline": "filesrc location='a ! b"}"#,
    ] {
        let settings: Settings = serde_json::from_str(settings).unwrap();
        assert!(settings.check().is_err(), "{settings:?}");
    }
    assert!(serde_json::from_str::<Settings>(r#"{"colour": 1}"#).is_err());
    let rtp: Settings = serde_json::from_str(r#"{"source": "rtp", "listen": "[::]:5600"}"#).unwrap();
    assert_eq!(rtp.check(), Ok(()));
    let pipeline = r#"{"source": "gstreamer", "pipeline": "videotestsrc ! x264enc"}"#;
    let pipeline: Settings = serde_json::from_str(pipeline).unwrap();
    assert_eq!(pipeline.check(), Ok(()));
}
