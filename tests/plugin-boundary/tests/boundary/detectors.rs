//! The detector that ships, through the host: what it says of good pictures and bad, and what becomes of models that are none.

use serde_json::{Value, json};
use skein_domain::exchange::{Create, Effect, Event, EventBatch};
use skein_domain::payload::{FrameHeader, PixelFormat};
use skein_domain::{Incarnation, NodeTime, VehicleId};
use skein_plugin_host::{FrameSource, Instance, Isolation, PluginError, RunnerSettings, Runners};
use skein_tests_plugin_boundary::shipped;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

const WIDTH: u32 = 64;
const HEIGHT: u32 = 48;

fn runners() -> Arc<Runners> {
    Runners::with_settings(RunnerSettings {
        threads: 1,
        call_deadline: Duration::from_secs(20),
        create_deadline: Duration::from_secs(20),
        ..RunnerSettings::default()
    })
}

/// One of the small models that the plugin's own tests load.
fn model(name: &str) -> Value {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../plugins/detector/src/tests/models");
    json!({ "path": folder.join(format!("{name}.onnx")), "camera": "front" })
}

async fn detector(runners: &Arc<Runners>, config: &Value, snapshot: Option<Vec<u8>>) -> Result<Instance, PluginError> {
    let create = Create {
        vehicle: VehicleId(1),
        incarnation: Incarnation(1),
        config_json: config.to_string(),
        snapshot,
        now: NodeTime(0),
        payload: Some("eyes".to_owned()),
        system_id: None,
    };
    runners.create(shipped("detector"), Isolation::InProcess, create).await
}

/// Shows pictures of a brightness until the detector has said something of the last one: its state then, and its snapshot.
async fn shown(instance: &Instance, numbers: std::ops::Range<u32>, brightness: u8) -> (Value, Vec<u8>) {
    let source = FrameSource::new().expect("memory");
    let at = |number: u32| NodeTime(0).plus_seconds(1.0 + f64::from(number) / 30.0);
    let (mut said, mut snapshot) = (Value::Null, Vec::new());
    for number in numbers {
        let pixels: Vec<u8> = (0..WIDTH * HEIGHT)
            .map(|at| brightness + u8::from(at % 7 == number % 7))
            .collect();
        let header = FrameHeader {
            time: at(number),
            width_px: WIDTH,
            height_px: HEIGHT,
            format: PixelFormat::Gray8,
            camera: "front".to_owned(),
            ..FrameHeader::default()
        };
        let other = FrameHeader {
            camera: "rear".to_owned(),
            ..header.clone()
        };
        let frame = source.frame(header, &pixels).expect("room");
        let not_meant = source.frame(other, &pixels).expect("room");
        let mut events = vec![
            Event::Frame(not_meant.header.clone()),
            Event::Frame(frame.header.clone()),
        ];
        let mut frames = vec![not_meant, frame];
        // Pictures are looked at beside the calls.
        for _ in 0..4000 {
            events.push(Event::Tick);
            let batch = EventBatch {
                now: at(number),
                events: std::mem::take(&mut events),
            };
            let answer = instance.call(batch, &frames).await.expect("answers");
            frames.clear();
            snapshot = answer.snapshot;
            let mut reports = answer.effects.into_iter().filter_map(|effect| match effect {
                Effect::Report { state_json } => serde_json::from_str(&state_json).ok(),
                _ => None,
            });
            said = reports.next_back().unwrap_or(said);
            if said["time"] == json!(at(number)) {
                break;
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        assert_eq!(said["time"], json!(at(number)), "a picture was not looked at: {said}");
    }
    (said, snapshot)
}

#[tokio::test]
async fn findings_have_names_that_no_later_instance_gives_again() {
    let runners = runners();
    let config = model("constant");
    let first = detector(&runners, &config, None).await.expect("is created");
    let (said, snapshot) = shown(&first, 0..4, 90).await;
    assert_eq!(said["camera"], "front");
    assert_eq!((&said["width_px"], &said["height_px"]), (&json!(WIDTH), &json!(HEIGHT)));
    assert_eq!(
        (&said["looked"], &said["dropped"], &said["fault"]),
        (&json!(4), &json!(0), &json!(""))
    );
    let findings = said["findings"].as_array().expect("a list");
    assert_eq!(findings.len(), 1, "{said}");
    assert_eq!(
        (&findings[0]["class"], &findings[0]["id"]),
        (&json!("drone"), &json!("1"))
    );
    drop(first);
    let second = detector(&runners, &config, Some(snapshot)).await.expect("is created");
    let (said, _) = shown(&second, 4..8, 90).await;
    assert_eq!(said["findings"][0]["id"], "2");
}

#[tokio::test]
async fn numbers_that_are_none_are_a_fault_of_that_picture_alone() {
    let runners = runners();
    let instance = detector(&runners, &model("no-numbers"), None)
        .await
        .expect("is created");
    let (said, _) = shown(&instance, 0..3, 10).await;
    assert_eq!(said["fault"], "");
    let (said, _) = shown(&instance, 3..4, 200).await;
    assert!(
        said["fault"]
            .as_str()
            .is_some_and(|why| why.contains("numbers that are none")),
        "{said}"
    );
    let (said, _) = shown(&instance, 4..6, 10).await;
    assert_eq!(said["fault"], "");
}

#[tokio::test]
async fn a_look_that_takes_ten_times_its_budget_is_told() {
    let runners = runners();
    let mut config = model("slow");
    // No computer does seven billion multiplications in ten milliseconds on one core.
    config["budget_s"] = json!(0.001);
    let instance = detector(&runners, &config, None).await.expect("is created");
    let (said, _) = shown(&instance, 0..1, 90).await;
    assert!(
        said["fault"]
            .as_str()
            .is_some_and(|why| why.contains("ten times its budget")),
        "{said}"
    );
}

#[tokio::test]
async fn models_and_settings_that_cannot_be_are_refused_with_the_reason() {
    let runners = runners();
    for (config, why) in [
        (model("five-rows"), "[1, 5, 2], not [1, 4 + 4 classes, boxes]"),
        (model("four-channels"), "not [1, 3, height, width]"),
        (json!({ "path": "/nowhere.onnx" }), "/nowhere.onnx cannot be read"),
        (json!({ "path": file!() , "classes": [] }), "one name for each score"),
        (json!({ "doubtful_score": 0.9 }), "must not be above certain_score"),
        (json!({ "classes": ["cat"] }), "without path they are the plugin's own"),
    ] {
        let error = detector(&runners, &config, None).await.expect_err(why);
        assert!(error.to_string().contains(why), "{error}");
    }
}
