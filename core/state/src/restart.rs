//! When a failed actor or plugin is started again: pure policy with named limits. The caller passes the time and a random number.

use skein_domain::NodeTime;
use std::collections::VecDeque;

/// Limits of one kind of restart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RestartLimits {
    /// Who ran for so long before it failed is started again at once, in seconds: its failure is no consequence of its start.
    pub healthy_after_s: f64,
    /// Delay before the restart after the second failure in quick succession, in seconds; doubled for each further one. After the
    /// first there is none: in flight the link holds position meanwhile.
    pub base_delay_s: f64,
    /// No delay is longer than this, in seconds.
    pub max_delay_s: f64,
    /// Share of a delay that is drawn at random on top, so that many that failed together do not start together.
    pub jitter: f64,
    /// More failures in quick succession than this: give up and escalate.
    pub max_in_succession: usize,
    /// More failures than this within the window: give up and escalate.
    pub max_failures: usize,
    /// The window in seconds.
    pub window_s: f64,
}

/// A vehicle's actor or its UAV-model plugin. Eight failures one after the other are no accident, and take less time than the link
/// holds position; nor are more than twenty in a minute. The vehicle is then held by its autopilot.
pub const VEHICLE_LIMITS: RestartLimits = RestartLimits {
    healthy_after_s: 1.0,
    base_delay_s: 0.05,
    max_delay_s: 2.0,
    jitter: 0.2,
    max_in_succession: 7,
    max_failures: 20,
    window_s: 60.0,
};

/// A payload's actor or plugin. Nothing falls while it is away, so that it may try for longer: about half a minute.
pub const PAYLOAD_LIMITS: RestartLimits = RestartLimits {
    healthy_after_s: 1.0,
    base_delay_s: 0.05,
    max_delay_s: 5.0,
    jitter: 0.2,
    max_in_succession: 11,
    max_failures: 20,
    window_s: 60.0,
};

/// Parts of the node itself (fleet, coordinator, pulse, endpoints). They are tried for ever, but slower: without them nothing flies.
pub const NODE_LIMITS: RestartLimits = RestartLimits {
    healthy_after_s: 1.0,
    base_delay_s: 0.1,
    max_delay_s: 5.0,
    jitter: 0.2,
    max_in_succession: usize::MAX,
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
    /// Failures in quick succession, the last one included.
    in_succession: usize,
    /// When it was to run again after the last failure.
    started: Option<NodeTime>,
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
        let ran_well = self
            .started
            .is_none_or(|started| now.seconds_since(started) >= limits.healthy_after_s);
        self.in_succession = if ran_well {
            1
        } else {
            self.in_succession.saturating_add(1)
        };
        if self.failures.len() > limits.max_failures || self.in_succession > limits.max_in_succession {
            return Decision::GiveUp;
        }
        let delay_s = match self.in_succession {
            0 | 1 => 0.0,
            n => {
                // 2^20 times any base is beyond any maximum: the exponent needs no more room.
                let doublings = i32::try_from(n - 2).unwrap_or(i32::MAX).min(20);
                (limits.base_delay_s * 2f64.powi(doublings)).min(limits.max_delay_s)
            }
        } * (1.0 + limits.jitter * random.clamp(0.0, 1.0));
        self.started = Some(now.plus_seconds(delay_s));
        Decision::RestartAfter(delay_s)
    }

    /// Forgets all failures, after an operator's reset.
    pub fn reset(&mut self) {
        *self = Self::default();
    }
}

/// A random number for the back-off: the microseconds of the failure's time are as good as random between vehicles.
#[must_use]
pub fn fraction(now: NodeTime) -> f64 {
    (now.0 % 1_000) as f64 / 1_000.0
}

#[cfg(test)]
mod tests;
