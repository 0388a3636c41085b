//! A trace goes from whoever asks over one node to another one, and to a collector that knows OpenTelemetry's own messages.

use axum::Router;
use axum::body::Bytes;
use axum::http::StatusCode;
use axum::routing::post;
use opentelemetry_proto::tonic::collector::trace::v1::ExportTraceServiceRequest;
use opentelemetry_proto::tonic::common::v1::any_value::Value as Any;
use opentelemetry_proto::tonic::common::v1::{AnyValue, KeyValue};
use opentelemetry_proto::tonic::trace::v1::Span;
use parking_lot::Mutex;
use prost::Message;
use serde_json::{Value, json};
use skein_testkit::{Process, eventually, free_udp_port, patience, plugins_dir, skein_binary};
use std::net::{Ipv4Addr, SocketAddr};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::sync::Arc;
use tokio::net::TcpListener;
use tokio::process::Command;

/// Who asks has begun this trace, and asks in this span of it.
const TRACE: &str = "4bf92f3577b34da6a3ce929d0e0e4736";
const ASKER: &str = "00f067aa0ba902b7";

/// One span, and the name of the service that made it.
#[derive(Debug, Clone)]
struct Told {
    service: String,
    span: Span,
}

impl Told {
    fn has(&self, key: &str) -> Option<String> {
        text(&self.span.attributes, key)
    }
}

fn text(attributes: &[KeyValue], key: &str) -> Option<String> {
    let found = attributes.iter().find(|one| one.key == key)?;
    match found.value.as_ref()? {
        AnyValue {
            value: Some(Any::StringValue(text)),
        } => Some(text.clone()),
        AnyValue {
            value: Some(Any::IntValue(number)),
        } => Some(number.to_string()),
        _ => None,
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Takes what is exported, and keeps it.
#[derive(Clone, Default)]
struct Collector(Arc<Mutex<Vec<Told>>>);

impl Collector {
    async fn start(&self) -> SocketAddr {
        let kept = self.clone();
        let take = move |body: Bytes| {
            let kept = kept.clone();
            async move { kept.take(&body) }
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.expect("a port");
        let address = listener.local_addr().expect("it is bound");
        let routes = Router::new().route("/v1/traces", post(take));
        tokio::spawn(async move { axum::serve(listener, routes).await });
        address
    }

    fn take(&self, body: &[u8]) -> StatusCode {
        let request = ExportTraceServiceRequest::decode(body).expect("OpenTelemetry's message");
        let mut kept = self.0.lock();
        for of in request.resource_spans {
            let service = of
                .resource
                .and_then(|resource| text(&resource.attributes, "service.name"));
            let service = service.unwrap_or_default();
            let spans = of.scope_spans.into_iter().flat_map(|scope| scope.spans);
            kept.extend(spans.map(|span| Told {
                service: service.clone(),
                span,
            }));
        }
        StatusCode::OK
    }

    fn find(&self, is_it: impl Fn(&Span) -> bool) -> Option<Told> {
        let kept = self.0.lock();
        kept.iter()
            .find(|told| hex(&told.span.trace_id) == TRACE && is_it(&told.span))
            .cloned()
    }
}

fn node(folder: &Path, service: &str, config: &str, collector: SocketAddr) -> Process {
    let file = folder.join(format!("{service}.toml"));
    let whole = format!(
        "[node]\nname = \"{service}\"\n[web]\nlisten = \"127.0.0.1:0\"\n[plugins]\ndirectories = [{:?}]\n{config}",
        plugins_dir()
    );
    std::fs::write(&file, whole).expect("is written");
    let mut command = Command::new(skein_binary());
    command.args(["run", "--config"]).arg(file);
    command
        .env("OTEL_EXPORTER_OTLP_ENDPOINT", format!("http://{collector}"))
        .env("OTEL_SERVICE_NAME", service)
        .env("OTEL_BSP_SCHEDULE_DELAY", "100");
    Process::start(service, command)
}

async fn disarm(base: &str) -> Value {
    let asked = reqwest::Client::new()
        .post(format!("{base}/api/v1/commands"))
        .header("traceparent", format!("00-{TRACE}-{ASKER}-01"))
        .json(&json!({ "targets": "all", "command": { "command": "disarm" } }));
    asked.send().await.expect("answers").json().await.expect("JSON")
}

#[tokio::test]
async fn a_request_at_one_node_and_the_command_at_another_are_one_trace() {
    let folder = tempfile::tempdir().expect("a folder");
    let collector = Collector::default();
    let address = collector.start().await;
    let secret = folder.path().join("swarm.key");
    std::fs::write(&secret, "7".repeat(64)).expect("is written");
    std::fs::set_permissions(&secret, PermissionsExt::from_mode(0o600)).expect("its owner alone");

    let (link, meeting) = (free_udp_port(), free_udp_port());
    let swarm = |number: u8, zenoh: String| {
        format!(
            "[swarm]\nid = \"traced\"\nnode = {number}\nsecret_file = {secret:?}\ntransports = [\"zenoh\"]\n\
             coordinator_priority = {}\n[swarm.zenoh]\nmulticast = false\n{zenoh}\n",
            100 - number
        )
    };
    let ground = swarm(1, format!("listen = [\"udp/127.0.0.1:{meeting}\"]"));
    let vehicle = swarm(2, format!("connect = [\"udp/127.0.0.1:{meeting}\"]\nlisten = []"))
        + &format!(
            "[[endpoints]]\nname = \"vehicle\"\naddress = \"udp-listen://127.0.0.1:{link}\"\n\
             [[adopt]]\nname = \"uav\"\nmodel = \"generic-uav\"\n"
        );
    let mut ground = node(folder.path(), "ground", &ground, address);
    let mut vehicle = node(folder.path(), "vehicle", &vehicle, address);
    let to = format!("127.0.0.1:{link}");
    let simulation = Process::skein(&["sim", "--vehicles", "1", "--send-to", &to]);
    let line = ground.line("http://").await;
    let base = line.split_whitespace().find(|word| word.starts_with("http://"));
    let base = base.expect("an address").trim_end_matches(['/', '.', ',']).to_owned();

    eventually(
        patience(),
        "the command is taken up by the other node's vehicle",
        async || {
            let answer = disarm(&base).await;
            let receipt = answer.pointer("/receipts/0")?;
            (receipt["id"].is_u64() && receipt["refusal"].is_null()).then_some(())
        },
    )
    .await;
    let command = eventually(patience(), "the command's span", async || {
        collector.find(|span| span.name == "command disarm")
    })
    .await;
    let request = "the span in which it was asked for";
    let asked = eventually(patience(), request, async || {
        collector.find(|span| span.span_id == command.span.parent_span_id)
    })
    .await;
    assert_eq!(command.service, "vehicle");
    assert_eq!(command.has("vehicle").as_deref(), Some("1"));
    assert_eq!(command.has("outcome").as_deref(), Some("done"));
    assert_eq!(
        (asked.service.as_str(), asked.span.name.as_str()),
        ("ground", "POST /api/v1/commands")
    );
    assert_eq!(hex(&asked.span.parent_span_id), ASKER);
    assert_eq!(asked.has("http.response.status_code").as_deref(), Some("200"));

    for process in [&mut ground, &mut vehicle] {
        process.signal("TERM").await;
        assert_eq!(process.exit_code(patience()).await, 0, "{}", process.output());
    }
    drop(simulation);
}

/// A collector that is not there changes nothing, and a place that cannot be is said at once.
#[tokio::test]
async fn without_a_collector_the_node_ends_in_order_and_a_wrong_address_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let nobody: SocketAddr = ([127, 0, 0, 1], 9).into();
    let mut lonely = node(folder.path(), "lonely", "", nobody);
    lonely.line("http://").await;
    lonely.signal("TERM").await;
    assert_eq!(lonely.exit_code(patience()).await, 0, "{}", lonely.output());

    let mut command = Command::new(skein_binary());
    command.args(["run", "--config"]).arg(folder.path().join("lonely.toml"));
    command.env("OTEL_EXPORTER_OTLP_ENDPOINT", "no address");
    let mut wrong = Process::start("wrong", command);
    assert_eq!(wrong.exit_code(patience()).await, 2, "{}", wrong.output());
    assert!(
        wrong.output().contains("OTEL_EXPORTER_OTLP_ENDPOINT"),
        "{}",
        wrong.output()
    );
}
