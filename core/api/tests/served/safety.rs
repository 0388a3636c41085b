//! Fences, preflight overrides, the emergency stop, references and previews over HTTP: what is taken, what is refused and why.

use crate::node::Served;
use serde_json::{Value, json};
use skein_config::OperatorSettings;
use skein_domain::Geodetic;

fn code(body: &Value) -> &str {
    body["error"]["code"].as_str().unwrap_or_default()
}

const FIELD: &str = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"name":"field","ceiling_m":50},
  "geometry":{"type":"Polygon","coordinates":[[[8.54,47.39],[8.56,47.39],[8.56,47.40],[8.54,47.40],[8.54,47.39]]]}}]}"#;

async fn start() -> Served {
    Served::start_with(|config| {
        config.swarm.origin = Some(Geodetic {
            latitude_deg: 47.397_742,
            longitude_deg: 8.545_594,
            altitude_amsl_m: 488.0,
        });
        config.operators = vec![OperatorSettings {
            name: "anna".into(),
            // Of "password".
            token_sha256: "5e884898da28047151d0e56f8dc6292773603d0d6aabbdd62a11ef721d1542d8".into(),
            may_override_preflight: true,
            may_upgrade: false,
        }];
    })
    .await
}

#[tokio::test(flavor = "multi_thread")]
async fn a_file_of_fences_is_read_put_in_force_and_given_back() {
    let served = start().await;
    let (status, imported) = served
        .ask(
            "POST",
            "/api/v1/fences/import",
            Some(json!({ "name": "field.geojson", "text": FIELD })),
        )
        .await;
    assert_eq!(status, 200, "{imported}");
    assert_eq!(imported["plan"]["zones"][0]["name"], "field");
    let (_, before) = served.ask("GET", "/api/v1/fences", None).await;
    assert_eq!(before["plan"]["zones"], json!([]), "reading puts nothing in force");
    let body = json!({ "plan": imported["plan"] });
    let (status, answer) = served.ask("PUT", "/api/v1/fences", Some(body)).await;
    assert_eq!(status, 200, "{answer}");
    let (_, in_force) = served.ask("GET", "/api/v1/fences", None).await;
    assert_eq!(in_force["plan"], imported["plan"]);
    let (status, exported) = served.ask("GET", "/api/v1/fences/geojson", None).await;
    assert_eq!((status, exported["type"].as_str()), (200, Some("FeatureCollection")));

    // Wrong ones say what is wrong, and change nothing.
    for (text, says) in [("{", "parse"), (r#"{"type":"Point"}"#, "coordinates"), ("[]", "")] {
        let body = json!({ "text": text });
        let (status, refused) = served.ask("POST", "/api/v1/fences/import", Some(body)).await;
        assert_eq!((status, code(&refused)), (409, "invalid_value"), "{text}");
        let message = refused["error"]["message"].as_str().unwrap_or_default();
        assert!(message.contains(says), "{text}: {message}");
    }
    let mut wrong = imported["plan"].clone();
    wrong["zones"][0]["floor_m"] = json!(80.0);
    let (status, refused) = served
        .ask("PUT", "/api/v1/fences", Some(json!({ "plan": wrong })))
        .await;
    assert_eq!(status, 409, "{refused}");
    assert_eq!(served.ask("GET", "/api/v1/fences", None).await.1, in_force);
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn only_a_configured_operator_overrides_the_preflight_report() {
    let served = start().await;
    let body = json!({ "items": ["fences"], "reason": "a field without fences", "valid_s": 60.0 });
    let (status, refused) = served
        .ask("POST", "/api/v1/preflight/overrides", Some(body.clone()))
        .await;
    assert_eq!((status, code(&refused)), (401, "no_operator"));
    let as_operator = async |secret: &str, body: &Value| {
        let answer = served
            .http
            .post(served.url("/api/v1/preflight/overrides"))
            .header("authorization", format!("Bearer {secret}"))
            .json(body)
            .send()
            .await
            .unwrap();
        (answer.status().as_u16(), answer.json::<Value>().await.unwrap())
    };
    assert_eq!(as_operator("guess", &body).await.0, 401);
    let (status, given) = as_operator("password", &body).await;
    assert_eq!((status, given["operator"].as_str()), (200, Some("anna")), "{given}");
    let (_, preflight) = served.ask("GET", "/api/v1/preflight", None).await;
    assert_eq!(preflight["overrides"][0]["reason"], "a field without fences");
    let (_, events) = served.ask("GET", "/api/v1/events", None).await;
    assert!(events.to_string().contains("overridden by anna"), "it is on record");
    // What nobody can override, nobody overrides.
    let body = json!({ "items": ["position"], "reason": "never mind", "valid_s": 60.0 });
    assert_eq!(as_operator("password", &body).await.0, 403);
    let body = json!({ "items": ["fences"], "reason": " ", "valid_s": 60.0 });
    assert_eq!(as_operator("password", &body).await.0, 409);
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_emergency_stop_needs_its_first_step() {
    let served = start().await;
    let stop = |key: &Value| json!({ "key": key, "targets": "all" });
    let (status, refused) = served
        .ask("POST", "/api/v1/emergency-stop", Some(stop(&json!("0"))))
        .await;
    assert_eq!((status, code(&refused)), (403, "not_permitted"));
    let (status, unlocked) = served.ask("POST", "/api/v1/emergency-stop/unlock", None).await;
    assert_eq!(status, 200);
    let (status, receipts) = served
        .ask("POST", "/api/v1/emergency-stop", Some(stop(&unlocked["key"])))
        .await;
    assert_eq!(
        (status, &receipts["receipts"]),
        (200, &json!([])),
        "there is nobody to stop"
    );
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn references_are_told_listed_and_forgotten() {
    let served = start().await;
    let at = |north_m: f64| json!({ "position": { "north_m": north_m, "east_m": 0.0, "down_m": -5.0 } });
    let (status, answer) = served.ask("PUT", "/api/v1/references/car", Some(at(3.0))).await;
    assert_eq!(status, 204, "{answer}");
    let (_, list) = served.ask("GET", "/api/v1/references", None).await;
    assert_eq!(list["references"][0]["name"], "car");
    assert_eq!(list["references"][0]["report"]["position"]["north_m"], 3.0);
    let (status, _) = served.ask("PUT", "/api/v1/references/car", Some(at(1e9))).await;
    assert_eq!(status, 422);
    assert_eq!(served.ask("DELETE", "/api/v1/references/car", None).await.0, 204);
    let (status, gone) = served.ask("DELETE", "/api/v1/references/car", None).await;
    assert_eq!((status, code(&gone)), (404, "unknown_reference"));
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_formation_is_previewed_without_being_flown() {
    let served = start().await;
    let ask = |shape: &str, extra: Value| {
        let mut body = json!({ "shape": shape, "spacing_m": 5.0, "members": [1, 2, 3, 4, 5] });
        for (key, value) in extra.as_object().unwrap() {
            body[key] = value.clone();
        }
        body
    };
    let preview = "/api/v1/formation/preview";
    let (status, wedge) = served.ask("POST", preview, Some(ask("wedge", json!({})))).await;
    assert_eq!(
        (status, wedge["slots"].as_array().map(Vec::len)),
        (200, Some(5)),
        "{wedge}"
    );
    assert!(wedge["smallest_distance_m"].as_f64().unwrap() >= 5.0 - 1e-6);
    // The leader at the tip looks ahead; nobody of this swarm carries a camera.
    assert_eq!(
        (&wedge["views"][0], wedge["views"].as_array().map(Vec::len)),
        (&json!("ahead"), Some(5))
    );
    assert_eq!(wedge["looking"], 0);
    let (_, larger) = served
        .ask("POST", preview, Some(ask("wedge", json!({ "scale": 2.0 }))))
        .await;
    assert!(larger["smallest_distance_m"].as_f64().unwrap() >= 10.0 - 1e-6);
    let (status, few) = served
        .ask("POST", preview, Some(ask("free", json!({ "offsets": [] }))))
        .await;
    assert_eq!(status, 422, "{few}");
    let (status, arc) = served
        .ask("POST", preview, Some(ask("arc", json!({ "arc_deg": 400.0 }))))
        .await;
    assert_eq!((status, code(&arc)), (422, "invalid_value"));
    assert_eq!(
        served.ask("GET", "/api/v1/formation", None).await.1["formation"],
        Value::Null
    );
    served.stop().await;
}
