//! What is found is told, and nothing that cannot be.

use super::*;
use serde_json::{Value, json};
use skein_view::{ActorHealth, PluginHealth};

fn payload(name: &str, kind: PayloadKind, state: &Value) -> PayloadSnapshot {
    PayloadSnapshot {
        name: name.to_owned(),
        kind,
        actor: ActorHealth::default(),
        plugin: PluginHealth::default(),
        state: Some(state.clone()),
        transport_fault: String::new(),
        frame: None,
    }
}

fn said(state: &Value) -> Option<Detection2DArray> {
    let state = super::state(&payload("finder", PayloadKind::Detector, state))?;
    Some(array(&Header::default(), &state))
}

#[test]
fn a_finding_is_a_box_with_its_class_and_its_name() {
    let finding = json!({
        "class": "uav", "score": 0.75, "center_x_px": 320.5, "center_y_px": 200.0, "width_px": 40.0, "height_px": 20.0, "id": "7",
    });
    // What else a detector says of itself does not disturb.
    let all = said(&json!({ "time": 5, "findings": [finding], "model": "own" })).expect("a state");
    let [one] = all.detections.as_slice() else {
        panic!("{all:?}")
    };
    assert_eq!((one.bbox.center.position.x, one.bbox.center.position.y), (320.5, 200.0));
    assert_eq!((one.bbox.size_x, one.bbox.size_y), (40.0, 20.0));
    let what = &one.results[0].hypothesis;
    assert_eq!(
        (what.class_id.as_str(), what.score, one.id.as_str()),
        ("uav", 0.75, "7")
    );
}

#[test]
fn what_else_it_may_be_follows_by_score() {
    let classes = json!({ "bird": 0.2, "uav": 0.6, "aeroplane": 0.3 });
    let finding = json!({ "class": "uav", "score": 0.6, "classes": classes });
    let all = said(&json!({ "time": 5, "findings": [finding] })).expect("a state");
    let results = all.detections[0].results.iter();
    let told: Vec<&str> = results.map(|one| one.hypothesis.class_id.as_str()).collect();
    assert_eq!(told, ["uav", "aeroplane", "bird"]);
}

#[test]
fn what_can_not_be_is_left_out() {
    let sound = json!({ "class": "uav", "score": 0.5 });
    let odd = [
        json!({ "score": 1.5 }),
        json!({ "score": -0.1 }),
        json!({ "score": 0.5, "width_px": -1.0 }),
        json!({ "score": 0.5, "classes": { "uav": 2.0 } }),
    ];
    let findings: Vec<Value> = odd.into_iter().chain([sound]).collect();
    let all = said(&json!({ "time": 5, "findings": findings })).expect("a state");
    assert_eq!(all.detections.len(), 1);
    // And what is no state of a detector is none.
    assert_eq!(said(&json!({ "frames": 3 })), None);
    assert_eq!(said(&json!({ "time": 5, "findings": "many" })), None);
}

#[test]
fn of_very_much_the_beginning_is_told() {
    let findings = vec![json!({ "class": "grass", "score": 0.1 }); 3_000];
    let all = said(&json!({ "time": 5, "findings": findings })).expect("a state");
    assert_eq!(all.detections.len(), MOST);
}
