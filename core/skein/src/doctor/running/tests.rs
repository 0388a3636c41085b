//! What is made of a node's answers.

use super::{Findings, others, recorder};
use serde_json::json;

#[test]
fn a_clock_is_judged_by_how_well_it_is_known_and_not_by_when_its_node_was_started() {
    let node = |offset_s: f64, error_s: f64, fault: bool| json!({ "name": "uav-2", "clock_offset_s": offset_s, "clock_error_s": error_s, "clock_fault": fault });
    for (node, said) in [
        (node(-8000.0, 0.002, false), "ok    node: uav-2 is in the swarm"),
        (
            node(0.001, 0.2, false),
            "warn  clock: that of node uav-2 is known to 0.200 s only",
        ),
        (
            node(0.001, 0.002, true),
            "warn  clock: that of node uav-2 cannot be trusted",
        ),
    ] {
        let mut findings = Findings::default();
        others(&json!({ "nodes": [node] }), &mut findings);
        let told = findings.lines.join("\n");
        assert!(told.contains(said), "{told}");
    }
}

#[test]
fn what_keeps_flights_from_being_recorded_is_told_with_a_remedy() {
    let told = |status: serde_json::Value| {
        let mut findings = Findings::default();
        recorder(&json!({ "recorder": status }), &mut findings);
        findings.lines.join("\n")
    };
    let off = told(json!({ "state": "off" }));
    assert!(off.is_empty(), "{off}");
    let writes = told(json!({ "state": "recording", "file": "a.mcap" }));
    assert!(writes.contains("ok    recorder: writes a.mcap"), "{writes}");
    let full = told(json!({ "state": "interrupted", "why": "the disk is full" }));
    assert!(
        full.contains("warn  recorder: flights are not recorded: the disk is full"),
        "{full}"
    );
    assert!(full.contains("make room"), "{full}");
}
