//! What detectors and other sensors see becomes tracks: from several cameras, over the API, in a flood of what is not true, and over two nodes of which one is lost.
#![allow(
    clippy::unwrap_used,
    reason = "what tests share may stop at the first surprise, as they do"
)]

use reqwest::Method;
use serde_json::{Value, json};
use skein_config::{AdoptionRule, Escalation, Isolation, PayloadRule};
use skein_domain::payload::{FIRST_FUSED_TRACK, TrackEstimate, TrackSource};
use skein_domain::{NodeTime, PositionNed, VelocityNed};
use skein_sim::{PayloadPlan, VehicleStart};
use skein_testkit::{Flock, LONGEST_GAP_S, Member, Swarm, eventually, example_library, patience};
use skein_view::{EventKind, FleetSnapshot};
use std::net::SocketAddr;
use std::time::Duration;

/// What all cameras see.
const START: PositionNed = PositionNed::new(50.0, 8.0, -14.0);
const VELOCITY: VelocityNed = VelocityNed::new(0.0, 0.2, 0.0);
/// 99.9 % of the squared deviations of a place.
const FARTHEST: f64 = 16.3;

fn rule(name: &str, config: Value) -> PayloadRule {
    PayloadRule {
        name: name.into(),
        plugin: name.into(),
        isolation: Isolation::InProcess,
        transport: None,
        on_failure: Escalation::Hold,
        config,
    }
}

/// Two vehicles that look north side by side, and a third one that looks the same way from where they see it.
async fn looking(plugins: &tempfile::TempDir) -> Swarm {
    let library = example_library("fixture-world-points", "world_points");
    std::fs::copy(library, plugins.path().join("libworld_points.so")).unwrap();
    let directory = plugins.path().to_owned();
    let points = json!([{ "id": "one", "class": "drone", "start": START, "velocity": VELOCITY, "width_m": 0.5 }]);
    let camera = json!({
        "source": "synthetic", "width_px": 320, "height_px": 240, "rate_hz": 10.0, "mount_pitch_rad": 0.0,
    });
    Swarm::start_with(3, move |config, sim| {
        config.swarm.origin = Some(sim.origin);
        config.plugins.directories.push(directory);
        config.tracking.steer_by_fused = true;
        config.adopt = vec![AdoptionRule {
            payloads: vec![
                rule("camera", camera),
                rule("world-points", json!({ "points": points })),
            ],
            ..AdoptionRule::default()
        }];
        sim.payloads = PayloadPlan::all();
        let start = |north_m, east_m| VehicleStart {
            position: PositionNed::new(north_m, east_m, 0.0),
            ..VehicleStart::default()
        };
        sim.starts = vec![start(0.0, 0.0), start(0.0, 30.0), start(35.0, 20.0)];
    })
    .await
}

fn fused(fleet: &FleetSnapshot) -> Vec<&TrackEstimate> {
    let tracks = fleet.tracks.iter();
    tracks.filter(|track| track.source == TrackSource::Fused).collect()
}

/// How far a track is from where the thing was then: squared, by its covariance.
fn squared_deviation(track: &TrackEstimate) -> f64 {
    let truth = START.after(&VELOCITY, track.track.time.as_seconds());
    let off = track.track.position.vector() - truth.vector();
    let covariance = track.position_covariance().unwrap();
    off.dot(&covariance.cholesky().unwrap().solve(&off))
}

async fn send(address: SocketAddr, method: Method, path: &str, body: Option<&Value>) -> (u16, Value) {
    let request = reqwest::Client::new().request(method, format!("http://{address}{path}"));
    let request = match body {
        Some(body) => request.json(body),
        None => request,
    };
    let answer = request.send().await.unwrap();
    let status = answer.status().as_u16();
    (
        status,
        serde_json::from_str(&answer.text().await.unwrap()).unwrap_or_default(),
    )
}

async fn post(address: SocketAddr, body: &Value) -> (u16, Value) {
    send(address, Method::POST, "/api/v1/detections", Some(body)).await
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cameras_see_is_one_track_that_operators_name_pin_and_drop() {
    let plugins = tempfile::tempdir().unwrap();
    let swarm = looking(&plugins).await;
    swarm.take_off(10.0).await;
    let seen_by_all = |fleet: &FleetSnapshot| {
        let tracks = fused(fleet);
        tracks.len() == 1 && tracks[0].sensors.len() == 3 && !tracks[0].guessed_range && tracks[0].age_s > 2.0
    };
    let fleet = swarm.until("one track", Duration::from_secs(20), seen_by_all).await;
    let track = fused(&fleet)[0].clone();
    assert_eq!(track.class, "drone");
    assert_eq!(track.sensors, ["1/camera", "2/camera", "3/camera"]);
    assert!(squared_deviation(&track) < FARTHEST, "{track:?}");
    assert!(track.largest_error_m().unwrap() < 10.0, "{track:?}");

    let (address, number) = (swarm.web_address(), track.track.track);
    assert!(number >= FIRST_FUSED_TRACK);
    let path = format!("/api/v1/tracks/{number}");
    let change = json!({ "name": "visitor", "pinned": true });
    assert_eq!(send(address, Method::PATCH, &path, Some(&change)).await.0, 204);
    let (_, list) = send(address, Method::GET, "/api/v1/tracks", None).await;
    let shown = &list["tracks"][0];
    assert_eq!(
        (&shown["name"], &shown["pinned"], &shown["track"]),
        (&json!("visitor"), &json!(true), &json!(number))
    );
    refused_changes(address, number).await;

    an_observation_is_asked_for(&swarm, number).await;
    a_flood_changes_nothing(&swarm, number).await;

    assert_eq!(send(address, Method::DELETE, &path, None).await.0, 204);
    let gone = |fleet: &FleetSnapshot| fused(fleet).iter().all(|track| track.track.track != number);
    swarm.until("the track dropped", Duration::ZERO, gone).await;
    let (status, error) = send(address, Method::DELETE, &path, None).await;
    assert_eq!((status, &error["error"]["code"]), (404, &json!("unknown_track")));
    let events = swarm.node().events_after(0);
    let told: Vec<&str> = events
        .iter()
        .filter(|event| event.kind == EventKind::Track { track: number })
        .map(|event| event.text.as_str())
        .collect();
    for what in ["has begun", "\"visitor\"", "is pinned", "was dropped"] {
        assert!(told.iter().any(|text| text.contains(what)), "{what}: {told:?}");
    }
    for vehicle in &swarm.truth_now().await.vehicles {
        let gap_s = vehicle.offboard_gap_sender_max_s;
        assert!(gap_s < LONGEST_GAP_S, "{gap_s:.3} s without a setpoint");
    }
    swarm.stop().await;
}

/// Names that are none, tracks that are not there, numbers that are not to be told.
async fn refused_changes(address: SocketAddr, number: u64) {
    let path = format!("/api/v1/tracks/{number}");
    let long = json!({ "name": "x".repeat(33) });
    assert_eq!(send(address, Method::PATCH, &path, Some(&long)).await.0, 422);
    let unprintable = json!({ "name": "a\nb" });
    assert_eq!(send(address, Method::PATCH, &path, Some(&unprintable)).await.0, 409);
    let nobody = send(
        address,
        Method::PATCH,
        "/api/v1/tracks/1000999",
        Some(&json!({ "pinned": true })),
    )
    .await;
    assert_eq!(nobody.0, 404);
    let track = json!({
        "track": number,
        "position": PositionNed::default(),
        "velocity": VelocityNed::default(),
        "time": NodeTime::default(),
    });
    let told = send(
        address,
        Method::PUT,
        "/api/v1/tracks",
        Some(&json!({ "tracks": [track] })),
    )
    .await;
    assert_eq!((told.0, &told.1["error"]["code"]), (409, &json!("invalid_value")));
}

/// No vehicle here can observe: they are named with the reason that nobody can be asked.
async fn an_observation_is_asked_for(swarm: &Swarm, number: u64) {
    let address = swarm.web_address();
    let (status, list) = send(
        address,
        Method::GET,
        &format!("/api/v1/tracks/{number}/observers"),
        None,
    )
    .await;
    assert_eq!((status, &list["observers"]), (200, &json!([])));
    let path = format!("/api/v1/tracks/{number}/observe");
    let (status, error) = send(address, Method::POST, &path, Some(&json!({}))).await;
    assert_eq!((status, &error["error"]["code"]), (409, &json!("not_enough_vehicles")));
    let named = json!({ "vehicles": [1], "stand_off_m": 20.0 });
    let (status, answer) = send(address, Method::POST, &path, Some(&named)).await;
    assert_eq!(status, 200, "{answer}");
    assert_eq!(answer["asked"][0]["receipt"]["refusal"]["reason"], "not_supported");
}

/// Ten thousand things that are nowhere near: the track and the flight go on.
async fn a_flood_changes_nothing(swarm: &Swarm, number: u64) {
    let address = swarm.web_address();
    let far = |index: u32| {
        let place = PositionNed::new(-500.0 - f64::from(index % 100), f64::from(index % 37) * 9.0, -80.0);
        json!({ "position": place })
    };
    let many: Vec<Value> = (0..1_000).map(far).collect();
    let body = json!({ "source": "noise", "detections": many });
    for _ in 0..10 {
        let (status, answer) = post(address, &body).await;
        assert!(matches!(status, 202 | 429), "{answer}");
    }
    let counts = swarm.node().seen_counts();
    assert!(counts.told > 0 && counts.told + counts.dropped >= 10_000, "{counts:?}");
    let there = |fleet: &FleetSnapshot| fused(fleet).iter().any(|track| track.track.track == number);
    let fleet = swarm
        .until("the track after a flood", Duration::from_secs(10), there)
        .await;
    let track = fused(&fleet)
        .into_iter()
        .find(|track| track.track.track == number)
        .unwrap()
        .clone();
    assert!(squared_deviation(&track) < FARTHEST, "{track:?}");
    let over = json!({ "source": "noise", "detections": vec![far(0); 1_001] });
    assert_eq!(post(address, &over).await.0, 422);
}

/// What a radar says of one thing that stands in the air.
fn echo(place: &PositionNed) -> Value {
    json!({
        "source": "radar-north",
        "detections": [{
            "id": 7, "class": "uav", "score": 0.9, "position": place, "covariance_m2": [4.0, 0.0, 0.0, 4.0, 0.0, 9.0],
        }],
    })
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cannot_be_true_is_refused_with_its_place_and_its_reason() {
    let swarm = Swarm::start(1).await;
    let address = swarm.web_address();
    let sound = echo(&PositionNed::new(100.0, 0.0, -40.0))["detections"][0].clone();
    let origin = PositionNed::default();
    let bearing = json!({ "origin": origin, "azimuth_rad": 0.5, "elevation_rad": 0.1, "error_rad": 0.02 });
    for (wrong, field) in [
        (
            json!({ "position": origin, "covariance_m2": [1, 0, 0, 1, 0, 0] }),
            "detections[1]",
        ),
        (
            json!({ "position": origin, "covariance_m2": [-1, 0, 0, 1, 0, 1] }),
            "detections[1]",
        ),
        (json!({ "position": origin, "bearing": bearing }), "detections[1]"),
        (json!({ "class": "uav" }), "detections[1]"),
        (json!({ "position": origin, "age_s": 3.0 }), "detections[1].age_s"),
    ] {
        let (status, error) = post(address, &json!({ "source": "radar", "detections": [sound, wrong] })).await;
        assert_eq!(
            (status, &error["error"]["detail"]["field"]),
            (422, &json!(field)),
            "{error}"
        );
    }
    let strange = json!({ "source": "radar", "detections": [{ "position": origin, "colour": "red" }] });
    assert_eq!(post(address, &strange).await.0, 422);
    let nameless = json!({ "source": "", "detections": [sound] });
    assert_eq!(post(address, &nameless).await.0, 422);
    let unread = reqwest::Client::new()
        .post(format!("http://{address}/api/v1/detections"))
        .header("content-type", "application/json")
        .body(r#"{"source":"radar","detections":[{"position":{"north_m":NaN,"east_m":0,"down_m":0}}]}"#)
        .send()
        .await
        .unwrap();
    assert_eq!(unread.status().as_u16(), 400);
    // Nothing of it was taken, not even what was sound.
    assert_eq!(swarm.node().seen_counts().told, 0);
    swarm.stop().await;
}

/// A radar that tells ten times a second until this is dropped.
struct Radar(tokio::task::JoinHandle<()>);

impl Radar {
    fn at(address: SocketAddr, place: PositionNed) -> Self {
        Self(tokio::spawn(async move {
            let mut every = tokio::time::interval(Duration::from_millis(100));
            loop {
                every.tick().await;
                post(address, &echo(&place)).await;
            }
        }))
    }
}

impl Drop for Radar {
    fn drop(&mut self) {
        self.0.abort();
    }
}

/// The node that coordinates, as this one knows it.
fn acts(flock: &Flock, node: u8) -> bool {
    flock.node(node).swarm().is_some_and(|swarm| swarm.acting)
}

async fn coordinator(flock: &Flock) -> u8 {
    eventually(patience(), "a coordinator", async || {
        [1, 2].into_iter().find(|node| acts(flock, *node))
    })
    .await
}

#[tokio::test(flavor = "multi_thread")]
async fn a_track_keeps_its_number_when_the_node_that_coordinates_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    // The third is there so that nobody is alone when one is lost.
    let members = [1, 2, 3].map(|node| Member {
        node,
        priority: Some(node).filter(|node| *node < 3),
        flies: node < 3,
    });
    let mut flock = Flock::start(&members, folder.path().to_owned(), |_| ()).await;
    let both = |fleet: &FleetSnapshot| fleet.vehicles.len() == 2 && fleet.frame.is_some();
    for node in [1, 2] {
        flock.until(node, "both vehicles", Duration::from_secs(20), both).await;
    }
    let leader = coordinator(&flock).await;
    let other = 3 - leader;
    let place = PositionNed::new(120.0, 40.0, -50.0);
    let _radar = Radar::at(flock.web_address(other), place);
    let known = |fleet: &FleetSnapshot| {
        let tracks = fused(fleet);
        tracks.len() == 1 && tracks[0].track.position.distance_m(&place) < 5.0
    };
    let at_leader = flock
        .until(
            leader,
            "a track of what the other's radar sees",
            Duration::from_secs(20),
            known,
        )
        .await;
    let number = fused(&at_leader)[0].track.track;
    let same = |fleet: &FleetSnapshot| known(fleet) && fused(fleet)[0].track.track == number;
    flock.until(other, "the same track", Duration::from_secs(5), same).await;
    // Named where it is not made.
    flock
        .node(other)
        .change_track(number, Some("visitor".into()), None)
        .await
        .unwrap();
    let named = |fleet: &FleetSnapshot| same(fleet) && fused(fleet)[0].name == "visitor";
    for node in [leader, other] {
        flock.until(node, "its name", Duration::from_secs(5), named).await;
    }
    flock.end(leader).await;
    eventually(patience() + Duration::from_secs(10), "a successor", async || {
        acts(&flock, other).then_some(())
    })
    .await;
    let seen_since = |fleet: &FleetSnapshot| {
        named(fleet)
            && fused(fleet)[0].sensors == ["radar-north"]
            && fleet.time.seconds_since(fused(fleet)[0].seen) < 1.0
    };
    flock
        .until(
            other,
            "the same track, gone on with",
            Duration::from_secs(10),
            seen_since,
        )
        .await;
    flock.stop().await;
}
