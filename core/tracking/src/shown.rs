//! Tracks of the swarm as everybody reads them, and back: what one tracker showed another one goes on with.
//!
//! Must never do: change what is known.

use nalgebra::{Matrix3, Matrix6};
use skein_domain::NodeTime;
use skein_domain::payload::{FIRST_FUSED_TRACK, Track, TrackEstimate, TrackSource, largest_error_m, upper_triangle};
use skein_vision::{ClassScores, Sensor, SwarmSettings, SwarmTrack};

/// How well a velocity is known that another tracker showed, along each axis in m/s: one standard deviation. Covariances of positions are shown, these are not.
const VELOCITY_ERROR_M_S: f64 = 2.0;

/// Greater numbers do not survive JSON.
const LARGEST_NUMBER: u64 = (1 << 53) - 1;

/// The number under which everybody knows a track.
pub(crate) fn number(id: u64) -> u64 {
    FIRST_FUSED_TRACK - 1 + id
}

/// The number under which the tracker knows it; none if it is no track of the swarm's making.
pub(crate) fn id(number: u64) -> Option<u64> {
    (FIRST_FUSED_TRACK..=LARGEST_NUMBER)
        .contains(&number)
        .then(|| number - (FIRST_FUSED_TRACK - 1))
}

/// As everybody reads it.
pub(crate) fn estimate(track: SwarmTrack) -> TrackEstimate {
    let covariance = track.position_covariance();
    TrackEstimate {
        track: Track {
            track: number(track.id),
            position: track.position.into(),
            velocity: track.velocity.into(),
            time: track.time,
            error_m: largest_error_m(&covariance),
        },
        class: track
            .scores
            .best()
            .map_or_else(String::new, |(class, _)| class.to_owned()),
        classes: track
            .scores
            .iter()
            .map(|(class, score)| (class.to_owned(), score))
            .collect(),
        covariance_m2: Some(upper_triangle(&covariance)),
        pinned: track.pinned,
        guessed_range: track.guessed_range,
        age_s: track.age_s,
        confidence: track.confidence,
        seen: track.seen,
        sensors: track.sensors.into_iter().map(|sensor| sensor.0).collect(),
        name: track.name,
        source: TrackSource::Fused,
    }
}

/// As a tracker goes on with it; nothing if it was told, or is not known well enough to go on.
pub(crate) fn taken_over(estimate: &TrackEstimate) -> Option<SwarmTrack> {
    let mut covariance = Matrix6::zeros();
    covariance
        .fixed_view_mut::<3, 3>(0, 0)
        .copy_from(&estimate.position_covariance()?);
    let velocities = Matrix3::from_diagonal_element(VELOCITY_ERROR_M_S * VELOCITY_ERROR_M_S);
    covariance.fixed_view_mut::<3, 3>(3, 3).copy_from(&velocities);
    Some(SwarmTrack {
        id: id(estimate.track.track)?,
        name: estimate.name.clone(),
        pinned: estimate.pinned,
        time: estimate.track.time,
        position: estimate.track.position.vector(),
        velocity: estimate.track.velocity.vector(),
        covariance,
        guessed_range: estimate.guessed_range,
        scores: ClassScores::all(estimate.classes.clone()),
        age_s: estimate.age_s,
        confidence: estimate.confidence,
        seen: estimate.seen,
        sensors: estimate.sensors.iter().cloned().map(Sensor).collect(),
    })
}

/// Whether a track that nobody tells of any more is still shown: as long as a tracker would keep it.
pub(crate) fn is_kept(track: &TrackEstimate, now: NodeTime) -> bool {
    let settings = SwarmSettings::default();
    let most_s = if track.pinned {
        settings.keep_pinned_s
    } else {
        settings.keep_s
    };
    now.seconds_since(track.seen) < most_s
}

#[cfg(test)]
mod tests {
    use super::*;
    use skein_domain::{PositionNed, VelocityNed};
    use std::collections::BTreeMap;

    fn shown() -> TrackEstimate {
        let mut shown = TrackEstimate {
            track: Track {
                track: FIRST_FUSED_TRACK + 4,
                position: PositionNed::new(10.0, -20.0, -30.0),
                velocity: VelocityNed::new(1.0, 2.0, 0.0),
                time: NodeTime::from_seconds(60.0),
                error_m: None,
            },
            name: "visitor".to_owned(),
            class: "drone".to_owned(),
            classes: BTreeMap::from([("bird".to_owned(), 0.2), ("drone".to_owned(), 0.7)]),
            covariance_m2: Some([4.0, 1.0, 0.5, 3.0, 0.25, 2.0]),
            pinned: true,
            guessed_range: false,
            confidence: 0.8,
            age_s: 12.0,
            seen: NodeTime::from_seconds(59.5),
            sensors: vec!["1/camera".to_owned(), "radar".to_owned()],
            source: TrackSource::Fused,
        };
        shown.track.error_m = shown.largest_error_m();
        shown
    }

    #[test]
    fn what_is_shown_can_be_gone_on_with() {
        let track = taken_over(&shown()).expect("is one");
        assert_eq!(track.id, 5);
        assert_eq!(estimate(track), shown());
        let told = TrackEstimate::told(Track {
            track: 4,
            ..shown().track
        });
        assert!(taken_over(&told).is_none());
        assert!(
            taken_over(&TrackEstimate {
                covariance_m2: None,
                ..shown()
            })
            .is_none()
        );
    }

    #[test]
    fn a_track_that_nobody_tells_of_is_shown_for_a_while() {
        let at = NodeTime::from_seconds;
        let plain = TrackEstimate {
            pinned: false,
            ..shown()
        };
        assert!(is_kept(&plain, at(64.0)) && !is_kept(&plain, at(65.0)));
        assert!(is_kept(&shown(), at(89.0)) && !is_kept(&shown(), at(90.0)));
    }
}
