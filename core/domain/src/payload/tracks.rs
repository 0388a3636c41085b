//! What is tracked: where something that is no vehicle of the swarm is and goes, how well that is known, and who says so.
//!
//! Must never do: decide what belongs together; that is the fusion's.

use crate::{NodeTime, PositionNed, VelocityNed};
use minicbor::{Decode, Encode};
use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Tracks that the swarm makes itself have numbers from here up. What is told to it has lower ones, so that the two are never taken for each other.
pub const FIRST_FUSED_TRACK: u64 = 1_000_001;

/// Something tracked: where it is and where it goes, in the swarm frame.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Track {
    /// Its number.
    #[n(0)]
    #[schemars(range(max = 9_007_199_254_740_991_u64))]
    pub track: u64,
    /// Where it was at `time`.
    #[n(1)]
    pub position: PositionNed,
    /// Its velocity at `time`.
    #[n(2)]
    pub velocity: VelocityNed,
    /// When that was, on the node's clock.
    #[n(3)]
    pub time: NodeTime,
    /// Standard deviation of the position in metres, along the direction in which it is known worst; null if nobody says.
    #[n(4)]
    #[serde(default)]
    pub error_m: Option<f64>,
}

/// Who says that something is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TrackSource {
    /// Somebody told the swarm of the track as it is.
    Told,
    /// The swarm made it of what its cameras and other sensors saw.
    Fused,
}

/// Something tracked, with all that is known of it.
#[derive(Debug, Clone, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct TrackEstimate {
    /// Number, place, velocity and time.
    #[serde(flatten)]
    pub track: Track,
    /// What an operator calls it; empty if nobody named it.
    pub name: String,
    /// What it is most likely; empty if nobody says.
    pub class: String,
    /// What it may be: the score of each class, 0..=1.
    pub classes: BTreeMap<String, f64>,
    /// Covariance of its position along north, east and down, in square metres: north-north, north-east, north-down, east-east, east-down,
    /// down-down. Null if nobody says.
    pub covariance_m2: Option<[f64; 6]>,
    /// An operator wants it kept.
    pub pinned: bool,
    /// Its range is only guessed from how large it looks: one camera alone has seen it so far.
    pub guessed_range: bool,
    /// How sure it is that something is there at all, 0..=1, from how surely it is seen again and again. What was told is sure.
    pub confidence: f64,
    /// Since it began, in seconds.
    pub age_s: f64,
    /// When it was last seen, on the node's clock.
    pub seen: NodeTime,
    /// Who sees it now: `VEHICLE/CAMERA`, or the source that tells of it over the API.
    pub sensors: Vec<String>,
    /// Who says that it is there.
    pub source: TrackSource,
}

impl TrackEstimate {
    /// One that was told as it is, of which nothing else is known.
    #[must_use]
    pub fn told(track: Track) -> Self {
        Self {
            track,
            name: String::new(),
            class: String::new(),
            classes: BTreeMap::new(),
            covariance_m2: None,
            pinned: false,
            guessed_range: false,
            confidence: 1.0,
            age_s: 0.0,
            seen: track.time,
            sensors: Vec::new(),
            source: TrackSource::Told,
        }
    }

    /// The covariance of its position as a matrix, if it is said and is one.
    #[must_use]
    pub fn position_covariance(&self) -> Option<Matrix3<f64>> {
        let parts = self.covariance_m2?;
        parts.iter().all(|part| part.is_finite()).then(|| symmetric(parts))
    }

    /// Standard deviation of its position in metres, along the direction in which it is known worst.
    #[must_use]
    pub fn largest_error_m(&self) -> Option<f64> {
        largest_error_m(&self.position_covariance()?)
    }
}

/// Standard deviation along the direction in which a position of this covariance in square metres is known worst, in metres.
#[must_use]
pub fn largest_error_m(covariance: &Matrix3<f64>) -> Option<f64> {
    let largest = covariance.symmetric_eigenvalues().max();
    (largest >= 0.0).then(|| largest.sqrt())
}

/// A symmetric matrix of its upper triangle, row by row.
#[must_use]
pub fn symmetric([nn, ne, nd, ee, ed, dd]: [f64; 6]) -> Matrix3<f64> {
    Matrix3::new(nn, ne, nd, ne, ee, ed, nd, ed, dd)
}

/// The upper triangle of a symmetric matrix, row by row.
#[must_use]
pub fn upper_triangle(matrix: &Matrix3<f64>) -> [f64; 6] {
    [
        matrix[(0, 0)],
        matrix[(0, 1)],
        matrix[(0, 2)],
        matrix[(1, 1)],
        matrix[(1, 2)],
        matrix[(2, 2)],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(covariance_m2: Option<[f64; 6]>) -> TrackEstimate {
        let track = Track {
            track: FIRST_FUSED_TRACK,
            position: PositionNed::new(1.0, 2.0, -3.0),
            velocity: VelocityNed::new(0.5, 0.0, 0.0),
            time: NodeTime(7),
            error_m: None,
        };
        TrackEstimate {
            covariance_m2,
            ..TrackEstimate::told(track)
        }
    }

    #[test]
    fn the_largest_error_is_that_of_the_worst_direction() {
        // Known to 1 m across, to 5 m along north-east.
        let along = nalgebra::Vector3::new(1.0, 1.0, 0.0).normalize();
        let covariance = Matrix3::identity() + along * along.transpose() * 24.0;
        let error_m = estimate(Some(upper_triangle(&covariance))).largest_error_m().unwrap();
        assert!((error_m - 5.0).abs() < 1e-9, "{error_m}");
        assert_eq!(symmetric(upper_triangle(&covariance)), covariance);
        assert_eq!(estimate(None).largest_error_m(), None);
        assert_eq!(estimate(Some([f64::NAN; 6])).largest_error_m(), None);
    }

    #[test]
    fn in_json_it_is_a_track_with_more_beside_it() {
        let told = estimate(None);
        let json = serde_json::to_value(&told).unwrap();
        let plain = serde_json::to_value(told.track).unwrap();
        for (key, value) in plain.as_object().unwrap() {
            assert_eq!(json.get(key), Some(value));
        }
        assert_eq!(json["source"], "told");
        assert_eq!(serde_json::from_value::<TrackEstimate>(json).unwrap(), told);
    }
}
