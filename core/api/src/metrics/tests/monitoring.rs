//! The dashboard for Grafana and the rules for Prometheus name nothing that the program does not write.
//!
//! Must never do: ask a Prometheus; that is for `tests/interop`.

use super::*;
use metrics::{Counter, Gauge, Histogram, Key, KeyName, Metadata, Recorder, SharedString, Unit};
use parking_lot::Mutex;
use serde_json::{Value, json};
use skein_link_mavlink::EndpointCounters;
use skein_state::video::{VideoHealth, VideoState};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What Prometheus adds: its own labels, and those of its series `ALERTS`.
const OF_PROMETHEUS: [&str; 4] = ["job", "instance", "alertname", "alertstate"];
const DASHBOARD: &str = "grafana/skein.json";
const RULES: &str = "prometheus/skein.rules.yml";
const RULES_TESTED: &str = "prometheus/skein.rules.test.yml";

/// Every metric that was described or written, with its labels.
#[derive(Default)]
struct Written(Mutex<BTreeMap<String, BTreeSet<String>>>);

impl Written {
    fn describe(&self, name: &KeyName) {
        self.0.lock().entry(name.as_str().to_owned()).or_default();
    }

    fn register(&self, key: &Key) {
        let mut written = self.0.lock();
        let labels = written.entry(key.name().to_owned()).or_default();
        labels.extend(key.labels().map(|label| label.key().to_owned()));
    }
}

impl Recorder for Written {
    fn describe_counter(&self, name: KeyName, _: Option<Unit>, _: SharedString) {
        self.describe(&name);
    }

    fn describe_gauge(&self, name: KeyName, _: Option<Unit>, _: SharedString) {
        self.describe(&name);
    }

    fn describe_histogram(&self, name: KeyName, _: Option<Unit>, _: SharedString) {
        self.describe(&name);
    }

    fn register_counter(&self, key: &Key, _: &Metadata<'_>) -> Counter {
        self.register(key);
        Counter::noop()
    }

    fn register_gauge(&self, key: &Key, _: &Metadata<'_>) -> Gauge {
        self.register(key);
        Gauge::noop()
    }

    fn register_histogram(&self, key: &Key, _: &Metadata<'_>) -> Histogram {
        self.register(key);
        Histogram::noop()
    }
}

/// A vehicle of which everything is known, with a detector.
fn seeing_vehicle() -> VehicleSnapshot {
    let detector = PayloadSnapshot {
        name: "detector".into(),
        kind: PayloadKind::Detector,
        actor: ActorHealth::default(),
        plugin: PluginHealth::default(),
        state: Some(json!({ "dropped": 3 })),
        transport_fault: String::new(),
        frame: None,
    };
    VehicleSnapshot {
        payloads: vec![detector],
        ..flying_vehicle(1)
    }
}

fn watched_camera() -> CameraVideo {
    CameraVideo {
        vehicle: skein_domain::VehicleId(1),
        payload: "camera".into(),
        health: VideoHealth {
            state: VideoState::Live,
            format: None,
            size_px: (640, 480),
            measured: Default::default(),
            age_s: Some(0.1),
            viewers: 1,
            glass_to_glass_s: Some((0.1, 0.2)),
        },
        fault: String::new(),
    }
}

/// All metrics of the program with their labels.
fn written() -> BTreeMap<String, BTreeSet<String>> {
    let recorder = Written::default();
    metrics::with_local_recorder(&recorder, || {
        install();
        describe();
        describe_tracks();
        let snapshot = FleetSnapshot {
            vehicles: vec![seeing_vehicle()],
            actors: vec![ActorHealth::default()],
            ..FleetSnapshot::default()
        };
        let seen = SeenCounts {
            camera_to_track_us: Some((1, 2)),
            ..SeenCounts::default()
        };
        fleet(&snapshot);
        tracks(&snapshot, &seen);
        video(&watched_camera());
        let records = RecorderStatus {
            state: RecorderWord::Recording,
            ..RecorderStatus::default()
        };
        recording(&records, 3);
        endpoint("sitl", &EndpointCounters::default().named());
    });
    recorder.0.into_inner()
}

fn deployed(path: &str) -> String {
    let deploy = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../deploy");
    std::fs::read_to_string(deploy.join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The words of a text that are names of metrics.
fn metrics_in(text: &str) -> Vec<&str> {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
        .filter(|word| word.starts_with("skein_"))
        .collect()
}

/// The labels that a line of PromQL or of a test selects or groups by.
fn labels_in(line: &str) -> Vec<&str> {
    let within = |open: &'static str, close: char| {
        let parts = line.split(open).skip(1);
        parts.flat_map(move |part| part.split(close).next().unwrap_or_default().split(','))
    };
    let selected = within("{", '}').filter_map(|one| one.split_once(['=', '!']).map(|(label, _)| label));
    let grouped = within("by (", ')').chain(within("on (", ')'));
    selected
        .chain(grouped)
        .map(str::trim)
        .filter(|label| !label.is_empty())
        .collect()
}

#[test]
fn dashboard_and_rules_name_only_metrics_and_labels_that_are_written() {
    let written = written();
    for path in [DASHBOARD, RULES, RULES_TESTED] {
        let text = deployed(path);
        let lines = text.lines().filter(|line| line.contains("skein_"));
        let mut named = 0;
        for line in lines {
            let mut labels: BTreeSet<&str> = OF_PROMETHEUS.into();
            for metric in metrics_in(line) {
                let own = written
                    .get(metric)
                    .unwrap_or_else(|| panic!("{path}: nothing writes {metric}"));
                labels.extend(own.iter().map(String::as_str));
                named += 1;
            }
            for label in labels_in(line) {
                assert!(labels.contains(label), "{path}: no label {label:?} in: {line}");
            }
        }
        assert!(named > 20, "{path} names {named} metrics: has it another form now?");
    }
}

#[test]
fn every_alert_says_what_to_do_and_has_a_test_in_which_it_fires() {
    let (rules, tested) = (deployed(RULES), deployed(RULES_TESTED));
    let mut alerts = 0;
    for rule in rules.split("- alert: ").skip(1) {
        let name = rule.lines().next().unwrap_or_default();
        for part in ["expr: ", "severity: ", "summary: ", "description: "] {
            assert!(rule.contains(part), "{name} has no {part}");
        }
        let mut tests = tested
            .split("- alertname: ")
            .filter(|test| test.lines().next() == Some(name));
        assert!(
            tests.any(|test| test.contains("exp_alerts:")),
            "{name} fires in no test"
        );
        alerts += 1;
    }
    assert!(alerts > 20, "{alerts} alerts: has the file another form now?");
}

#[test]
fn every_panel_has_a_unit_and_asks_the_chosen_source() {
    let dashboard: Value = serde_json::from_str(&deployed(DASHBOARD)).expect("JSON");
    let panels = dashboard["panels"].as_array().expect("panels");
    let mut ids = BTreeSet::new();
    for panel in panels {
        assert!(ids.insert(panel["id"].as_u64()), "twice the same id: {panel}");
        if panel["type"] == "row" {
            continue;
        }
        let unit = panel["fieldConfig"]["defaults"]["unit"].as_str();
        assert!(unit.is_some_and(|unit| !unit.is_empty()), "no unit: {panel}");
        assert!(panel["description"].is_string(), "no description: {panel}");
        assert_eq!(panel["datasource"]["uid"], "${datasource}", "{panel}");
        for target in panel["targets"].as_array().expect("targets") {
            assert!(target["expr"].is_string(), "{target}");
        }
    }
}
