//! How much speaks for a track: what sees it adds to that, time takes from it. A detector that sees what is not there does so with little certainty, now here
//! and now there; what is there is seen again and again.
//!
//! Must never do: say where something is.

use super::{Observation, Sighting};
use crate::{ClassScores, UNKNOWN_CLASS};
use skein_domain::NodeTime;

/// In this time, in seconds, what was seen counts half.
const HALF_LIFE_S: f64 = 2.0;
/// From so much on a track is told of.
const TOLD_FROM: f64 = 0.6;
/// Below so much it is told of no more.
const DOUBTED_BELOW: f64 = 0.1;
/// What a position says.
const POSITION: f64 = 0.8;
/// What a bearing says whose class has the score 1: it counts by the square of the score, since what is not there has small ones. Ten a second of each sensor
/// count at most: one that looks more often sees the same cloud more often.
const BEARING: f64 = 0.5;
/// What a bearing says of which nobody knows what it is of, such as a direction finder's, or of something that only moves.
const UNKNOWN_BEARING: f64 = 0.02;

/// What speaks for a track.
#[derive(Debug, Clone, Copy)]
pub(super) struct Evidence {
    amount: f64,
    time: NodeTime,
    told: bool,
}

impl Evidence {
    pub(super) fn new(time: NodeTime, amount: f64) -> Self {
        Self {
            amount,
            time,
            told: amount >= TOLD_FROM,
        }
    }

    /// One more sighting.
    pub(super) fn add(&mut self, sighting: &Sighting) {
        self.amount = self.at(sighting.time) + worth(&sighting.observation, &sighting.scores);
        self.time = self.time.max(sighting.time);
        self.told |= self.amount >= TOLD_FROM;
    }

    /// Another track turns out to be the same one.
    pub(super) fn join(&mut self, other: &Self) {
        let time = self.time.max(other.time);
        let told = self.told || other.told;
        *self = Self::new(time, self.at(time) + other.at(time));
        self.told |= told;
    }

    /// Whether there is enough to tell of the track.
    pub(super) fn is_told(&self, now: NodeTime) -> bool {
        self.told && self.at(now) >= DOUBTED_BELOW
    }

    /// How sure it is that something is there, 0..=1: half where a track begins to be told of.
    pub(super) fn confidence(&self, now: NodeTime) -> f64 {
        let amount = self.at(now);
        amount / (amount + TOLD_FROM)
    }

    /// As another tracker had it.
    pub(super) fn of(time: NodeTime, confidence: f64) -> Self {
        let confidence = confidence.clamp(0.5, 0.95);
        Self::new(time, TOLD_FROM * confidence / (1.0 - confidence))
    }

    fn at(&self, now: NodeTime) -> f64 {
        let since_s = now.seconds_since(self.time).max(0.0);
        self.amount * 0.5_f64.powf(since_s / HALF_LIFE_S)
    }
}

/// What a sighting says.
pub(super) fn worth(seen: &Observation, scores: &ClassScores) -> f64 {
    match seen {
        Observation::Position { .. } => POSITION,
        Observation::Bearing { .. } => {
            let known = scores.iter().filter(|(class, _)| *class != UNKNOWN_CLASS);
            let score = known.fold(0.0, |best: f64, (_, score)| best.max(score));
            (BEARING * score * score).max(UNKNOWN_BEARING)
        }
    }
}
