//! What is told of: what is seen again and again and with certainty, not what a detector takes for something now and then.

use super::{EAST, SOUTH, WEST, radar, run, seen, target};
use crate::ClassScores;
use crate::fusion::{OwnVehicle, RangeGuess, Sensor, Sighting, SwarmSettings, SwarmTracker};
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

/// A camera sees a target all along, while a vehicle of the swarm flies away from it below the target, seen or not: the target's track is led nowhere.
#[test]
fn a_vehicle_of_ours_that_passes_in_front_of_a_track_does_not_take_it() {
    let (first, second) = ([0.0, 0.0, -20.0], [0.0, 10.0, -20.0]);
    // On a circle of 8 m around a place 40 m north, 2 m/s.
    let at = |t: f64| {
        let angle_rad = (t - 1.0) / 4.0;
        [40.0 + 8.0 * angle_rad.cos(), 5.0 + 8.0 * angle_rad.sin(), -25.0]
    };
    for ours_is_seen in [true, false] {
        let mut tracker = SwarmTracker::new(SwarmSettings::default());
        let see = |t: f64| {
            vec![
                seen("1/camera", Some(1), t, first, at(t)),
                seen("2/camera", Some(1), t, second, at(t)),
            ]
        };
        let id = run(&mut tracker, 1.0, 4.0, see)[0].id;
        assert!(tracker.pin(id, true));
        // The second one flies there and looks at the ground on its way; the first one alone sees the target.
        for step in 0..60 {
            let t = 4.0 + f64::from(step) / 10.0;
            let way_s = t - 4.0;
            let ours = Vector3::new(0.45 * way_s * way_s, 5.0 - 0.1 * way_s, -20.0);
            let own = [OwnVehicle {
                id: VehicleId(2),
                time: NodeTime::from_seconds(t - 0.1),
                position: ours + Vector3::new(0.3, 0.2, 0.3),
                velocity: Vector3::new(0.9 * way_s, -0.1, 0.0),
                error_m: 1.5,
            }];
            tracker
                .take(seen("1/camera", Some(1), t, first, at(t)))
                .expect("is sound");
            if ours_is_seen && ours.x > 3.0 {
                tracker
                    .take(seen("1/camera", Some(2), t, first, ours.into()))
                    .expect("is sound");
            }
            tracker.step(NodeTime::from_seconds(t), &own);
            let tracks: Vec<_> = tracker.tracks(NodeTime::from_seconds(t)).collect();
            assert_eq!(tracks.len(), 1, "{t:.1} s, seen {ours_is_seen}: {tracks:?}");
            if ours_is_seen && t > 6.0 {
                assert_eq!(
                    tracks[0].sensors,
                    [Sensor("1/camera".to_owned())],
                    "{t:.1} s, seen {ours_is_seen}"
                );
            }
            let off = tracks[0].position - Vector3::from(at(t));
            let across_m = off
                .cross(&(Vector3::from(at(t)) - Vector3::from(first)).normalize())
                .norm();
            assert!(across_m < 2.0, "{t:.1} s, seen {ours_is_seen}: {across_m:.1} m beside");
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

/// A third camera does not know well for a while where it looks, and begins a track of its own of what the other two know.
#[test]
fn what_one_camera_guesses_joins_what_others_know() {
    for named in [false, true] {
        let mut tracker = SwarmTracker::new(SwarmSettings::default());
        let see = |t: f64| {
            let off_m = if t < 6.0 { 8.0 } else { 0.0 };
            let [north_m, east_m, down_m] = target(t);
            let east = Sighting {
                guess: Some(RangeGuess {
                    range_m: 12.0,
                    range_factor: 1.2,
                }),
                ..seen("east", Some(1), t, EAST, [north_m, east_m, down_m + off_m])
            };
            let known =
                [("west", WEST), ("south", SOUTH)].map(|(camera, from)| seen(camera, Some(1), t, from, target(t)));
            known.into_iter().chain((t > 3.0).then_some(east)).collect()
        };
        let tracks = run(&mut tracker, 1.0, 6.0, see);
        let guessed = tracks.iter().find(|track| track.guessed_range).expect("of its own");
        assert_eq!(tracks.len(), 2, "{tracks:?}");
        if named {
            tracker.rename(guessed.id, "visitor");
        }
        let tracks = run(&mut tracker, 6.0, 12.0, see);
        assert_eq!(tracks.len(), 1, "{tracks:?}");
        assert!(!tracks[0].guessed_range && tracks[0].sensors.len() == 3, "{tracks:?}");
        assert!((tracks[0].position - Vector3::from(target(12.0))).norm() < 1.0);
        assert_eq!(tracks[0].name, if named { "visitor" } else { "" });
    }
}

/// What a camera calls by one name jumps to something else, which flies away from what the other cameras see.
#[test]
fn a_camera_that_goes_on_with_something_else_does_not_lead_the_track_away() {
    let mut tracker = SwarmTracker::new(SwarmSettings::default());
    let see = |t: f64| {
        let away = Vector3::new(0.0, 0.0, 1.5 + 3.0 * (t - 4.0)) * f64::from(u8::from(t > 4.0));
        let other = Vector3::from(target(t)) + away;
        vec![
            seen("east", Some(1), t, EAST, other.into()),
            seen("west", Some(1), t, WEST, target(t)),
            seen("south", Some(1), t, SOUTH, target(t)),
        ]
    };
    let mut worst_m = 0.0_f64;
    for step in 0..80 {
        let t = 1.0 + f64::from(step) / 10.0;
        let tracks = run(&mut tracker, t, t + 0.1, see);
        if t > 3.0 {
            worst_m = worst_m.max((tracks[0].position - Vector3::from(target(t + 0.1))).norm());
        }
    }
    assert!(worst_m < 0.8, "{worst_m:.1} m");
}
