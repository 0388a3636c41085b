//! How far a vehicle's clock is ahead of the node's, and how that changes with time, from messages that take differently long.
//!
//! Must never do: take a message that was held up for a clock that runs slow.
//!
//! The largest difference of a window is that of the message that took the shortest time. A quartz keeps it for hours. The time of a simulation
//! does not: it runs as fast as the computer computes it.

use skein_domain::NodeTime;

/// How long a window is, in seconds. The first three are shorter, so that a pace is found soon.
const WINDOW_S: f64 = 1.0;
const FIRST_S: f64 = 0.2;
/// A clock that gains or loses more than this on the node's, in seconds per second, is that of a simulation. A quartz gains or loses a hundredth of it.
const PACE_OFF: f64 = 0.01;
/// It may gain or lose so much: from one that stands to one twice as fast as ours.
const PACE_MAX: f64 = 1.0;
/// Nothing is known of the pace after so long without a message, in seconds.
const KEEPS_S: f64 = 3.0;

/// A message that took a short time: the difference to its stamp in microseconds, and when it was heard.
#[derive(Debug, Clone, Copy)]
struct Best {
    ahead_us: i64,
    at: NodeTime,
}

impl Best {
    /// What it says of a later moment, if the clock gains `pace` seconds per second.
    fn later_us(self, now: NodeTime, pace: f64) -> i64 {
        let passed_s = now.seconds_since(self.at).clamp(-KEEPS_S, KEEPS_S);
        self.ahead_us.saturating_add((passed_s * pace * 1e6) as i64)
    }

    /// How much the clock gained since an earlier one, in seconds per second, if that is long enough ago to say.
    fn pace_since(self, earlier: Self) -> Option<f64> {
        let passed_s = self.at.seconds_since(earlier.at);
        let gained_s = self.ahead_us.saturating_sub(earlier.ahead_us) as f64 * 1e-6;
        (passed_s > 0.4 * FIRST_S && passed_s <= KEEPS_S).then(|| gained_s / passed_s)
    }
}

/// The difference of one clock.
#[derive(Debug, Clone, Default)]
pub(super) struct Trend {
    /// Of the present window and the one before.
    now: Option<Best>,
    before: Option<Best>,
    /// When the present window began.
    window: NodeTime,
    windows: u32,
    /// What the clock gains, in seconds per second; nothing for one of quartz.
    pace: f64,
    /// What it gained in the last two windows.
    seen: f64,
}

impl Trend {
    /// A clock of which this is all that is known.
    pub(super) fn new(now: NodeTime, ahead_us: i64) -> Self {
        Self {
            now: Some(Best { ahead_us, at: now }),
            window: now,
            ..Self::default()
        }
    }

    /// How far ahead it is now, in microseconds, if anything was heard.
    pub(super) fn ahead_us(&self, now: NodeTime) -> Option<i64> {
        let later = |best: Best| best.later_us(now, self.pace);
        self.now.map(later).max(self.before.map(later))
    }

    /// Takes in the difference of a message that agrees with what is known.
    pub(super) fn take(&mut self, now: NodeTime, ahead_us: i64) {
        let heard = Best { ahead_us, at: now };
        let window_s = if self.windows < 3 { FIRST_S } else { WINDOW_S };
        if now.seconds_since(self.window) < window_s {
            if self.now.is_none_or(|best| best.later_us(now, self.pace) <= ahead_us) {
                self.now = Some(heard);
            }
            return;
        }
        if let Some(seen) = self.now.zip(self.before).and_then(|(new, old)| new.pace_since(old)) {
            self.note_pace(seen);
        }
        (self.before, self.now, self.window) = (self.now, Some(heard), now);
        self.windows = self.windows.saturating_add(1);
    }

    /// Takes in the difference of a message that stands for itself, as one a second is: one that is `far_us` off is a new clock, or one of another pace.
    pub(super) fn take_any(&mut self, now: NodeTime, ahead_us: i64, far_us: i64) {
        let heard = Best { ahead_us, at: now };
        let is_far = |known: i64| known.saturating_sub(ahead_us).saturating_abs() > far_us;
        if self.ahead_us(now).is_none_or(is_far) {
            let pace = self.now.and_then(|before| heard.pace_since(before));
            *self = Self::new(now, ahead_us);
            self.pace = pace.filter(|pace| pace.abs() <= PACE_MAX).unwrap_or(0.0);
            self.seen = self.pace;
        } else {
            self.take(now, ahead_us);
        }
    }

    /// A message that was held up makes one window slower and the next one faster; a pace lasts.
    fn note_pace(&mut self, seen: f64) {
        let seen = seen.clamp(-PACE_MAX, PACE_MAX);
        let lasts = seen.abs().min(self.seen.abs()) > PACE_OFF && seen * self.seen > 0.0;
        self.pace = if lasts { seen } else { 0.0 };
        self.seen = seen;
    }
}

#[cfg(test)]
mod tests {
    //! Paces, and messages that are held up.

    use super::*;

    /// Messages at this rate for so long, of a clock that is `ahead_s` ahead at the start and gains `pace`; the greatest error once a second has passed.
    fn worst_s(trend: &mut Trend, rate_hz: f64, for_s: f64, pace: f64, delay_s: impl Fn(u32) -> f64) -> f64 {
        let mut worst_s = 0.0_f64;
        for i in 0..(for_s * rate_hz) as u32 {
            let t_s = f64::from(i) / rate_hz;
            let now = NodeTime::from_seconds(10.0 + t_s);
            let truth_s = 5.0 + pace * t_s;
            trend.take_any(now, ((truth_s - delay_s(i)) * 1e6) as i64, 250_000);
            if t_s > 1.0 {
                worst_s = worst_s.max((trend.ahead_us(now).unwrap() as f64 * 1e-6 - truth_s).abs());
            }
        }
        worst_s
    }

    #[test]
    fn a_simulations_pace_is_followed() {
        for pace in [-0.5, -0.1, -0.02, 0.02, 0.5] {
            let worst = worst_s(&mut Trend::default(), 50.0, 20.0, pace, |i| {
                0.001 + f64::from(i % 7) * 0.001
            });
            assert!(worst < 0.03, "{worst} s at {pace}");
        }
    }

    #[test]
    fn one_message_a_second_is_enough() {
        for pace in [-0.5, -0.02, 0.5] {
            let mut trend = Trend::default();
            let worst = worst_s(&mut trend, 1.0, 5.0, pace, |_| 0.002);
            assert!(worst < 0.05, "{worst} s at {pace}");
        }
    }

    #[test]
    fn messages_that_are_held_up_are_no_pace() {
        // Every third second everything takes a tenth of a second longer.
        let worst = worst_s(&mut Trend::default(), 50.0, 30.0, 0.0, |i| {
            if i / 50 % 3 == 2 { 0.1 } else { 0.001 }
        });
        assert!(worst < 0.005, "{worst} s");
    }
}
