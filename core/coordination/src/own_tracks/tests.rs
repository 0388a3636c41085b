//! Tests of who is taken for one of ours, and who is not.

use super::*;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{FlightState, LinkHealth, PositionNed, Telemetry, VelocityNed};

fn entry(id: u16, north_m: f64, speed_m_s: f64, at_s: f64) -> PeerEntry {
    PeerEntry {
        id: VehicleId(id),
        kinematics: Some(VehicleKinematics {
            position: PositionNed::new(north_m, 0.0, -20.0),
            velocity: VelocityNed::new(speed_m_s, 0.0, 0.0),
            yaw_rad: 0.0,
            measured: NodeTime::from_seconds(at_s),
        }),
        airborne: true,
        telemetry: Telemetry::default(),
        link: LinkHealth::default(),
        flight_state: FlightState::Holding,
        anchor: None,
        home: None,
        limits: None,
        under_order: false,
        may_rejoin: false,
        energy: None,
    }
}

fn track(north_m: f64, east_m: f64, speed_m_s: f64, at_s: f64) -> Track {
    Track {
        track: 7,
        position: PositionNed::new(north_m, east_m, -20.0),
        velocity: VelocityNed::new(speed_m_s, 0.0, 0.0),
        time: NodeTime::from_seconds(at_s),
        error_m: None,
    }
}

/// Whether track 7 counts as a stranger at a moment.
fn strange(tracks: &mut OwnTracks, seen: Track, entries: &[PeerEntry], at_s: f64) -> bool {
    !tracks
        .strangers(&[seen], entries, NodeTime::from_seconds(at_s))
        .is_empty()
}

#[test]
fn a_track_that_was_ours_from_the_first_is_ours_while_it_stays() {
    let mut tracks = OwnTracks::default();
    for step in 0..100 {
        let at_s = 0.1 * f64::from(step);
        let ours = entry(1, 5.0 * at_s, 5.0, at_s);
        // Told late: its place is that of a fifth of a second ago, which is a metre.
        let seen = track(5.0 * (at_s - 0.2) + 2.0, 1.0, 4.5, at_s - 0.2);
        assert!(!strange(&mut tracks, seen, &[ours], at_s), "{at_s}");
    }
    let gone = track(80.0, 0.0, 5.0, 10.0);
    assert!(strange(&mut tracks, gone, &[entry(1, 50.0, 5.0, 10.0)], 10.0));
    let back = track(51.0, 0.0, 5.0, 10.1);
    assert!(
        strange(&mut tracks, back, &[entry(1, 50.5, 5.0, 10.1)], 10.1),
        "it was another's"
    );
}

#[test]
fn a_stranger_that_comes_near_stays_one() {
    let mut tracks = OwnTracks::default();
    let ours = entry(1, 0.0, 0.0, 0.0);
    for step in 0..100 {
        let at_s = 0.1 * f64::from(step);
        let ours = PeerEntry {
            ..entry(1, 0.0, 0.0, at_s)
        };
        // Past it, two metres beside.
        assert!(
            strange(&mut tracks, track(-25.0 + 5.0 * at_s, 2.0, 5.0, at_s), &[ours], at_s),
            "{at_s}"
        );
    }
    // And so does one that flies along four metres beside.
    let mut tracks = OwnTracks::default();
    assert!(strange(&mut tracks, track(30.0, 4.0, 0.0, 0.0), &[ours], 0.0));
    for step in 1..100 {
        let at_s = 0.1 * f64::from(step);
        assert!(strange(
            &mut tracks,
            track(0.0, 4.0, 0.0, at_s),
            &[entry(1, 0.0, 0.0, at_s)],
            at_s
        ));
    }
}

#[test]
fn one_seen_first_right_beside_us_at_another_speed_is_a_stranger() {
    let mut tracks = OwnTracks::default();
    assert!(strange(
        &mut tracks,
        track(3.0, 0.0, -8.0, 0.0),
        &[entry(1, 0.0, 0.0, 0.0)],
        0.0
    ));
}

#[test]
fn our_own_track_that_began_badly_is_ours_after_some_seconds() {
    let mut tracks = OwnTracks::default();
    assert!(strange(
        &mut tracks,
        track(9.0, 0.0, 0.0, 0.0),
        &[entry(1, 0.0, 0.0, 0.0)],
        0.0
    ));
    let ours_at = |at_s: f64| entry(1, 2.0 * at_s, 2.0, at_s);
    let mut since_s = None;
    for step in 1..60 {
        let at_s = 0.1 * f64::from(step);
        let seen = track(2.0 * at_s + 0.5, 0.5, 2.0, at_s);
        if !strange(&mut tracks, seen, &[ours_at(at_s)], at_s) {
            since_s.get_or_insert(at_s);
        }
    }
    assert!(since_s.is_some_and(|s| (3.0..3.3).contains(&s)), "{since_s:?}");
}
