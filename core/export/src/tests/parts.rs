//! Parts of recordings, and several of them as one.

use super::flight::{BEGIN_UNIX_NS, Flight};
use super::{check, findings, folder, open};
use crate::{ExportError, Format, Overview, cut, merge, redecide};
use skein_domain::NodeId;
use skein_recording::{ClockOffset, Recording, Select, Topic};
use std::path::Path;

fn counts(recording: &Recording) -> Vec<(String, u64)> {
    let topics = Overview::of(recording).topics.into_iter();
    topics.map(|of| (of.topic, of.messages)).collect()
}

#[test]
fn a_part_is_a_whole_recording_whose_audit_can_be_followed() {
    let folder = folder();
    let (path, _) = Flight::default().write(folder.path(), "flight.mcap");
    let recording = open(&path);
    let out = folder.path().join("part.mcap");
    let written = cut(&recording, 5.0, 10.0, &out, &mut |_| {}).expect("is cut");
    assert_eq!(written.damage, []);
    let part = open(&out);
    assert_eq!(part.header(), recording.header());
    let overview = Overview::of(&part);
    assert_eq!(overview.begin, "2026-11-28T10:00:05.000000Z");
    assert!(overview.finished && (overview.length_s - 4.9).abs() < 1e-6);
    let counts = counts(&part);
    let of = |topic: &str| counts.iter().find(|(name, _)| name == topic).map(|(_, count)| *count);
    assert_eq!(of("/vehicles/2/telemetry"), Some(50));
    // All of the audit up to the end of the part; pictures and clocks from the beginning of the part and the last ones before.
    assert_eq!(
        (of("/skein/audit"), of("/skein/fleet"), of("/skein/clock")),
        (Some(5), Some(6), Some(6))
    );
    let found = check(&[part], &mut |_| {});
    assert_eq!((found.findings.as_slice(), found.audited), (&[][..], 5));
    // What lies outside of it.
    for (from_s, until_s) in [(30.0, 40.0), (5.0, 5.0), (-1.0, 3.0), (f64::NAN, 3.0), (1.0, f64::NAN)] {
        let refused = cut(&recording, from_s, until_s, &folder.path().join("x.mcap"), &mut |_| {});
        assert!(matches!(refused, Err(ExportError::NoPart { .. })), "{from_s} {until_s}");
    }
}

/// Two nodes: the second one's clock is 40 s ahead of the first one's, and its time of day 7 s.
fn of_two(folder: &Path, measured: bool) -> Vec<Recording> {
    let offset = ClockOffset {
        node: NodeId(1),
        ahead_s: 40.0,
        error_s: Some(0.001),
    };
    let from_second = ClockOffset {
        ahead_s: -40.0,
        ..offset.clone()
    };
    let (first, _) = Flight {
        flies: vec![1, 3],
        ..Flight::default()
    }
    .write(folder, "first.mcap");
    let second = Flight {
        node: Some(2),
        flies: vec![2],
        zero_unix_ns: BEGIN_UNIX_NS - 140_000_000_000 + 7_000_000_000,
        from_s: 140.0,
        others: if measured { vec![from_second] } else { Vec::new() },
        ..Flight::default()
    };
    let (second, _) = second.write(folder, "second.mcap");
    vec![open(&first), open(&second)]
}

#[test]
fn recordings_of_two_nodes_are_one_by_their_clocks_and_each_vehicle_is_told_by_who_flies_it() {
    let folder = folder();
    let both = of_two(folder.path(), true);
    let out = folder.path().join("both.mcap");
    let report = merge(&both, &out, &mut |_| {}).expect("is merged");
    assert_eq!(report.nodes, ["1", "2"]);
    assert_eq!(
        (report.unmeasured.as_slice(), report.written.damage.as_slice()),
        (&[][..], &[][..])
    );
    let merged = open(&out);
    assert_eq!(merged.header(), both[0].header());
    let counts = counts(&merged);
    let of = |topic: &str| counts.iter().find(|(name, _)| name == topic).map(|(_, count)| *count);
    for vehicle in ["1", "2", "3"] {
        assert_eq!(of(&format!("/vehicles/{vehicle}/telemetry")), Some(200), "{counts:?}");
        assert_eq!(of(&format!("/vehicles/{vehicle}/setpoint")), Some(200), "{counts:?}");
    }
    assert_eq!(of("/nodes/1/vehicles/2/telemetry"), Some(200));
    assert_eq!(of("/nodes/2/vehicles/1/telemetry"), Some(200));
    assert_eq!((of("/skein/events"), of("/nodes/2/skein/events")), (Some(20), Some(20)));
    assert_eq!(of("/nodes/2/vehicles/2/telemetry"), None);
    assert_eq!(Overview::with_events(&merged).events["critical"], 10);
    // Both flew at the same time, whatever their times of day say.
    assert!((Overview::of(&merged).length_s - 19.9).abs() < 0.01);
    let total: u64 = counts.iter().map(|(_, count)| count).sum();
    assert_eq!(
        (report.written.messages, total),
        (total, 2 * (20 * (3 * 10 + 3) + 10) + 20 * 30)
    );
    let found = check(&[merged], &mut |_| {});
    assert_eq!((found.findings.as_slice(), found.audited), (&[][..], 20));
    let merged = open(&out);
    assert!(matches!(
        redecide(&merged, &mut |_| {}),
        Err(ExportError::Merged { .. })
    ));
    let again = merge(&[merged], &folder.path().join("again.mcap"), &mut |_| {});
    assert!(matches!(again, Err(ExportError::Merged { .. })));
}

#[test]
fn a_part_of_a_merged_recording_keeps_who_tells_what() {
    let folder = folder();
    let out = folder.path().join("both.mcap");
    merge(&of_two(folder.path(), true), &out, &mut |_| {}).expect("is merged");
    let part = folder.path().join("part.mcap");
    cut(&open(&out), 2.0, 6.0, &part, &mut |_| {}).expect("is cut");
    let part = open(&part);
    let counts = counts(&part);
    assert!(counts.contains(&("/nodes/2/skein/events".to_owned(), 4)), "{counts:?}");
    assert_eq!(findings(std::slice::from_ref(&part)), Vec::<String>::new());
    let tables = folder.path().join("tables");
    let exported = crate::export(&part, Format::Csv, &tables, &mut |_| {}).expect("is written");
    assert_eq!((exported.counts["events"], exported.counts["telemetry"]), (8, 120));
}

#[test]
fn clocks_that_nobody_measured_are_named() {
    let folder = folder();
    let out = folder.path().join("both.mcap");
    let report = merge(&of_two(folder.path(), false), &out, &mut |_| {}).expect("is merged");
    assert_eq!(report.unmeasured, ["node-2"]);
    assert!((Overview::of(&open(&out)).length_s - 26.9).abs() < 0.01);
}

#[test]
fn two_files_of_one_node_follow_on_each_other() {
    let folder = folder();
    let (first, chain) = Flight::default().write(folder.path(), "first.mcap");
    let later = Flight {
        from_s: 200.0,
        audit: skein_recording::AuditChain::after(chain.last()),
        ..Flight::default()
    };
    let (second, _) = later.clone().write(folder.path(), "second.mcap");
    let files = [open(&second), open(&first)];
    assert_eq!(findings(&files), Vec::<String>::new());
    let out = folder.path().join("both.mcap");
    merge(&files, &out, &mut |_| {}).expect("is merged");
    let merged = open(&out);
    let audits = merged.messages(Select::only(|topic| *topic == Topic::Audit)).count();
    assert_eq!(audits, 20);
    // The first was not there.
    let stranger = Flight {
        audit: skein_recording::AuditChain::after("something else"),
        ..later
    };
    let (third, _) = stranger.write(folder.path(), "third.mcap");
    let found = findings(&[open(&first), open(&third)]);
    assert!(
        found.len() == 1 && found[0].contains("does not follow on that of first.mcap"),
        "{found:?}"
    );
}
