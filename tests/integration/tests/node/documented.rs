//! The bodies that the documents show, sent to a node: each example of the OpenAPI document, and what the guides and the tutorial print, is
//! taken, or refused for the state of things; none for what it is.
#![allow(
    clippy::unwrap_used,
    reason = "what tests share may stop at the first surprise, as they do"
)]

use serde_json::{Value, json};
use skein_config::{AdoptionRule, Escalation, Isolation, PayloadRule};
use skein_domain::FlightState;
use skein_sim::PayloadPlan;
use skein_testkit::{Swarm, eventually, patience};
use skein_view::FleetSnapshot;
use std::collections::BTreeMap;
use std::time::Duration;

/// Paths in the order in which a flight has a use for them, and how each is answered.
const IN_ORDER: [(&str, u16); 27] = [
    ("POST /api/v1/vehicles/{id}/parameters/reading", 202),
    ("PUT /api/v1/vehicles/{id}/parameters/{name}", 200),
    ("POST /api/v1/vehicles/{id}/payloads", 202),
    ("POST /api/v1/vehicles/{id}/payloads/{payload}/command", 200),
    // No operator is configured.
    ("POST /api/v1/preflight/overrides", 401),
    ("POST /api/v1/upgrades", 401),
    ("POST /api/v1/upgrades/back", 401),
    ("POST /api/v1/fences/import", 200),
    ("PUT /api/v1/fences", 200),
    ("PUT /api/v1/references/{name}", 204),
    ("PUT /api/v1/tracks", 202),
    // There is no track 1.
    ("PATCH /api/v1/tracks/{id}", 404),
    ("POST /api/v1/tracks/{id}/observe", 404),
    ("POST /api/v1/detections", 202),
    ("POST /api/v1/events/acknowledge", 200),
    // It flies: what it shows is no recording.
    ("PUT /api/v1/replay", 409),
    // Nothing was broken off, and the node is in no swarm.
    ("POST /api/v1/resume", 403),
    ("POST /api/v1/swarm/coordinator", 403),
    ("POST /api/v1/commands", 200),
    ("POST /api/v1/trajectories/preview", 200),
    ("POST /api/v1/trajectories", 202),
    ("POST /api/v1/formation/preview", 200),
    ("PUT /api/v1/formation", 200),
    ("PUT /api/v1/formation/route", 202),
    ("POST /api/v1/faults", 202),
    ("POST /api/v1/control", 200),
    ("POST /api/v1/emergency-stop", 200),
];

/// Two vehicles, the first with a gimbal.
async fn swarm() -> Swarm {
    let gimbal = PayloadRule {
        name: "gimbal".into(),
        plugin: "gimbal".into(),
        isolation: Isolation::InProcess,
        transport: None,
        on_failure: Escalation::Hold,
        config: json!({}),
    };
    let adopt = AdoptionRule {
        payloads: vec![gimbal],
        ..AdoptionRule::default()
    };
    let swarm = Swarm::start_with(2, move |config, sim| {
        config.adopt = vec![adopt];
        sim.payloads = PayloadPlan::all();
    })
    .await;
    let connected = |fleet: &FleetSnapshot| {
        fleet.vehicles.len() == 2
            && fleet.vehicles.iter().all(|vehicle| vehicle.ready_to_arm == Some(true))
            && fleet.vehicles.iter().flat_map(|vehicle| &vehicle.payloads).all(|p| {
                let state = p.state.as_ref();
                state.is_some_and(|state| state["connected"] == json!(true))
            })
    };
    swarm
        .until("both and their gimbals", Duration::from_secs(20), connected)
        .await;
    swarm
}

async fn send(swarm: &Swarm, method: &str, path: &str, body: &Value) -> (u16, Value) {
    let name = if path.contains("parameters") {
        "MPC_XY_CRUISE"
    } else {
        "van"
    };
    let path = path
        .replace("{id}", "1")
        .replace("{payload}", "gimbal")
        .replace("{name}", name);
    let address = format!("http://{}{path}", swarm.web_address());
    let request = reqwest::Client::new().request(method.parse().unwrap(), address);
    let answer = request.json(body).send().await.unwrap();
    let status = answer.status().as_u16();
    let text = answer.text().await.unwrap();
    (status, serde_json::from_str(&text).unwrap_or(Value::String(text)))
}

/// `METHOD path` of each operation that takes a body, and its example.
fn examples() -> BTreeMap<String, Value> {
    let document: Value = serde_json::from_str(&skein_api::openapi::document()).unwrap();
    let paths = document["paths"].as_object().unwrap();
    let operations = paths.iter().flat_map(|(path, item)| {
        let item = item.as_object().unwrap();
        item.iter().map(move |(method, operation)| (method, path, operation))
    });
    operations
        .filter_map(|(method, path, operation)| {
            let content = operation.get("requestBody")?.pointer("/content/application~1json")?;
            Some((format!("{} {path}", method.to_uppercase()), content["example"].clone()))
        })
        .collect()
}

/// Bodies in a text: after `POST /path` in the same or in the next code span, and those of curl.
fn printed(text: &str) -> Vec<(String, Value)> {
    let spans: Vec<String> = text
        .split('`')
        .skip(1)
        .step_by(2)
        .map(|span| span.split_whitespace().collect::<Vec<_>>().join(" "))
        .collect();
    let mut found = Vec::new();
    for (k, span) in spans.iter().enumerate() {
        let Some((method, rest)) = span.split_once(' ').filter(|(m, _)| ["POST", "PUT"].contains(m)) else {
            continue;
        };
        let (path, within) = rest.split_once(' ').unwrap_or((rest, ""));
        let body = if within.is_empty() {
            spans.get(k + 1).map_or("", String::as_str)
        } else {
            within
        };
        if body.starts_with('{') {
            found.push((format!("{method} {path}"), serde_json::from_str(body).unwrap()));
        }
    }
    for line in text.lines().filter(|line| line.starts_with("curl -X ")) {
        let method = line.split_whitespace().nth(2).unwrap();
        let (body, address) = line.split_once("-d '").unwrap().1.split_once("' ").unwrap();
        let path = address.split_once("8080").unwrap().1;
        found.push((format!("{method} {path}"), serde_json::from_str(body).unwrap()));
    }
    found
}

#[tokio::test(flavor = "multi_thread")]
async fn what_the_documents_show_is_taken() {
    let swarm = swarm().await;
    let examples = examples();
    let known: Vec<&str> = IN_ORDER.iter().map(|(operation, _)| *operation).collect();
    for operation in examples.keys() {
        assert!(known.contains(&operation.as_str()), "{operation} is not tried here");
    }
    let mut wrong = Vec::new();
    for (operation, expected) in IN_ORDER {
        let (method, path) = operation.split_once(' ').unwrap();
        let mut body = examples[operation].clone();
        if operation == "POST /api/v1/emergency-stop" {
            // It is another one each time.
            body["key"] = send(&swarm, method, "/api/v1/emergency-stop/unlock", &Value::Null)
                .await
                .1["key"]
                .clone();
        }
        if operation == "POST /api/v1/commands" {
            // It takes off: a position that came late for a moment forbids it.
            swarm.ready().await;
        }
        let (status, answer) = send(&swarm, method, path, &body).await;
        if status != expected {
            wrong.push(format!("{operation}: {status}, not {expected}: {answer}"));
            continue;
        }
        match operation {
            "POST /api/v1/commands" => {
                let receipts = answer["receipts"].as_array().unwrap();
                assert!(receipts.iter().all(|receipt| receipt["refusal"].is_null()), "{answer}");
                hold(&swarm).await;
            }
            "POST /api/v1/trajectories" => {
                let (status, _) = send(&swarm, "DELETE", "/api/v1/trajectories", &Value::Null).await;
                assert_eq!(status, 200);
                hold(&swarm).await;
            }
            "POST /api/v1/formation/preview" => {
                // Whose trajectory has just ended is still on its way to hold.
                let both = eventually(patience(), "a preview with both", async || {
                    let (_, answer) = send(&swarm, method, path, &examples[operation]).await;
                    let ways = answer["forecast"]["ways"].as_array().map_or(0, Vec::len);
                    (ways == 2).then_some(answer)
                });
                foreseen(&both.await);
            }
            _ => {}
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    swarm.stop().await;
}

async fn hold(swarm: &Swarm) {
    let holding = |fleet: &FleetSnapshot| {
        fleet
            .vehicles
            .iter()
            .all(|vehicle| vehicle.flight_state == FlightState::Holding)
    };
    swarm
        .until("both hold in the air", Duration::from_secs(60), holding)
        .await;
}

/// A preview says who would go where, how long it takes, and how close they come.
fn foreseen(preview: &Value) {
    assert_eq!(preview["refusal"], Value::Null, "{preview}");
    let forecast = &preview["forecast"];
    assert!(forecast["receipt"]["duration_s"].as_f64().unwrap() > 0.0, "{forecast}");
    assert!(
        forecast["receipt"]["planned_min_distance_m"].as_f64().unwrap() > 1.0,
        "{forecast}"
    );
    let ways = forecast["ways"].as_array().unwrap();
    let vehicles: Vec<&Value> = ways.iter().map(|way| &way["vehicle"]).collect();
    assert_eq!(vehicles, [&json!(1), &json!(2)], "the leader first");
    let apart =
        |end: &str, axis: &str| (ways[0][end][axis].as_f64().unwrap() - ways[1][end][axis].as_f64().unwrap()).abs();
    let apart_m = apart("to", "north_m").hypot(apart("to", "east_m"));
    assert!((apart_m - 6.0).abs() < 0.5, "{apart_m} m apart in their places");
}

#[tokio::test(flavor = "multi_thread")]
async fn what_guides_and_tutorial_print_is_taken() {
    let swarm = swarm().await;
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    for file in [
        "deploy/docs/src/operator.md",
        "deploy/docs/src/several-computers.md",
        "plugins/TUTORIAL.md",
    ] {
        let bodies = printed(&std::fs::read_to_string(format!("{root}/{file}")).unwrap());
        assert!(!bodies.is_empty(), "{file} shows none");
        for (operation, body) in bodies {
            let (method, path) = operation.split_once(' ').unwrap();
            let (status, answer) = send(&swarm, method, path, &body).await;
            assert!(
                [200, 201, 202, 204, 403, 409].contains(&status),
                "{file}: {operation}: {status} {answer}"
            );
        }
    }
    swarm.stop().await;
}
