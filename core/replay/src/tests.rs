//! What is shown of a recording at which moment.

#[path = "../../export/src/tests/flight.rs"]
mod flight;

use crate::player::Player;
use crate::timeline::Index;
use crate::{Replay, ReplayChange, ReplayError};
use flight::{Flight, position};
use skein_domain::VehicleId;
use skein_recording::Recording;
use skein_view::FleetSnapshot;
use std::path::PathBuf;
use std::time::Duration;

fn recorded(folder: &tempfile::TempDir, flight: &Flight) -> PathBuf {
    flight.clone().write(folder.path(), "flight.mcap").0
}

fn place(fleet: &FleetSnapshot, vehicle: u16) -> (f64, f64) {
    let of = fleet.vehicles.iter().find(|one| one.id == VehicleId(vehicle)).unwrap();
    let at = of.kinematics.unwrap().position;
    (at.north_m, at.east_m)
}

/// Where it was recorded last before a moment: five times a second.
fn is_where_it_was(fleet: &FleetSnapshot, after_s: f64) {
    for vehicle in 1..=3 {
        let (north_m, east_m) = place(fleet, vehicle);
        let was = position(vehicle, after_s);
        let off_m = (north_m - was.north_m).hypot(east_m - was.east_m);
        // 6 m/s, a fifth of a second.
        assert!(off_m < 1.3, "{vehicle} is {off_m:.2} m off at {after_s} s");
    }
}

#[test]
fn going_on_and_jumping_come_to_the_same_fleet() {
    let folder = tempfile::tempdir().unwrap();
    let recording = Recording::open(&recorded(&folder, &Flight::default())).unwrap();
    let begin = recording.span().0;
    let mut going = Player::at(&recording, begin);
    let mut events = 0;
    for step in 1..=19 * 4 {
        let after_s = f64::from(step) * 0.25;
        let at = begin.plus_seconds(after_s);
        events += going.advance(at).events.len();
        let (gone, jumped) = (going.fleet(at, 1), Player::at(&recording, at).fleet(at, 1));
        assert_eq!(
            serde_json::to_value(&gone).unwrap(),
            serde_json::to_value(&jumped).unwrap(),
            "at {after_s} s"
        );
        is_where_it_was(&gone, after_s);
    }
    let index = Index::of(&recording);
    let known = index.events_until(begin.plus_seconds(19.0)).count();
    assert!(known > 0 && known >= events, "{known} known, {events} told");
}

#[test]
fn what_was_not_recorded_grows_old() {
    let folder = tempfile::tempdir().unwrap();
    let flight = Flight {
        gap_at: Some(8),
        ..Flight::default()
    };
    let recording = Recording::open(&recorded(&folder, &flight)).unwrap();
    let begin = recording.span().0;
    let end = recording.span().1;
    let mut player = Player::at(&recording, begin);
    player.advance(end);
    let long_after = end.plus_seconds(30.0);
    let fleet = player.fleet(long_after, 1);
    let old_s = long_after.seconds_since(fleet.time);
    assert!((27.0..=28.5).contains(&old_s), "{old_s}");
}

#[test]
fn the_timeline_tells_what_happened_and_who_did_it() {
    let folder = tempfile::tempdir().unwrap();
    let recording = Recording::open(&recorded(&folder, &Flight::default())).unwrap();
    let timeline = Index::of(&recording).timeline;
    assert!(timeline.complete && timeline.left_out == 0);
    assert!(
        timeline.marks.iter().any(|mark| mark.who.is_some()),
        "{:?}",
        timeline.marks
    );
    assert!(timeline.marks.iter().any(|mark| mark.who.is_none()));
    assert!(timeline.marks.is_sorted_by(|a, b| a.position_s <= b.position_s));
    assert!(
        timeline
            .marks
            .iter()
            .all(|mark| (0.0..=20.5).contains(&mark.position_s))
    );
}

#[tokio::test]
async fn it_goes_where_it_is_told_and_ends_at_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let replay = Replay::open(&recorded(&folder, &Flight::default())).unwrap();
    let stands = replay.state();
    assert!(!stands.playing && stands.position_s == 0.0 && stands.duration_s > 15.0);
    let jump = |position_s| ReplayChange {
        position_s: Some(position_s),
        ..ReplayChange::default()
    };
    let there = replay.change(jump(7.5)).await.unwrap();
    assert!((there.position_s - 7.5).abs() < 1e-6 && there.jumps > stands.jumps);
    is_where_it_was(&replay.node().snapshot(), 7.5);
    assert_eq!(replay.node().now(), there.begin.plus_seconds(7.5));
    let back = replay.change(jump(2.0)).await.unwrap();
    assert!(back.jumps > there.jumps);
    is_where_it_was(&replay.node().snapshot(), 2.0);
    // As quick as it can, from near the end: it stands still there.
    let quick = ReplayChange {
        position_s: Some(back.duration_s - 2.0),
        rate: Some(1e6),
        playing: Some(true),
    };
    let gone_on = replay.change(quick).await.unwrap();
    assert!(gone_on.playing && (gone_on.rate - 20.0).abs() < 1e-9);
    let mut watch = replay.watch();
    let ended = watch.wait_for(|state| !state.playing);
    let ended = tokio::time::timeout(Duration::from_secs(60), ended)
        .await
        .unwrap()
        .unwrap()
        .clone();
    assert!((ended.position_s - ended.duration_s).abs() < 1e-3, "{ended:?}");
    assert!(!replay.node().events_after(0).is_empty());
}

#[tokio::test]
async fn nothing_can_be_commanded() {
    let folder = tempfile::tempdir().unwrap();
    let replay = Replay::open(&recorded(&folder, &Flight::default())).unwrap();
    let receipts = replay
        .node()
        .command(
            &skein_runtime::Targets::Vehicles(vec![VehicleId(1)]),
            skein_domain::VehicleCommand::Land,
        )
        .await;
    assert!(receipts.iter().all(|receipt| receipt.refusal.is_some()), "{receipts:?}");
}

#[test]
fn what_is_no_recording_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.mcap");
    std::fs::write(&path, "not one").unwrap();
    assert!(matches!(Replay::open(&path), Err(ReplayError::Read(_))));
}
