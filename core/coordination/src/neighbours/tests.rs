//! Where a vehicle is looked for that is heard, that has just fallen silent, and that has been silent for long.

use super::*;
use proptest::prelude::*;
use skein_domain::VehicleId;
use skein_domain::telemetry::{LinkHealth, Telemetry, VehicleKinematics};

const HEARD_S: f64 = 100.0;

fn at_s(time_s: f64) -> NodeTime {
    NodeTime(0).plus_seconds(time_s)
}

/// In the air, under our control, last heard at [`HEARD_S`].
fn entry(velocity: VelocityNed) -> PeerEntry {
    PeerEntry {
        id: VehicleId(1),
        kinematics: Some(VehicleKinematics {
            position: PositionNed::new(10.0, 20.0, -30.0),
            velocity,
            measured: at_s(HEARD_S),
            ..VehicleKinematics::default()
        }),
        airborne: true,
        telemetry: Telemetry::default(),
        link: LinkHealth {
            connected: true,
            setpoint_rate_hz: 50.0,
            ..LinkHealth::default()
        },
        flight_state: FlightState::Following,
        anchor: None,
        home: None,
        limits: None,
        under_order: false,
        may_rejoin: false,
        energy: None,
    }
}

fn after(entry: &PeerEntry, silent_s: f64) -> Vec<Neighbour> {
    vehicle(entry, at_s(HEARD_S + silent_s))
}

#[test]
fn who_is_heard_is_in_one_place_and_does_its_part() {
    let north = entry(VelocityNed::new(5.0, 0.0, 0.0));
    let seen = after(&north, 0.3);
    assert_eq!(seen.len(), 1);
    assert_eq!(seen[0].cooperation, Cooperation::Shares);
    assert_eq!(seen[0].velocity, VelocityNed::new(5.0, 0.0, 0.0));
}

#[test]
fn who_has_just_fallen_silent_has_flown_on_or_braked() {
    let north = entry(VelocityNed::new(7.0, 0.0, 0.0));
    let seen = after(&north, 0.6);
    assert!(seen.iter().all(|n| n.cooperation == Cooperation::DoesNot));
    let [on, halfway, braked] = seen[..] else {
        panic!("{seen:?}")
    };
    assert_eq!((on.velocity.north_m_s, on.position.north_m), (7.0, 10.0 + 0.6 * 7.0));
    // 7 m/s² for 0.3 s.
    assert!((halfway.velocity.north_m_s - 4.9).abs() < 1e-9, "{halfway:?}");
    // 7 m/s² for 0.6 s.
    assert!((braked.velocity.north_m_s - 2.8).abs() < 1e-9, "{braked:?}");
    assert!(
        (braked.position.north_m - (10.0 + 0.6 * 0.5 * (7.0 + 2.8))).abs() < 1e-9,
        "{braked:?}"
    );
    // It does not fly backwards.
    let seen = after(&north, 1.5);
    assert!((seen[2].position.north_m - 13.5).abs() < 1e-9, "{seen:?}");
    assert_eq!(seen[2].velocity, VelocityNed::default());
    // And does not drive those beside it away.
    assert!(seen.iter().all(|n| n.uncertainty_m < 2.0), "{seen:?}");
}

#[test]
fn who_stood_is_kept_away_from_over_and_under_its_place_and_no_further() {
    let seen = after(&entry(VelocityNed::default()), 10.0);
    assert_eq!(seen.len(), COLUMN_M.len());
    assert!(
        seen.iter()
            .all(|n| (n.position.north_m, n.position.east_m) == (10.0, 20.0))
    );
    let is_there = seen.iter().filter(|n| n.cooperation == Cooperation::DoesNot);
    assert!(is_there.map(|n| n.position.down_m).eq([-30.0]));
    // On the ground nobody climbs.
    let landed = PeerEntry {
        airborne: false,
        ..entry(VelocityNed::default())
    };
    assert_eq!(after(&landed, 10.0).len(), 1);
}

proptest! {
    /// However it stopped, at once or after a second's flight, and whatever it does then over its place, it is within reach of a place
    /// that is kept away from: there is no gap between two of them wide enough for another.
    #[test]
    fn wherever_on_its_course_it_stopped_it_is_kept_away_from(
        speed_m_s in 0.3..10.0, course_rad in 0.0..std::f64::consts::TAU, within_s in 0.5..2.1, up_m in -10.0..20.0,
        silent_s in 2.1..60.0,
    ) {
        let velocity = VelocityNed::new(speed_m_s * course_rad.cos(), speed_m_s * course_rad.sin(), 0.0);
        let known = entry(velocity);
        let stood = known.kinematics.unwrap().position.after(&velocity, within_s);
        let there = PositionNed { down_m: stood.down_m - up_m, ..stood };
        let seen = after(&known, silent_s);
        prop_assert!(seen.iter().all(|n| n.velocity == VelocityNed::default() && n.cooperation != Cooperation::Shares));
        let near = seen.iter().any(|n| {
            let apart = n.position.vector() - there.vector();
            apart.xy().norm() <= n.uncertainty_m && apart.z.abs() <= 2.5 + 1e-6
        });
        prop_assert!(near, "{there:?}");
    }
}

#[test]
fn a_track_of_our_own_making_is_kept_away_from_as_far_as_it_is_known() {
    let told = TrackEstimate::told(Track {
        track: 4,
        position: PositionNed::new(1.0, 2.0, -3.0),
        velocity: VelocityNed::default(),
        time: at_s(HEARD_S),
        error_m: None,
    });
    assert_eq!(estimated(&told), Some(track(&told.track)), "as it always was");
    let fused = |error_m: f64| TrackEstimate {
        source: TrackSource::Fused,
        covariance_m2: Some([error_m * error_m, 0.0, 0.0, 0.01, 0.0, 0.01]),
        age_s: 2.5,
        ..told.clone()
    };
    let uncertainty_m = |estimate: &TrackEstimate| estimated(estimate).map(|neighbour| neighbour.uncertainty_m);
    assert_eq!(uncertainty_m(&fused(0.5)), Some(2.0));
    assert!((uncertainty_m(&fused(2.5)).expect("is known") - 5.0).abs() < 1e-9);
    assert_eq!(uncertainty_m(&fused(3.5)), None);
    assert!(is_known(&fused(9.5)) && !is_known(&fused(10.5)) && is_known(&told));
    let new = TrackEstimate {
        age_s: 1.0,
        ..fused(0.5)
    };
    assert_eq!(uncertainty_m(&new), None, "it may be nothing");
    assert!(is_known(&new));
    let unsure = TrackEstimate {
        confidence: 0.6,
        ..fused(0.5)
    };
    assert_eq!(uncertainty_m(&unsure), None, "it may be nothing");
    let guessed = TrackEstimate {
        guessed_range: true,
        ..fused(0.5)
    };
    assert_eq!(uncertainty_m(&guessed), None);
    let unsaid = TrackEstimate {
        covariance_m2: None,
        ..fused(0.5)
    };
    assert_eq!(uncertainty_m(&unsaid), None);
}
