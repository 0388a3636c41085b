//! Tests of what is accepted as a request body.

use super::*;
use crate::protocol::{AcknowledgeBody, CommandBody, RouteBody};
use axum::body::Body as HttpBody;
use proptest::prelude::*;
use serde_json::json;
use skein_domain::{FormationRequest, VehicleId};
use skein_runtime::{Fault, Targets};

fn read<T: DeserializeOwned + JsonSchema + Example + 'static>(
    kind: &str,
    body: impl Into<HttpBody>,
) -> Result<T, (u16, String, String)> {
    let request = Request::builder()
        .header("content-type", kind)
        .body(body.into())
        .unwrap();
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_time()
        .build()
        .unwrap();
    let read = runtime.block_on(Body::<T>::from_request(request, &()));
    read.map(|Body(value)| value)
        .map_err(|error| (error.status().as_u16(), error.code().to_owned(), error.to_string()))
}

fn command(body: Value) -> Result<CommandBody, (u16, String, String)> {
    read("application/json; charset=utf-8", body.to_string())
}

fn refused<T: std::fmt::Debug>(outcome: Result<T, (u16, String, String)>, status: u16, code: &str, says: &str) {
    let (is_status, is_code, message) = outcome.unwrap_err();
    assert_eq!((is_status, is_code.as_str()), (status, code), "{message}");
    assert!(message.contains(says), "{message:?} does not say {says:?}");
}

#[test]
fn every_command_is_read() {
    let place = json!({ "north_m": 1.0, "east_m": 2.0, "down_m": -3.0 });
    let commands = [
        json!({ "command": "arm" }),
        json!({ "command": "disarm" }),
        json!({ "command": "take_off", "height_m": 10 }),
        json!({ "command": "land" }),
        json!({ "command": "land_at", "spot": place }),
        json!({ "command": "hold" }),
        json!({ "command": "return" }),
        json!({ "command": "go_to", "position": place }),
        json!({ "command": "go_to", "position": place, "yaw_rad": 1.5, "speed_m_s": 4 }),
    ];
    for one in commands {
        let all = command(json!({ "targets": "all", "command": one })).unwrap();
        assert_eq!(all.command.name(), one["command"]);
        let some = command(json!({ "targets": { "vehicles": [1, 2] }, "command": one })).unwrap();
        assert_eq!(some.targets, Targets::Vehicles(vec![VehicleId(1), VehicleId(2)]));
    }
}

#[test]
fn what_is_not_the_published_shape_is_refused_with_the_place() {
    refused(
        command(json!({ "targets": "all" })),
        422,
        "invalid_body",
        "missing field `command`",
    );
    refused(
        command(json!({ "targets": "some", "command": { "command": "arm" } })),
        422,
        "invalid_body",
        "targets",
    );
    refused(
        command(json!({ "targets": "all", "command": { "command": "explode" } })),
        422,
        "invalid_body",
        "command",
    );
    let bad = json!({ "targets": "all", "command": { "command": "take_off", "height_m": "ten" } });
    refused(command(bad), 422, "invalid_body", "command: invalid type");
    let bad = json!({ "targets": { "vehicles": [70_000] }, "command": { "command": "arm" } });
    refused(command(bad), 422, "invalid_body", "vehicles");
    let bad = json!({ "targets": "all", "command": { "command": "arm" }, "more": 1 });
    refused(command(bad), 422, "invalid_body", "more");
    refused(command(json!([1])), 422, "invalid_body", "");
    refused(
        command(json!({ "targets": 1, "command": { "command": "arm" } })),
        422,
        "invalid_body",
        "targets",
    );
    refused(
        command(json!(["all", { "command": "arm" }])),
        422,
        "invalid_body",
        "body: a list",
    );
    refused(
        command(json!({ "targets": "all", "command": ["arm"] })),
        422,
        "invalid_body",
        "command: a list",
    );
}

#[test]
fn a_field_beside_a_tag_that_takes_none_is_found() {
    let bad = json!({ "targets": "all", "command": { "command": "arm", "when": 3 } });
    refused(command(bad), 422, "unknown_field", "command.when");
    let bad = json!({ "fault": "coordinator", "vehicle": 1 });
    refused(
        read::<Fault>("application/json", bad.to_string()),
        422,
        "unknown_field",
        "vehicle",
    );
    let bad = json!({ "shape": "wedge", "spacing_m": 5, "heading": { "kind": "auto", "heading_deg": 3 } });
    refused(
        read::<FormationRequest>("application/json", bad.to_string()),
        422,
        "unknown_field",
        "heading.heading_deg",
    );
}

#[test]
fn what_is_not_json_is_refused() {
    refused(read::<CommandBody>("application/json", "{"), 400, "bad_json", "");
    refused(read::<CommandBody>("application/json", ""), 400, "bad_json", "");
    let twice = r#"{"targets":"all","command":{"command":"arm"}} {}"#;
    refused(read::<CommandBody>("application/json", twice), 400, "bad_json", "");
    refused(
        read::<CommandBody>("application/json", vec![0xff, 0xfe, 0x00]),
        400,
        "bad_json",
        "",
    );
    refused(
        read::<CommandBody>("application/json", "[".repeat(100_000)),
        400,
        "bad_json",
        "",
    );
    refused(read::<CommandBody>("text/plain", "{}"), 415, "not_json", "content-type");
    refused(
        read::<CommandBody>("application/jsonp", "{}"),
        415,
        "not_json",
        "content-type",
    );
    let height = |number: &str| {
        let body = format!(r#"{{"targets":"all","command":{{"command":"take_off","height_m":{number}}}}}"#);
        read::<CommandBody>("application/json", body)
    };
    assert!(height("10").is_ok());
    refused(height("NaN"), 400, "bad_json", "");
    refused(height("Infinity"), 400, "bad_json", "");
    refused(height("1e999"), 422, "invalid_body", "number out of range");
    refused(height("-1e999"), 422, "invalid_body", "number out of range");
}

#[test]
fn more_than_the_limit_is_not_read() {
    let long = vec![b' '; 3 * 1024 * 1024];
    refused(read::<CommandBody>("application/json", long), 413, "too_large", "");
}

#[test]
fn numbers_that_make_no_sense_are_refused_with_their_place() {
    let take_off = |height_m: f64| {
        command(json!({ "targets": "all", "command": { "command": "take_off", "height_m": height_m } }))
    };
    assert!(take_off(0.1).is_ok());
    refused(take_off(0.0), 422, "invalid_value", "`command.height_m`");
    refused(take_off(-5.0), 422, "invalid_value", "`command.height_m`");
    refused(take_off(1e300), 422, "invalid_value", "`command.height_m`");
    let none = json!({ "targets": { "vehicles": [] }, "command": { "command": "arm" } });
    refused(command(none), 422, "invalid_value", "`targets.vehicles`");
    let twice = json!({ "targets": { "vehicles": [4, 2, 4] }, "command": { "command": "arm" } });
    refused(command(twice), 422, "invalid_value", "`targets.vehicles`");
    let far = json!({ "north_m": 0, "east_m": 1e9, "down_m": 0 });
    let route = |waypoints: Value, speed: f64, radius: f64| {
        let body = json!({ "route": { "waypoints": waypoints, "speed_m_s": speed, "corner_radius_m": radius } });
        read::<RouteBody>("application/json", body.to_string())
    };
    let near = json!({ "north_m": 0, "east_m": 1, "down_m": -5 });
    assert!(route(json!([near]), 5.0, 0.0).is_ok());
    refused(
        route(json!([near, far]), 5.0, 0.0),
        422,
        "invalid_value",
        "`route.waypoints[1].east_m`",
    );
    refused(route(json!([]), 5.0, 0.0), 422, "invalid_value", "`route.waypoints`");
    refused(
        route(json!([near]), 0.0, 0.0),
        422,
        "invalid_value",
        "`route.speed_m_s`",
    );
    refused(
        route(json!([near]), 5.0, -1.0),
        422,
        "invalid_value",
        "`route.corner_radius_m`",
    );
    let formation = |body: Value| read::<FormationRequest>("application/json", body.to_string());
    assert!(formation(json!({ "shape": "line", "spacing_m": 5 })).is_ok());
    refused(
        formation(json!({ "shape": "line", "spacing_m": 0 })),
        422,
        "invalid_value",
        "`spacing_m`",
    );
    refused(
        formation(json!({ "shape": "line", "spacing_m": 5, "members": [1, 1] })),
        422,
        "invalid_value",
        "`members`",
    );
    let turned = json!({ "shape": "line", "spacing_m": 5, "heading": { "kind": "fixed", "heading_deg": 1e12 } });
    refused(formation(turned), 422, "invalid_value", "`heading.heading_deg`");
}

proptest! {
    #[test]
    fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(read::<CommandBody>("application/json", bytes).is_err());
    }

    #[test]
    fn a_key_anywhere_in_a_go_to_that_is_not_published_is_refused(key in "[a-z_]{1,12}", place in 0..3usize) {
        let mut body = json!({
            "targets": { "vehicles": [1] },
            "command": { "command": "go_to", "position": { "north_m": 0, "east_m": 0, "down_m": 0 } },
        });
        let object = match place {
            0 => &mut body,
            1 => &mut body["command"],
            _ => &mut body["command"]["position"],
        };
        let known = ["targets", "command", "position", "yaw_rad", "speed_m_s", "north_m", "east_m", "down_m"];
        prop_assume!(!known.contains(&key.as_str()));
        object[&key] = json!(1.0);
        prop_assert_eq!(command(body).unwrap_err().0, 422);
    }
}

#[tokio::test(start_paused = true)]
async fn a_body_that_does_not_come_is_not_waited_for() {
    let never = HttpBody::from_stream(futures_util::stream::pending::<Result<Vec<u8>, std::io::Error>>());
    let request = Request::builder()
        .header("content-type", "application/json")
        .body(never)
        .unwrap();
    let error = Body::<CommandBody>::from_request(request, &()).await.unwrap_err();
    assert_eq!((error.status().as_u16(), error.code()), (408, "too_slow"));
}

#[test]
fn who_sends_what_is_not_taken_is_shown_what_is() {
    let request = Request::builder()
        .header("content-type", "application/json")
        .body(HttpBody::from(
            r#"{ "route": { "waypoints": [[1, 2, -3]], "speed_m_s": 2, "corner_radius_m": 1 } }"#,
        ))
        .unwrap();
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_time()
        .build()
        .unwrap();
    let refused = runtime.block_on(Body::<RouteBody>::from_request(request, &()));
    let detail = refused.unwrap_err().detail();
    assert_eq!(detail.code, "invalid_body");
    assert!(detail.message.contains("waypoints[0]"), "{}", detail.message);
    assert_eq!(detail.example, Some(RouteBody::example()));
}

#[test]
fn a_whole_number_may_be_written_with_a_point() {
    let events: AcknowledgeBody = read("application/json", r#"{"events": [3.0, 4]}"#).unwrap();
    assert_eq!(events.events, [3, 4]);
    refused(
        read::<AcknowledgeBody>("application/json", r#"{"events": [3.5]}"#),
        422,
        "invalid_body",
        "events[0]",
    );
}
