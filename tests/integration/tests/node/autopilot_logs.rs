//! Logs of autopilots fetched over their links, beside the recording of their flight; never in flight.

use reqwest::StatusCode;
use serde_json::Value;
use skein_domain::VehicleCommand;
use skein_sim::vehicle::SimVehicle;
use skein_testkit::{Swarm, eventually, patience};

async fn get(address: &str) -> (StatusCode, Value) {
    let answer = reqwest::get(address).await.expect("is answered");
    let status = answer.status();
    (status, answer.json().await.unwrap_or_default())
}

async fn post(address: &str) -> (StatusCode, Value) {
    let answer = reqwest::Client::new().post(address).send().await.expect("is answered");
    let status = answer.status();
    (status, answer.json().await.unwrap_or_default())
}

#[tokio::test(flavor = "multi_thread")]
async fn a_log_is_fetched_on_the_ground_and_lies_beside_the_flight() {
    let folder = tempfile::tempdir().expect("a folder");
    let flights = folder.path().join("flights");
    let swarm = Swarm::start_with(2, |config, _| config.recorder.folder = Some(flights.clone())).await;
    swarm.ready().await;
    let of = |id: u16, rest: &str| format!("http://{}/api/v1/vehicles/{id}/logs{rest}", swarm.web_address());

    let (status, list) = get(&of(2, "")).await;
    assert_eq!(
        (status, list["logs"].as_array().map(Vec::len)),
        (StatusCode::OK, Some(2)),
        "{list}"
    );
    assert_eq!(post(&of(2, "/7/fetch")).await.0, StatusCode::CONFLICT);
    let (status, begun) = post(&of(2, "/0/fetch")).await;
    assert_eq!(status, StatusCode::ACCEPTED, "{begun}");
    // One at a time.
    assert_eq!(post(&of(2, "/1/fetch")).await.0, StatusCode::FORBIDDEN);
    let fetched = eventually(patience(), "the log", async || {
        let (_, answer) = get(&of(2, "/fetch")).await;
        let end = answer["fetch"]["end"].clone();
        (!end.is_null()).then_some(end)
    })
    .await;
    assert_eq!(fetched["end"], "fetched", "{fetched}");
    let file = fetched["file"].as_str().expect("a name").to_owned();
    let written = std::fs::read(flights.join(&file)).expect("is there");
    assert_eq!(written, SimVehicle::log(2, 0));
    let (_, list) = get(&format!("http://{}/api/v1/flights", swarm.web_address())).await;
    assert_eq!(list["flights"][0]["logs"], serde_json::json!([file]), "{list}");
    let sent = reqwest::get(format!("http://{}/api/v1/flights/{file}", swarm.web_address())).await;
    assert_eq!(
        sent.expect("is answered").bytes().await.expect("bytes").len(),
        written.len()
    );

    swarm.take_off(6.0).await;
    let (status, why) = get(&of(2, "")).await;
    assert_eq!(
        (status, &why["error"]["code"]),
        (StatusCode::FORBIDDEN, &Value::from("not_permitted"))
    );
    assert_eq!(post(&of(2, "/0/fetch")).await.0, StatusCode::FORBIDDEN);
    swarm.command_all(VehicleCommand::Land).await;
    swarm.stop().await;
}
