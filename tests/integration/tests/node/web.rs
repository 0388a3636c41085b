//! The swarm flown by REST and watched by WebSocket, as the dashboard and other programs do it.
#![allow(
    clippy::unwrap_used,
    reason = "what tests share may stop at the first surprise, as they do"
)]

use futures_util::StreamExt;
use serde_json::{Value, json};
use skein_api::wire::{FRAME_MAGIC, Field, HEADER_BYTES, Header, RECORD_BYTES, Record, flag};
use skein_config::NodeConfig;
use skein_domain::FlightState;
use skein_testkit::{Swarm, patience};
use std::collections::BTreeMap;
use std::time::Duration;
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream};

/// A flight of some seconds, beyond our patience.
const FLIGHT: Duration = Duration::from_secs(60);

/// The REST side.
struct Rest {
    http: reqwest::Client,
    base: String,
}

impl Rest {
    fn of(swarm: &Swarm) -> Self {
        Self {
            http: reqwest::Client::new(),
            base: format!("http://{}", swarm.web_address()),
        }
    }

    async fn ask(&self, method: &str, path: &str, body: Option<Value>) -> (u16, Value) {
        let mut request = self
            .http
            .request(method.parse().unwrap(), format!("{}{path}", self.base));
        if let Some(body) = body {
            request = request.json(&body);
        }
        let answer = request.send().await.unwrap();
        let status = answer.status().as_u16();
        let text = answer.text().await.unwrap();
        (status, serde_json::from_str(&text).unwrap_or(Value::String(text)))
    }

    async fn command(&self, targets: Value, command: Value) -> (u16, Value) {
        self.ask(
            "POST",
            "/api/v1/commands",
            Some(json!({ "targets": targets, "command": command })),
        )
        .await
    }
}

/// The WebSocket side: what was heard last, and all events.
struct Watch {
    stream: WebSocketStream<MaybeTlsStream<TcpStream>>,
    fleet: Value,
    safety: BTreeMap<u64, Value>,
    events: Vec<Value>,
    frame: Vec<u8>,
}

impl Watch {
    async fn open(swarm: &Swarm) -> Self {
        let url = format!("ws://{}/api/v1/stream?after=0", swarm.web_address());
        let (stream, _) = tokio_tungstenite::connect_async(url).await.unwrap();
        Self {
            stream,
            fleet: Value::Null,
            safety: BTreeMap::new(),
            events: Vec::new(),
            frame: Vec::new(),
        }
    }

    /// Watches until it is as wanted.
    async fn until(&mut self, what: &str, wanted: impl Fn(&Self) -> bool) {
        let watching = async {
            while !wanted(self) {
                match self.stream.next().await.expect("the stream stays open").unwrap() {
                    Message::Binary(frame) => self.frame = frame.to_vec(),
                    Message::Text(text) => self.heard(serde_json::from_str(&text).unwrap()),
                    _ => {}
                }
            }
        };
        let in_time = tokio::time::timeout(patience() + FLIGHT, watching).await.is_ok();
        assert!(
            in_time,
            "waited in vain for {what}; fleet: {:#}; last events: {:#?}",
            self.fleet,
            self.events.last()
        );
    }

    fn heard(&mut self, message: Value) {
        match message["type"].as_str().unwrap() {
            "fleet" => self.fleet = message,
            "safety" => {
                for vehicle in message["vehicles"].as_array().unwrap() {
                    let before = self.safety.insert(vehicle["id"].as_u64().unwrap(), vehicle.clone());
                    assert_ne!(before.as_ref(), Some(vehicle), "only what has changed is told");
                }
            }
            "event" => self.events.push(message),
            "hello" => assert_eq!(message["protocol"], 1),
            other => panic!("unexpected {other}: {message}"),
        }
    }

    fn vehicles(&self) -> usize {
        if self.frame.is_empty() {
            0
        } else {
            read(&self.frame[..HEADER_BYTES], Header::FIELDS, "count") as usize
        }
    }

    fn value(&self, vehicle: usize, name: &str) -> i64 {
        read(
            &self.frame[HEADER_BYTES + vehicle * RECORD_BYTES..][..RECORD_BYTES],
            Record::FIELDS,
            name,
        )
    }

    fn all(&self, count: usize, fits: impl Fn(usize) -> bool) -> bool {
        self.vehicles() == count && (0..count).all(fits)
    }

    fn has(&self, vehicle: usize, bit: u8) -> bool {
        self.value(vehicle, "flags") & i64::from(bit) != 0
    }

    fn is(&self, vehicle: usize, state: FlightState) -> bool {
        self.value(vehicle, "flight_state") == i64::from(state.code())
    }

    /// How far a command has gone, by its events.
    fn progress(&self, id: &Value) -> Vec<&str> {
        let of_it = self
            .events
            .iter()
            .map(|event| &event["kind"])
            .filter(|kind| kind["kind"] == "command" && kind["id"] == *id);
        of_it
            .map(|kind| kind["progress"]["progress"].as_str().unwrap())
            .collect()
    }
}

/// Reads a number of a frame by the published table.
fn read(bytes: &[u8], fields: &[Field], name: &str) -> i64 {
    let field = fields.iter().find(|field| field.name == name).unwrap();
    let at = &bytes[field.offset..];
    match field.kind {
        "u8" => i64::from(at[0]),
        "u16" => i64::from(u16::from_le_bytes([at[0], at[1]])),
        "i16" => i64::from(i16::from_le_bytes([at[0], at[1]])),
        "u32" => i64::from(u32::from_le_bytes([at[0], at[1], at[2], at[3]])),
        "i32" => i64::from(i32::from_le_bytes([at[0], at[1], at[2], at[3]])),
        other => panic!("unknown kind {other}"),
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_swarm_is_flown_by_rest_and_watched_by_websocket() {
    let swarm = Swarm::start(3).await;
    let (rest, mut watch) = (Rest::of(&swarm), Watch::open(&swarm).await);
    watch
        .until("three vehicles that are ready", |w| w.all(3, |v| w.has(v, flag::READY)))
        .await;
    assert_eq!(read(&watch.frame, Header::FIELDS, "magic"), i64::from(FRAME_MAGIC));
    on_the_ground(&rest).await;
    // A machine that stood still has raised alarms, which pass.
    swarm.ready().await;
    take_off(&rest, &mut watch).await;
    assert_eq!(
        watch.safety.keys().copied().collect::<Vec<_>>(),
        [1, 2, 3],
        "told of all of them"
    );
    for safety in watch.safety.values() {
        assert!(
            safety["energy"]["remaining"].as_f64().is_some_and(|share| share > 0.5),
            "{safety}"
        );
        assert_eq!((&safety["stopped"], &safety["failsafe"]), (&json!(false), &Value::Null));
    }
    fly_in_formation(&rest, &mut watch).await;
    land(&rest, &mut watch).await;
    swarm.stop().await;
}

/// What is there, and what is refused while all stand on the ground.
async fn on_the_ground(rest: &Rest) {
    let (_, list) = rest.ask("GET", "/api/v1/vehicles", None).await;
    let ids: Vec<_> = list["vehicles"]
        .as_array()
        .unwrap()
        .iter()
        .map(|vehicle| vehicle["id"].clone())
        .collect();
    assert_eq!(ids, [json!(1), json!(2), json!(3)]);
    let (status, vehicle) = rest.ask("GET", "/api/v1/vehicles/2", None).await;
    assert_eq!(
        (status, &vehicle["plugin"], &vehicle["flight_state"]),
        (200, &json!("generic-uav"), &json!("idle"))
    );
    its_links(rest).await;
    let (_, plugins) = rest.ask("GET", "/api/v1/plugins", None).await;
    assert!(
        plugins["plugins"]
            .as_array()
            .unwrap()
            .iter()
            .any(|plugin| plugin["name"] == "generic-uav"),
        "{plugins}"
    );

    let (status, refused) = rest
        .ask(
            "PUT",
            "/api/v1/formation",
            Some(json!({ "shape": "line", "spacing_m": 5 })),
        )
        .await;
    assert_eq!(
        (status, &refused["error"]["code"]),
        (409, &json!("not_enough_vehicles"))
    );
    let go = json!({ "command": "go_to", "position": { "north_m": 5, "east_m": 0, "down_m": -5 } });
    let (status, answer) = rest.command(json!({ "vehicles": [1, 99] }), go).await;
    assert_eq!(status, 200, "one of them is known: each answers for itself");
    assert_eq!(answer["receipts"][0]["refusal"]["reason"], "wrong_state");
    assert_eq!(
        answer["receipts"][1]["refusal"],
        json!({ "reason": "unknown_vehicle", "vehicle": 99 })
    );
    let (status, _) = rest
        .command(json!({ "vehicles": [99] }), json!({ "command": "hold" }))
        .await;
    assert_eq!(status, 404);
}

/// All three are heard, and something went both ways.
async fn its_links(rest: &Rest) {
    let (status, links) = rest.ask("GET", "/api/v1/links", None).await;
    assert_eq!(status, 200, "{links}");
    let heard = |vehicle: &Value| vehicle["link"]["connected"] == true && vehicle["ways"] == json!([]);
    assert!(
        links["vehicles"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|v| heard(v))
            .count()
            == 3,
        "{links}"
    );
    let carried = |endpoint: &Value| {
        ["bytes_in", "frames_in", "bytes_out", "frames_out"]
            .iter()
            .all(|key| endpoint[key].as_u64() > Some(0))
    };
    assert!(links["endpoints"].as_array().unwrap().iter().any(carried), "{links}");
}

async fn take_off(rest: &Rest, watch: &mut Watch) {
    let heights: Vec<i64> = (0..3).map(|vehicle| watch.value(vehicle, "altitude_amsl_mm")).collect();
    let (status, answer) = rest
        .command(json!("all"), json!({ "command": "take_off", "height_m": 8 }))
        .await;
    assert_eq!(status, 200);
    let receipts = answer["receipts"].as_array().unwrap().clone();
    assert_eq!(receipts.len(), 3);
    assert!(
        receipts.iter().all(|receipt| receipt["refusal"].is_null()),
        "{receipts:?}"
    );
    watch
        .until("all three up and holding", |w| {
            w.all(3, |v| w.is(v, FlightState::Holding))
        })
        .await;
    for (vehicle, ground) in heights.iter().enumerate() {
        let climbed_m = (watch.value(vehicle, "altitude_amsl_mm") - ground) as f64 * 1e-3;
        assert!(
            (5.0..11.0).contains(&climbed_m),
            "vehicle {vehicle} climbed {climbed_m} m"
        );
        assert!(watch.has(vehicle, flag::ARMED | flag::CONNECTED) && watch.has(vehicle, flag::POSITION));
    }
    let done = |w: &Watch| {
        receipts
            .iter()
            .all(|receipt| w.progress(&receipt["id"]).last() == Some(&"done"))
    };
    watch.until("the end of each command", done).await;
    for receipt in &receipts {
        assert_eq!(
            watch.progress(&receipt["id"]),
            ["executing", "done"],
            "no step twice, none left out"
        );
    }
}

async fn fly_in_formation(rest: &Rest, watch: &mut Watch) {
    let wedge = json!({ "shape": "wedge", "spacing_m": 6, "leader": 2 });
    let (status, receipt) = rest.ask("PUT", "/api/v1/formation", Some(wedge)).await;
    assert_eq!(
        (status, &receipt["leader"], &receipt["members"][0]),
        (200, &json!(2), &json!(2)),
        "{receipt}"
    );
    assert!(receipt["planned_min_distance_m"].as_f64().unwrap() > 2.0);
    watch
        .until("the formation among what is said of the fleet", |w| {
            w.fleet["formation"]["leader"] == 2
        })
        .await;
    let in_slots = |w: &Watch| {
        w.all(3, |v| {
            if w.value(v, "id") == 2 {
                w.has(v, flag::LEADER)
            } else {
                w.has(v, flag::SLOT) && w.value(v, "tracking_error_cm") < 60
            }
        })
    };
    watch.until("the followers in their slots", in_slots).await;
    let (_, formation) = rest.ask("GET", "/api/v1/formation", None).await;
    assert_eq!(formation["formation"]["request"]["shape"], "wedge");

    let route = |speed: f64| json!({ "route": { "waypoints": [{ "north_m": 30, "east_m": 0, "down_m": -8 }], "speed_m_s": speed, "corner_radius_m": 5 } });
    let (status, refused) = rest.ask("PUT", "/api/v1/formation/route", Some(route(100.0))).await;
    assert_eq!(
        (status, &refused["error"]["code"]),
        (409, &json!("too_fast")),
        "{refused}"
    );
    let (status, _) = rest.ask("PUT", "/api/v1/formation/route", Some(route(4.0))).await;
    assert_eq!(status, 202);
    watch
        .until("the leader under way", |w| {
            w.all(3, |v| w.value(v, "velocity_north_cm_s") > 200)
        })
        .await;

    assert_eq!(rest.ask("DELETE", "/api/v1/formation", None).await.0, 204);
    watch
        .until("the end of the formation", |w| {
            w.fleet["formation"].is_null() && w.all(3, |v| w.is(v, FlightState::Holding))
        })
        .await;
}

async fn land(rest: &Rest, watch: &mut Watch) {
    let (status, _) = rest.command(json!("all"), json!({ "command": "land" })).await;
    assert_eq!(status, 200);
    let landed = |w: &Watch| w.all(3, |v| w.is(v, FlightState::Idle) && !w.has(v, flag::ARMED));
    watch.until("all three landed and disarmed", landed).await;
    let (status, health) = rest.ask("GET", "/api/v1/health", None).await;
    assert_eq!(
        (status, &health["status"], &health["vehicles_connected"]),
        (200, &json!("ok"), &json!(3)),
        "{health}"
    );
    let (_, metrics) = rest.ask("GET", "/metrics", None).await;
    let metrics = metrics.as_str().unwrap();
    for line in [
        "skein_vehicles{state=\"idle\"} 3",
        "skein_vehicle_armed{vehicle=\"1\",name=\"uav-1\"} 0",
    ] {
        assert!(metrics.lines().any(|is| is == line), "{line:?} is not in\n{metrics}");
    }
    assert!(
        metrics.contains("skein_endpoint_frames_in_total{endpoint="),
        "{metrics}"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn a_fault_is_seen_on_the_stream_and_in_the_health() {
    let swarm = Swarm::start(1).await;
    swarm.ready().await;
    let (rest, mut watch) = (Rest::of(&swarm), Watch::open(&swarm).await);
    let before = |w: &Watch| w.fleet["vehicles"][0]["model"]["incarnation"] == 1;
    watch.until("the model's first incarnation", before).await;
    let (status, _) = rest
        .ask(
            "POST",
            "/api/v1/faults",
            Some(json!({ "fault": "plugin_panic", "vehicle": 1 })),
        )
        .await;
    assert_eq!(status, 202);
    let again = |w: &Watch| {
        let model = &w.fleet["vehicles"][0]["model"];
        model["incarnation"] == 2 && model["status"] == "running" && w.all(1, |v| w.value(v, "model_incarnation") == 2)
    };
    watch.until("the model's second incarnation", again).await;
    assert!(
        watch.events.iter().any(|event| event["kind"]["kind"] == "supervision"),
        "{:#?}",
        watch.events
    );
    seen_by_one_is_seen_by_all(&swarm, &rest, &mut watch).await;
    swarm.stop().await;
}

/// An alert that one page acknowledges is acknowledged on the others, on those too that are opened later.
async fn seen_by_one_is_seen_by_all(swarm: &Swarm, rest: &Rest, watch: &mut Watch) {
    let alert = |event: &&Value| event["severity"] == "warning" || event["severity"] == "critical";
    let seq = watch.events.iter().find(alert).expect("the fault is an alert")["seq"].clone();
    let acknowledge = || rest.ask("POST", "/api/v1/events/acknowledge", Some(json!({ "events": [seq] })));
    assert_eq!(acknowledge().await, (200, json!({ "alerts": 1 })));
    assert_eq!(acknowledge().await, (200, json!({ "alerts": 0 })), "once is enough");
    let told = |w: &Watch| {
        let of_it = |event: &&Value| event["kind"]["kind"] == "acknowledged" && event["kind"]["events"] == json!([seq]);
        w.events.iter().filter(of_it).count() == 1
    };
    watch.until("the acknowledgement", told).await;
    Watch::open(swarm)
        .await
        .until("the acknowledgement in what has been", told)
        .await;
}

/// Every socket of this process, with all its nodes and vehicles, is bound to loopback.
#[cfg(target_os = "linux")]
#[tokio::test(flavor = "multi_thread")]
async fn nothing_listens_beyond_loopback() {
    assert!(NodeConfig::default().web.listen.ip().is_loopback());
    let swarm = Swarm::start(2).await;
    swarm.ready().await;
    assert!(swarm.web_address().ip().is_loopback());
    let own: Vec<String> = std::fs::read_dir("/proc/self/fd")
        .unwrap()
        .filter_map(|entry| std::fs::read_link(entry.ok()?.path()).ok())
        .filter_map(|target| Some(target.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?.to_owned()))
        .collect();
    let mut seen = 0;
    for table in ["tcp", "tcp6", "udp", "udp6"] {
        let Ok(text) = std::fs::read_to_string(format!("/proc/self/net/{table}")) else {
            continue;
        };
        for line in text.lines().skip(1) {
            let columns: Vec<&str> = line.split_whitespace().collect();
            if own.iter().any(|inode| inode == columns[9]) {
                // Addresses are written as hexadecimal words in the machine's order: 127.x.y.z ends in 7F.
                let address = columns[1].split(':').next().unwrap();
                let is_loopback =
                    (address.len() == 8 && address.ends_with("7F")) || address == "00000000000000000000000001000000";
                assert!(is_loopback, "{table}: {line}");
                seen += 1;
            }
        }
    }
    assert!(
        seen >= 2,
        "at least the endpoint and the web server are sockets of this process"
    );
    swarm.stop().await;
}

/// Whoever opens connections and asks nothing, or half of something, keeps nobody from the emergency stop.
#[tokio::test(flavor = "multi_thread")]
async fn a_flood_of_connections_does_not_lock_the_operator_out() {
    use tokio::io::AsyncWriteExt;
    let swarm = Swarm::start(1).await;
    swarm.ready().await;
    let address = swarm.web_address();
    let flood = tokio::spawn(async move {
        let mut held = std::collections::VecDeque::new();
        loop {
            if let Ok(mut stream) = TcpStream::connect(address).await {
                // Refused halfway is as good.
                let _ = stream.write_all(b"GET /api/v1/fleet HTTP/1.1\r\nHost: ").await;
                held.push_back(stream);
            }
            if held.len() > 400 {
                held.pop_front();
            }
        }
    });
    let rest = Rest::of(&swarm);
    tokio::time::timeout(patience(), async {
        for _ in 0..20 {
            let (status, key) = rest.ask("POST", "/api/v1/emergency-stop/unlock", None).await;
            assert_eq!(status, 200, "{key}");
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
        let (_, key) = rest.ask("POST", "/api/v1/emergency-stop/unlock", None).await;
        let stop = json!({ "key": key["key"], "targets": "all" });
        let (status, receipts) = rest.ask("POST", "/api/v1/emergency-stop", Some(stop)).await;
        assert_eq!(status, 200, "{receipts}");
    })
    .await
    .expect("the operator is answered");
    flood.abort();
    swarm.stop().await;
}
