//! A flight as the recorder has it, in its file and live, beside what the node showed.

use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use skein_domain::{VehicleCommand, VehicleId};
use skein_recording::{
    AuditChain, AuditRecord, Message, Recording, Redecided, Redecider, Select, SetpointRecord, Topic, VehicleTelemetry,
};
use skein_testkit::{Swarm, eventually, free_tcp_port, patience};
use skein_view::{EventRecord, FleetSnapshot};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tokio_tungstenite::tungstenite;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::http::HeaderValue;

/// What Foxglove and Lichtblick ask for when they connect.
const SUBPROTOCOL: &str = "foxglove.sdk.v1";
/// The first byte of a message on a topic.
const MESSAGE_DATA: u8 = 1;

fn only_file(folder: &Path) -> PathBuf {
    let files = std::fs::read_dir(folder)
        .expect("a folder")
        .filter_map(|entry| Some(entry.ok()?.path()));
    let files: Vec<_> = files.collect();
    assert_eq!(files.len(), 1, "{files:?}");
    files.into_iter().next().expect("one")
}

fn messages(recording: &Recording) -> Vec<Message> {
    let read: Result<Vec<_>, _> = recording.messages(Select::default()).collect();
    read.expect("nothing is damaged")
}

fn redecided(messages: &[Message]) -> Redecided {
    let mut again = Redecider::default();
    messages.iter().for_each(|message| again.take(message));
    again.finish()
}

/// Looks on as Foxglove does, until so many messages came on a topic.
async fn looked_on(port: u16, topic: &str, count: usize) -> Vec<Value> {
    let mut request = format!("ws://127.0.0.1:{port}")
        .into_client_request()
        .expect("an address");
    let wanted = HeaderValue::from_static(SUBPROTOCOL);
    request.headers_mut().insert("sec-websocket-protocol", wanted);
    let (mut socket, _) = tokio_tungstenite::connect_async(request).await.expect("connects");
    let mut seen = Vec::new();
    while seen.len() < count {
        let next = tokio::time::timeout(patience(), socket.next())
            .await
            .expect("is shown in time");
        match next.expect("goes on").expect("is whole") {
            tungstenite::Message::Text(text) => {
                let told: Value = serde_json::from_str(&text).expect("is JSON");
                let channels = told["channels"].as_array().cloned().unwrap_or_default();
                if let Some(channel) = channels.iter().find(|channel| channel["topic"] == topic) {
                    assert_eq!(channel["schemaName"], "skein.VehicleTelemetry");
                    let subscription = json!({ "id": 7, "channelId": channel["id"] });
                    let subscribe = json!({ "op": "subscribe", "subscriptions": [subscription] });
                    socket.send(subscribe.to_string().into()).await.expect("is sent");
                }
            }
            tungstenite::Message::Binary(bytes) if bytes.first() == Some(&MESSAGE_DATA) => {
                // Opcode, subscription, time; then the message.
                seen.push(serde_json::from_slice(bytes.get(13..).expect("has a head")).expect("is JSON"));
            }
            _ => {}
        }
    }
    seen
}

fn of(messages: &[Message], topic: Topic) -> impl DoubleEndedIterator<Item = &Message> {
    messages
        .iter()
        .filter(move |message| message.topic.as_ref() == Some(&topic))
}

/// A formation is asked for; the flight under way is listed, and has a report.
async fn asked_and_listed(base: &str) {
    let asked = reqwest::Client::new()
        .put(format!("{base}/api/v1/formation"))
        .header("skein-console", "desk-1")
        .json(&json!({ "shape": "line", "spacing_m": 5.0 }))
        .send()
        .await
        .expect("is answered");
    assert!(asked.status().is_success(), "{}", asked.status());
    // The flight under way is listed, and has a report.
    let flight = eventually(patience(), "the flight in the list", async || {
        let list: Value = reqwest::get(format!("{base}/api/v1/flights"))
            .await
            .ok()?
            .json()
            .await
            .ok()?;
        let flight = list["flights"].get(0)?.clone();
        (flight["seconds"].as_f64()? > 1.0).then_some(flight)
    })
    .await;
    assert_eq!(flight["finished"], false, "{flight}");
    let page = reqwest::get(format!(
        "{base}/api/v1/flights/{}/report",
        flight["file"].as_str().expect("a name")
    ))
    .await;
    let page = page.expect("is answered").text().await.expect("is text");
    assert!(
        page.contains("<svg") && page.to_lowercase().contains("<!doctype html>"),
        "{page}"
    );
}

/// Vehicles, setpoints and events are as the node had them.
fn is_as_shown(messages: &[Message], vehicles: usize) {
    let fleet: FleetSnapshot = of(messages, Topic::Fleet)
        .next_back()
        .expect("some")
        .json()
        .expect("is one");
    assert_eq!(fleet.vehicles.len(), vehicles);
    for id in [VehicleId(1), VehicleId(2)] {
        let telemetry: Vec<VehicleTelemetry> = of(messages, Topic::Telemetry(id))
            .map(|m| m.json().expect("is one"))
            .collect();
        assert!(telemetry.windows(2).all(|pair| pair[0].time < pair[1].time));
        assert!(
            telemetry
                .iter()
                .any(|one| one.kinematics.is_some_and(|k| k.position.down_m < -5.0))
        );
        let setpoints = of(messages, Topic::Setpoint(id)).map(|m| m.json::<SetpointRecord>().expect("is one"));
        assert!(setpoints.filter(|one| one.flown.is_some()).count() > 0);
    }
    let events: Vec<EventRecord> = of(messages, Topic::Events).map(|m| m.json().expect("is one")).collect();
    assert!(
        events.iter().any(|event| event.text.contains("formation")),
        "{events:?}"
    );
}

/// What was asked over the API is in it, with who asked and what came of it.
fn is_audited(messages: &[Message]) {
    let mut chain = AuditChain::default();
    let audit: Vec<AuditRecord> = of(messages, Topic::Audit).map(|m| m.json().expect("is one")).collect();
    audit.iter().for_each(|record| chain.follow(record).expect("follows"));
    let asked = audit
        .iter()
        .find(|record| record.audit.what == "PUT /api/v1/formation")
        .expect("is recorded");
    assert_eq!(
        (asked.audit.who.as_str(), asked.audit.outcome.as_str()),
        ("desk-1", "200")
    );
    assert!(asked.audit.with.contains("\"line\""), "{asked:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_flight_is_recorded_as_it_was_shown_and_its_decisions_come_out_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let port = free_tcp_port();
    let flights = folder.path().join("flights");
    let swarm = Swarm::start_with(2, |config, _| {
        config.recorder.folder = Some(flights.clone());
        config.recorder.foxglove = Some(([127, 0, 0, 1], port).into());
    })
    .await;
    swarm.take_off(6.0).await;
    let seen = looked_on(port, "/vehicles/2/telemetry", 3).await;
    assert!(
        seen.iter()
            .all(|message| message["vehicle"] == 2 && message["armed"] == true),
        "{seen:?}"
    );
    let base = format!("http://{}", swarm.web_address());
    asked_and_listed(&base).await;
    swarm.command_all(VehicleCommand::Land).await;
    swarm
        .until("disarmed", Duration::from_secs(20), |fleet| {
            fleet.vehicles.iter().all(|v| !v.armed)
        })
        .await;
    let shown = swarm.node().snapshot();
    swarm.stop().await;

    let recording = Recording::open(&only_file(&flights)).expect("opens");
    assert!(recording.is_finished());
    let messages = messages(&recording);
    is_as_shown(&messages, shown.vehicles.len());
    // The node was stopped as soon as both were disarmed.
    for vehicle in &shown.vehicles {
        let last = of(&messages, Topic::Telemetry(vehicle.id)).next_back().expect("some");
        let last: VehicleTelemetry = last.json().expect("is one");
        assert!(!vehicle.armed && !last.armed, "{last:?}");
    }
    is_audited(&messages);
    let again = redecided(&messages);
    assert_eq!(again.differences, []);
    assert!(
        again.setpoints > 0 && again.formations > 0 && again.without_inputs == 0,
        "{again:?}"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn a_folder_that_cannot_be_written_is_told_and_changes_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let in_the_way = folder.path().join("flights");
    std::fs::write(&in_the_way, "a file").expect("is written");
    let swarm = Swarm::start_with(1, |config, _| config.recorder.folder = Some(in_the_way.clone())).await;
    let told = |text: &'static str| {
        let node = swarm.node();
        async move {
            eventually(patience(), text, async || {
                let events = node.events_after(0);
                events.iter().any(|event| event.text.contains(text)).then_some(())
            })
            .await;
        }
    };
    told("flights are not recorded").await;
    swarm.take_off(6.0).await;
    std::fs::remove_file(&in_the_way).expect("goes");
    told("flights are recorded again").await;
    swarm.stop().await;
    assert!(Recording::open(&only_file(&in_the_way)).expect("opens").is_finished());
}
