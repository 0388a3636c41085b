//! What one sensor follows under one name, and what that belongs to.

use super::{Observation, RangeGuess, Sensor, Sighting, evidence};
use crate::ClassScores;
use nalgebra::Vector3;
use skein_domain::{NodeTime, VehicleId};
use std::collections::VecDeque;

/// Not seen for so long, a tracklet is forgotten, in seconds.
pub(super) const FORGOTTEN_AFTER_S: f64 = 2.0;
/// So many sightings are remembered.
const MOST: usize = 12;
/// How a tracklet's size follows the newest.
const SIZE_SHARE: f64 = 0.2;
/// At most every so many seconds one is remembered.
const EVERY_S: f64 = 0.095;
/// So many sightings that do not fit, one after the other, take it from its track.
const MISSES: u32 = 6;

/// To what a tracklet belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Belongs {
    Nothing,
    Track(u64),
    Own(VehicleId),
    /// An operator dropped its track.
    Dropped,
}

#[derive(Debug)]
pub(super) struct Tracklet {
    pub(super) sensor: Sensor,
    pub(super) name: u64,
    pub(super) belongs: Belongs,
    pub(super) sightings: VecDeque<(NodeTime, Observation)>,
    pub(super) scores: ClassScores,
    pub(super) guess: Option<RangeGuess>,
    /// How large it looks, in radians.
    pub(super) size_rad: Option<f64>,
    /// The track that predicts it best, and since when.
    pub(super) fits: Option<(u64, NodeTime)>,
    began: NodeTime,
    seen: NodeTime,
    misses: u32,
}

impl Tracklet {
    pub(super) fn new(sensor: Sensor, name: u64) -> Self {
        Self {
            sensor,
            name,
            belongs: Belongs::Nothing,
            sightings: VecDeque::new(),
            scores: ClassScores::default(),
            guess: None,
            size_rad: None,
            fits: None,
            began: NodeTime(0),
            seen: NodeTime(0),
            misses: 0,
        }
    }

    /// Takes a sighting, and says whether it is so much later than the last one that it is remembered. `None` for one that is not newer than the last.
    pub(super) fn remember(&mut self, sighting: &Sighting) -> Option<bool> {
        if !self.sightings.is_empty() && sighting.time <= self.seen {
            return None;
        }
        if self.sightings.is_empty() {
            self.began = sighting.time;
            self.scores = sighting.scores.clone();
        }
        self.seen = sighting.time;
        self.scores.blend(&sighting.scores, 0.1);
        self.guess = sighting.guess.or(self.guess);
        self.size_rad = match (self.size_rad, sighting.size_rad) {
            (Some(before), Some(now)) => Some(before.powf(1.0 - SIZE_SHARE) * now.powf(SIZE_SHARE)),
            (before, now) => now.or(before),
        };
        let due = self
            .sightings
            .back()
            .is_none_or(|(last, _)| sighting.time.seconds_since(*last) >= EVERY_S);
        if due {
            if self.sightings.len() == MOST {
                self.sightings.pop_front();
            }
            self.sightings.push_back((sighting.time, sighting.observation.clone()));
        }
        Some(due)
    }

    /// What all that is remembered of it says together.
    pub(super) fn worth(&self) -> f64 {
        let each = self
            .sightings
            .iter()
            .map(|(_, seen)| evidence::worth(seen, &self.scores));
        each.sum()
    }

    pub(super) fn seen(&self) -> NodeTime {
        self.seen
    }

    /// How long it has been seen, in seconds.
    pub(super) fn age_s(&self) -> f64 {
        self.seen.seconds_since(self.began)
    }

    /// How large it would be at a place, in metres; `None` if nobody says how large it looks.
    pub(super) fn size_at_m(&self, place: &Vector3<f64>) -> Option<f64> {
        match &self.sightings.back()?.1 {
            Observation::Bearing { origin, .. } => Some(self.size_rad? * (place - origin).norm()),
            Observation::Position { .. } => None,
        }
    }

    pub(super) fn is_bearing(&self) -> bool {
        matches!(self.sightings.back(), Some((_, Observation::Bearing { .. })))
    }

    /// Whether the last sighting fitted the track that it belongs to. After several that did not it belongs to nothing.
    pub(super) fn note(&mut self, fitted: bool) {
        self.misses = if fitted { 0 } else { self.misses + 1 };
        if self.misses >= MISSES {
            self.misses = 0;
            self.belongs = Belongs::Nothing;
            // What it saw before may have been another thing.
            let newest = self.sightings.len().saturating_sub(2);
            self.sightings.drain(..newest);
        }
    }
}
