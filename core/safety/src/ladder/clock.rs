//! Watches the offset between an autopilot's clock and the node's: a jump, a drift, or time that goes backwards.
//!
//! The clock of a vehicle is a quartz: one that runs at another pace is broken. The time of a simulation runs as fast as the computer
//! computes it, and stands still while that does something else: there a pace between half and one and a half is no fault, a jump is.

use super::Health;
use skein_domain::NodeTime;
use skein_domain::ladder::ClockFaultRule;

/// Of `clear_s`: an offset that wanders no further counts as steady.
const STEADY_SHARE: f64 = 0.2;
/// How fast the offset of a simulated clock may wander, in seconds per second: a pace of 0.5 to 1.5, and now and then a moment in
/// which it stands still.
const SIMULATED_DRIFT_S_PER_S: f64 = 0.75;

/// What is remembered of the clocks of one vehicle.
#[derive(Debug, Clone, PartialEq, Default)]
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
