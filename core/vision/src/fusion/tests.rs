//! Tests of the swarm's tracks: several cameras and targets that cross, against the truth; hand-over, own vehicles, operators, and whatever may
//! come in.

mod believing;
mod world;

use super::*;
use proptest::prelude::*;
use skein_domain::VehicleId;
use world::{Judged, World};

/// So long each seed is flown, in seconds.
const FLIGHT_S: f64 = 40.0;

#[test]
fn four_cameras_follow_six_targets_that_cross_better_than_any_alone() {
    let (mut switched, mut squared, mut samples) = (0, 0.0, 0_u32);
    for seed in 0..10 {
        let together = flown(seed, &[0, 1, 2, 3]);
        let alone = (0..4).map(|camera| flown(seed, &[camera]).error_m());
        let best_alone_m = alone.min_by(f64::total_cmp).unwrap();
        println!(
            "seed {seed}: {together:?}, {:.2} m, alone {best_alone_m:.2} m",
            together.error_m()
        );
        assert!(together.error_m() < 0.1 * best_alone_m);
        assert!(together.error_m() < 1.0 && together.followed() > 0.99);
        assert!(together.strangers < 20);
        switched += u32::from(together.switches > 0);
        squared += together.squared;
        samples += together.samples;
    }
    // Of six dimensions; the samples are not independent of each other, which widens the bounds.
    let mean = squared / f64::from(samples);
    println!("mean squared deviation {mean:.2}, seeds with a change of names {switched}");
    assert!((5.0..7.0).contains(&mean), "{mean}");
    assert!(switched <= 1);
}

fn flown(seed: u64, cameras: &[usize]) -> Judged {
    World::new(seed, 4, 6).fly(FLIGHT_S, cameras)
}

/// A camera at a place that sees a place.
fn seen(camera: &str, name: Option<u64>, time_s: f64, from: [f64; 3], at: [f64; 3]) -> Sighting {
    let origin = Vector3::from(from);
    Sighting {
        sensor: Sensor(camera.to_owned()),
        name,
        time: NodeTime::from_seconds(time_s),
        observation: Observation::Bearing {
            origin,
            origin_error_m: 0.2,
            direction: (Vector3::from(at) - origin).normalize(),
            error_rad: 0.01,
        },
        scores: ClassScores::one("drone", 0.8),
        guess: None,
        size_rad: None,
    }
}

fn radar(name: Option<u64>, time_s: f64, at: [f64; 3]) -> Sighting {
    Sighting {
        sensor: Sensor("radar".to_owned()),
        name,
        time: NodeTime::from_seconds(time_s),
        observation: Observation::Position {
            position: Vector3::from(at),
            covariance: Matrix3::from_diagonal_element(4.0),
        },
        scores: ClassScores::default(),
        guess: None,
        size_rad: None,
    }
}

const WEST: [f64; 3] = [0.0, -60.0, -20.0];
const SOUTH: [f64; 3] = [-60.0, 0.0, -30.0];
const EAST: [f64; 3] = [0.0, 60.0, -25.0];

/// Where the one target is.
fn target(time_s: f64) -> [f64; 3] {
    [2.0 * time_s - 20.0, 0.5 * time_s, -30.0]
}

/// Ten steps a second from one second to another.
fn run(
    tracker: &mut SwarmTracker,
    from_s: f64,
    to_s: f64,
    mut see: impl FnMut(f64) -> Vec<Sighting>,
) -> Vec<SwarmTrack> {
    let steps = ((to_s - from_s) * 10.0).round() as u32;
    for step in 0..steps {
        let time_s = from_s + f64::from(step) / 10.0;
        for sighting in see(time_s) {
            tracker.take(sighting).expect("is sound");
        }
        tracker.step(NodeTime::from_seconds(time_s), &[]);
    }
    tracker.tracks(NodeTime::from_seconds(to_s)).collect()
}

#[test]
fn a_track_keeps_its_number_when_one_camera_after_the_other_loses_sight() {
    let mut tracker = SwarmTracker::new(SwarmSettings::default());
    let tracks = run(&mut tracker, 1.0, 3.0, |t| {
        vec![
            seen("west", Some(1), t, WEST, target(t)),
            seen("south", Some(7), t, SOUTH, target(t)),
        ]
    });
    assert_eq!(tracks.len(), 1);
    let id = tracks[0].id;
    assert_eq!(tracks[0].sensors.len(), 2);
    assert!(
        (tracks[0].position - Vector3::from(target(3.0))).norm() < 1.5,
        "{tracks:?}"
    );
    // One is left, then nobody for a second, then a third one begins with names of its own.
    run(&mut tracker, 3.0, 5.0, |t| {
        vec![seen("west", Some(1), t, WEST, target(t))]
    });
    run(&mut tracker, 5.0, 6.0, |_| vec![]);
    let tracks = run(&mut tracker, 6.0, 8.0, |t| {
        vec![
            seen("east", Some(3), t, EAST, target(t)),
            seen("south", Some(8), t, SOUTH, target(t)),
        ]
    });
    assert_eq!((tracks.len(), tracks[0].id), (1, id), "{tracks:?}");
    assert_eq!(tracks[0].scores.best().unwrap().0, "drone");
    // A pinned one is kept longer than one that is not.
    assert!(tracker.pin(id, true) && tracker.rename(id, "visitor") && !tracker.rename(99, "nobody"));
    let tracks = run(&mut tracker, 8.0, 20.0, |_| vec![]);
    assert_eq!((tracks[0].name.as_str(), tracks[0].pinned), ("visitor", true));
    assert!(tracker.pin(id, false));
    assert!(run(&mut tracker, 20.0, 20.2, |_| vec![]).is_empty());
}

#[test]
fn another_tracker_goes_on_with_the_same_numbers_names_and_places() {
    let mut first = SwarmTracker::new(SwarmSettings::default());
    let alone = [-20.0, -90.0, -40.0];
    let guess = |t: f64| {
        let mut sighting = seen("east", Some(5), t, EAST, alone);
        let range_m = (Vector3::from(alone) - Vector3::from(EAST)).norm();
        sighting.guess = Some(RangeGuess {
            range_m,
            range_factor: 1.5,
        });
        sighting
    };
    let tracks = run(&mut first, 1.0, 6.0, |t| {
        vec![
            seen("west", Some(1), t, WEST, target(t)),
            seen("south", Some(7), t, SOUTH, target(t)),
            guess(t),
        ]
    });
    let (guessed, known): (Vec<_>, Vec<_>) = tracks.iter().partition(|track| track.guessed_range);
    assert_eq!((guessed.len(), known.len()), (1, 1), "{tracks:?}");
    assert!(first.pin(known[0].id, true) && first.rename(known[0].id, "visitor"));
    let handed: Vec<SwarmTrack> = first.tracks(NodeTime::from_seconds(6.0)).collect();

    let mut second = SwarmTracker::new(SwarmSettings::default());
    second.take_over(handed.clone());
    second.take_over(handed);
    // Half a second later it sees, under names of its own.
    let tracks = run(&mut second, 6.5, 9.5, |t| {
        vec![
            seen("west", Some(31), t, WEST, target(t)),
            seen("south", Some(32), t, SOUTH, target(t)),
            guess(t),
        ]
    });
    assert_eq!(tracks.len(), 2, "{tracks:?}");
    let same = tracks
        .iter()
        .find(|track| track.id == known[0].id)
        .expect("is still there");
    assert_eq!((same.name.as_str(), same.pinned), ("visitor", true));
    assert_eq!(same.sensors.len(), 2);
    assert!((same.position - Vector3::from(target(9.5))).norm() < 1.5, "{same:?}");
    assert!((same.age_s - (9.5 - 1.0)).abs() < 1.5, "{}", same.age_s);
    assert!(
        tracks
            .iter()
            .any(|track| track.id == guessed[0].id && track.guessed_range)
    );
    // What comes new gets a new number.
    let tracks = run(&mut second, 9.5, 12.0, |t| vec![radar(Some(5), t, [80.0, 80.0, -60.0])]);
    let newest = tracks.iter().map(|track| track.id).max().expect("is there");
    assert!(newest > known[0].id.max(guessed[0].id));
}

#[test]
fn what_an_operator_drops_does_not_come_back_under_the_same_names() {
    let mut tracker = SwarmTracker::new(SwarmSettings::default());
    let see = |t: f64| {
        vec![
            seen("west", Some(1), t, WEST, target(t)),
            seen("south", Some(7), t, SOUTH, target(t)),
        ]
    };
    let id = run(&mut tracker, 1.0, 3.0, see)[0].id;
    assert!(tracker.drop_track(id) && !tracker.drop_track(id));
    assert!(run(&mut tracker, 3.0, 6.0, see).is_empty());
}

#[test]
fn vehicles_of_the_swarm_are_no_tracks() {
    let mut tracker = SwarmTracker::new(SwarmSettings::default());
    for step in 0..40 {
        let t = 1.0 + f64::from(step) / 10.0;
        let own = OwnVehicle {
            id: VehicleId(3),
            time: NodeTime::from_seconds(t - 0.2),
            position: Vector3::from(target(t - 0.2)),
            velocity: Vector3::new(2.0, 0.5, 0.0),
            error_m: 0.5,
        };
        // Those that carry the cameras explain nothing of what these see.
        let carrier = |id: u16, from: [f64; 3]| OwnVehicle {
            id: VehicleId(id),
            position: Vector3::from(from) + Vector3::new(0.3, -0.2, 0.1),
            velocity: Vector3::zeros(),
            error_m: 1.5,
            ..own
        };
        let all = [carrier(1, WEST), carrier(2, SOUTH), own];
        let stranger = [target(t)[0], target(t)[1] + 12.0, -35.0];
        for (camera, from) in [("west", WEST), ("south", SOUTH)] {
            tracker.take(seen(camera, Some(1), t, from, target(t))).unwrap();
            tracker.take(seen(camera, Some(2), t, from, stranger)).unwrap();
        }
        tracker.take(radar(Some(1), t, target(t))).unwrap();
        tracker.step(NodeTime::from_seconds(t), &all);
    }
    let tracks: Vec<_> = tracker.tracks(NodeTime::from_seconds(5.0)).collect();
    assert_eq!(tracks.len(), 1, "{tracks:?}");
    assert!((tracks[0].position.y - target(5.0)[1] - 12.0).abs() < 2.0);
}

#[test]
fn one_camera_alone_guesses_the_range_and_a_second_one_makes_it_known() {
    let mut tracker = SwarmTracker::new(SwarmSettings::default());
    let guess = |mut sighting: Sighting, range_m: f64| {
        sighting.guess = Some(RangeGuess {
            range_m,
            range_factor: 1.5,
        });
        sighting
    };
    let tracks = run(&mut tracker, 1.0, 6.0, |t| {
        vec![guess(seen("west", Some(1), t, WEST, target(t)), 90.0)]
    });
    assert!(tracks[0].guessed_range);
    let error_m = tracks[0].position_covariance().symmetric_eigenvalues().max().sqrt();
    assert!((20.0..60.0).contains(&error_m), "{error_m}");
    let id = tracks[0].id;
    let tracks = run(&mut tracker, 6.0, 8.0, |t| {
        let west = guess(seen("west", Some(1), t, WEST, target(t)), 90.0);
        vec![west, seen("south", Some(1), t, SOUTH, target(t))]
    });
    assert_eq!((tracks.len(), tracks[0].id, tracks[0].guessed_range), (1, id, false));
    assert!(
        (tracks[0].position - Vector3::from(target(8.0))).norm() < 1.5,
        "{tracks:?}"
    );
}

#[test]
fn positions_of_a_radar_with_and_without_names_become_tracks_and_help_cameras() {
    let mut tracker = SwarmTracker::new(SwarmSettings::default());
    let nameless = |t: f64| vec![radar(None, t, target(t)), radar(None, t, [40.0, 40.0, -60.0])];
    let tracks = run(&mut tracker, 1.0, 4.0, nameless);
    assert_eq!(tracks.len(), 2, "{tracks:?}");
    let id = tracks
        .iter()
        .find(|track| (track.position - Vector3::from(target(4.0))).norm() < 3.0)
        .unwrap()
        .id;
    // A camera goes on with what the radar began.
    let tracks = run(&mut tracker, 4.0, 6.0, |t| {
        let mut all = nameless(t);
        all.push(seen("west", Some(1), t, WEST, target(t)));
        all
    });
    let track = tracks.iter().find(|track| track.id == id).unwrap();
    assert_eq!(track.sensors, [Sensor("west".to_owned())]);
    let mut tracker = SwarmTracker::new(SwarmSettings::default());
    let tracks = run(&mut tracker, 1.0, 4.0, |t| vec![radar(Some(5), t, target(t))]);
    assert_eq!((tracks.len(), tracks[0].sensors.len()), (1, 1));
}

#[test]
fn what_cannot_be_true_is_refused() {
    let mut tracker = SwarmTracker::new(SwarmSettings::default());
    let with = |covariance: Matrix3<f64>| {
        let mut sighting = radar(None, 1.0, [0.0; 3]);
        let position = Vector3::zeros();
        sighting.observation = Observation::Position { position, covariance };
        sighting
    };
    // Singular, negative, lopsided, no number.
    assert_eq!(
        tracker.take(with(Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0)))),
        Err(Unsound::Covariance)
    );
    assert_eq!(tracker.take(with(-Matrix3::identity())), Err(Unsound::Covariance));
    let mut lopsided = Matrix3::identity();
    lopsided[(0, 1)] = 0.5;
    assert_eq!(tracker.take(with(lopsided)), Err(Unsound::Covariance));
    assert_eq!(
        tracker.take(with(Matrix3::from_element(f64::NAN))),
        Err(Unsound::Number)
    );
    let mut short = seen("west", Some(1), 1.0, WEST, target(1.0));
    if let Observation::Bearing { direction, .. } = &mut short.observation {
        *direction *= 0.5;
    }
    assert_eq!(tracker.take(short), Err(Unsound::Direction));
    assert!(run(&mut tracker, 1.0, 2.0, |_| vec![]).is_empty());
}

fn any_sighting() -> impl Strategy<Value = Sighting> {
    let place = || prop::array::uniform3(-200.0..200.0);
    let numbers = (0_u32..4, prop::option::of(0_u64..5), 0.0..30.0, 0.0..1.0);
    (numbers, place(), place(), prop::bool::ANY, 1e-3..50.0).prop_map(
        |((sensor, name, time_s, score), from, at, bearing, error)| {
            let mut sighting = if bearing {
                seen("", name, time_s, from, at)
            } else {
                radar(name, time_s, at)
            };
            match &mut sighting.observation {
                Observation::Bearing { error_rad, .. } => *error_rad = error / 50.0,
                Observation::Position { covariance, .. } => *covariance *= error,
            }
            sighting.sensor = Sensor(sensor.to_string());
            sighting.scores = ClassScores::one("drone", score);
            sighting.guess = (error > 10.0).then_some(RangeGuess {
                range_m: error,
                range_factor: 1.0 + score,
            });
            sighting
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// In any order of time, from anywhere.
    #[test]
    fn whatever_is_seen_tracks_are_sound_and_bounded(sightings in prop::collection::vec(any_sighting(), 0..200)) {
        let settings = SwarmSettings { most_tracks: 10, most_tracklets: 15, ..SwarmSettings::default() };
        let mut tracker = SwarmTracker::new(settings);
        for (index, sighting) in sightings.into_iter().enumerate() {
            let now = sighting.time;
            // A direction from a place to itself is none.
            let _ = tracker.take(sighting);
            if index % 5 == 0 {
                tracker.step(now, &[]);
            }
            prop_assert!(tracker.tracks.len() <= 10 && tracker.tracklets.len() <= 15);
            for track in tracker.tracks(now) {
                prop_assert!(track.position.iter().chain(track.covariance.iter()).all(|part| part.is_finite()), "{track:?}");
                prop_assert!(track.position_covariance().cholesky().is_some(), "{track:?}");
            }
        }
    }
}
