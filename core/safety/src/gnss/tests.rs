//! Sources that agree, one that is spoofed away, and what motion and age explain.

use super::*;
use skein_domain::{LocalFrame, LocalPositionNed, PositionNed, VelocityNed};

fn origin() -> Geodetic {
    Geodetic {
        latitude_deg: 47.4,
        longitude_deg: 8.5,
        altitude_amsl_m: 480.0,
    }
}

fn place(north_m: f64, east_m: f64) -> Geodetic {
    SwarmFrame::new(origin()).geodetic(&PositionNed::new(north_m, east_m, -20.0))
}

fn now() -> NodeTime {
    NodeTime::from_seconds(100.0)
}

fn telemetry() -> Telemetry {
    let mut t = Telemetry {
        global: Some(place(100.0, 50.0)),
        local: Some(LocalPositionNed::new(100.0, 50.0, -20.0)),
        local_frame: Some(LocalFrame { origin: origin() }),
        gnss_place: Some(place(100.4, 50.0)),
        gnss2_place: Some(place(100.0, 50.9)),
        velocity: Some(VelocityNed::default()),
        ..Telemetry::default()
    };
    for heard in [
        &mut t.heard.global,
        &mut t.heard.local,
        &mut t.heard.gnss,
        &mut t.heard.gnss2,
    ] {
        *heard = now();
    }
    t
}

#[test]
fn sources_that_agree_are_as_far_apart_as_their_noise() {
    let apart_m = disagreement_m(&telemetry(), now()).expect("compared");
    assert!((apart_m - 0.4_f64.hypot(0.9)).abs() < 0.01, "{apart_m}");
}

#[test]
fn any_one_source_that_is_elsewhere_is_found() {
    let away = Some(place(112.0, 50.0));
    let moved: [fn(&mut Telemetry, Option<Geodetic>); 3] =
        [|t, p| t.global = p, |t, p| t.gnss_place = p, |t, p| t.gnss2_place = p];
    for moves in moved {
        let mut t = telemetry();
        moves(&mut t, away);
        let apart_m = disagreement_m(&t, now()).expect("compared");
        assert!(apart_m > 11.0, "{apart_m}");
    }
    let mut t = telemetry();
    t.local = Some(LocalPositionNed::new(88.0, 50.0, -20.0));
    assert!(disagreement_m(&t, now()).expect("compared") > 11.0);
}

#[test]
fn what_was_flown_between_two_reports_is_no_disagreement() {
    let mut t = telemetry();
    t.gnss_place = Some(place(97.0, 50.0));
    t.gnss2_place = None;
    t.velocity = Some(VelocityNed::new(12.0, 0.0, 0.0));
    t.heard.gnss = now().plus_seconds(-0.1);
    let apart_m = disagreement_m(&t, now()).expect("compared");
    assert!(apart_m < 0.1, "{apart_m}");
}

#[test]
fn old_and_invalid_sources_are_not_compared() {
    let mut t = telemetry();
    t.local_frame = None;
    t.gnss2_place = None;
    t.gnss_place = Some(place(500.0, 0.0));
    assert!(disagreement_m(&t, now()).is_some());
    t.heard.gnss = now().plus_seconds(-10.0);
    assert_eq!(disagreement_m(&t, now()), None);
    t.heard.gnss = now();
    t.gnss_place = Some(Geodetic {
        latitude_deg: f64::NAN,
        ..origin()
    });
    assert_eq!(disagreement_m(&t, now()), None);
    assert_eq!(disagreement_m(&Telemetry::default(), now()), None);
}
