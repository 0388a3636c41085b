//! Tests of what plugins read as tracks, and of the bounds of what waits to become one.

use super::*;
use skein_domain::payload::FIRST_FUSED_TRACK;
use skein_domain::{PositionNed, VelocityNed};
use skein_vision::{ClassScores, Observation, Sensor, Sighting};

fn track(number: u64) -> Track {
    Track {
        track: number,
        position: PositionNed::new(number as f64, 0.0, -20.0),
        velocity: VelocityNed::default(),
        time: NodeTime::from_seconds(1.0),
        error_m: None,
    }
}

fn fused(number: u64) -> TrackEstimate {
    TrackEstimate {
        source: skein_domain::payload::TrackSource::Fused,
        covariance_m2: Some([1.0, 0.0, 0.0, 1.0, 0.0, 1.0]),
        ..TrackEstimate::told(track(number))
    }
}

fn sighting(name: u64) -> Sighting {
    Sighting {
        sensor: Sensor("radar".to_owned()),
        name: Some(name),
        time: NodeTime::from_seconds(1.0),
        observation: Observation::Bearing {
            origin: PositionNed::default().vector(),
            origin_error_m: 0.5,
            direction: PositionNed::new(1.0, 0.0, 0.0).vector(),
            error_rad: 0.01,
        },
        scores: ClassScores::default(),
        guess: None,
        size_rad: None,
    }
}

fn numbers(observed: &Observed) -> Vec<u64> {
    observed.tracks().iter().map(|track| track.track).collect()
}

#[test]
fn plugins_read_what_was_told_and_what_was_made_as_one() {
    let observed = Observed::new(10.0, true);
    let nothing = observed.tracks();
    observed.publish_fused(Vec::new());
    assert!(Arc::ptr_eq(&nothing, &observed.tracks()), "nothing is no news");
    observed.tell_tracks(vec![track(4)]);
    observed.publish_fused(vec![fused(FIRST_FUSED_TRACK)]);
    assert_eq!(numbers(&observed), [4, FIRST_FUSED_TRACK]);
    let strange = observed.strange_tracks(&[], NodeTime::from_seconds(1.0));
    assert_eq!(strange, [TrackEstimate::told(track(4)), fused(FIRST_FUSED_TRACK)]);
    assert!(observed.fused_here().is_some() && observed.tracks_here().is_some());
    observed.hear_fused(vec![fused(FIRST_FUSED_TRACK + 1)]);
    assert!(observed.fused_here().is_none(), "another node made them");
    observed.retain_fused(|_| false);
    assert_eq!(numbers(&observed), [4]);
}

#[test]
fn what_is_made_steers_only_where_the_node_is_set_so_and_its_place_is_known() {
    let (shown, steering) = (Observed::new(10.0, false), Observed::new(10.0, true));
    let guessed = TrackEstimate {
        guessed_range: true,
        ..fused(FIRST_FUSED_TRACK + 1)
    };
    let far = TrackEstimate {
        covariance_m2: Some([400.0, 0.0, 0.0, 1.0, 0.0, 1.0]),
        ..fused(FIRST_FUSED_TRACK + 2)
    };
    let made = vec![fused(FIRST_FUSED_TRACK), guessed, far];
    for observed in [&shown, &steering] {
        observed.publish_fused(made.clone());
        assert_eq!(observed.estimates(), made, "all are shown");
    }
    assert_eq!(numbers(&shown), Vec::<u64>::new());
    assert_eq!(numbers(&steering), [FIRST_FUSED_TRACK]);
    let why = |observed: &Observed, track| observed.steering_track(track).map_err(|refusal| refusal.to_string());
    assert!(why(&shown, FIRST_FUSED_TRACK).is_err_and(|why| why.contains("steer_by_fused")));
    assert!(why(&steering, FIRST_FUSED_TRACK + 2).is_err_and(|why| why.contains("not known well enough")));
    assert_eq!(
        steering.steering_track(FIRST_FUSED_TRACK).map(|track| track.track),
        Ok(FIRST_FUSED_TRACK)
    );
    assert_eq!(steering.steering_track(7), Err(Refusal::UnknownTrack { track: 7 }));
}

#[test]
fn what_waits_is_bounded_and_what_is_left_out_is_counted() {
    let seen = Seen::default();
    assert_eq!(seen.tell((0..5_000).map(sighting)), 4_096);
    let taken = seen.take_told(512);
    assert_eq!(taken.first().and_then(|first| first.name), Some(4_096 - 512));
    assert_eq!(taken.len(), 512);
    assert_eq!(seen.counts().dropped, 4_096 - 512);
    seen.tell_others((0..200).map(sighting).collect());
    let told: Vec<_> = seen.take_for_others().into_iter().filter_map(|one| one.name).collect();
    assert_eq!(told, (72..200).collect::<Vec<_>>());
    seen.hear((0..10).map(sighting).collect());
    assert_eq!(seen.take_heard(512).len(), 10);
    let counts = seen.counts();
    assert_eq!((counts.told, counts.heard, counts.dropped), (4_096, 10, 3_584 + 72));
}
