//! Reports of a flight that was drawn: their facts, their page, and what is said where a recording is damaged.

mod flight;
mod page;
mod story;

use crate::{EndState, FindingKind, Report};
use flight::{DRIFTS, Flight, RATE_HZ, at};
use skein_domain::VehicleId;
use skein_domain::exchange::Severity;
use skein_recording::Recording;
use std::path::{Path, PathBuf};

fn written(folder: &Path, flight: &Flight) -> PathBuf {
    let path = folder.join("flight.mcap");
    flight.write(&path).finish().expect("ends");
    path
}

fn report(flight: &Flight) -> Report {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = Recording::open(&written(folder.path(), flight)).expect("opens");
    Report::of(&recording).expect("is readable")
}

/// The smallest distance of any two, looked at directly.
fn smallest_m(flight: &Flight) -> (f64, [VehicleId; 2]) {
    let mut least = (f64::INFINITY, [VehicleId(0); 2]);
    for tick in 0..=(flight.seconds * RATE_HZ) as u64 {
        let t_s = tick as f64 / RATE_HZ;
        let flies = t_s > 2.0 && t_s < flight.seconds - 4.0;
        for (a, b) in (0..flight.vehicles)
            .flat_map(|a| (0..a).map(move |b| (b, a)))
            .filter(|_| flies)
        {
            let silent = a == 1 || b == 1;
            let distance_m = flight.place(a, t_s).distance_m(&flight.place(b, t_s));
            if distance_m < least.0 && !(silent && (44.0..47.0).contains(&t_s)) {
                least = (distance_m, [VehicleId(a.min(b) + 1), VehicleId(a.max(b) + 1)]);
            }
        }
    }
    least
}

#[test]
fn figures_of_a_flight_are_those_of_the_flight() {
    let flight = Flight::default();
    let report = report(&flight);
    let (least_m, pair) = smallest_m(&flight);
    let found = *report.charts.distance_m.lowest().expect("is measured");
    assert!((found.value - least_m).abs() < 0.01, "{found:?} is not {least_m}");
    assert_eq!(found.pair, Some(pair));
    assert_eq!(report.vehicles.len(), 4);
    assert!((report.about.duration_s - 60.0).abs() < 0.3);
    assert_eq!(report.about.origin, Some(flight::SWARM.origin));
    for vehicle in &report.vehicles {
        assert_eq!(vehicle.end, EndState::OnGround);
        assert!((vehicle.flight_s - 53.6).abs() < 0.5, "{}", vehicle.flight_s);
        assert!((vehicle.highest_m.expect("flew").value - 20.0).abs() < 0.5);
        assert!((190.0..320.0).contains(&vehicle.flown_m), "{}", vehicle.flown_m);
        let used = vehicle.battery.map(|battery| battery.first - battery.last);
        assert!((used.expect("is known") - 0.115).abs() < 0.01);
    }
    let worst = report.vehicles.iter().max_by(|a, b| {
        let error_m = |of: &crate::VehicleFacts| of.largest_error_m.map_or(0.0, |error| error.value);
        error_m(a).total_cmp(&error_m(b))
    });
    assert_eq!(worst.map(|vehicle| vehicle.id), Some(DRIFTS));
    assert_eq!(report.vehicle(VehicleId(3)).expect("is there").setpoints_refused, 3);
    assert_eq!(report.charts.formations_s, [[10.0, 44.0]]);
    assert_eq!(report.actions.len(), 5);
    assert_eq!(report.audit_broken, None);
    assert!(report.about.whole.is_whole());
}

#[test]
fn what_went_wrong_is_told_once_with_what_was_done() {
    let report = report(&Flight::default());
    let of = |kind: FindingKind| {
        report
            .findings
            .iter()
            .find(move |found| found.kind == kind)
            .expect("was found")
    };
    let failsafe = of(FindingKind::Failsafe);
    assert_eq!(
        (failsafe.vehicle, failsafe.severity, failsafe.count),
        (Some(DRIFTS), Severity::Critical, 1)
    );
    let done: Vec<&str> = failsafe.done.iter().map(|step| step.text.as_str()).collect();
    assert_eq!(done, ["hold ordered", "hold in effect", "cause over", "taken up again"]);
    assert_eq!(of(FindingKind::Avoidance).count, 2);
    assert_eq!(of(FindingKind::TooClose).vehicle, Some(VehicleId(3)));
    assert!(
        of(FindingKind::LinkLoss).done[0]
            .text
            .starts_with("heard again after 1.")
    );
    assert!(
        of(FindingKind::Restart).done[0]
            .text
            .starts_with("runs again after 0.8 s")
    );
    let refused = of(FindingKind::Refusal);
    assert_eq!((refused.vehicle, refused.count), (Some(VehicleId(2)), 2));
    assert!(
        report
            .findings
            .iter()
            .map(|found| found.number)
            .eq(1..=report.findings.len())
    );
    assert!(report.findings.is_sorted_by(|a, b| a.t_s <= b.t_s));
    let verdict = report.verdict.join(" ");
    assert!(verdict.starts_with("No vehicle was lost."), "{verdict}");
    assert!(
        verdict.contains("between 3 and 4") && verdict.contains("under the limit of 2.00 m"),
        "{verdict}"
    );
    assert!(
        verdict.contains("one failsafe") || verdict.contains("One failsafe"),
        "{verdict}"
    );
}

#[test]
fn a_flight_without_trouble_has_nothing_to_tell() {
    let report = report(&Flight {
        trouble: false,
        ..Flight::default()
    });
    assert!(report.findings.is_empty(), "{:?}", report.findings);
    assert!(
        report
            .verdict
            .iter()
            .any(|sentence| sentence == "Nothing was reported as wrong.")
    );
}

#[test]
fn a_recording_that_is_cut_off_or_damaged_is_told_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = written(folder.path(), &Flight::default());
    let whole = std::fs::read(&path).expect("is there");
    for share in [0.2, 0.5, 0.9] {
        let length = (whole.len() as f64 * share) as usize;
        std::fs::write(&path, &whole[..length]).expect("is written");
        let report = Report::of(&Recording::open(&path).expect("opens")).expect("is readable");
        assert!(!report.about.whole.finished);
        assert!(crate::html(&report).contains("The recording is cut off"));
        if share == 0.5 {
            assert!(
                report
                    .verdict
                    .iter()
                    .any(|sentence| sentence.contains("still in the air"))
            );
        }
    }
    // Not every place is one of a message.
    let holes = (1..40).filter(|part| {
        let mut damaged = whole.clone();
        let at = damaged.len() * part / 60;
        damaged[at..at + 40].fill(0x55);
        std::fs::write(&path, &damaged).expect("is written");
        let report = Report::of(&Recording::open(&path).expect("opens")).expect("is readable");
        let told = crate::html(&report).contains("The recording has holes");
        assert_eq!(told, report.about.whole.finished && !report.about.whole.is_whole());
        told
    });
    assert!(holes.count() > 10);
}

#[test]
fn nothing_that_can_be_read_is_an_error_and_no_panic() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = written(
        folder.path(),
        &Flight {
            vehicles: 1,
            seconds: 2.0,
            ..Flight::default()
        },
    );
    let whole = std::fs::read(&path).expect("is there");
    for at in (300..whole.len()).step_by(whole.len() / 150) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0xA5;
        std::fs::write(&path, &bytes).expect("is written");
        if let Ok(recording) = Recording::open(&path)
            && let Ok(report) = Report::of(&recording)
        {
            assert!(crate::html(&report).ends_with("</html>"));
        }
    }
}

#[test]
fn times_on_the_page_are_where_one_wants_them() {
    let report = report(&Flight::default()).at_utc_offset_s(3600);
    let page = crate::html(&report);
    assert!(page.contains("28 November 2026, 13:03:00 UTC+01:00"));
    assert_eq!(at(0.0).as_seconds(), 90.0);
}
