//! What is told of: what is seen again and again and with certainty, not what a detector takes for something now and then.

use super::{EAST, SOUTH, WEST, radar, run, seen, target};
use crate::ClassScores;
use crate::fusion::{OwnVehicle, RangeGuess, Sighting, SwarmSettings, SwarmTracker};
use nalgebra::Vector3;
use proptest::prelude::*;
use skein_domain::{NodeTime, VehicleId};

/// A bearing of something that looks so large that its range can be guessed.
fn guessed(time_s: f64, scores: ClassScores) -> Sighting {
    Sighting {
        scores,
        guess: Some(RangeGuess {
            range_m: 60.0,
            range_factor: 1.5,
        }),
        ..seen("west", Some(1), time_s, WEST, target(time_s))
    }
}

#[test]
fn what_one_camera_sees_is_told_of_if_it_is_sure_of_it_and_not_if_it_is_not() {
    for (score, told) in [(0.15, 0), (0.2, 0), (0.35, 1), (0.8, 1)] {
        let mut tracker = SwarmTracker::new(SwarmSettings::default());
        let tracks = run(&mut tracker, 1.0, 12.0, |t| {
            vec![guessed(t, ClassScores::one("drone", score))]
        });
        assert_eq!(tracks.len(), told, "score {score}");
    }
}

#[test]
fn what_only_moves_is_told_of_when_two_cameras_follow_it() {
    let unknown = |sighting: Sighting| Sighting {
        scores: ClassScores::one("unknown", 0.5),
        ..sighting
    };
    let both = |t: f64| {
        vec![
            unknown(seen("west", Some(1), t, WEST, target(t))),
            unknown(seen("south", Some(1), t, SOUTH, target(t))),
        ]
    };
    let mut tracker = SwarmTracker::new(SwarmSettings::default());
    assert_eq!(run(&mut tracker, 1.0, 6.0, both).len(), 1);
    // What is there for a moment and then not is told of no more, before it is forgotten.
    let mut tracker = SwarmTracker::new(SwarmSettings::default());
    assert_eq!(run(&mut tracker, 1.0, 2.0, both).len(), 0);
    assert_eq!(run(&mut tracker, 2.0, 4.0, |_| Vec::new()).len(), 0);
}

#[test]
fn a_radar_that_turns_slowly_is_believed_and_what_an_operator_pins_stays() {
    let mut tracker = SwarmTracker::new(SwarmSettings::default());
    let slowly = |t: f64| {
        if ((t * 10.0).round() as u32).is_multiple_of(20) {
            vec![radar(None, t, target(t))]
        } else {
            Vec::new()
        }
    };
    let tracks = run(&mut tracker, 1.0, 8.0, slowly);
    assert_eq!(tracks.len(), 1);
    assert!(tracker.pin(tracks[0].id, true));
    let tracks = run(&mut tracker, 8.0, 20.0, |_| Vec::new());
    assert_eq!(tracks.len(), 1, "12 s without a sighting");
}

proptest! {
    /// A vehicle of the swarm is no track, however near it flies to the camera, as long as its telemetry is right.
    #[test]
    fn a_vehicle_of_ours_is_no_track_near_or_far(way in (3.0..60.0f64, -1.0..1.0f64), off in prop::array::uniform3(-0.5..0.5f64)) {
        let (far_m, aside) = way;
        let of = |camera: [f64; 3]| {
            let towards = (Vector3::from([0.0, 0.0, -25.0]) - Vector3::from(camera)).normalize();
            Vector3::from(camera) + (towards + Vector3::new(0.0, 0.0, 0.3 * aside)).normalize() * far_m
        };
        let at = of(EAST);
        let own = [OwnVehicle {
            id: VehicleId(4),
            time: NodeTime::from_seconds(1.0),
            position: at + Vector3::from(off),
            velocity: Vector3::zeros(),
            error_m: 1.5,
        }];
        let mut tracker = SwarmTracker::new(SwarmSettings::default());
        for step in 0..50 {
            let time_s = 1.0 + f64::from(step) * 0.1;
            for (camera, from) in [("east", EAST), ("south", SOUTH)] {
                let sighting = seen(camera, Some(1), time_s, from, at.into());
                let guess = Some(RangeGuess { range_m: 0.8 * far_m, range_factor: 1.5 });
                tracker.take(Sighting { guess, ..sighting }).expect("is sound");
            }
            tracker.step(NodeTime::from_seconds(time_s), &own);
            prop_assert_eq!(tracker.tracks(NodeTime::from_seconds(time_s)).count(), 0);
        }
    }
}

#[test]
fn what_would_be_a_grain_to_one_camera_and_a_barn_to_the_other_is_not_one_thing() {
    let sized = |sighting: Sighting, size_rad: f64| Sighting {
        size_rad: Some(size_rad),
        ..sighting
    };
    for (south_rad, told) in [(0.02, 1), (0.04, 1), (0.2, 0), (0.002, 0)] {
        let mut tracker = SwarmTracker::new(SwarmSettings::default());
        let tracks = run(&mut tracker, 1.0, 6.0, |t| {
            vec![
                sized(seen("west", Some(1), t, WEST, target(t)), 0.02),
                sized(seen("south", Some(1), t, SOUTH, target(t)), south_rad),
            ]
        });
        assert_eq!(tracks.len(), told, "{south_rad} rad");
    }
}
