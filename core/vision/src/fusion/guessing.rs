//! Ranges that are guessed from how large things look, for as long as one camera alone sees them.

use super::estimate::{Estimate, across};
use super::joining::is_enough;
use super::tracklet::Belongs;
use super::{BELIEVED_AFTER, Observation, SwarmTracker};
use nalgebra::{Matrix3, Vector3};
use skein_domain::NodeTime;

/// A camera's tracklet stays alone for so long before its range is guessed, in seconds.
const ALONE_S: f64 = 1.0;
/// A track is held by a guess when it is known so much worse than that.
const WORSE: f64 = 1.0;
/// A guess of a range says so much less of the other directions.
const BLIND: f64 = 30.0;

impl SwarmTracker {
    /// A camera's tracklet that stays alone, and whose range can be guessed.
    pub(super) fn begin_from_guesses(&mut self, now: NodeTime) {
        for index in 0..self.tracklets.len() {
            let tracklet = &self.tracklets[index];
            let alone = tracklet.belongs == Belongs::Nothing && tracklet.age_s() > ALONE_S && is_enough(tracklet);
            let seen_now = now.seconds_since(tracklet.seen()) < self.settings.sight_lost_s;
            let (Some(guess), true) = (tracklet.guess, alone && seen_now) else {
                continue;
            };
            let Some((
                time,
                Observation::Bearing {
                    origin,
                    direction,
                    error_rad,
                    ..
                },
            )) = tracklet.sightings.back()
            else {
                continue;
            };
            let wide_m = (guess.range_m * error_rad).max(0.1);
            let covariance = ellipsoid(direction, guess.error_m(), wide_m);
            let position = origin + direction * guess.range_m;
            let estimate = Estimate::of_position(*time, &position, &covariance);
            let (scores, worth) = (tracklet.scores.clone(), tracklet.worth());
            if let Some(id) = self.begin(estimate, scores, BELIEVED_AFTER, worth) {
                self.change(id, |track| track.guessed_range = true);
                self.tracklets[index].belongs = Belongs::Track(id);
            }
        }
    }

    /// A track that one camera alone sees is no worse known in range than by how large it looks.
    pub(super) fn hold_by_guesses(&mut self, now: NodeTime) {
        for index in 0..self.tracklets.len() {
            let tracklet = &self.tracklets[index];
            let seen_now = now.seconds_since(tracklet.seen()) < self.settings.sight_lost_s;
            let (Belongs::Track(id), Some(guess), true) = (tracklet.belongs, tracklet.guess, seen_now) else {
                continue;
            };
            let Some((time, Observation::Bearing { origin, direction, .. })) = tracklet.sightings.back() else {
                continue;
            };
            if self.sensors_of(id, now).len() != 1 {
                continue;
            }
            let (time, deep_m) = (*time, guess.error_m());
            let covariance = ellipsoid(direction, deep_m, deep_m * BLIND);
            let position = origin + direction * guess.range_m;
            let (direction, density) = (*direction, self.settings.acceleration_m2_s3);
            let Some(track) = self.tracks.iter_mut().find(|track| track.id == id) else {
                continue;
            };
            let known = direction.dot(&(track.estimate.position_covariance() * direction));
            if known.sqrt() > WORSE * deep_m {
                let seen = Observation::Position { position, covariance };
                track.estimate.correct(time, &seen, density);
            }
        }
    }
}

/// The covariance of a place that is known so well along a direction and across it.
fn ellipsoid(direction: &Vector3<f64>, deep_m: f64, wide_m: f64) -> Matrix3<f64> {
    let deep = direction * direction.transpose() * deep_m.powi(2);
    across(direction)
        .iter()
        .fold(deep, |sum, axis| sum + axis * axis.transpose() * wide_m.powi(2))
}
