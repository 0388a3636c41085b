//! A recorded flight shown again beside the node that flies: the same routes and the same page, and nothing that can be commanded.

use futures_util::StreamExt;
use reqwest::StatusCode;
use serde_json::{Value, json};
use skein_testkit::{Swarm, eventually, patience};
use std::path::Path;

async fn get(address: &str) -> (StatusCode, Value) {
    let answer = reqwest::get(address).await.expect("is answered");
    let status = answer.status();
    (status, answer.json().await.unwrap_or_default())
}

/// The only flight that a node lists, once so much of it is recorded.
async fn recorded(base: &str, seconds: f64) -> String {
    eventually(patience(), "the flight in the list", async || {
        let (_, list) = get(&format!("{base}/api/v1/flights")).await;
        let flight = list["flights"].get(0)?;
        (flight["seconds"].as_f64()? >= seconds).then_some(flight["file"].as_str()?.to_owned())
    })
    .await
}

/// Goes to a moment, stands there, and gives the highest vehicle's height there.
async fn highest_at(shown: &str, position_s: f64) -> f64 {
    let there = reqwest::Client::new()
        .put(format!("{shown}/api/v1/replay"))
        .json(&json!({ "position_s": position_s, "playing": false }))
        .send()
        .await
        .expect("is answered");
    assert_eq!(there.status(), StatusCode::OK);
    let there: Value = there.json().await.expect("is JSON");
    assert_eq!(there["playing"], false);
    let (_, fleet) = get(&format!("{shown}/api/v1/fleet")).await;
    let height = |vehicle: &Value| -vehicle["kinematics"]["position"]["down_m"].as_f64().unwrap_or_default();
    let vehicles = fleet["vehicles"].as_array().cloned().unwrap_or_default();
    assert_eq!(vehicles.len(), 2, "at {position_s} s: {fleet}");
    vehicles.iter().map(height).fold(f64::NEG_INFINITY, f64::max)
}

/// What is said on a stream first.
async fn first_said(shown: &str, count: usize) -> Vec<Value> {
    let address = format!("{}/api/v1/stream", shown.replacen("http", "ws", 1));
    let (mut socket, _) = tokio_tungstenite::connect_async(address).await.expect("connects");
    let mut said = Vec::new();
    while said.len() < count {
        let next = tokio::time::timeout(patience(), socket.next()).await.expect("comes");
        if let tokio_tungstenite::tungstenite::Message::Text(text) = next.expect("goes on").expect("is whole") {
            said.push(serde_json::from_str(&text).expect("is JSON"));
        }
    }
    said
}

#[tokio::test(flavor = "multi_thread")]
async fn a_flight_is_shown_again_while_the_node_flies_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let flights = folder.path().join("flights");
    let swarm = Swarm::start_with(2, |config, _| config.recorder.folder = Some(flights.clone())).await;
    swarm.ready().await;
    let ready_s = swarm.node().now().as_seconds();
    swarm.take_off(6.0).await;
    let base = format!("http://{}", swarm.web_address());
    let flown_s = swarm.node().now().as_seconds();
    let file = recorded(&base, flown_s - 2.0).await;
    let shown = format!("{base}/replay/{file}");

    let (_, there) = get(&format!("{shown}/api/v1/replay")).await;
    assert_eq!(there["replay"]["file"], file.as_str(), "{there}");
    let end_s = there["replay"]["duration_s"].as_f64().expect("a number");
    let ground_s = ready_s - there["replay"]["begin"].as_f64().expect("a number") * 1e-6;
    assert!(highest_at(&shown, ground_s).await < 1.0);
    assert!(highest_at(&shown, end_s).await > 4.0);
    assert!(highest_at(&shown, ground_s).await < 1.0);
    let (status, one) = get(&format!("{shown}/api/v1/vehicles/2")).await;
    assert_eq!((status, &one["id"]), (StatusCode::OK, &json!(2)));

    // The page's own address ends with a slash, and never leads to another host.
    for (asked, led) in [
        (file.as_str(), format!("/replay/{file}/")),
        ("%2F%2Fexample.org", "/replay/%2F%2Fexample.org/".into()),
    ] {
        let client = reqwest::Client::builder()
            .redirect(reqwest::redirect::Policy::none())
            .build();
        let answer = client
            .expect("a client")
            .get(format!("{base}/replay/{asked}"))
            .send()
            .await;
        let answer = answer.expect("is answered");
        assert_eq!(
            answer.headers().get("location").and_then(|to| to.to_str().ok()),
            Some(led.as_str())
        );
    }
    is_told(&shown).await;
    nothing_is_commanded(&base, &shown).await;
    what_there_is_not(&base, &flights).await;
    swarm.stop().await;
}

/// The page, the stream, the timeline.
async fn is_told(shown: &str) {
    let page = reqwest::get(format!("{shown}/")).await.expect("is answered");
    assert_eq!(page.status(), StatusCode::OK);
    assert!(page.text().await.expect("is text").contains("<div id=\"app\">"));
    let said = first_said(shown, 3).await;
    let kinds: Vec<&str> = said.iter().filter_map(|one| one["type"].as_str()).collect();
    assert_eq!(kinds, ["hello", "replay", "fleet"]);
    let timeline = eventually(patience(), "the timeline", async || {
        let (_, timeline) = get(&format!("{shown}/api/v1/replay/timeline")).await;
        (timeline["complete"] == true).then_some(timeline)
    })
    .await;
    let marks = timeline["marks"].as_array().cloned().unwrap_or_default();
    assert!(
        marks
            .iter()
            .any(|mark| mark["text"].as_str().is_some_and(|text| text.contains("adopted"))),
        "{timeline}"
    );
}

async fn nothing_is_commanded(base: &str, shown: &str) {
    let command = json!({ "targets": "all", "command": { "command": "land" } });
    let refused = reqwest::Client::new()
        .post(format!("{shown}/api/v1/commands"))
        .json(&command)
        .send()
        .await
        .expect("is answered");
    assert_eq!(refused.status(), StatusCode::CONFLICT);
    let why: Value = refused.json().await.expect("is JSON");
    assert_eq!(why["error"]["code"], "replaying");
    let (_, live) = get(&format!("{base}/api/v1/fleet")).await;
    let states: Vec<&Value> = live["vehicles"]
        .as_array()
        .expect("some")
        .iter()
        .map(|of| &of["armed"])
        .collect();
    assert!(states.iter().all(|armed| **armed == true), "{live}");
    // The node that flies is none that can be wound back.
    let (_, own) = get(&format!("{base}/api/v1/replay")).await;
    assert_eq!(own, json!({ "replay": null }));
    let wound_back = reqwest::Client::new()
        .put(format!("{base}/api/v1/replay"))
        .json(&json!({ "position_s": 1.0 }))
        .send()
        .await
        .expect("is answered");
    let why: Value = wound_back.json().await.expect("is JSON");
    assert_eq!(why["error"]["code"], "not_replaying");
}

async fn what_there_is_not(base: &str, flights: &Path) {
    std::fs::write(flights.join("broken.mcap"), "no recording").expect("is written");
    for (file, status, code) in [
        ("none.mcap", StatusCode::NOT_FOUND, "unknown_recording"),
        ("..%2F..%2Fetc%2Fpasswd", StatusCode::NOT_FOUND, "unknown_recording"),
        ("broken.mcap", StatusCode::CONFLICT, "unreadable_recording"),
    ] {
        let (answered, why) = get(&format!("{base}/replay/{file}/api/v1/replay")).await;
        assert_eq!((answered, &why["error"]["code"]), (status, &json!(code)), "{file}");
    }
}
