//! Parameters of an autopilot through the API: read, written, refused; each write an event; and over two nodes by who has control authority over the vehicle.
#![allow(
    clippy::unwrap_used,
    reason = "what tests share may stop at the first surprise, as they do"
)]

use serde_json::{Value, json};
use skein_domain::VehicleCommand;
use skein_testkit::{Flock, Member, Swarm, eventually, patience};
use std::net::SocketAddr;
use std::time::Duration;

const LIST: &str = "/api/v1/vehicles/1/parameters";

/// An answer's status and body; `console` says who asks.
async fn ask(swarm: &Swarm, console: Option<&str>, method: &str, path: &str, body: Option<Value>) -> (u16, Value) {
    ask_at(swarm.web_address(), console, method, path, body).await
}

async fn ask_at(at: SocketAddr, console: Option<&str>, method: &str, path: &str, body: Option<Value>) -> (u16, Value) {
    let url = format!("http://{at}{path}");
    let mut request = reqwest::Client::new().request(method.parse().unwrap(), url);
    if let Some(console) = console {
        request = request.header("skein-console", console);
    }
    if let Some(body) = body {
        request = request.json(&body);
    }
    let answer = request.send().await.unwrap();
    let status = answer.status().as_u16();
    let text = answer.text().await.unwrap();
    (status, serde_json::from_str(&text).unwrap_or(Value::Null))
}

async fn write(swarm: &Swarm, console: Option<&str>, name: &str, value: Value) -> (u16, Value) {
    let path = format!("{LIST}/{name}");
    ask(swarm, console, "PUT", &path, Some(json!({ "value": value }))).await
}

fn value(list: &Value, name: &str) -> Value {
    let all = list["parameters"].as_array().unwrap();
    let found = all.iter().find(|one| one["name"] == name);
    found.map_or(Value::Null, |one| one["value"].clone())
}

fn events(swarm: &Swarm, words: &str) -> usize {
    let kept = swarm.node().events_after(0);
    kept.iter().filter(|event| event.text.contains(words)).count()
}

#[tokio::test(flavor = "multi_thread")]
async fn parameters_are_read_and_written_and_refused_with_reasons() {
    let swarm = Swarm::start(1).await;
    swarm.ready().await;
    let (status, before) = ask(&swarm, None, "GET", LIST, None).await;
    assert_eq!(
        (status, &before["reading"]["state"]),
        (200, &json!("not_begun")),
        "{before}"
    );

    let all = eventually(patience(), "all parameters", async || {
        let (_, list) = ask(&swarm, None, "GET", &format!("{LIST}?read=true"), None).await;
        (list["reading"]["state"] == "complete").then_some(list)
    })
    .await;
    let count = all["parameters"].as_array().unwrap().len();
    assert!(count > 50, "{count}");
    assert_eq!(
        (all["total"].as_u64(), all["read"].as_u64()),
        (Some(count as u64), Some(count as u64))
    );
    assert_eq!(value(&all, "MPC_XY_CRUISE"), json!({ "type": "real", "value": 5.0 }));
    assert_eq!(value(&all, "COM_RC_IN_MODE")["type"], "integer");

    // What is written is kept, is an event, and is all that is new.
    let (status, receipt) = write(&swarm, Some("anna-1"), "MPC_XY_CRUISE", json!(6.5)).await;
    assert_eq!((status, &receipt["value"]["value"]), (200, &json!(6.5)), "{receipt}");
    assert_eq!(receipt["before"]["value"], 5.0);
    let news_path = format!("{LIST}?since={}", all["revision"]);
    let (_, news) = ask(&swarm, None, "GET", &news_path, None).await;
    assert_eq!(news["parameters"].as_array().unwrap().len(), 1, "{news}");
    assert_eq!(news["parameters"][0]["changed_from"]["value"], 5.0);
    assert_eq!(events(&swarm, "MPC_XY_CRUISE set to 6.5, was 5 by console anna-1"), 1);

    // What does not fit is refused with the reason, and is an event too.
    for (name, sent, status, code) in [
        ("COM_RC_IN_MODE", json!(0.5), 409, "wrong_type"),
        ("COM_RC_IN_MODE", json!(3e9), 409, "out_of_range"),
        ("NO_SUCH_THING", json!(1), 409, "no_answer"),
        ("SEVENTEEN_LETTERS", json!(1), 422, "invalid_name"),
        ("MPC_XY_CRUISE", json!("six"), 422, "invalid_body"),
    ] {
        let (got, body) = write(&swarm, None, name, sent).await;
        assert_eq!(
            (got, body["error"]["code"].as_str()),
            (status, Some(code)),
            "{name}: {body}"
        );
    }
    assert_eq!(events(&swarm, "COM_RC_IN_MODE not written"), 2);

    // Under another operator's control.
    let take = json!({ "targets": "all", "console": { "id": "ben-2", "name": "Ben" }, "action": { "action": "take" } });
    let (status, _) = ask(&swarm, Some("ben-2"), "POST", "/api/v1/control", Some(take)).await;
    assert_eq!(status, 200);
    for console in [None, Some("anna-1")] {
        let (status, body) = write(&swarm, console, "MPC_XY_CRUISE", json!(7)).await;
        assert_eq!(
            (status, body["error"]["code"].as_str()),
            (409, Some("no_control_authority")),
            "{body}"
        );
    }
    let (status, _) = write(&swarm, Some("ben-2"), "MPC_XY_CRUISE", json!(7)).await;
    assert_eq!(status, 200);
    assert_eq!(events(&swarm, "MPC_XY_CRUISE set to 7, was 6.5 by Ben"), 1);
    assert_eq!(events(&swarm, "MPC_XY_CRUISE not written"), 2);
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn nothing_is_written_to_an_armed_vehicle() {
    let swarm = Swarm::start(1).await;
    swarm.ready().await;
    swarm.command_all(VehicleCommand::Arm).await;
    let is_armed = |fleet: &skein_view::FleetSnapshot| fleet.vehicles.iter().all(|vehicle| vehicle.armed);
    swarm.until("armed", Duration::from_secs(5), is_armed).await;
    let (status, body) = write(&swarm, None, "MPC_XY_CRUISE", json!(6)).await;
    assert_eq!((status, body["error"]["code"].as_str()), (409, Some("armed")), "{body}");
    // Reading is nothing that an armed vehicle minds.
    let list = eventually(patience(), "all parameters", async || {
        let (_, list) = ask(&swarm, None, "GET", &format!("{LIST}?read=true"), None).await;
        (list["reading"]["state"] == "complete").then_some(list)
    })
    .await;
    assert_eq!(value(&list, "MPC_XY_CRUISE")["value"], 5.0);
    assert_eq!(
        events(
            &swarm,
            "MPC_XY_CRUISE not written: MPC_XY_CRUISE is not written while the vehicle is armed"
        ),
        1
    );
    swarm.stop().await;
}

/// What is asked at one node about a vehicle that another one flies goes there with the name of who asks.
#[tokio::test(flavor = "multi_thread")]
async fn who_has_control_authority_writes_its_parameters_at_any_node() {
    let folder = tempfile::tempdir().unwrap();
    let members = [1, 2].map(|node| Member {
        node,
        priority: Some(node),
        flies: true,
    });
    let flock = Flock::start(&members, folder.path().to_owned(), |_| ()).await;
    for node in [1, 2] {
        let both = |fleet: &skein_view::FleetSnapshot| fleet.vehicles.len() == 2;
        flock.until(node, "both vehicles", Duration::from_secs(10), both).await;
    }
    let elsewhere = flock.web_address(2);
    let cruise = format!("{LIST}/MPC_XY_CRUISE");
    let written = async |console: Option<&str>, to: f64| {
        ask_at(elsewhere, console, "PUT", &cruise, Some(json!({ "value": to }))).await
    };
    // Under nobody's control, whoever asks.
    eventually(patience(), "a first write", async || {
        (written(None, 6.0).await.0 == 200).then_some(())
    })
    .await;

    let ben = json!({ "id": "ben-2", "name": "Ben" });
    let take = json!({ "targets": { "vehicles": [1] }, "console": ben, "action": { "action": "take" } });
    let (status, answer) = ask_at(elsewhere, Some("ben-2"), "POST", "/api/v1/control", Some(take)).await;
    assert_eq!(status, 200, "{answer}");
    let flies_it = flock.node(1);
    eventually(patience(), "its own node knows", async || {
        flies_it
            .control()
            .iter()
            .any(|control| control.console.id == "ben-2")
            .then_some(())
    })
    .await;
    for console in [None, Some("anna-1")] {
        let (status, body) = written(console, 8.0).await;
        assert_eq!(
            (status, &body["error"]["code"]),
            (409, &json!("no_control_authority")),
            "{body}"
        );
    }
    let (status, receipt) = written(Some("ben-2"), 7.0).await;
    assert_eq!((status, &receipt["before"]["value"]), (200, &json!(6.0)), "{receipt}");
    flock.stop().await;
}
