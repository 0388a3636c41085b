//! The real Prometheus reads a swarm by the configuration that ships: it takes every expression of dashboard and rules and finds data for it, and no
//! alert speaks of a healthy swarm. Its promtool checks the files and runs the tests of the rules.

use serde_json::Value;
use skein_testkit::{Process, Swarm, eventually, free_tcp_port, patience, repository};
use skein_tests_interop::program_of;
use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::Command;

/// What begins so is not there: the swarm has no camera and no detector, and nobody listens to its events.
const NOT_THERE: [&str; 4] = [
    "skein_video_",
    "skein_detector_",
    "skein_camera_to_track_",
    "skein_stream",
];

fn deployed(path: &str) -> PathBuf {
    repository().join("deploy").join(path)
}

fn read(path: &str) -> String {
    std::fs::read_to_string(deployed(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The names of metrics in an expression.
fn metrics(expression: &str) -> BTreeSet<&str> {
    expression
        .split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
        .filter(|word| word.starts_with("skein_"))
        .collect()
}

fn is_there(metric: &str) -> bool {
    !NOT_THERE.iter().any(|begin| metric.starts_with(begin))
}

/// Every expression of the dashboard, for all swarms, nodes and vehicles.
fn of_dashboard() -> Vec<String> {
    let dashboard: Value = serde_json::from_str(&read("grafana/skein.json")).expect("JSON");
    let panels = dashboard["panels"].as_array().expect("panels");
    let targets = panels.iter().filter_map(|panel| panel["targets"].as_array()).flatten();
    let mut expressions = Vec::new();
    for target in targets {
        let mut expression = target["expr"].as_str().expect("an expression").to_owned();
        for (variable, value) in [
            ("$job", ".*"),
            ("$node", ".*"),
            ("$vehicle", ".*"),
            ("$__rate_interval", "20s"),
        ] {
            expression = expression.replace(variable, value);
        }
        assert!(!expression.contains('$'), "an unknown variable: {expression}");
        expressions.push(expression);
    }
    assert!(expressions.len() > 40, "{} expressions", expressions.len());
    expressions
}

/// A running Prometheus.
struct Prometheus {
    process: Process,
    url: String,
    _folder: tempfile::TempDir,
}

impl Prometheus {
    /// By the configuration that ships, of this node alone, and more often.
    async fn start(node: SocketAddr) -> Self {
        let program = program_of("prometheus", "prometheus").expect("Prometheus");
        let folder = tempfile::tempdir().expect("a folder");
        let mut config = read("prometheus/prometheus.yml");
        for (shipped, here) in [
            ("- 127.0.0.1:8080", format!("- {node}")),
            ("scrape_interval: 5s", "scrape_interval: 2s".to_owned()),
            ("evaluation_interval: 5s", "evaluation_interval: 1s".to_owned()),
        ] {
            assert!(config.contains(shipped), "{shipped} is not in\n{config}");
            config = config.replace(shipped, &here);
        }
        let file = folder.path().join("prometheus.yml");
        std::fs::write(&file, config).expect("can be written");
        let rules = "skein.rules.yml";
        std::fs::write(folder.path().join(rules), read(&format!("prometheus/{rules}"))).expect("can be written");
        let listen = format!("127.0.0.1:{}", free_tcp_port());
        let mut command = tokio::process::Command::new(program);
        command
            .arg(format!("--config.file={}", file.display()))
            .arg(format!("--storage.tsdb.path={}", folder.path().join("data").display()))
            .arg(format!("--web.listen-address={listen}"))
            .current_dir(folder.path());
        let mut process = Process::start("prometheus", command);
        process.line("Server is ready to receive web requests").await;
        Self {
            process,
            url: format!("http://{listen}/api/v1"),
            _folder: folder,
        }
    }

    /// An answer's data; what is wrong with the question, if it is refused.
    async fn ask(&self, path: &str, query: &[(&str, &str)]) -> Value {
        let url = reqwest::Url::parse_with_params(&format!("{}/{path}", self.url), query).expect("an address");
        let answer = reqwest::get(url).await.expect("Prometheus answers");
        let mut answer: Value = answer.json().await.expect("JSON");
        assert_eq!(answer["status"], "success", "{path} {query:?}: {answer}");
        answer["data"].take()
    }

    /// How many series an expression gives now.
    async fn series(&self, expression: &str) -> usize {
        let data = self.ask("query", &[("query", expression)]).await;
        data["result"].as_array().map_or(0, Vec::len)
    }

    async fn until_there(&self, expression: &str) {
        let what = format!("data for {expression}");
        eventually(patience(), &what, async || {
            (self.series(expression).await > 0).then_some(())
        })
        .await;
    }

    async fn rules(&self) -> Vec<Value> {
        let data = self.ask("rules", &[]).await;
        let groups = data["groups"].as_array().expect("groups").iter();
        groups
            .flat_map(|group| group["rules"].as_array().expect("rules").clone())
            .collect()
    }

    /// Waits until each rule has been evaluated anew, with what is known by now.
    async fn judged(&self) {
        let moments = async || -> Vec<Value> {
            let rules = self.rules().await;
            rules.iter().map(|rule| rule["lastEvaluation"].clone()).collect()
        };
        let before = moments().await;
        eventually(patience(), "all rules to be evaluated", async || {
            let now = moments().await;
            now.iter().zip(&before).all(|(now, before)| now != before).then_some(())
        })
        .await;
        for rule in self.rules().await {
            assert_eq!(rule["health"], "ok", "{rule}");
        }
    }

    /// Alerts that fire, or would if they went on.
    async fn alerts(&self) -> Vec<Value> {
        let data = self.ask("alerts", &[]).await;
        data["alerts"].as_array().expect("alerts").clone()
    }

    /// Waits until there is none: a machine under load may make one pending for a moment.
    async fn until_no_alert(&self) {
        let deadline = tokio::time::Instant::now() + patience();
        eventually(patience() * 2, "no alert", async || {
            let alerts = self.alerts().await;
            let late = tokio::time::Instant::now() > deadline;
            assert!(!late || alerts.is_empty(), "alerts of a healthy swarm: {alerts:?}");
            alerts.is_empty().then_some(())
        })
        .await;
    }

    async fn none_fires(&self, when: &str) {
        let alerts = self.alerts().await;
        assert!(
            alerts.iter().all(|alert| alert["state"] != "firing"),
            "{when}: {alerts:?}"
        );
    }
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "long: part of `cargo xtask test interop`"]
async fn prometheus_finds_data_for_dashboard_and_rules_and_alerts_of_nothing() {
    let swarm = Swarm::start(2).await;
    swarm.ready().await;
    let mut prometheus = Prometheus::start(swarm.web_address()).await;
    prometheus.until_there(r#"up{job="skein"} == 1"#).await;
    prometheus.judged().await;
    prometheus.until_no_alert().await;
    swarm.take_off(5.0).await;
    for expression in of_dashboard() {
        if metrics(&expression).iter().all(|metric| is_there(metric)) {
            prometheus.until_there(&expression).await;
        } else {
            prometheus.series(&expression).await;
        }
    }
    for rule in prometheus.rules().await {
        let expression = rule["query"].as_str().expect("an expression").to_owned();
        prometheus.series(&expression).await;
        for metric in metrics(&expression).into_iter().filter(|metric| is_there(metric)) {
            prometheus.until_there(metric).await;
        }
    }
    prometheus.judged().await;
    prometheus.none_fires("in flight").await;
    swarm.stop().await;
    // The rules do judge what is scraped: this one speaks of a node that is gone.
    eventually(patience(), "the alert of a node that is gone", async || {
        let alerts = prometheus.alerts().await;
        alerts
            .iter()
            .any(|alert| alert["labels"]["alertname"] == "SkeinNodeDown")
            .then_some(())
    })
    .await;
    prometheus.process.kill().await;
}

#[test]
#[ignore = "long: part of `cargo xtask test interop`"]
fn promtool_takes_configuration_and_rules_and_their_tests_pass() {
    let promtool = program_of("prometheus", "promtool").expect("promtool");
    for (what, path) in [
        (["check", "config"], "prometheus/prometheus.yml"),
        (["check", "rules"], "prometheus/skein.rules.yml"),
        (["test", "rules"], "prometheus/skein.rules.test.yml"),
    ] {
        let output = Command::new(&promtool).args(what).arg(deployed(path)).output();
        let output = output.expect("promtool runs");
        let said = String::from_utf8_lossy(&output.stdout);
        let wrong = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{what:?} {path}:\n{said}\n{wrong}");
        assert!(said.contains("SUCCESS"), "{what:?} {path}:\n{said}");
    }
}
