//! Recordings that a made-up flight left: what is found in them, and what is made of them.

mod broken;
mod flight;
mod flights;
mod formats;
mod parts;

use crate::{Format, Overview, check, list, redecide};
use flight::Flight;
use skein_recording::{ReadError, Recording};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn open(path: &Path) -> Recording {
    Recording::open(path).expect("opens")
}

fn recorded(flight: Flight) -> (TempDir, PathBuf) {
    let folder = folder();
    let (path, _) = flight.write(folder.path(), "flight.mcap");
    (folder, path)
}

fn findings(recordings: &[Recording]) -> Vec<String> {
    let found = check(recordings, &mut |_| {});
    found.findings.into_iter().map(|finding| finding.to_string()).collect()
}

#[test]
fn an_overview_says_what_is_in_a_recording() {
    let (_folder, path) = recorded(Flight::default());
    let overview = Overview::with_events(&open(&path));
    assert_eq!((overview.node, overview.name.as_str()), (Some(1), "node-1"));
    assert_eq!(overview.begin, "2026-11-28T10:00:00.000000Z");
    assert!((overview.length_s - 19.9).abs() < 1e-6, "{}", overview.length_s);
    assert_eq!(overview.vehicles, [1, 2, 3]);
    assert_eq!((overview.events["info"], overview.events["critical"]), (10, 5));
    let telemetry = overview.topics.iter().find(|of| of.topic == "/vehicles/1/telemetry");
    let telemetry = telemetry.expect("a topic");
    assert_eq!(
        (telemetry.messages, telemetry.schema.as_str()),
        (200, "skein.VehicleTelemetry")
    );
    assert!(overview.finished && overview.damage.is_empty());
    assert!(serde_json::to_string(&overview).is_ok());
}

#[test]
fn a_folder_is_listed_with_what_is_no_recording() {
    let folder = folder();
    let later = Flight {
        from_s: 500.0,
        finishes: false,
        ..Flight::default()
    };
    later.write(folder.path(), "a.mcap");
    std::fs::create_dir(folder.path().join("old")).expect("a folder");
    Flight::default().write(&folder.path().join("old"), "b.mcap");
    std::fs::write(folder.path().join("c.mcap"), "nothing of ours").expect("is written");
    std::fs::write(folder.path().join("notes.txt"), "not asked for").expect("is written");
    let (found, others) = list(folder.path()).expect("is read");
    let names: Vec<_> = found.iter().filter_map(|of| of.file.file_name()?.to_str()).collect();
    assert_eq!(names, ["b.mcap", "a.mcap"]);
    assert_eq!([found[0].finished, found[1].finished], [true, false]);
    assert!(matches!(others.as_slice(), [ReadError::NotMcap { .. }]));
    assert!(list(&folder.path().join("none")).is_err());
}

#[test]
fn a_whole_recording_has_no_findings() {
    let (_folder, path) = recorded(Flight::default());
    let found = check(&[open(&path)], &mut |_| {});
    assert_eq!((found.findings.as_slice(), found.audited), (&[][..], 10));
    // Three vehicles ten times a second with their setpoints, and four topics of the node.
    assert_eq!(found.messages, 20 * (3 * 10 * 2 + 3) + 10);
}

#[test]
fn setpoints_whose_period_was_thinned_out_are_counted() {
    let (_folder, path) = recorded(Flight::default());
    let again = redecide(&open(&path), &mut |_| {}).expect("is of one node");
    assert_eq!((again.decided.setpoints, again.decided.thinned), (0, 600));
    assert_eq!(again.decided.differences, []);
}

#[test]
fn nothing_is_written_over_what_is_there() {
    let (folder, path) = recorded(Flight::default());
    let recording = open(&path);
    for format in [
        Format::Csv,
        Format::Kml,
        Format::Gpx,
        Format::Rosbag,
        Format::Tlog,
        Format::Parquet,
    ] {
        let out = folder.path().join(format!("{format:?}"));
        std::fs::write(&out, "mine").expect("is written");
        let refused = crate::export(&recording, format, &out, &mut |_| {}).expect_err("is there already");
        assert!(matches!(refused, crate::ExportError::Exists { .. }), "{refused}");
        assert_eq!(std::fs::read_to_string(&out).expect("is read"), "mine");
    }
    assert!(crate::cut(&recording, 0.0, 5.0, &path, &mut |_| {}).is_err());
}
