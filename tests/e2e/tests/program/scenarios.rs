//! The scenarios of the demonstration as a user starts them: each meets its own criteria by the simulator's truth, and says so.
//!
//! Each takes one to three minutes: none is flown in the everyday run.

use skein_testkit::Process;
use std::time::Duration;

/// A scenario takes three minutes at most; a busy machine may take its time to start.
const FLIGHT: Duration = Duration::from_secs(330);

/// Flies a scenario and gives its criteria.
async fn fly(scenario: &str, vehicles: u64) -> Vec<serde_json::Value> {
    fly_with(scenario, vehicles, &[]).await
}

async fn fly_with(scenario: &str, vehicles: u64, more: &[&str]) -> Vec<serde_json::Value> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("report.json");
    let arguments = ["demo", "--headless", "--port", "0", "--scenario", scenario];
    let (count, file_name) = (vehicles.to_string(), file.to_str().expect("is text"));
    let mut demo = Process::skein(&[&arguments[..], &["--vehicles", &count, "--report", file_name], more].concat());
    let code = demo.exit_code(FLIGHT).await;
    assert_eq!(code, 0, "{}", demo.output());
    let text = std::fs::read_to_string(&file).expect("the report is written");
    let report: serde_json::Value = serde_json::from_str(&text).expect("the report is JSON");
    assert_eq!(report["scenario"], scenario);
    assert_eq!(report["passed"], true);
    assert_eq!(report["vehicles"], vehicles);
    let criteria = report["criteria"].as_array().expect("criteria").clone();
    for criterion in &criteria {
        assert_eq!(criterion["met"], true, "{criterion}");
        assert!(criterion["value"].is_number(), "measured: {criterion}");
    }
    criteria
}

/// Every scenario is judged by what is common to all and by criteria of its own.
fn judged_by(criteria: &[serde_json::Value], own: &[&str]) {
    let common = ["smallest distance between two vehicles", "vehicles landed and disarmed"];
    for name in common.iter().chain(own) {
        assert!(criteria.iter().any(|c| c["name"] == *name), "no criterion \"{name}\"");
    }
}

#[tokio::test]
#[ignore = "long: part of `cargo xtask test e2e`"]
async fn a_lost_leader_is_succeeded_without_a_jump() {
    let criteria = fly("leader-loss", 5).await;
    judged_by(
        &criteria,
        &[
            "loss of the leader declared until new intent",
            "largest jump of a setpoint when the leader was lost",
        ],
    );
}

#[tokio::test]
#[ignore = "long: part of `cargo xtask test e2e`"]
async fn a_formation_without_a_coordinator_keeps_its_shape() {
    let criteria = fly("no-coordinator", 5).await;
    judged_by(&criteria, &["distances to neighbours off, root mean square"]);
}

#[tokio::test]
#[ignore = "long: part of `cargo xtask test e2e`"]
async fn video_is_received_while_the_cameras_follow_the_leader() {
    let criteria = fly("observe-video", 5).await;
    judged_by(&criteria, &["pictures per second of the slowest camera"]);
}

#[tokio::test]
#[ignore = "long: part of `cargo xtask test e2e`"]
async fn an_intruder_is_observed_from_two_sides_and_who_must_return_is_relieved() {
    let criteria = fly("observe", 4).await;
    judged_by(
        &criteria,
        &[
            "intruder's track off the intruder, root mean square",
            "intruder in the middle third of the pictures",
            "low battery until another one looks",
            "tracks of what is not there",
        ],
    );
}

#[tokio::test]
#[ignore = "long: part of `cargo xtask test e2e`"]
async fn observers_whose_cameras_are_fixed_lean_no_farther_than_they_can_look() {
    let criteria = fly_with("observe", 4, &["--airframe", "sih"]).await;
    judged_by(
        &criteria,
        &[
            "intruder's track off the intruder, root mean square",
            "intruder in the pictures of fixed cameras",
            "low battery until another one looks",
        ],
    );
}

#[tokio::test]
#[ignore = "long: part of `cargo xtask test e2e`"]
async fn every_shape_and_anchor_is_flown() {
    let criteria = fly("formations", 6).await;
    judged_by(
        &criteria,
        &[
            "shapes formed",
            "error about a virtual leader, turning, root mean square",
        ],
    );
}

#[tokio::test]
#[ignore = "long: part of `cargo xtask test e2e`"]
async fn vehicles_leave_and_join_in_flight() {
    let criteria = fly("join-leave", 6).await;
    judged_by(&criteria, &["from hovering until in a slot of the formation"]);
}

#[tokio::test]
#[ignore = "long: part of `cargo xtask test e2e`"]
async fn a_mixed_swarm_goes_with_its_slowest() {
    let criteria = fly("mixed", 5).await;
    judged_by(
        &criteria,
        &["smallest angle between a carrier's nose and another vehicle"],
    );
}

#[tokio::test]
#[ignore = "long: part of `cargo xtask test e2e`"]
async fn nobody_flies_beyond_the_fence() {
    let criteria = fly("fence", 4).await;
    judged_by(&criteria, &["deepest where nobody may be"]);
}
