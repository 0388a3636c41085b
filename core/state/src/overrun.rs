//! Whether the control loop comes in time: what one late computer does to all vehicles has one cause, which the operator is told, and time in
//! which this computer stood still is nobody else's silence.
//!
//! Must never do: decide anything. What flies has its own watch.

use skein_domain::NodeTime;
use skein_domain::exchange::Severity;
use skein_view::EventKind;
use std::collections::VecDeque;

/// A tick that comes later than this is told, in seconds. Setpoints are held on to for longer.
const LATE_S: f64 = 0.25;
/// So long without a late tick it is over, in seconds.
const OVER_AFTER_S: f64 = 5.0;
/// So many late ticks are remembered: more than there can be in a silence that is judged.
const MOST_LATE: usize = 32;

/// The ticks so far.
#[derive(Debug, Default)]
pub struct Overrun {
    last: Option<NodeTime>,
    period_s: f64,
    /// Of the last late tick, until it is over.
    late: Option<NodeTime>,
    /// When ticks came late, and by how many seconds; the newest last.
    stood_still: VecDeque<(NodeTime, f64)>,
}

/// What there is to tell of a tick.
pub type OverrunEvent = (Severity, EventKind, String);

impl Overrun {
    /// Takes note of a tick.
    pub fn tick(&mut self, now: NodeTime, period_s: f64) -> Option<OverrunEvent> {
        let since_s = self.last.replace(now).map_or(0.0, |last| now.seconds_since(last));
        self.period_s = period_s;
        let by_s = since_s - period_s;
        if by_s > LATE_S {
            self.late = Some(now);
            if self.stood_still.len() == MOST_LATE {
                self.stood_still.pop_front();
            }
            self.stood_still.push_back((now, by_s));
            let text = format!("this computer was late by {by_s:.1} s");
            return Some((Severity::Warning, EventKind::Overrun { by_s }, text));
        }
        self.late.take_if(|late| now.seconds_since(*late) > OVER_AFTER_S)?;
        Some((
            Severity::Info,
            EventKind::OverrunEnded,
            "this computer is in time again".to_owned(),
        ))
    }

    /// How long nothing has been heard at `now` from somebody who was last heard at `heard`, in seconds, without the time in which this
    /// computer stood still: what was said meanwhile may still lie in its sockets.
    pub fn silence_s(&self, heard: NodeTime, now: NodeTime) -> f64 {
        let overdue_s = self.last.map_or(0.0, |last| now.seconds_since(last) - self.period_s);
        let still_now = (overdue_s > LATE_S).then_some((now, overdue_s));
        let stood_still = self.stood_still.iter().copied().chain(still_now);
        // one that began before the last word counts from there
        let within = stood_still.filter(|(end, _)| *end > heard);
        let still_s: f64 = within.map(|(end, by_s)| by_s.min(end.seconds_since(heard))).sum();
        now.seconds_since(heard) - still_s
    }
}

#[cfg(test)]
mod tests {
    //! Each late tick is told, and once that it is over. What this computer missed meanwhile is not taken for silence.

    use super::*;

    fn told(gaps_s: &[f64]) -> Vec<String> {
        let (mut overrun, mut now_s) = (Overrun::default(), 0.0);
        let mut texts = Vec::new();
        for gap_s in gaps_s {
            now_s += gap_s;
            texts.extend(
                overrun
                    .tick(NodeTime::from_seconds(now_s), 0.02)
                    .map(|(_, _, text)| text),
            );
        }
        texts
    }

    #[test]
    fn late_ticks_are_told_and_their_end_once() {
        let in_time = [0.02; 600];
        assert_eq!(told(&in_time), Vec::<String>::new());
        let late = [&in_time[..10], &[0.42, 0.02, 1.02], &in_time[..]].concat();
        assert_eq!(
            told(&late),
            [
                "this computer was late by 0.4 s",
                "this computer was late by 1.0 s",
                "this computer is in time again"
            ]
        );
    }

    #[test]
    fn the_first_tick_is_not_late() {
        assert_eq!(told(&[100.0, 0.02]), Vec::<String>::new());
    }

    #[test]
    fn a_stall_is_nobodys_silence() {
        let at = NodeTime::from_seconds;
        let mut overrun = Overrun::default();
        let near = |silence_s: f64, expected_s: f64| assert!((silence_s - expected_s).abs() < 1e-6, "{silence_s} s");
        // nothing is known before the first tick
        near(overrun.silence_s(at(1.0), at(3.0)), 2.0);
        overrun.tick(at(10.0), 0.02);
        near(overrun.silence_s(at(9.9), at(10.02)), 0.12);
        // still going on: whoever looks before the control loop does
        near(overrun.silence_s(at(9.9), at(11.02)), 0.12);
        overrun.tick(at(11.02), 0.02);
        near(overrun.silence_s(at(9.9), at(11.02)), 0.12);
        near(overrun.silence_s(at(9.9), at(11.2)), 0.3);
        // heard in the middle of it, and after it
        near(overrun.silence_s(at(10.5), at(11.02)), 0.0);
        near(overrun.silence_s(at(11.1), at(11.2)), 0.1);
    }

    #[test]
    fn who_is_always_a_little_late_misses_the_silent_all_the_same() {
        let at = NodeTime::from_seconds;
        let mut overrun = Overrun::default();
        (0..20).for_each(|tick| {
            overrun.tick(at(f64::from(tick) * 0.2), 0.02);
        });
        assert!(overrun.silence_s(at(1.0), at(3.8)) > 2.7);
    }
}
