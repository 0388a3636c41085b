//! When a failed actor or plugin is started again: pure policy with named limits. The caller passes the time and a random number.

use skein_domain::NodeTime;
use std::collections::VecDeque;

/// Limits of one kind of restart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RestartLimits {
    /// Delay before the first restart in seconds. Zero in flight: the link holds position meanwhile.
    pub first_delay_s: f64,
    /// Delay before the second restart within the window, in seconds; doubled for each further one.
    pub base_delay_s: f64,
    /// No delay is longer than this, in seconds.
    pub max_delay_s: f64,
    /// Share of a delay that is drawn at random on top, so that many that failed together do not start together.
    pub jitter: f64,
    /// More failures than this within the window: give up and escalate.
    pub max_failures: usize,
    /// The window in seconds.
    pub window_s: f64,
}

/// A vehicle's actor or its UAV-model plugin. Eight failures in a minute are no accident; the vehicle is then held by its autopilot.
pub const VEHICLE_LIMITS: RestartLimits = RestartLimits {
    first_delay_s: 0.0,
    base_delay_s: 0.05,
    max_delay_s: 2.0,
    jitter: 0.2,
    max_failures: 8,
    window_s: 60.0,
};

/// Parts of the node itself (fleet, coordinator, pulse, endpoints). They are tried for ever, but slower: without them nothing flies.
pub const NODE_LIMITS: RestartLimits = RestartLimits {
    first_delay_s: 0.0,
    base_delay_s: 0.1,
    max_delay_s: 5.0,
    jitter: 0.2,
    max_failures: usize::MAX,
    window_s: 60.0,
};

/// What to do about a failure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Decision {
    /// Start again after so many seconds.
    RestartAfter(f64),
    /// Do not start again by itself; escalate.
    GiveUp,
}

/// The failures of one actor or plugin within the window.
#[derive(Debug, Clone, Default)]
pub struct RestartHistory {
    failures: VecDeque<NodeTime>,
}

impl RestartHistory {
    /// Records a failure at `now` and decides. `random` is 0..1.
    pub fn decide(&mut self, limits: &RestartLimits, now: NodeTime, random: f64) -> Decision {
        while self
            .failures
            .front()
            .is_some_and(|f| now.seconds_since(*f) > limits.window_s)
        {
            self.failures.pop_front();
        }
        self.failures.push_back(now);
        let failures = self.failures.len();
        if failures > limits.max_failures {
            return Decision::GiveUp;
        }
        let delay_s = match failures {
            0 | 1 => limits.first_delay_s,
            n => {
                // 2^20 times any base is beyond any maximum: the exponent needs no more room.
                let doublings = i32::try_from(n - 2).unwrap_or(i32::MAX).min(20);
                (limits.base_delay_s * 2f64.powi(doublings)).min(limits.max_delay_s)
            }
        };
        Decision::RestartAfter(delay_s * (1.0 + limits.jitter * random.clamp(0.0, 1.0)))
    }

    /// Forgets all failures, after an operator's reset.
    pub fn reset(&mut self) {
        self.failures.clear();
    }
}

#[cfg(test)]
mod tests;
