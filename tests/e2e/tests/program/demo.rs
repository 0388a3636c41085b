//! The demonstration as a user starts it: it flies, meets its criteria by the simulator's truth, and says so in its report.

use skein_testkit::{Process, eventually};
use std::path::Path;
use std::time::Duration;

/// A flight is laid out for two minutes; a busy machine may take its time to start.
const FLIGHT: Duration = Duration::from_secs(300);

async fn fly(extra: &[&str]) -> serde_json::Value {
    fly_with(extra, async |_| {}).await
}

/// The same; meanwhile something is done to the program.
async fn fly_with(extra: &[&str], meanwhile: impl AsyncFnOnce(&mut Process)) -> serde_json::Value {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("report.json");
    let report = file.to_str().expect("is text");
    let mut arguments = vec![
        "demo",
        "--headless",
        "--port",
        "0",
        "--seconds",
        "120",
        "--report",
        report,
    ];
    arguments.extend(extra);
    let mut demo = Process::skein(&arguments);
    meanwhile(&mut demo).await;
    let code = demo.exit_code(FLIGHT).await;
    assert_eq!(code, 0, "{}", demo.output());
    read(&file)
}

fn read(file: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(file).expect("the report is written")).expect("the report is JSON")
}

fn check(report: &serde_json::Value, vehicles: u64, criteria_expected: usize) {
    assert_eq!(report["passed"], true);
    assert_eq!(report["vehicles"], vehicles);
    let criteria = report["criteria"].as_array().expect("criteria");
    assert_eq!(criteria.len(), criteria_expected);
    for criterion in criteria {
        assert_eq!(criterion["met"], true, "{criterion}");
        assert!(
            criterion["value"].is_f64() || criterion["value"].is_u64(),
            "measured: {criterion}"
        );
    }
}

#[tokio::test]
#[ignore = "long: part of `cargo xtask test e2e`"]
async fn six_vehicles_fly_the_demonstration() {
    check(&fly(&["--vehicles", "6"]).await, 6, 10);
}

#[tokio::test]
async fn with_faults_the_criteria_still_hold() {
    let report = fly(&["--vehicles", "6", "--faults", "--seed", "2"]).await;
    check(&report, 6, 10);
    let restarts = report["restarts"].as_array().expect("restarts");
    assert!(
        restarts.len() >= 4,
        "two plugins, an actor and the coordinator were killed: {restarts:?}"
    );
}

#[tokio::test]
#[ignore = "long: part of `cargo xtask test e2e`"]
async fn a_computer_that_stands_still_for_two_seconds_flies_on() {
    let report = fly_with(&["--vehicles", "6"], async |demo| {
        for part in [
            "the others follow",
            "Line behind",
            "Circle behind",
            "landing, each on its spot",
        ] {
            eventually(FLIGHT, part, async || demo.output().contains(part).then_some(())).await;
            demo.signal("STOP").await;
            tokio::time::sleep(Duration::from_secs(2)).await;
            demo.signal("CONT").await;
        }
    });
    check(&report.await, 6, 10);
}

#[tokio::test]
#[ignore = "long: part of `cargo xtask test e2e`"]
async fn with_a_random_plugin_ended_twice_a_second_the_criteria_still_hold() {
    let report = fly(&["--vehicles", "6", "--faults", "plugins", "--seed", "3"]).await;
    check(&report, 6, 12);
    let restarts = report["plugin_restarts"].as_array().expect("restarts");
    let isolations: Vec<_> = restarts
        .iter()
        .map(|r| r["isolation"].as_str().expect("a word"))
        .collect();
    assert_eq!(isolations, ["in_process", "child"]);
    for of_one_kind in restarts {
        let number = |key: &str| of_one_kind[key].as_u64().expect("a number");
        assert!(number("count") >= 30, "twice a second over two minutes: {of_one_kind}");
        assert_eq!(
            number("restored_exactly") + number("without_state"),
            number("count"),
            "{of_one_kind}"
        );
    }
}

#[tokio::test]
#[ignore = "long: part of `cargo xtask test e2e`"]
async fn over_dds_the_same_is_flown() {
    // without gimbals, which speak MAVLink
    check(&fly(&["--vehicles", "6", "--link", "dds"]).await, 6, 9);
}

#[tokio::test]
#[ignore = "long: part of `cargo xtask test e2e`"]
async fn every_vehicle_flies_on_over_its_other_link_when_the_first_is_cut() {
    let report = fly(&["--vehicles", "6", "--link", "both", "--faults", "links"]).await;
    check(&report, 6, 13);
    assert_eq!(report["faults"], 6);
}

#[tokio::test]
async fn one_link_cannot_be_cut_in_turn() {
    let mut demo = Process::skein(&["demo", "--headless", "--port", "0", "--faults", "links"]);
    assert_ne!(demo.exit_code(Duration::from_secs(30)).await, 0);
    assert!(demo.output().contains("--link both"), "{}", demo.output());
}

#[tokio::test]
async fn another_program_on_the_usual_port_stops_no_demonstration() {
    // Where somebody has it already, that one is the other program.
    let _other = std::net::TcpListener::bind("127.0.0.1:8080");
    let mut demo = Process::skein(&["demo", "--manual", "--vehicles", "2"]);
    let line = demo.line("Dashboard: ").await;
    assert!(line.contains("another program has port 8080"), "{line}");
    demo.signal("INT").await;
    assert_eq!(demo.exit_code(Duration::from_secs(30)).await, 0, "{}", demo.output());
}
