//! Live video of a simulated camera over every way that a node has: what is seen is decoded, and the clock in it is read.
#![allow(
    clippy::unwrap_used,
    reason = "what tests share may stop at the first surprise, as they do"
)]

mod encoded;
mod ground_station;
mod odd;
mod rtp;

use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use skein_config::{AdoptionRule, Escalation, Isolation, NodeConfig, PayloadRule};
use skein_domain::{NodeTime, VehicleId};
use skein_runtime::Fault;
use skein_sim::PayloadPlan;
use skein_testkit::{Flock, LONGEST_GAP_S, Member, Peer, Swarm, eventually, patience};
use skein_video::{H264Decoder, jpeg};
use std::net::SocketAddr;
use std::time::Duration;
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream};

/// A picture is not older when it comes; a machine that stood still is forgiven by patience, not here.
const OLDEST_S: f64 = 5.0;

fn rule(name: &str, config: Value) -> PayloadRule {
    PayloadRule {
        name: name.into(),
        plugin: name.into(),
        isolation: Isolation::InProcess,
        transport: None,
        on_failure: Escalation::Degrade,
        config,
    }
}

/// A simulated camera; no larger and quicker than the tests need, since other flights run beside them.
fn camera() -> PayloadRule {
    let config = json!({ "source": "synthetic", "rate_hz": 12.0, "width_px": 480, "height_px": 360, "clock": true });
    rule("camera", config)
}

/// One vehicle with a camera.
async fn with_camera() -> Swarm {
    with_camera_in(Isolation::InProcess).await
}

async fn with_camera_in(isolation: Isolation) -> Swarm {
    with_camera_and(isolation, |_| {}).await
}

async fn with_camera_and(isolation: Isolation, adapt: impl FnOnce(&mut NodeConfig)) -> Swarm {
    let camera = PayloadRule { isolation, ..camera() };
    let adopt = AdoptionRule {
        payloads: vec![camera, rule("gimbal", json!({}))],
        ..AdoptionRule::default()
    };
    let swarm = Swarm::start_with(1, move |config, sim| {
        config.adopt = vec![adopt];
        sim.payloads = PayloadPlan::all();
        adapt(config);
    })
    .await;
    eventually(patience(), "the camera is live", async || {
        (stream_of(&swarm).await["state"] == "live").then_some(())
    })
    .await;
    swarm
}

async fn stream_of(swarm: &Swarm) -> Value {
    let url = format!("http://{}/api/v1/video", swarm.web_address());
    let answer: Value = reqwest::get(url).await.unwrap().json().await.unwrap();
    answer["streams"]
        .as_array()
        .unwrap()
        .first()
        .cloned()
        .unwrap_or_default()
}

/// A viewer over a WebSocket.
struct Viewer(WebSocketStream<MaybeTlsStream<TcpStream>>);

/// A picture as it came.
struct Picture {
    kind: u8,
    key: bool,
    after_gap: bool,
    size_px: (u16, u16),
    sequence: u32,
    taken: NodeTime,
    bytes: Vec<u8>,
}

impl Viewer {
    async fn open(swarm: &Swarm, query: &str) -> Self {
        Self::at(swarm.web_address(), query).await
    }

    async fn at(address: SocketAddr, query: &str) -> Self {
        let url = format!("ws://{address}/api/v1/vehicles/1/payloads/camera/video?{query}");
        Self(tokio_tungstenite::connect_async(url).await.unwrap().0)
    }

    async fn message(&mut self) -> Message {
        let next = tokio::time::timeout(patience(), self.0.next()).await;
        next.expect("something comes").expect("it is open").unwrap()
    }

    async fn picture(&mut self) -> Picture {
        loop {
            let Message::Binary(message) = self.message().await else {
                continue;
            };
            let number = |place: usize| u32::from_le_bytes(message[place..place + 4].try_into().unwrap());
            let side = |place: usize| u16::from_le_bytes(message[place..place + 2].try_into().unwrap());
            assert_eq!(message[0], 1, "the version");
            return Picture {
                kind: message[1],
                key: message[2] & 1 == 1,
                after_gap: message[2] & 2 == 2,
                size_px: (side(4), side(6)),
                sequence: number(8),
                taken: NodeTime(f64::from_le_bytes(message[16..24].try_into().unwrap()) as u64),
                bytes: message[32..].to_vec(),
            };
        }
    }

    async fn told(&mut self, kind: &str) -> Value {
        loop {
            let Message::Text(text) = self.message().await else {
                continue;
            };
            let said: Value = serde_json::from_str(&text).unwrap();
            if said["type"] == kind {
                return said;
            }
        }
    }
}

/// The clock that a picture shows, in milliseconds; none if it cannot be read.
fn clock_ms(file: &[u8]) -> Option<u32> {
    let picture = image::load_from_memory(file).unwrap().to_luma8();
    let cell = picture.width() / 80;
    let level = |index: u32| picture.get_pixel(cell + index * cell + cell / 2, cell + cell / 2).0[0];
    let (white, black) = (u32::from(level(0)), u32::from(level(1)));
    let is_one = |index: u32| u32::from(level(index)) * 2 > white + black;
    let number = |from: u32, count: u32| (from..from + count).fold(0_u32, |sum, bit| sum << 1 | u32::from(is_one(bit)));
    let clock = number(2, 32);
    let sum: u32 = clock
        .to_be_bytes()
        .iter()
        .map(|byte| u32::from(byte >> 4) + u32::from(byte & 15))
        .sum();
    (white > black + 60 && number(34, 4) == sum % 16).then_some(clock)
}

/// A picture shows when it was taken, to the millisecond.
fn shows_its_time(file: &[u8], taken: NodeTime) {
    assert_eq!(
        clock_ms(file),
        Some((taken.0 / 1000) as u32),
        "the clock in the picture"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn h264_over_a_websocket_is_decoded_and_shows_the_clock() {
    let swarm = with_camera().await;
    let mut viewer = Viewer::open(&swarm, "way=h264").await;
    let mut decoder = H264Decoder::new().unwrap();
    let mut last: Option<Picture> = None;
    for count in 0..20 {
        let picture = viewer.picture().await;
        assert_eq!((picture.kind, picture.size_px), (1, (480, 360)));
        assert!(count > 0 || picture.key, "a viewer begins with a key picture");
        let follows = last.as_ref().is_none_or(|last| picture.sequence == last.sequence + 1);
        assert!(follows || picture.after_gap && picture.key, "what is missing is told");
        let planes = decoder.decode(&picture.bytes).unwrap().expect("a picture");
        shows_its_time(&jpeg(&planes, 90).unwrap(), picture.taken);
        last = Some(picture);
    }
    let state = viewer.told("state").await;
    assert_eq!(
        (&state["state"], &state["width_px"]),
        (&json!("live"), &json!(480)),
        "{state}"
    );
    assert!(state["codec"].as_str().unwrap().starts_with("avc1.42"), "{state}");
    viewer.0.send(Message::text(r#"{"type":"ping","id":7}"#)).await.unwrap();
    let pong = viewer.told("pong").await;
    assert_eq!(pong["id"], 7);
    let now = NodeTime(pong["time_us"].as_u64().unwrap());
    let age_s = now.seconds_since(last.unwrap().taken);
    assert!((0.0..OLDEST_S).contains(&age_s), "{age_s} s");
    let seen = r#"{"type":"seen","p50_s":0.0125,"p99_s":0.5}"#;
    viewer.0.send(Message::text(seen)).await.unwrap();
    let url = format!("http://{}/metrics", swarm.web_address());
    eventually(patience(), "what a viewer sees is in the metrics", async || {
        let metrics = reqwest::get(&url).await.unwrap().text().await.unwrap();
        let line = r#"skein_video_glass_to_glass_p50_seconds{vehicle="1",payload="camera"} 0.0125"#;
        metrics.contains(line).then_some(())
    })
    .await;
    viewer.0.send(Message::text(r#"{"type":"zoom"}"#)).await.unwrap();
    assert!(viewer.told("error").await["reason"].as_str().unwrap().contains("zoom"));
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_key_picture_comes_when_a_decoder_asks_for_it() {
    let swarm = with_camera().await;
    let mut viewer = Viewer::open(&swarm, "way=h264").await;
    while viewer.picture().await.key {}
    viewer.0.send(Message::text(r#"{"type":"key"}"#)).await.unwrap();
    let mut pictures = 0;
    while !viewer.picture().await.key {
        pictures += 1;
    }
    // by itself one comes after two seconds, which are 24 pictures
    assert!(pictures < 18, "{pictures} pictures later");
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn small_pictures_and_jpeg_are_made_for_those_who_want_them() {
    let swarm = with_camera().await;
    let mut small = Viewer::open(&swarm, "way=h264&quality=sub").await;
    let picture = small.picture().await;
    assert_eq!((picture.kind, picture.size_px, picture.key), (1, (320, 240), true));
    let planes = H264Decoder::new()
        .unwrap()
        .decode(&picture.bytes)
        .unwrap()
        .expect("a picture");
    shows_its_time(&jpeg(&planes, 90).unwrap(), picture.taken);
    for query in ["way=jpeg", "way=jpeg&quality=sub"] {
        let mut viewer = Viewer::open(&swarm, query).await;
        let picture = viewer.picture().await;
        assert_eq!(picture.kind, 2);
        shows_its_time(&picture.bytes, picture.taken);
    }
    let mut silent = Viewer::open(&swarm, "way=none").await;
    assert_eq!(silent.told("state").await["vehicle"], 1);
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn jpeg_files_come_in_one_answer_that_does_not_end() {
    let swarm = with_camera().await;
    let url = format!(
        "http://{}/api/v1/vehicles/1/payloads/camera/video/mjpeg",
        swarm.web_address()
    );
    let mut answer = reqwest::get(url).await.unwrap();
    assert_eq!(
        answer.headers()["content-type"],
        "multipart/x-mixed-replace; boundary=picture"
    );
    let mut read = Vec::new();
    let parts = |read: &[u8]| read.windows(9).filter(|bytes| bytes == b"--picture").count();
    while parts(&read) < 4 {
        read.extend(answer.chunk().await.unwrap().expect("it does not end"));
    }
    let begin = read.windows(2).position(|bytes| bytes == [0xff, 0xd8]).unwrap();
    let end = read.windows(11).position(|bytes| bytes == b"\r\n--picture").unwrap();
    assert!(clock_ms(&read[begin..end]).is_some());
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_browser_that_speaks_webrtc_gets_the_same_pictures() {
    let swarm = with_camera().await;
    let base = format!("http://{}", swarm.web_address());
    let path = "/api/v1/vehicles/1/payloads/camera/video/whep";
    let mut peer = Peer::at(swarm.web_address().ip()).await;
    let post = |kind: &str, body: String| {
        let request = reqwest::Client::new().post(format!("{base}{path}"));
        request.header("content-type", kind).body(body).send()
    };
    let refused = post("application/json", peer.offer()).await.unwrap();
    assert_eq!(refused.status(), 415);
    let refused = post("application/sdp", "v=nonsense".into()).await.unwrap();
    assert_eq!(refused.status(), 422);

    let answer = post("application/sdp", peer.offer()).await.unwrap();
    assert_eq!(answer.status(), 201);
    let session = answer.headers()["location"].to_str().unwrap().to_owned();
    peer.accept(&answer.text().await.unwrap());
    let mut decoder = H264Decoder::new().unwrap();
    let mut shown = Vec::new();
    while shown.len() < 15 {
        let bytes = peer.picture().await;
        // A decoder that came late waits for a key picture.
        if let Ok(Some(planes)) = decoder.decode(&bytes) {
            shown.push(clock_ms(&jpeg(&planes, 90).unwrap()).expect("a clock"));
        }
    }
    assert!(shown.is_sorted() && shown.first() < shown.last(), "{shown:?}");
    assert_eq!(stream_of(&swarm).await["viewers"], 1);

    let end = || reqwest::Client::new().delete(format!("{base}{session}")).send();
    assert_eq!(end().await.unwrap().status(), 204);
    eventually(patience(), "nobody looks any more", async || {
        (stream_of(&swarm).await["viewers"] == 0).then_some(())
    })
    .await;
    // a browser may say it once more; of another session nobody knows
    assert_eq!(end().await.unwrap().status(), 204);
    let unknown = reqwest::Client::new().delete(format!("{base}/api/v1/video/sessions/none"));
    assert_eq!(unknown.send().await.unwrap().status(), 404);
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn one_who_does_not_read_and_many_who_come_and_go_disturb_nobody() {
    let swarm = with_camera().await;
    let mut viewer = Viewer::open(&swarm, "way=h264").await;
    let _never_read = Viewer::open(&swarm, "way=jpeg").await;
    let mut last = viewer.picture().await;
    for _ in 0..20 {
        drop(Viewer::open(&swarm, "way=h264").await);
        let next = viewer.picture().await;
        assert!(next.sequence == last.sequence + 1 || next.after_gap);
        last = next;
    }
    drop(viewer);
    eventually(patience(), "only who does not read is left, or nobody", async || {
        (stream_of(&swarm).await["viewers"].as_u64() <= Some(1)).then_some(())
    })
    .await;
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cannot_be_seen_is_said() {
    let swarm = with_camera().await;
    let status = async |path: &str| {
        let url = format!("http://{}/api/v1/vehicles/{path}", swarm.web_address());
        let request = reqwest::Client::new().get(url).header("connection", "upgrade");
        request.send().await.unwrap().status().as_u16()
    };
    assert_eq!(status("9/payloads/camera/video").await, 404);
    assert_eq!(status("1/payloads/laser/video").await, 404);
    assert_eq!(status("1/payloads/gimbal/video").await, 409);
    assert_eq!(status("1/payloads/camera/video?way=telepathy").await, 400);
    assert_eq!(status("1/payloads/camera/video").await, 426);

    // a camera that is ended says so, and its viewers see it come back
    let mut viewer = Viewer::open(&swarm, "way=h264").await;
    let before = viewer.picture().await;
    swarm.node().restart_plugin(VehicleId(1), Some("camera")).unwrap();
    let begun = tokio::time::Instant::now();
    let mut after = viewer.picture().await;
    while after.taken <= before.taken && begun.elapsed() < Duration::from_secs(60) {
        after = viewer.picture().await;
    }
    assert!(after.sequence > before.sequence);
    swarm.stop().await;
}

/// A vehicle with a camera whose node is another one than that of the ground station, which is node 9.
async fn with_camera_elsewhere(folder: &std::path::Path) -> Flock {
    with_camera_elsewhere_and(folder, |config| {
        config.adopt.iter_mut().for_each(|rule| rule.payloads = vec![camera()]);
    })
    .await
}

async fn with_camera_elsewhere_and(folder: &std::path::Path, adapt: fn(&mut NodeConfig)) -> Flock {
    let of_node = |node: u8, priority: u16, flies: bool| Member {
        node,
        priority: Some(u8::try_from(priority).unwrap()),
        flies,
    };
    let members = [of_node(1, 10, true), of_node(9, 200, false)];
    let flock = Flock::start(&members, folder.to_owned(), adapt).await;
    let what = "the camera is known at the ground";
    flock
        .until(9, what, patience(), |fleet| {
            fleet
                .vehicles
                .iter()
                .any(|vehicle| vehicle.payloads.iter().any(|payload| payload.name == "camera"))
        })
        .await;
    flock
}

#[tokio::test(flavor = "multi_thread")]
async fn a_camera_of_another_node_is_seen_at_the_ground_station() {
    let folder = tempfile::tempdir().unwrap();
    let flock = with_camera_elsewhere(folder.path()).await;
    let mut viewer = Viewer::at(flock.web_address(9), "way=h264").await;
    let mut decoder = H264Decoder::new().unwrap();
    let mut ahead_ms = Vec::new();
    for count in 0..30 {
        let picture = viewer.picture().await;
        assert!(count > 0 || picture.key);
        let planes = decoder.decode(&picture.bytes).unwrap().expect("a picture");
        // it shows the clock of its own node, and says when that was by the clock of this one
        let clock_ms = clock_ms(&jpeg(&planes, 90).unwrap()).expect("a clock");
        ahead_ms.push((picture.taken.0 / 1000) as i64 - i64::from(clock_ms));
    }
    let spread_ms = ahead_ms.iter().max().unwrap() - ahead_ms.iter().min().unwrap();
    assert!(spread_ms < 500, "the offset between the two clocks: {ahead_ms:?}");
    let state = viewer.told("state").await;
    assert_eq!(
        (&state["state"], &state["width_px"]),
        (&json!("live"), &json!(480)),
        "{state}"
    );

    // small ones and JPEG are made there and here
    let mut small = Viewer::at(flock.web_address(9), "way=jpeg&quality=sub").await;
    let picture = small.picture().await;
    assert_eq!((picture.kind, picture.size_px), (2, (320, 240)));
    drop((small, viewer));
    // nobody looks any more: the node that has the camera stops sending and encoding
    let url = format!("http://{}/api/v1/video", flock.web_address(1));
    eventually(patience(), "the other node sends nothing any more", async || {
        let answer: Value = reqwest::get(&url).await.unwrap().json().await.unwrap();
        (answer["streams"][0]["viewers"] == 0).then_some(())
    })
    .await;
    // and begins again for who comes later
    let mut again = Viewer::at(flock.web_address(9), "way=h264").await;
    let first = again.picture().await.taken;
    while again.picture().await.taken <= first {}
    flock.stop().await;
}

/// Raw times are told; what is judged is that each kill is followed by pictures, and the flight.
#[tokio::test(flavor = "multi_thread")]
#[ignore = "long: part of `cargo xtask test integration`"]
async fn a_camera_that_is_killed_twenty_times_in_a_minute_comes_back_each_time_and_the_flight_goes_on() {
    let swarm = with_camera_in(Isolation::Child).await;
    swarm.take_off(6.0).await;
    let mut viewer = Viewer::open(&swarm, "way=h264").await;
    let mut away_s = Vec::new();
    for _ in 0..20 {
        let payload = Some("camera".to_owned());
        let vehicle = VehicleId(1);
        let kill = Fault::PluginKill { vehicle, payload };
        let mut last = viewer.picture().await.taken;
        swarm.node().inject_fault(kill).await.unwrap();
        let until = swarm.node().now().plus_seconds(2.8);
        let mut longest_s: f64 = 0.0;
        while last < until {
            let next = viewer.picture().await.taken;
            longest_s = longest_s.max(next.seconds_since(last));
            last = next;
        }
        away_s.push(longest_s);
    }
    away_s.sort_by(f64::total_cmp);
    println!(
        "    away for {:.2} s (median), {:.2} s (longest)",
        away_s[10], away_s[19]
    );
    let fleet = swarm.node().next_snapshot().await;
    let camera = fleet.vehicles[0]
        .payloads
        .iter()
        .find(|payload| payload.name == "camera");
    let restarts = camera.map(|camera| camera.plugin.restarts);
    assert!(restarts >= Some(20), "it was started again {restarts:?} times");
    assert!(away_s[10] < 1.0, "{away_s:?}");
    for vehicle in &swarm.truth_now().await.vehicles {
        let gap_s = vehicle.offboard_gap_sender_max_s;
        assert!(gap_s < LONGEST_GAP_S, "{gap_s:.3} s without a setpoint");
    }
    swarm.stop().await;
}
