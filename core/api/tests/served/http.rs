//! REST, documents, headers and errors.

use crate::node::Served;
use serde_json::{Value, json};
use std::time::Duration;

/// The error code of an answer, which has to have the published shape.
fn code(body: &Value) -> &str {
    let error = body["error"]
        .as_object()
        .unwrap_or_else(|| panic!("not an error: {body}"));
    let mut fields: Vec<_> = error.keys().map(String::as_str).collect();
    // A refused body is shown one that would be taken.
    fields.retain(|field| *field != "example");
    fields.sort_unstable();
    assert_eq!(fields, ["code", "detail", "message"]);
    assert!(!error["message"].as_str().unwrap().is_empty());
    error["code"].as_str().unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn exactly_the_documented_routes_are_served() {
    let served = Served::start().await;
    let (status, document) = served.ask("GET", "/api/v1/openapi.json", None).await;
    assert_eq!(status, 200);
    let paths = document["paths"].as_object().unwrap();
    assert!(paths.len() >= 13);
    for (path, item) in paths {
        for method in ["GET", "POST", "PUT", "DELETE", "PATCH"] {
            let (status, body) = served.ask(method, &path.replace("{id}", "1"), None).await;
            let is_documented = item.get(method.to_lowercase()).is_some();
            assert_eq!(status != 405, is_documented, "{method} {path}: {status} {body}");
            if !is_documented {
                assert_eq!(code(&body), "method_not_allowed");
            } else if status == 404 {
                assert!(code(&body).starts_with("unknown_"), "{method} {path}: {body}");
            }
        }
    }
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn every_documented_answer_says_so() {
    let served = Served::start().await;
    let (_, document) = served.ask("GET", "/api/v1/openapi.json", None).await;
    for (path, item) in document["paths"].as_object().unwrap() {
        if item.get("get").is_none() {
            continue;
        }
        let answer = served
            .http
            .get(served.url(&path.replace("{id}", "1")))
            .send()
            .await
            .unwrap();
        let status = answer.status().as_u16().to_string();
        let documented = &item["get"]["responses"][&status]["content"];
        let kind = answer.headers()["content-type"]
            .to_str()
            .unwrap()
            .split(';')
            .next()
            .unwrap()
            .to_owned();
        assert!(
            documented.get(&kind).is_some(),
            "GET {path} answers {status} {kind}, which is not documented: {documented}"
        );
    }
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_not_there_is_not_found() {
    let served = Served::start().await;
    for path in [
        "/api",
        "/api/",
        "/api/v1",
        "/api/v1/nothing",
        "/api/v2/version",
        "/api/v1/vehicles/",
        "/nothing.js",
        "/.gitkeep",
    ] {
        let (status, body) = served.ask("GET", path, None).await;
        assert_eq!((status, code(&body)), (404, "not_found"), "{path}");
    }
    for path in ["/api/v1/vehicles/x", "/api/v1/vehicles/-1", "/api/v1/vehicles/70000"] {
        let (status, body) = served.ask("GET", path, None).await;
        assert_eq!((status, code(&body)), (400, "invalid_path"), "{path}");
    }
    let (status, body) = served.ask("POST", "/", Some(json!({}))).await;
    assert_eq!((status, code(&body)), (405, "method_not_allowed"));
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_node_without_vehicles_says_what_it_is() {
    let served = Served::start_with(|config| config.node.name = "ground".into()).await;
    let (status, version) = served.ask("GET", "/api/v1/version", None).await;
    assert_eq!(status, 200);
    assert_eq!(
        version,
        json!({ "program": "skein", "version": env!("CARGO_PKG_VERSION"), "node": "ground", "protocol": 1 })
    );
    let (status, health) = served.ask("GET", "/api/v1/health", None).await;
    assert_eq!((status, health["status"].as_str()), (200, Some("ok")), "{health}");
    assert_eq!(health["vehicles"], 0);
    let (_, vehicles) = served.ask("GET", "/api/v1/vehicles", None).await;
    assert_eq!(vehicles["vehicles"], json!([]));
    let (_, fleet) = served.ask("GET", "/api/v1/fleet", None).await;
    assert_eq!(fleet["vehicles"], json!([]));
    assert_eq!(
        served.ask("GET", "/api/v1/formation", None).await,
        (200, json!({ "formation": null }))
    );
    let (_, plugins) = served.ask("GET", "/api/v1/plugins", None).await;
    assert_eq!(plugins, json!({ "plugins": [], "problems": [] }));
    let (_, tree) = served.ask("GET", "/api/v1/supervision", None).await;
    let actors = tree["actors"].as_array().unwrap();
    let coordinator = actors.iter().find(|actor| actor["name"] == "coordinator");
    assert_eq!(
        coordinator.map(|actor| &actor["status"]),
        Some(&json!("running")),
        "{tree}"
    );
    assert_eq!(tree["vehicles"], json!([]));
    let metrics = served
        .http
        .get(served.url("/metrics"))
        .send()
        .await
        .unwrap()
        .text()
        .await
        .unwrap();
    for line in [
        "skein_vehicles{state=\"holding\"} 0",
        "skein_actor_up{actor=\"coordinator\"} 1",
    ] {
        assert!(metrics.lines().any(|is| is == line), "{line:?} is not in\n{metrics}");
    }
    assert!(metrics.contains("skein_info{version=\"") && metrics.contains("node=\"ground\""));
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn commands_that_reach_nobody_are_refused() {
    let served = Served::start().await;
    let arm = json!({ "command": "arm" });
    let some = json!({ "targets": { "vehicles": [3, 4] }, "command": arm });
    let (status, body) = served.ask("POST", "/api/v1/commands", Some(some)).await;
    assert_eq!((status, code(&body)), (404, "unknown_vehicle"));
    let receipts = body["error"]["detail"]["receipts"].as_array().unwrap();
    assert_eq!(receipts.len(), 2);
    assert_eq!(
        receipts[0]["refusal"],
        json!({ "reason": "unknown_vehicle", "vehicle": 3 })
    );
    let all = json!({ "targets": "all", "command": arm });
    let (status, body) = served.ask("POST", "/api/v1/commands", Some(all)).await;
    assert_eq!((status, code(&body)), (409, "not_enough_vehicles"));
    let (status, body) = served.ask("GET", "/api/v1/vehicles/9", None).await;
    assert_eq!((status, code(&body)), (404, "unknown_vehicle"));
    let (status, body) = served
        .ask(
            "PUT",
            "/api/v1/formation",
            Some(json!({ "shape": "wedge", "spacing_m": 5 })),
        )
        .await;
    assert_eq!(status, 409, "{body}");
    let route = json!({ "route": { "waypoints": [{ "north_m": 9, "east_m": 0, "down_m": -5 }], "speed_m_s": 5, "corner_radius_m": 5 } });
    let (status, body) = served.ask("PUT", "/api/v1/formation/route", Some(route)).await;
    assert_eq!(status, 409, "{body}");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn faults_are_injected_only_where_permitted() {
    let served = Served::start().await;
    let coordinator = json!({ "fault": "coordinator" });
    let (status, body) = served.ask("POST", "/api/v1/faults", Some(coordinator.clone())).await;
    assert_eq!((status, code(&body)), (403, "not_permitted"));
    served.stop().await;
    let drill = Served::start_with(|config| config.faults.enabled = true).await;
    let (status, body) = drill.ask("POST", "/api/v1/faults", Some(coordinator)).await;
    assert_eq!((status, body), (202, json!({ "accepted": true })));
    let (status, body) = drill
        .ask(
            "POST",
            "/api/v1/faults",
            Some(json!({ "fault": "plugin_panic", "vehicle": 5 })),
        )
        .await;
    assert_eq!((status, code(&body)), (404, "unknown_vehicle"));
    drill.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn bad_bodies_are_refused_with_the_right_status() {
    let served = Served::start().await;
    let send = |kind: &'static str, body: String| {
        served
            .http
            .post(served.url("/api/v1/commands"))
            .header("content-type", kind)
            .body(body)
            .send()
    };
    let json_kind = "application/json";
    let arm = |more: &str| format!(r#"{{"targets":"all","command":{{"command":"arm"{more}}}}}"#);
    for (kind, body, status, expected) in [
        (json_kind, "{".to_owned(), 400, "bad_json"),
        (json_kind, String::new(), 400, "bad_json"),
        (json_kind, "{}".to_owned(), 422, "invalid_body"),
        (json_kind, arm(r#","when":1"#), 422, "unknown_field"),
        (
            json_kind,
            r#"{"targets":"all","command":{"command":"take_off","height_m":NaN}}"#.to_owned(),
            400,
            "bad_json",
        ),
        (
            json_kind,
            r#"{"targets":"all","command":{"command":"take_off","height_m":-3}}"#.to_owned(),
            422,
            "invalid_value",
        ),
        (json_kind, " ".repeat(1024 * 1024 + 1), 413, "too_large"),
        ("text/plain", arm(""), 415, "not_json"),
        ("application/x-www-form-urlencoded", arm(""), 415, "not_json"),
    ] {
        let answer = send(kind, body).await.unwrap();
        let is = answer.status().as_u16();
        let body: Value = answer.json().await.unwrap();
        assert_eq!((is, code(&body)), (status, expected), "{body}");
    }
    let (status, _) = served.ask("GET", "/api/v1/version", None).await;
    assert_eq!(status, 200, "nothing else is disturbed");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn events_are_listed_from_where_one_left_off() {
    let served = Served::start_with(|config| config.faults.enabled = true).await;
    let unknown = skein_runtime::Fault::PluginPanic {
        vehicle: skein_domain::VehicleId(9),
        payload: None,
    };
    for _ in 0..3 {
        served.handle().inject_fault(unknown.clone()).await.unwrap_err();
    }
    let (status, all) = served.ask("GET", "/api/v1/events", None).await;
    assert_eq!((status, &all["missed"]), (200, &json!(0)));
    let sequence: Vec<u64> = all["events"]
        .as_array()
        .unwrap()
        .iter()
        .map(|event| event["seq"].as_u64().unwrap())
        .collect();
    assert!(
        sequence.len() >= 3 && sequence.windows(2).all(|pair| pair[1] == pair[0] + 1),
        "{sequence:?}"
    );
    let last = sequence.last().unwrap();
    let (_, rest) = served
        .ask("GET", &format!("/api/v1/events?after={}", last - 1), None)
        .await;
    assert_eq!(rest["events"].as_array().unwrap().len(), 1);
    assert_eq!(rest["events"][0]["seq"], *last);
    for query in ["after=x", "after=-1", "before=1", "after=1&more=2"] {
        let (status, body) = served.ask("GET", &format!("/api/v1/events?{query}"), None).await;
        assert_eq!((status, code(&body)), (400, "invalid_query"), "{query}");
    }
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn foreign_pages_are_kept_out() {
    let served = Served::start().await;
    let arm = json!({ "targets": "all", "command": { "command": "arm" } });
    let post = || served.http.post(served.url("/api/v1/commands")).json(&arm);
    for (header, value, expected) in [
        ("host", "evil.example", "foreign_host"),
        ("origin", "http://evil.example", "foreign_origin"),
        ("origin", "null", "foreign_origin"),
        ("sec-fetch-site", "cross-site", "foreign_origin"),
    ] {
        let answer = post().header(header, value).send().await.unwrap();
        assert_eq!(answer.status(), 403);
        assert_eq!(code(&answer.json().await.unwrap()), expected);
    }
    let own = post()
        .header("origin", format!("http://{}", served.address()))
        .send()
        .await
        .unwrap();
    assert_eq!(own.status(), 409, "let in, and there is no vehicle");
    let rebound = served
        .http
        .get(served.url("/"))
        .header("host", "evil.example")
        .send()
        .await
        .unwrap();
    assert_eq!(rebound.status(), 403);
    let preflight = served
        .http
        .request(reqwest::Method::OPTIONS, served.url("/api/v1/commands"));
    let preflight = preflight
        .header("origin", "http://evil.example")
        .header("access-control-request-method", "POST");
    let answer = preflight.send().await.unwrap();
    assert_eq!(answer.status(), 405);
    assert!(answer.headers().get("access-control-allow-origin").is_none());
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn answers_carry_the_headers_that_keep_browsers_careful() {
    let served = Served::start().await;
    for path in ["/", "/api/v1/version", "/metrics", "/api/v1/nothing"] {
        let answer = served.http.get(served.url(path)).send().await.unwrap();
        let headers = answer.headers();
        assert_eq!(headers["x-content-type-options"], "nosniff", "{path}");
        assert_eq!(headers["referrer-policy"], "no-referrer");
        assert_eq!(headers["x-frame-options"], "DENY");
        let policy = headers["content-security-policy"].to_str().unwrap();
        let of_pages = path == "/";
        assert_eq!(policy.contains("default-src 'self'"), of_pages, "{path}: {policy}");
        assert_eq!(policy.contains("default-src 'none'"), !of_pages);
        assert_eq!(
            headers["cache-control"],
            if of_pages { "no-cache" } else { "no-store" },
            "{path}"
        );
    }
    let page = served.http.get(served.url("/")).send().await.unwrap();
    assert_eq!(page.headers()["content-type"], "text/html; charset=utf-8");
    assert!(page.text().await.unwrap().contains("Skein"));
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_server_ends_while_connections_are_open() {
    let served = Served::start().await;
    let idle = tokio::net::TcpStream::connect(served.address()).await.unwrap();
    let (status, _) = served.ask("GET", "/api/v1/version", None).await;
    assert_eq!(status, 200);
    tokio::time::timeout(Duration::from_secs(20), served.stop())
        .await
        .expect("it ends");
    drop(idle);
}
