//! Watches the offset between an autopilot's clock and the node's: a jump, a drift, or time that goes backwards.
//!
//! The clock of a vehicle is a quartz: one that runs at another pace is broken. The time of a simulation runs as fast as the computer
//! computes it, and stands still while that does something else: there a pace between half and one and a half is no fault, a jump is.
//!
//! Where this node did not look for a while, and the vehicle's clock is then behind by just that time, no time has passed for the vehicle: it
//! is simulated on a computer that stood still with this node, or this computer's own clock went ahead. Nothing was missed, and the offset
//! is known: no fault.

use super::{Health, STOOD_STILL_S};
use serde::{Deserialize, Serialize};
use skein_domain::NodeTime;
use skein_domain::failsafe::ClockFaultRule;

/// Of `clear_s`: an offset that wanders no further counts as steady.
const STEADY_SHARE: f64 = 0.2;
/// How fast the offset of a simulated clock may wander, in seconds per second: a pace of 0.5 to 1.5, and now and then a moment in
/// which it stands still.
const SIMULATED_DRIFT_S_PER_S: f64 = 0.75;
/// A computer that goes on after a stall is late for another moment, in which the vehicle's clock runs already: so much less of that time it may be behind.
const LESS_SHARE: f64 = 0.25;
/// Within this time the link has measured a step of a clock.
const EXPLAINS_FOR_S: f64 = 3.0;

/// What is remembered of the clocks of one vehicle.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct ClockWatch {
    /// Where the offset is expected: it follows no faster than clocks drift.
    expected_s: Option<f64>,
    /// Since when the offset has been off.
    off_since: Option<NodeTime>,
    /// An offset and since when it has been steady there.
    steady: Option<(f64, NodeTime)>,
    /// Last call, and the newest time at which a position was measured.
    last: Option<(NodeTime, Option<NodeTime>)>,
    /// The greatest jump backwards lately, in seconds, and when.
    backwards: Option<(f64, NodeTime)>,
    /// For how long this node stood still lately, in seconds, and when it went on.
    stood_still: Option<(f64, NodeTime)>,
}

impl ClockWatch {
    /// How far the clocks are from where they should be, in seconds. Not a number counts as infinitely far.
    pub(super) fn deviation_s(&mut self, now: NodeTime, health: &Health, rule: &ClockFaultRule) -> f64 {
        let position_time = health.position_time;
        let max_drift_s_per_s = if health.simulated {
            rule.max_drift_s_per_s.max(SIMULATED_DRIFT_S_PER_S)
        } else {
            rule.max_drift_s_per_s
        };
        let from_offset_s = health.clock_offset_s.map_or(0.0, |offset_s| {
            self.allow_for_stall(now, offset_s, rule);
            self.offset_deviation_s(now, offset_s, max_drift_s_per_s, rule)
        });
        self.note_backwards(now, position_time, rule);
        // A position from the future: one of the two clocks is wrong.
        let ahead_s = position_time.map_or(0.0, |at| at.seconds_since(now).max(0.0));
        let recent = self
            .backwards
            .filter(|(_, at)| now.seconds_since(*at) <= rule.settled_after_s);
        self.last = Some((now, position_time.or(self.last.and_then(|(_, position)| position))));
        from_offset_s.max(ahead_s).max(recent.map_or(0.0, |(back_s, _)| back_s))
    }

    /// A clock that stood still as long as this node did is expected where it went on.
    fn allow_for_stall(&mut self, now: NodeTime, offset_s: f64, rule: &ClockFaultRule) {
        let (Some(expected_s), Some((last, _))) = (self.expected_s, self.last) else {
            return;
        };
        let recent = self
            .stood_still
            .filter(|(_, at)| now.seconds_since(*at) <= EXPLAINS_FOR_S);
        let gap_s = now.seconds_since(last);
        self.stood_still = if gap_s > STOOD_STILL_S {
            Some((gap_s + recent.map_or(0.0, |(before_s, _)| before_s), now))
        } else {
            recent
        };
        if let Some((stood_s, _)) = self.stood_still
            && ((1.0 - LESS_SHARE) * stood_s - rule.limit_s..=stood_s + rule.limit_s).contains(&(expected_s - offset_s))
        {
            (self.expected_s, self.stood_still) = (Some(offset_s), None);
        }
    }

    fn offset_deviation_s(
        &mut self,
        now: NodeTime,
        offset_s: f64,
        max_drift_s_per_s: f64,
        rule: &ClockFaultRule,
    ) -> f64 {
        if !offset_s.is_finite() {
            return f64::INFINITY;
        }
        let dt_s = self.last.map_or(0.0, |(last, _)| now.seconds_since(last).max(0.0));
        let expected_s = self.expected_s.unwrap_or(offset_s);
        let follows_s = (max_drift_s_per_s * dt_s).max(0.0);
        let mut expected_s = expected_s + (offset_s - expected_s).clamp(-follows_s, follows_s);
        let steady = self
            .steady
            .filter(|(at_s, _)| (offset_s - at_s).abs() <= STEADY_SHARE * rule.clear_s)
            .unwrap_or((offset_s, now));
        self.steady = Some(steady);
        let off_s = (offset_s - expected_s).abs();
        if off_s <= rule.clear_s {
            self.off_since = None;
        } else if off_s > rule.limit_s || self.off_since.is_some() {
            let off_since = *self.off_since.get_or_insert(now);
            if now.seconds_since(off_since.max(steady.1)) >= rule.settled_after_s {
                // The jump is over: the clock runs on evenly from where it is.
                expected_s = offset_s;
                self.off_since = None;
            }
        }
        self.expected_s = Some(expected_s);
        (offset_s - expected_s).abs()
    }

    fn note_backwards(&mut self, now: NodeTime, position_time: Option<NodeTime>, rule: &ClockFaultRule) {
        let Some((last, last_position)) = self.last else { return };
        let node_s = last.seconds_since(now);
        let position_s = last_position
            .zip(position_time)
            .map_or(0.0, |(before, at)| before.seconds_since(at));
        // The node's clock may not go back at all; positions may overtake each other on the way here.
        if node_s > 0.0 {
            self.backwards = Some((node_s.max(2.0 * rule.limit_s), now));
        } else if position_s > rule.limit_s {
            self.backwards = Some((position_s, now));
        }
    }
}
