//! Trajectories over HTTP: bodies that make no sense, refusals item by item, and an empty list. They are flown in `tests/integration`.

use crate::node::Served;
use serde_json::{Value, json};
use skein_domain::Geodetic;

const PATH: &str = "/api/v1/trajectories";

async fn start() -> Served {
    Served::start_with(|config| {
        config.swarm.origin = Some(Geodetic {
            latitude_deg: 47.397_742,
            longitude_deg: 8.545_594,
            altitude_amsl_m: 488.0,
        });
    })
    .await
}

fn at(north_m: f64, east_m: f64) -> Value {
    json!({ "north_m": north_m, "east_m": east_m, "down_m": -10.0 })
}

fn body(change: impl FnOnce(&mut Value)) -> Value {
    let mut body = json!({
        "vehicles": [
            { "vehicle": 1, "waypoints": [at(10.0, 0.0), at(20.0, 5.0)] },
            { "vehicle": 2, "waypoints": [at(10.0, 20.0)] },
        ],
        "kind": "snap",
        "start": { "when": "in", "in_s": 3.0 },
        "upload": true,
    });
    change(&mut body);
    body
}

#[tokio::test(flavor = "multi_thread")]
async fn what_makes_no_sense_is_told_with_its_place() {
    let served = start().await;
    type Change = fn(&mut Value);
    let wrong: &[(&str, &str, Change)] = &[
        ("invalid_value", "vehicles", |b| b["vehicles"] = json!([])),
        ("invalid_value", "vehicles[1].waypoints", |b| {
            b["vehicles"][1]["waypoints"] = json!([])
        }),
        ("invalid_value", "vehicles[0].waypoints[1].north_m", |b| {
            b["vehicles"][0]["waypoints"][1] = at(1e9, 0.0)
        }),
        ("invalid_value", "start.in_s", |b| b["start"]["in_s"] = json!(-1.0)),
        ("invalid_value", "max_speed_m_s", |b| b["max_speed_m_s"] = json!(0.0)),
        ("invalid_body", "crackle", |b| b["kind"] = json!("crackle")),
        ("invalid_body", "speed", |b| b["speed"] = json!(3.0)),
    ];
    for path in [PATH, "/api/v1/trajectories/preview"] {
        for (code, says, change) in wrong {
            let (status, refused) = served.ask("POST", path, Some(body(change))).await;
            assert_eq!(
                (status, refused["error"]["code"].as_str()),
                (422, Some(*code)),
                "{refused}"
            );
            let message = refused["error"]["message"].as_str().unwrap_or_default();
            assert!(message.contains(says), "{says}: {message}");
        }
        let twice = body(|b| b["vehicles"][1]["vehicle"] = json!(1));
        let (status, refused) = served.ask("POST", path, Some(twice)).await;
        let message = refused["error"]["message"].as_str().unwrap_or_default();
        assert!(
            status == 409 && message.contains("vehicle 1 is there twice"),
            "{refused}"
        );
    }
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn everything_that_is_against_them_is_told() {
    let served = start().await;
    let (status, refused) = served
        .ask("POST", PATH, Some(body(|b| b["max_speed_m_s"] = json!(150.0))))
        .await;
    assert_eq!(
        (status, refused["error"]["code"].as_str()),
        (409, Some("trajectories_refused")),
        "{refused}"
    );
    let against = refused["error"]["detail"]["against"].as_array().unwrap().clone();
    let reasons: Vec<_> = against
        .iter()
        .map(|o| {
            (
                o["vehicle"].as_u64(),
                o["refusal"]["reason"].as_str().unwrap_or_default(),
            )
        })
        .collect();
    assert_eq!(
        reasons,
        [
            (None, "too_fast"),
            (Some(1), "unknown_vehicle"),
            (Some(2), "unknown_vehicle")
        ]
    );
    let (_, refused) = served
        .ask(
            "POST",
            PATH,
            Some(body(|b| b["start"] = json!({ "when": "at", "time": 1 }))),
        )
        .await;
    let refusal = &refused["error"]["detail"]["against"][0]["refusal"];
    assert_eq!(refusal["reason"], "clock", "{refused}");
    // One reason alone has its own status.
    let one = body(|b| b["vehicles"] = json!([{ "vehicle": 7, "waypoints": [at(0.0, 0.0)] }]));
    let (status, refused) = served.ask("POST", PATH, Some(one)).await;
    assert_eq!(status, 404, "{refused}");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn nothing_is_flown_and_nothing_ends_where_nothing_was_begun() {
    let served = start().await;
    let (status, list) = served.ask("GET", PATH, None).await;
    assert_eq!((status, &list["trajectories"]), (200, &json!([])));
    assert!(list["time"].as_u64().is_some(), "{list}");
    let (status, ended) = served.ask("DELETE", PATH, None).await;
    assert_eq!((status, ended), (200, json!({ "vehicles": [] })));
    served.stop().await;
}
