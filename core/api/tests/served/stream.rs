//! The telemetry stream, with a client that behaves and with one that does not.

use crate::node::Served;
use crate::raw::{BINARY, CLOSE, PING, PONG, RawStream, TEXT};
use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use skein_domain::VehicleId;
use skein_runtime::Fault;
use std::time::Duration;
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::{Error, Message};
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream};

type Client = WebSocketStream<MaybeTlsStream<TcpStream>>;

/// Longest wait for something that comes by itself.
const PATIENCE: Duration = Duration::from_secs(30);

async fn open(served: &Served, query: &str) -> Client {
    let url = format!("ws://{}/api/v1/stream{query}", served.address());
    tokio_tungstenite::connect_async(url).await.unwrap().0
}

/// The next message that is wanted.
async fn next<T>(client: &mut Client, wanted: impl Fn(&Message) -> Option<T>) -> T {
    let found = async {
        loop {
            let message = client.next().await.expect("the stream is open").unwrap();
            if let Some(found) = wanted(&message) {
                return found;
            }
        }
    };
    timeout(PATIENCE, found).await.expect("it comes")
}

fn said(message: &Message) -> Option<Value> {
    message
        .to_text()
        .ok()
        .filter(|_| message.is_text())
        .map(|text| serde_json::from_str(text).unwrap())
}

async fn next_of(client: &mut Client, kind: &str) -> Value {
    next(client, |message| said(message).filter(|value| value["type"] == kind)).await
}

async fn next_frame(client: &mut Client) -> Vec<u8> {
    next(client, |message| match message {
        Message::Binary(frame) => Some(frame.to_vec()),
        _ => None,
    })
    .await
}

fn u32_at(frame: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(frame[at..at + 4].try_into().unwrap())
}

/// Makes so many events happen.
async fn events(served: &Served, count: usize) {
    for _ in 0..count {
        served
            .handle()
            .inject_fault(Fault::PluginPanic {
                vehicle: VehicleId(9),
                payload: None,
            })
            .await
            .unwrap_err();
    }
}

/// The fleet as it is told next, with its dead-man's switch in this state.
async fn dead_man(client: &mut Client, state: &str) -> Value {
    next(client, |message| {
        said(message).filter(|value| value["type"] == "fleet" && value["dead_man"]["state"] == state)
    })
    .await
}

#[tokio::test(flavor = "multi_thread")]
async fn it_tells_whether_an_operator_is_heard() {
    let served = Served::start_with(|config| {
        let rule = &mut config.safety.failsafe.operator_dead_man;
        rule.mode = skein_domain::failsafe::TriggerMode::React;
        rule.steps = vec![skein_domain::failsafe::FailsafeStep {
            after_s: 1.5,
            reaction: skein_domain::Reaction::Warn,
        }];
    })
    .await;
    let mut client = open(&served, "").await;
    let unheard = dead_man(&mut client, "unheard").await;
    assert_eq!(unheard["dead_man"]["warns_after_s"], 1.5);
    let (status, _) = served.ask("POST", "/api/v1/operator/alive", None).await;
    assert_eq!(status, 204);
    dead_man(&mut client, "heard").await;
    dead_man(&mut client, "silent").await;
    served.ask("POST", "/api/v1/operator/alive", None).await;
    dead_man(&mut client, "heard").await;
    served.stop().await;
}

fn with_faults(config: &mut skein_config::NodeConfig) {
    config.faults.enabled = true;
}

#[tokio::test(flavor = "multi_thread")]
async fn it_says_hello_then_the_fleet_then_sends_frames() {
    let served = Served::start().await;
    let mut client = open(&served, "").await;
    let first = timeout(PATIENCE, client.next()).await.unwrap().unwrap().unwrap();
    let hello = said(&first).unwrap();
    assert_eq!(
        hello,
        json!({ "type": "hello", "protocol": 1, "version": env!("CARGO_PKG_VERSION"), "node": "skein" })
    );
    let second = timeout(PATIENCE, client.next()).await.unwrap().unwrap().unwrap();
    let fleet = said(&second).unwrap();
    assert_eq!(
        (&fleet["type"], &fleet["vehicles"], &fleet["formation"]),
        (&json!("fleet"), &json!([]), &Value::Null)
    );
    assert!(
        fleet["actors"]
            .as_array()
            .unwrap()
            .iter()
            .any(|actor| actor["name"] == "coordinator"),
        "{fleet}"
    );
    let (earlier, later) = (next_frame(&mut client).await, next_frame(&mut client).await);
    for frame in [&earlier, &later] {
        assert_eq!(&frame[..4], b"SKN1");
        assert_eq!((frame.len(), u32_at(frame, 8)), (16, 0));
    }
    assert!(
        u32_at(&later, 4) > u32_at(&earlier, 4),
        "each frame is of a newer snapshot"
    );
    assert!(u32_at(&later, 12) > u32_at(&earlier, 12));
    served.stop().await;
}

/// What is told by `PUT /api/v1/tracks`: one track at this place, or none.
async fn tell_track(served: &Served, north_m: Option<f64>) {
    let (_, list) = served.ask("GET", "/api/v1/tracks", None).await;
    let velocity = json!({ "north_m_s": 0.0, "east_m_s": 0.0, "down_m_s": 0.0 });
    let track = |north_m: f64| {
        let position = json!({ "north_m": north_m, "east_m": 0.0, "down_m": -9.0 });
        json!({ "track": 7, "position": position, "velocity": velocity, "time": list["time"] })
    };
    let tracks: Vec<Value> = north_m.into_iter().map(track).collect();
    let (status, answer) = served
        .ask("PUT", "/api/v1/tracks", Some(json!({ "tracks": tracks })))
        .await;
    assert!(status < 300, "{status} {answer}");
}

#[tokio::test(flavor = "multi_thread")]
async fn tracks_are_told_when_they_change_and_that_there_are_none_only_after_some() {
    let served = Served::start().await;
    let mut client = open(&served, "").await;
    // Ten frames are a second, in which the slow state was looked at several times: nothing is said of tracks.
    for _ in 0..10 {
        let next = next(&mut client, |message| {
            let tracks = said(message).is_some_and(|value| value["type"] == "tracks");
            (tracks || message.is_binary()).then_some(tracks)
        });
        assert!(!next.await, "there are none, and none were told");
    }
    tell_track(&served, Some(4.0)).await;
    let first = next_of(&mut client, "tracks").await;
    assert_eq!(first["tracks"][0]["position"]["north_m"], 4.0);
    assert_eq!(first["tracks"][0]["source"], "told");
    // Said again only because it has changed.
    tell_track(&served, Some(5.0)).await;
    let second = next_of(&mut client, "tracks").await;
    assert_eq!(second["tracks"][0]["position"]["north_m"], 5.0);
    tell_track(&served, None).await;
    let last = next_of(&mut client, "tracks").await;
    assert_eq!(last["tracks"], json!([]));
    assert!(last["time"].as_u64() > first["time"].as_u64());
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn events_come_in_order_and_from_where_one_left_off() {
    let served = Served::start_with(with_faults).await;
    events(&served, 1).await;
    let mut live = open(&served, "").await;
    next_of(&mut live, "fleet").await;
    events(&served, 50).await;
    let mut last = next_of(&mut live, "event").await["seq"].as_u64().unwrap();
    let first = last;
    for _ in 1..50 {
        let event = next_of(&mut live, "event").await;
        assert_eq!(event["seq"], last + 1);
        assert_eq!(event["kind"], json!({ "kind": "notice" }));
        last += 1;
    }
    let mut resumed = open(&served, &format!("?after={first}")).await;
    assert_eq!(next_of(&mut resumed, "event").await["seq"], first + 1);
    let mut of_another_run = open(&served, "?after=123456789").await;
    assert_eq!(
        next_of(&mut of_another_run, "event").await["seq"],
        1,
        "numbers began anew: all of this run is news"
    );
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn who_was_away_too_long_is_told_how_much_was_missed() {
    let served = Served::start_with(with_faults).await;
    events(&served, 2_500).await;
    let oldest = served.handle().events_after(0).first().unwrap().seq;
    assert!(oldest > 100);
    let mut client = open(&served, "?after=100").await;
    let gap = next(&mut client, |message| {
        said(message).filter(|value| value["type"] == "gap" || value["type"] == "event")
    })
    .await;
    assert_eq!(gap, json!({ "type": "gap", "missed": oldest - 101 }));
    assert_eq!(next_of(&mut client, "event").await["seq"], oldest);
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_chooses_its_rate_and_is_told_when_it_is_not_understood() {
    let served = Served::start().await;
    let mut client = open(&served, "").await;
    client
        .send(Message::text(r#"{"type":"rate","rate_hz":50}"#))
        .await
        .unwrap();
    assert_eq!(next_of(&mut client, "rate").await["rate_hz"], 50.0);
    for (text, expected) in [
        (r#"{"type":"rate","rate_hz":0.5}"#, "invalid_value"),
        (r#"{"type":"rate","rate_hz":51}"#, "invalid_value"),
        (r#"{"type":"rate","rate_hz":1e999}"#, "invalid_message"),
        (r#"{"type":"rate"}"#, "invalid_message"),
        (r#"{"type":"rate","rate_hz":5,"more":1}"#, "invalid_message"),
        (r#"{"type":"take_off"}"#, "invalid_message"),
        ("", "invalid_message"),
    ] {
        client.send(Message::text(text)).await.unwrap();
        assert_eq!(next_of(&mut client, "error").await["error"]["code"], expected, "{text}");
    }
    next_frame(&mut client).await;
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stick_that_is_refused_is_answered() {
    let served = Served::start().await;
    let mut client = open(&served, "?console=c1").await;
    let stick = |vehicle: u16, forward_m_s: &str| {
        Message::text(format!(
            r#"{{"type":"stick","vehicle":{vehicle},"forward_m_s":{forward_m_s},"right_m_s":0,"up_m_s":0,"yaw_rate_rad_s":0}}"#
        ))
    };
    client.send(stick(9, "1")).await.unwrap();
    let error = next_of(&mut client, "error").await["error"].clone();
    assert_eq!(error["code"], "unknown_vehicle");
    assert_eq!(error["detail"]["stick"], 9);
    assert_eq!(error["detail"]["refusal"]["reason"], "unknown_vehicle");
    client.send(stick(9, "51")).await.unwrap();
    let error = next_of(&mut client, "error").await["error"].clone();
    assert_eq!(
        (&error["code"], &error["detail"]["stick"]),
        (&json!("invalid_value"), &json!(9))
    );
    // What is no stick at all is answered as any message.
    for text in [
        r#"{"type":"stick","vehicle":9}"#.to_owned(),
        stick(9, "1e999").to_string(),
        stick(9, "null").to_string(),
    ] {
        client.send(Message::text(text.as_str())).await.unwrap();
        assert_eq!(
            next_of(&mut client, "error").await["error"]["code"],
            "invalid_message",
            "{text}"
        );
    }
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_that_breaks_the_protocol_is_closed() {
    let served = Served::start().await;
    let mut binary = open(&served, "").await;
    binary.send(Message::binary(vec![1, 2, 3])).await.unwrap();
    let why = next(&mut binary, |message| match message {
        Message::Close(why) => Some(why.clone()),
        _ => None,
    });
    assert_eq!(u16::from(why.await.unwrap().code), 1008);
    let mut large = open(&served, "").await;
    large.send(Message::text("x".repeat(1_000_000))).await.ok();
    let ended = async {
        while let Some(Ok(message)) = large.next().await {
            if message.is_close() {
                return;
            }
        }
    };
    timeout(PATIENCE, ended).await.expect("it is closed");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn frames_are_never_queued_for_a_client_that_does_not_answer() {
    let served = Served::start().await;
    let mut silent = RawStream::open(served.address()).await;
    let mut lively = open(&served, "").await;
    // At ten frames a second no more than five go unanswered.
    let (mut frames, mut ping) = (Vec::new(), Vec::new());
    while frames.len() < 5 || ping != 5u32.to_be_bytes() {
        let (kind, payload) = timeout(PATIENCE, silent.next()).await.unwrap().unwrap();
        match kind {
            BINARY => frames.push(payload),
            PING => ping = payload,
            kind => assert_eq!(kind, TEXT),
        }
    }
    // Meanwhile another client gets its frames; by then ten more would have come.
    let mut newest = next_frame(&mut lively).await;
    for _ in 0..10 {
        newest = next_frame(&mut lively).await;
    }
    // Nothing was kept for the silent one: the first frame after its answer is a new one.
    silent.send(PONG, &ping).await;
    let next = loop {
        let (kind, payload) = timeout(PATIENCE, silent.next()).await.unwrap().unwrap();
        if kind == BINARY {
            break payload;
        }
    };
    assert!(
        u32_at(&next, 4) >= u32_at(&newest, 4),
        "a frame was kept for a client that had not answered"
    );
    assert!(u32_at(&next, 4) > u32_at(frames.last().unwrap(), 4) + 5);
    // An answer to something that was never sent opens nothing: the stream ends, since the client owes the right one.
    silent.send(PONG, &1_000_000u32.to_be_bytes()).await;
    let mut more = 0;
    let ended = async {
        while let Some((kind, _)) = silent.next().await {
            assert_ne!(
                kind, CLOSE,
                "it is not heard of any more, so that there is nobody to say farewell to"
            );
            more += usize::from(kind == BINARY);
        }
    };
    timeout(PATIENCE, ended)
        .await
        .expect("who does not answer is closed after a time");
    assert!(more <= 5, "{more} frames for a client that did not answer");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn only_so_many_streams_are_served_at_once() {
    let served = Served::start().await;
    let mut open_streams = Vec::new();
    for _ in 0..64 {
        open_streams.push(open(&served, "").await);
    }
    let url = format!("ws://{}/api/v1/stream", served.address());
    let Err(Error::Http(answer)) = tokio_tungstenite::connect_async(url).await else {
        panic!("one too many was let in")
    };
    assert_eq!(answer.status(), 503);
    open_streams.pop().unwrap().close(None).await.unwrap();
    let again = async {
        while tokio_tungstenite::connect_async(format!("ws://{}/api/v1/stream", served.address()))
            .await
            .is_err()
        {
            tokio::task::yield_now().await;
        }
    };
    timeout(PATIENCE, again)
        .await
        .expect("the place of one that left is free again");
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn foreign_pages_can_open_no_stream_and_the_own_one_can() {
    let served = Served::start().await;
    let url = format!("ws://{}/api/v1/stream", served.address());
    let from = |origin: &str| {
        let mut request = url.as_str().into_client_request().unwrap();
        request.headers_mut().insert("origin", origin.parse().unwrap());
        tokio_tungstenite::connect_async(request)
    };
    let Err(Error::Http(answer)) = from("http://evil.example").await else {
        panic!("a foreign page was let in")
    };
    assert_eq!(answer.status(), 403);
    from(&format!("http://{}", served.address())).await.unwrap();
    let (status, body) = served.ask("GET", "/api/v1/stream", None).await;
    assert_eq!((status, body["error"]["code"].as_str()), (426, Some("not_a_websocket")));
    let (status, body) = served.ask("GET", "/api/v1/stream?since=3", None).await;
    assert_eq!((status, body["error"]["code"].as_str()), (400, Some("invalid_query")));
    served.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn streams_are_told_when_the_server_ends() {
    let served = Served::start().await;
    let mut client = open(&served, "").await;
    next_frame(&mut client).await;
    let farewell = async {
        next(&mut client, |message| match message {
            Message::Close(why) => Some(why.clone()),
            _ => None,
        })
        .await
    };
    let (why, ()) = tokio::join!(farewell, served.stop());
    assert_eq!(u16::from(why.unwrap().code), 1001);
}
