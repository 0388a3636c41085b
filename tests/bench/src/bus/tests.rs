//! The bench of the bus measures what it says, in a short run.

use super::*;

#[test]
#[ignore = "long: part of `cargo xtask test --all`"]
fn all_transports_carry_the_same_traffic() {
    let report = run_bus_bench(&BusBenchArgs { nodes: 3, seconds: 3 }).unwrap();
    println!("{report}");
    let names: Vec<&str> = report.transports.iter().map(|of| of.transport).collect();
    assert_eq!(names, ["in-process", "bare UDP", "Zenoh UDP", "Zenoh TCP", "DDS"]);
    for of in &report.transports {
        // Six pairs, five states a second; fewer where the machine stood still.
        assert!((1..=100).contains(&of.states), "{}: {} states", of.transport, of.states);
        assert!(of.node_bytes_per_s > 1000.0 && of.p50_us <= of.p99_us && of.bulk_s.is_some());
    }
    let bare = &report.transports[1];
    assert!((bare.cpu_ratio - 1.0).abs() < 1e-9 && (bare.p50_ratio - 1.0).abs() < 1e-9);
}

#[test]
fn a_number_of_nodes_that_makes_no_sense_is_refused() {
    for nodes in [0, 1, 13] {
        assert!(run_bus_bench(&BusBenchArgs { nodes, seconds: 1 }).is_err());
    }
}
