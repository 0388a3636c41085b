//! How long a change takes so that the separation filter has nothing to change: no two close faster on it than the filter lets them.
//!
//! Must never do: know how the filter works. It says how much of what it permits two members use.

use super::clearance::horizontal_m;
use super::detour::{Ways, too_far};
use crate::time_law::{bump_over_time, progress};
use nalgebra::Vector3;
use skein_safety::avoidance::{self, AvoidanceSettings};

/// Two may close at this share of what the filter permits: what they do differs a little from what is planned.
const MAY_USE: f64 = 0.85;
/// States of others are so old in flight, in seconds.
const AGE_S: f64 = 0.1;
/// A pair is looked at so many times over its way.
const LOOKS: u32 = 48;
/// How often the duration is tried again.
const TRIES: usize = 12;
/// A change takes no longer than this many times what its members need for it alone.
const LONGEST: f64 = 2.0;
/// Pairs that never come closer than this many seconds of their fastest approach do not matter.
const REACH_S: f64 = 2.0;

/// Two members that come closer to each other: other minus own at the start, its change over the way, and how much higher the other's
/// detour is.
struct Pair {
    from: Vector3<f64>,
    way: Vector3<f64>,
    lift_m: f64,
}

impl Pair {
    /// The largest share of the speed permitted that they use; nothing if they come so close that no duration would help.
    fn used(&self, duration_s: f64, filter: &AvoidanceSettings) -> f64 {
        let mut looks = (1..LOOKS).map(|k| {
            let s = progress(duration_s * f64::from(k) / f64::from(LOOKS), duration_s);
            let b = bump_over_time(s);
            let lift = Vector3::new(0.0, 0.0, -self.lift_m);
            let apart = self.from + self.way * s.value + lift * b.value;
            let parting = self.way * s.first + lift * b.first;
            avoidance::used_share(&apart, &-parting, AGE_S, filter)
        });
        looks
            .try_fold(0.0, |most, used| Some(f64::max(most, used?)))
            .unwrap_or(0.0)
    }
}

/// The duration in seconds, not less than `at_least_s`.
pub(super) fn duration_s(ways: &Ways, filter: &AvoidanceSettings, at_least_s: f64) -> f64 {
    let pairs = pairs(ways, filter, at_least_s);
    let mut duration_s = at_least_s;
    for _ in 0..TRIES {
        let used = pairs
            .iter()
            .map(|pair| pair.used(duration_s, filter))
            .fold(0.0, f64::max);
        if used <= MAY_USE || duration_s >= LONGEST * at_least_s {
            break;
        }
        duration_s = (duration_s * (used / MAY_USE).clamp(1.01, 1.5)).min(LONGEST * at_least_s);
    }
    duration_s
}

/// All that may come so close and so fast to each other that it matters.
fn pairs(ways: &Ways, filter: &AvoidanceSettings, at_least_s: f64) -> Vec<Pair> {
    let mut pairs = Vec::new();
    let members: Vec<_> = ways.each().collect();
    for (i, (start, end, lift_m)) in members.iter().enumerate() {
        for (other_start, other_end, other_lift_m) in members.iter().skip(i + 1) {
            let pair = Pair {
                from: *other_start - *start,
                way: (*other_end - *other_start) - (*end - *start),
                lift_m: other_lift_m - lift_m,
            };
            let goes_apart = pair.lift_m == 0.0 && pair.from.dot(&pair.way) >= 0.0;
            // No law has more than twice its mean speed.
            let reach_m = 2.0 * filter.min_separation_m + REACH_S * 2.0 * pair.way.norm() / at_least_s.max(1e-3);
            if !goes_apart && !too_far(&pair.from, &pair.way, reach_m) && horizontal_m(&pair.from, &pair.way) < reach_m
            {
                pairs.push(pair);
            }
        }
    }
    pairs
}
