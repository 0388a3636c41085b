//! How a link falls off with distance, learned while flying, and how far it reaches.
//!
//! Signal over noise falls by so many decibels per tenfold distance (log-distance path loss). The line is fitted to what was measured,
//! old measurements weighing less and less, and held to what is usual where little was measured yet.

use minicbor::{Decode, Encode};

/// Usual fall per tenfold distance in decibels: twenty in free space, forty near the ground and behind things.
const USUAL_FALL_DB: f64 = 28.0;
/// How far from the usual it may well be, in decibels.
const USUAL_SPREAD_DB: f64 = 7.0;
/// How much a measurement is off by shadows and fading, in decibels.
const SHADOW_DB: f64 = 5.0;
/// No link falls off more gently or more steeply than this, in decibels per tenfold distance.
const FALL_DB: std::ops::RangeInclusive<f64> = 15.0..=50.0;
/// Nearer than this all distances count as one, in metres: antennas are beside each other, and the position is not better known.
const NEAREST_M: f64 = 5.0;
/// Farther than this no range is told, in metres.
const FARTHEST_M: f64 = 1e6;
/// How much has to be measured before anything is said, in seconds.
const ENOUGH_S: f64 = 5.0;
/// A measurement stands for no more time than this, in seconds.
const LONGEST_STEP_S: f64 = 1.0;

/// What was measured, summed up with forgetting.
#[derive(Debug, Clone, Copy, PartialEq, Default, Encode, Decode)]
pub(crate) struct FallOff {
    /// Weight, in seconds of measuring.
    #[n(0)]
    weight_s: f64,
    /// Mean logarithm of the distance.
    #[n(1)]
    mean_x: f64,
    /// Mean signal over noise in decibels.
    #[n(2)]
    mean_y: f64,
    /// Weighted sum of squares of the first about its mean, and of both.
    #[n(3)]
    spread_xx: f64,
    #[n(4)]
    spread_xy: f64,
}

impl FallOff {
    /// Takes a measurement that stands for `step_s` seconds.
    pub(crate) fn learn(&mut self, distance_m: f64, snr_db: f64, step_s: f64, memory_s: f64) {
        if !(distance_m.is_finite() && snr_db.is_finite() && step_s > 0.0) {
            return;
        }
        let step_s = step_s.min(LONGEST_STEP_S);
        let keep = (-step_s / memory_s).exp();
        self.weight_s *= keep;
        self.spread_xx *= keep;
        self.spread_xy *= keep;
        let x = distance_m.max(NEAREST_M).log10();
        let total_s = self.weight_s + step_s;
        let (off_x, off_y) = (x - self.mean_x, snr_db - self.mean_y);
        self.mean_x += off_x * step_s / total_s;
        self.mean_y += off_y * step_s / total_s;
        let share = self.weight_s * step_s / total_s;
        self.spread_xx += off_x * off_x * share;
        self.spread_xy += off_x * off_y * share;
        self.weight_s = total_s;
    }

    /// Fall in decibels per tenfold distance.
    fn fall_db(&self) -> f64 {
        let (noise, usual) = (SHADOW_DB.powi(2), USUAL_SPREAD_DB.powi(2));
        let fall = (-self.spread_xy / noise + USUAL_FALL_DB / usual) / (self.spread_xx / noise + 1.0 / usual);
        fall.clamp(*FALL_DB.start(), *FALL_DB.end())
    }

    /// At what distance the signal is only `margin_db` over the noise, in metres; `None` until enough was measured.
    pub(crate) fn range_m(&self, margin_db: f64) -> Option<f64> {
        if self.weight_s < ENOUGH_S {
            return None;
        }
        let log10 = self.mean_x + (self.mean_y - margin_db) / self.fall_db();
        Some(10_f64.powf(log10.clamp(0.0, FARTHEST_M.log10())))
    }
}

/// Where a vehicle is as seen from the ground station.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Away {
    pub(crate) distance_m: f64,
    /// Growing positive, in metres per second.
    pub(crate) radial_m_s: f64,
}

/// When to warn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Thresholds {
    pub(crate) before_s: f64,
    pub(crate) share: f64,
}

/// The warning ends only when things are better than where it begins by these factors.
const CALM_SHARE: f64 = 0.85;
const CALM_TIME: f64 = 2.0;
/// Slower than this it does not fly away, in metres per second.
const STILL_M_S: f64 = 0.5;

impl Away {
    /// Time until the vehicle is out of range as it flies now, in seconds; `None` if it does not fly away.
    pub(crate) fn out_of_range_in_s(&self, range_m: f64) -> Option<f64> {
        if self.distance_m >= range_m {
            return Some(0.0);
        }
        (self.radial_m_s > STILL_M_S).then(|| (range_m - self.distance_m) / self.radial_m_s)
    }

    /// Whether to warn, given whether that is so already.
    pub(crate) fn warns(&self, range_m: f64, thresholds: Thresholds, warned: bool) -> bool {
        let (share, before_s) = if warned {
            (thresholds.share * CALM_SHARE, thresholds.before_s * CALM_TIME)
        } else {
            (thresholds.share, thresholds.before_s)
        };
        let soon = self.out_of_range_in_s(range_m).is_some_and(|in_s| in_s < before_s);
        self.distance_m > share * range_m || soon
    }
}

#[cfg(test)]
mod tests;
