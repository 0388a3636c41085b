//! Tests of tracks in the picture: names that last through crossings and gaps, births, deaths, and whatever a detector may say.

use super::*;
use proptest::prelude::*;

fn at(center_x_px: f64, center_y_px: f64, class: &str, score: f64) -> Found {
    let bounds = Bounds {
        center_x_px,
        center_y_px,
        width_px: 14.0,
        height_px: 10.0,
    };
    Found {
        bounds,
        scores: ClassScores::one(class, score),
    }
}

fn picture(index: u32) -> NodeTime {
    NodeTime::from_seconds(f64::from(index) / 30.0)
}

fn told(tracker: &PictureTracker) -> Vec<PictureTrack> {
    tracker.tracks().collect()
}

#[test]
fn one_box_is_no_track_and_three_are() {
    let mut tracker = PictureTracker::new(PictureSettings::default());
    for index in 0..3 {
        assert!(told(&tracker).is_empty());
        tracker.take(
            picture(index),
            &Turn::default(),
            vec![at(100.0 + f64::from(index), 50.0, "drone", 0.9)],
        );
    }
    let tracks = told(&tracker);
    assert_eq!((tracks.len(), tracks[0].id, tracks[0].coasted_s), (1, 1, 0.0));
    assert_eq!(tracks[0].scores.best().unwrap().0, "drone");
    // A doubtful box goes on with it, but begins none.
    tracker.take(
        picture(3),
        &Turn::default(),
        vec![at(103.0, 50.0, "drone", 0.2), at(200.0, 50.0, "drone", 0.2)],
    );
    assert_eq!(told(&tracker).len(), 1);
    assert_eq!(told(&tracker)[0].coasted_s, 0.0);
}

#[test]
fn two_that_cross_keep_their_names() {
    let mut tracker = PictureTracker::new(PictureSettings::default());
    let places = |index: u32| (60.0 + 3.0 * f64::from(index), 180.0 - 3.0 * f64::from(index));
    let mut names = Vec::new();
    for index in 0..40 {
        let (right, left) = places(index);
        let mut found = vec![at(right, 100.0, "drone", 0.9), at(left, 104.0, "bird", 0.9)];
        // Where they are one before the other only one is found.
        if (18..23).contains(&index) {
            found.truncate(1);
        }
        tracker.take(picture(index), &Turn::default(), found);
        if index == 10 {
            names = told(&tracker).iter().map(|track| track.id).collect();
        }
    }
    let (right, _) = places(39);
    let tracks = told(&tracker);
    assert_eq!(tracks.iter().map(|track| track.id).collect::<Vec<_>>(), names);
    let first = tracks.iter().find(|track| track.id == 1).unwrap();
    assert!((first.bounds.center_x_px - right).abs() < 3.0, "{first:?}");
    assert_eq!(first.scores.best().unwrap().0, "drone");
}

#[test]
fn two_tracks_of_one_thing_become_the_older_one() {
    let mut tracker = PictureTracker::new(PictureSettings::default());
    for index in 0..60 {
        // Two boxes that come to lie over each other, as of a detector that finds one thing twice.
        let apart_px = (20.0 - f64::from(index)).max(1.0);
        let found = vec![at(100.0, 50.0, "drone", 0.9), at(100.0 + apart_px, 50.0, "drone", 0.8)];
        tracker.take(picture(index), &Turn::default(), found);
        let names: Vec<u64> = told(&tracker).iter().map(|track| track.id).collect();
        match index {
            0..2 => assert!(names.is_empty()),
            2..18 => assert_eq!(names, [1, 2]),
            // What is found twice begins a track again and again, which ends before long.
            40.. => assert!(names.contains(&1) && names.len() <= 2, "{names:?}"),
            _ => {}
        }
    }
}

#[test]
fn a_gap_is_coasted_through_and_a_long_one_ends_it() {
    let mut tracker = PictureTracker::new(PictureSettings::default());
    for index in 0..15 {
        tracker.take(
            picture(index),
            &Turn::default(),
            vec![at(100.0 + 2.0 * f64::from(index), 50.0, "drone", 0.9)],
        );
    }
    for index in 15..30 {
        tracker.take(picture(index), &Turn::default(), vec![]);
    }
    let track = told(&tracker).remove(0);
    assert!((track.bounds.center_x_px - 158.0).abs() < 4.0, "{track:?}");
    assert!((track.coasted_s - 0.5).abs() < 1e-6 && track.error_px > 2.0);
    tracker.take(picture(30), &Turn::default(), vec![at(160.0, 50.0, "drone", 0.9)]);
    assert_eq!(told(&tracker)[0].id, 1);
    for index in 31..65 {
        tracker.take(picture(index), &Turn::default(), vec![]);
    }
    assert!(told(&tracker).is_empty());
}

#[test]
fn the_motion_of_the_camera_is_taken_out() {
    let mut tracker = PictureTracker::new(PictureSettings::default());
    for index in 0..10 {
        tracker.take(picture(index), &Turn::default(), vec![at(100.0, 50.0, "drone", 0.9)]);
    }
    // It is turned quickly: everything jumps, and nothing changes its name.
    tracker.take(
        picture(10),
        &Turn::default().put_right(Some((80.0, -20.0))),
        vec![at(180.0, 30.0, "drone", 0.9)],
    );
    let track = told(&tracker).remove(0);
    assert_eq!((track.id, track.coasted_s), (1, 0.0));
}

#[test]
fn a_few_wrong_names_do_not_change_the_class() {
    let mut tracker = PictureTracker::new(PictureSettings::default());
    for index in 0..60 {
        let class = if index % 4 == 3 { "bird" } else { "drone" };
        tracker.take(picture(index), &Turn::default(), vec![at(100.0, 50.0, class, 0.8)]);
    }
    let track = told(&tracker).remove(0);
    assert!(
        track.scores.of("drone") > 2.0 * track.scores.of("bird"),
        "{:?}",
        track.scores
    );
}

/// The track of something 14 pixels wide after two seconds. It moves by `moves_px` from picture to picture, and the scene behind it by `scene_px`.
fn after_two_s(moves_px: f64, scene_px: f64) -> PictureTrack {
    let mut tracker = PictureTracker::new(PictureSettings::default());
    for index in 0..60 {
        // Boxes wander by a pixel.
        let wander_px = if index % 2 == 0 { 0.5 } else { -0.5 };
        let found = at(300.0 + moves_px * f64::from(index) + wander_px, 50.0, "drone", 0.8);
        let turn = Turn::default().put_right(Some((scene_px, 0.0)));
        tracker.take(picture(index), &turn, vec![found]);
    }
    told(&tracker).remove(0)
}

#[test]
fn what_moves_with_the_scene_has_not_moved() {
    assert!(!after_two_s(0.0, 0.0).moved);
    assert!(!after_two_s(2.0, 2.0).moved, "the camera turns, and it stands");
    assert!(after_two_s(0.0, 2.0).moved, "the camera follows it");
    assert!(after_two_s(0.1, 0.0).moved, "a fifth of its size in a second");
}

#[test]
fn what_has_moved_once_does_not_become_a_part_of_the_scene() {
    let mut tracker = PictureTracker::new(PictureSettings::default());
    for index in 0..300_u32 {
        let x_px = 100.0 + f64::from(index.min(30));
        tracker.take(picture(index), &Turn::default(), vec![at(x_px, 50.0, "drone", 0.8)]);
    }
    let track = told(&tracker).remove(0);
    assert!(track.moved && track.age_s > 9.0);
}

proptest! {
    #[test]
    fn whatever_is_found_the_tracks_are_sound_and_bounded(
        pictures in prop::collection::vec(
            prop::collection::vec((any::<f64>(), -50.0..700.0, any::<f64>(), -5.0..90.0, -0.5..1.5), 0..20), 0..30),
        moved in (-1e3..1e3, -1e3..1e3),
    ) {
        let mut tracker = PictureTracker::new(PictureSettings { most_tracks: 8, ..PictureSettings::default() });
        for (index, boxes) in pictures.into_iter().enumerate() {
            let found = boxes.into_iter().enumerate().map(|(which, (wild, tame, wild_size, size, score))| {
                let (center, width_px) = if which % 5 == 0 { (wild, wild_size) } else { (tame, size) };
                let bounds = Bounds { center_x_px: center, center_y_px: tame, width_px, height_px: size };
                Found { bounds, scores: ClassScores::one("drone", score) }
            });
            tracker.take(picture(index as u32), &Turn::default().put_right(Some(moved)), found.collect());
            let tracks = told(&tracker);
            prop_assert!(tracks.len() <= 8);
            for track in &tracks {
                prop_assert!(track.bounds.is_sound(), "{track:?}");
                prop_assert!(track.error_px.is_finite() && track.scores.best().is_some());
            }
            let mut names: Vec<u64> = tracks.iter().map(|track| track.id).collect();
            names.dedup();
            prop_assert_eq!(names.len(), tracks.len());
        }
    }
}
